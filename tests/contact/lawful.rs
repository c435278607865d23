//! The solution that an answer stands for: the one with its states, by Newton steps from it that are solved in twice the digits.

use super::reference::reference;
use fracas::contact::{ContactState, Thresholds, next_state};
use fracas::nonlinear::{ContactProblem, State};
use fracas_solvers::saddle::U;

/// Newton steps tried. Unit: 1.
const STEPS: usize = 30;

/// Change of u and t relative to their largest entries below which a step is the last. Unit: 1.
const SMALL: f64 = 1e-12;

/// The same below which what rounding keeps from falling is a solution. Unit: 1.
const ENOUGH: f64 = 1e-9;

/// The solution with the states of `near`, of the first step of a run, where Newton steps find one and all states are what the law says to
/// this share of the largest traction.
pub(crate) fn of_its_states(
    problem: &ContactProblem<'_>,
    near: &State,
    share: f64,
) -> Option<State> {
    let states = &near.states;
    let h = problem.stabilization(states);
    let (start, load) = (problem.at_rest(), problem.loads().at(0.0, 1.0));
    let n_u = problem.saddle().layout().length(U);
    let [mut u, mut t] = [near.u.clone(), near.t.clone()];
    let largest = |v: &[f64]| v.iter().fold(0.0f64, |most, v| most.max(v.abs()));
    let mut last = f64::INFINITY;
    for _ in 0..STEPS {
        let at = problem.evaluate(states, h.as_ref(), [&u, &t], &start, &load);
        let blocks = problem.assembled(states, h.as_ref(), &at, false).ok()?;
        let change = reference(&blocks, &blocks.rhs())?;
        let (of_u, of_t) = change.split_at(n_u);
        u.iter_mut().zip(of_u).for_each(|(u, change)| *u += change);
        t.iter_mut().zip(of_t).for_each(|(t, change)| *t += change);
        let size = (largest(of_u) / largest(&u)).max(largest(of_t) / largest(&t));
        let stands = size < ENOUGH && size > 0.5 * last;
        if size < SMALL || stands {
            let at = problem.evaluate(states, h.as_ref(), [&u, &t], &start, &load);
            let zero = Thresholds {
                jump: share * largest(&at.jumps),
                traction: share * largest(&t),
                slip: share * largest(&t),
            };
            let is_lawful = |(f, state): (usize, &ContactState)| {
                let face = problem.measure(f, *state, &t, &at.effective, &start);
                let next = next_state(*state, &face, &zero);
                next.constrained() == state.constrained()
            };
            let lawful = states.iter().enumerate().all(is_lawful);
            return lawful.then(|| State {
                u,
                t,
                ..near.clone()
            });
        }
        last = size;
    }
    None
}
