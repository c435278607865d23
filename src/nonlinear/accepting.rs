//! What a settled step leaves: the state after it, and its row of the history.

use super::active_set::{Log, Settled};
use super::fields::{path_after, slip_after};
use super::record::count;
use super::times::Target;
use super::{Accepted, FaceFields, Load, Simulation, State, StepRecord};
use crate::contact::ContactState;

impl Simulation<'_> {
    /// The step from `before` to `target`, which has settled under `load`; `next` is the increment that comes after it [s].
    pub(super) fn accept(
        &self,
        before: &State,
        target: Target,
        settled: Settled,
        load: &Load,
        log: Log,
        cuts: usize,
        next: f64,
    ) -> Accepted {
        let Settled {
            states,
            x,
            force,
            traction,
            effective,
            slip_violation,
            size,
            error,
            unstable,
            flow,
            wells,
            joined: _,
            released,
            mut torn,
        } = settled;
        let problem = &self.problem;
        let from = problem.jumps(&before.u, &problem.loads().at(before.time, before.loaded));
        let jump = problem.jumps(&x.u, load);
        let slip = slip_after(
            &before.slip,
            [&from, &effective, &x.t],
            (&states, problem.compliance()),
        );
        let path = path_after(&before.path, [&before.slip, &slip]);
        torn.resize(states.len(), false);
        let of_faces = [&x.t[..], &slip, &path];
        let fields = FaceFields::new(problem, (&states, &torn), of_faces, jump, Vec::new());
        let accepted = log.linear.iter().map(|l| l.attempt).max();
        let last = log.linear.iter().filter(|l| Some(l.attempt) == accepted);
        let setups = log.linear.iter().filter(|l| l.setup).count();
        let mut record = StepRecord {
            step: before.step,
            time: target.time,
            dt: target.time - before.time,
            active_it: log.rounds,
            newton_it: log.linear.len(),
            lin_it: log.linear.iter().map(|l| l.iterations).sum(),
            lin_res: last.fold(0.0, |m: f64, l| m.max(l.relative_residual)),
            faces: count(&states),
            max_slip_viol: slip_violation,
            error,
            arrested: unstable.is_some(),
            cuts,
            setups,
            reuses: log.linear.len() - setups,
            ..StepRecord::default()
        };
        let (krylov, prepared) = match &self.springs {
            Some(springs) => (0.0, springs.carried()),
            None => self.linear.carried(),
        };
        let creep = before.creep.as_ref().and_then(|_| {
            let held = problem.loads().prescribed_at(target.time, target.loaded);
            let u = [&self.displacement(before)[..], &held.expand(&x.u)];
            problem.crept(before, u)
        });
        let mut flips = before.flips.clone();
        for (f, face) in self.problem.faces().iter().enumerate() {
            if states[f] != before.states[f] {
                record.changed_area += face.area;
                flips[f] += 1;
            }
            // with multipliers what overlaps on a closed face is the work of H
            let held = self.springs.is_none() && states[f] != ContactState::Open;
            let overlap = match held {
                true => &mut record.h_overlap,
                false => &mut record.max_pen,
            };
            *overlap = overlap.max(-fields.jump[3 * f]);
            let [n, t1, t2] = [0, 1, 2].map(|k: usize| fields.stabilization_jump[3 * f + k]);
            record.h_jump = record.h_jump.max(n.hypot(t1).hypot(t2));
            record.slip_max = record.slip_max.max(fields.slip[f]);
            let shear = x.t[3 * f + 1].hypot(x.t[3 * f + 2]);
            record.max_tau_viol = record.max_tau_viol.max(shear - fields.tau_limit[f]);
        }
        Accepted {
            state: State {
                step: before.step + 1,
                time: target.time,
                loaded: target.loaded,
                next,
                force,
                traction,
                size,
                krylov,
                prepared,
                u: x.u,
                t: x.t,
                p: x.p,
                states,
                slip,
                path,
                creep,
                released,
                torn,
                flips,
                onsets: before.onsets.clone(),
            },
            record,
            flow,
            wells,
            linear: log.linear,
            events: log.events,
        }
    }
}
