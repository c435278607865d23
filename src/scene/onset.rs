//! The onset of slip: how closely a run is to know when it begins.

use super::Problem;
use super::located::{Located, at};
use super::sections::SceneSections;
use crate::mesh::FractureMesh;
use crate::units::{Area, Duration, Measure};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Shortest interval over the length of a step: steps land on times to a thousandth of that. Unit: 1.
const CLOSEST: f64 = 1e-6;

/// Share by which the area of a patch may miss what is asked for: sums of faces round. Unit: 1.
const SAME_AREA: f64 = 1e-9;

/// When slip begins on every fracture: the time at which a first face slips or opens, and that at which a patch of faces does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OnsetSection {
    /// Length of the interval in which the time is to lie, at most.
    pub within: Measure<Duration>,
    /// Area of faces of one fracture that slip or are open at once and hang together by their edges; not given, a first face is looked for
    /// alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub patch: Option<Measure<Area>>,
}

/// An [`OnsetSection`] in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Onset {
    /// Longest interval in which the time may lie [s].
    pub within: f64,
    /// Area of the patch that is looked for beside a first face [m²].
    pub patch: Option<f64>,
}

impl Onset {
    /// True for a patch of this area [m²].
    pub fn has_patch(self, area: f64) -> bool {
        self.patch
            .is_some_and(|least| area >= (1.0 - SAME_AREA) * least)
    }
}

/// An onset that nobody can look for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OnsetProblem {
    /// An interval that steps cannot tell from none.
    #[error(
        "`within` of the onset is {within}, less than a millionth of a step ({step:.6e} s), and times are told apart no more closely; give at least {least:.1e} s"
    )]
    Close {
        /// As written.
        within: String,
        /// Length of a step [s].
        step: f64,
        /// The shortest [s].
        least: f64,
    },
    /// A patch that no fracture has room for.
    #[error(
        "`patch` of the onset is {patch}, and the largest fracture, \"{fracture}\", has {area:.6} m2; give an area that fits"
    )]
    Large {
        /// As written.
        patch: String,
        /// The largest fracture.
        fracture: String,
        /// Its area [m²].
        area: f64,
    },
}

/// What `[time] onset` asks for.
///
/// # Errors
/// No fracture, an interval that is too short, a patch that is too large.
pub(super) fn onset(
    sections: &SceneSections,
    fractures: &FractureMesh,
) -> Result<Option<Onset>, Located> {
    let Some((time, onset)) = sections
        .time
        .as_ref()
        .and_then(|t| Some((t, t.onset.as_ref()?)))
    else {
        return Ok(None);
    };
    if fractures.faces.is_empty() {
        let (key, what, without) = ("onset", "[time]".into(), "[[fracture]]");
        let path = ["time", "onset"];
        return Err(at(&path, Problem::Idle { key, what, without }));
    }
    let step = time.end.si() / f64::from(time.steps.get());
    let least = CLOSEST * step;
    let found = Onset {
        within: onset.within.si(),
        patch: onset.patch.as_ref().map(Measure::si),
    };
    if found.within < least {
        let within = onset.within.to_string();
        let problem = OnsetProblem::Close {
            within,
            step,
            least,
        };
        return Err(at(&["time", "onset", "within"], problem));
    }
    let mut areas = vec![0.0; fractures.names.len()];
    for face in &fractures.faces {
        areas[usize::from(face.fracture)] += face.area;
    }
    let largest = (0..areas.len()).max_by(|a, b| areas[*a].total_cmp(&areas[*b]));
    match (&onset.patch, largest) {
        (Some(patch), Some(largest)) if !found.has_patch(areas[largest]) => {
            let problem = OnsetProblem::Large {
                patch: patch.to_string(),
                fracture: fractures.names[largest].clone(),
                area: areas[largest],
            };
            Err(at(&["time", "onset", "patch"], problem))
        }
        _ => Ok(Some(found)),
    }
}
