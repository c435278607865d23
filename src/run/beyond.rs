//! Steps in which H acts on more than the states constrain, and lets more through than slips or opens.

use crate::mesh::FractureMesh;
use crate::nonlinear::{Event, FaceFields};

/// What the steps of a run have shown so far.
#[derive(Debug, Default)]
pub(super) struct Beyond {
    /// Steps in which a jump through H is larger than all slip and opening.
    steps: usize,
    worst: Option<Worst>,
}

/// The step in which it is so by most.
#[derive(Debug)]
struct Worst {
    step: usize,
    fracture: String,
    /// Largest jump through H [m].
    jump: f64,
    /// Over the largest slip or opening; infinite where there is none. Unit: 1.
    ratio: f64,
}

impl Beyond {
    /// Takes in a step, its events and the fields at its end, which are asked for where H acts beyond its states.
    pub(super) fn add(
        &mut self,
        step: usize,
        events: &[Event],
        fields: impl FnOnce() -> FaceFields,
        fractures: &FractureMesh,
    ) {
        let acts = |event: &Event| matches!(event, Event::Stabilized { .. });
        if !events.iter().any(acts) {
            return;
        }
        let fields = fields();
        let through = fields.stabilization_jump.chunks_exact(3);
        let through = through.map(|j| j[0].hypot(j[1]).hypot(j[2])).enumerate();
        let Some((face, jump)) = through.max_by(|a, b| a.1.total_cmp(&b.1)) else {
            return;
        };
        let moved = fields.slip.iter().chain(&fields.aperture);
        let moved = moved.fold(0.0f64, |m, v| m.max(v.abs()));
        if jump <= moved {
            return;
        }
        self.steps += 1;
        let ratio = jump / moved;
        if self.worst.as_ref().is_none_or(|worst| ratio > worst.ratio) {
            let number = usize::from(fractures.faces[face].fracture);
            self.worst = Some(Worst {
                step,
                fracture: fractures.names[number].clone(),
                jump,
                ratio,
            });
        }
    }

    /// What is to be said at the end of the run.
    pub(super) fn remark(&self) -> Option<String> {
        let Worst {
            step,
            fracture,
            jump,
            ratio,
        } = self.worst.as_ref()?;
        let steps = match self.steps {
            1 => "1 step".to_owned(),
            n => format!("{n} steps"),
        };
        let than = match ratio.is_finite() {
            true => format!("{ratio:.3} times as large as any slip or opening"),
            false => "where nothing slips or opens".to_owned(),
        };
        Some(format!(
            "in {steps} H acts on faces beyond their states and lets more through than slips or opens; most in step {step}, a jump of {jump:.3e} m \
             on fracture \"{fracture}\", {than}; finer cells around it lower H, and [solver] method = {{ penalty = {{ factor = 1e3 }} }} \
             solves without H, to compare"
        ))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::sample::Sample;

    #[test]
    fn a_jump_through_h_beyond_slip_and_opening_is_told_once() {
        let fractures = Sample::cycle().body().fractures;
        let n = fractures.faces.len();
        let fields = |through: f64, slip: f64, opening: f64| {
            let mut fields = FaceFields {
                stabilization_jump: vec![0.0; 3 * n],
                slip: vec![0.0; n],
                aperture: vec![0.0; n],
                ..FaceFields::default()
            };
            fields.stabilization_jump[3 * (n - 1) + 1] = -through;
            (fields.slip[0], fields.aperture[n - 1]) = (slip, opening);
            fields
        };
        let held = [Event::Stabilized { faces: 3 }];
        let mut beyond = Beyond::default();
        for (step, events, (through, slip, opening)) in [
            (1, &held[..], (1e-3, 2e-3, 0.0)),
            (2, &held, (1e-3, 0.0, 2e-3)),
            // H of the states alone
            (3, &[], (9e-3, 1e-3, 0.0)),
        ] {
            beyond.add(step, events, || fields(through, slip, opening), &fractures);
        }
        assert_eq!(beyond.remark(), None);
        beyond.add(4, &held, || fields(3e-3, 1e-3, 2e-3), &fractures);
        beyond.add(5, &held, || fields(4e-3, 1e-3, 0.0), &fractures);
        let text = beyond.remark().unwrap();
        let told = "in 2 steps H acts on faces beyond their states";
        assert!(text.starts_with(told), "{text}");
        let most = "most in step 5, a jump of 4.000e-3 m on fracture \"cut\", 4.000 times";
        assert!(text.contains(most), "{text}");
        beyond.add(6, &held, || fields(1e-3, 0.0, 0.0), &fractures);
        let text = beyond.remark().unwrap();
        assert!(text.contains("where nothing slips or opens"), "{text}");
    }
}
