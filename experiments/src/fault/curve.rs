//! Slip over the change of pressure.

use super::FaultFile;
use super::file::nucleation;
use fracas::analytic::{DisplacedFault, FaultState, NoState};

/// A fault at one change of pressure.
#[derive(Clone, Debug)]
pub struct Point {
    /// Δp [Pa].
    pub change: f64,
    /// Length that slides [m].
    pub length: f64,
    /// Longest piece without a gap [m].
    pub patch: f64,
    /// Largest |δ| [m].
    pub slip: f64,
    /// ∫ |δ| ds [m²].
    pub integral: f64,
    /// G ∫ |δ| ds [N]: moment per metre of strike.
    pub moment: f64,
    /// Largest |τ|/τ_L [1]; at corners of blocks it depends on the elements.
    pub criticality: f64,
    /// Elements under tension.
    pub open: usize,
}

/// The way to the whole change of pressure, or to where slip runs away.
#[derive(Clone, Debug)]
pub struct Curve {
    /// The fault.
    pub fault: DisplacedFault,
    /// A point per step.
    pub points: Vec<Point>,
    /// States at some of them, the last one among them: Δp [Pa].
    pub states: Vec<(f64, FaultState)>,
    /// Where slip runs away: Δp [Pa] and the piece that does [m].
    pub runaway: Option<Runaway>,
    /// Nucleation half-length where the fault is pressed most [m]; infinite without weakening.
    pub nucleation: f64,
}

/// Where slip runs away.
#[derive(Clone, Copy, Debug)]
pub struct Runaway {
    /// Δp [Pa].
    pub change: f64,
    /// Heights between which it does [m].
    pub heights: [f64; 2],
}

/// States that a curve keeps for its profiles.
const PROFILES: usize = 4;

/// The curve of a file.
///
/// # Errors
/// A fault that is not in equilibrium before the pressure changes, or on which elements never settle.
pub fn curve(file: &FaultFile) -> anyhow::Result<Curve> {
    let given = file.given()?;
    let fault = file.build(&given)?;
    file.rest(&fault, given.strength)?;
    let steps = file.pressure.steps;
    let (mut points, mut states, mut runaway) = (Vec::new(), Vec::new(), None);
    let mut path = fault.path(given.strength);
    for k in 0..=steps {
        let share = k as f64 / steps as f64;
        match path.advance(share) {
            Ok(state) => {
                points.push(Point::of(&fault, &state, share * file.change()));
                if k > 0 && (k * PROFILES) / steps > ((k - 1) * PROFILES) / steps {
                    states.push((share * file.change(), state));
                }
            }
            Err(NoState::Runaway { sliding }) => {
                let state = path.state();
                let change = path.share() * file.change();
                points.push(Point::of(&fault, &state, change));
                states.push((change, state));
                runaway = Some(Runaway {
                    change,
                    heights: heights(&fault, &sliding),
                });
                break;
            }
            Err(NoState::Unsettled) => {
                anyhow::bail!(
                    "at {:.1} % of the change of pressure elements change between stick and slip without end; take more elements",
                    100.0 * share
                )
            }
        }
    }
    let nucleation = nucleation(&fault, given.strength);
    Ok(Curve {
        points,
        states,
        runaway,
        nucleation,
        fault,
    })
}

/// Height of an element [m].
pub(super) fn height(fault: &DisplacedFault, element: usize) -> f64 {
    fault.along[element] * fault.dip.sin()
}

/// Ends of the longest piece without a gap [m].
fn heights(fault: &DisplacedFault, elements: &[usize]) -> [f64; 2] {
    let half = 0.5 * fault.h * fault.dip.sin();
    let pieces = elements.chunk_by(|a, b| a + 1 == *b);
    let elements = pieces.max_by_key(|piece| piece.len()).unwrap_or_default();
    let ends = |pick: fn(f64, f64) -> f64, start| {
        elements.iter().map(|i| height(fault, *i)).fold(start, pick)
    };
    [
        ends(f64::min, f64::INFINITY) - half,
        ends(f64::max, f64::NEG_INFINITY) + half,
    ]
}

impl Point {
    fn of(fault: &DisplacedFault, state: &FaultState, change: f64) -> Self {
        let integral = state.slip_integral(fault.h);
        Self {
            change,
            length: state.slipping_length(fault.h),
            patch: state.longest_patch(fault.h),
            slip: state.largest_slip(),
            integral,
            moment: fault.rock.shear() * integral,
            criticality: state.criticality.iter().fold(0.0, |m, chi| chi.max(m)),
            open: state.normal.iter().filter(|n| **n > 0.0).count(),
        }
    }
}
