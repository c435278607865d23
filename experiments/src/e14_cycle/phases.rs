//! What the steps cost between one kind of contact and the next.

use super::steps::{Row, Run};
use crate::report::{Cell, Table};

/// Names of the states, by number.
const STATES: [&str; 4] = ["stick", "new slip", "slip", "open"];

/// The states that the faces are in after a step.
fn kind(row: &Row) -> String {
    let present = STATES.iter().zip(row.done.record.faces);
    let names: Vec<&str> = present.filter(|(_, n)| *n > 0).map(|(s, _)| *s).collect();
    names.join(" + ")
}

/// A face has changed its state.
fn is_changing(row: &Row) -> bool {
    row.done.record.changed_area > 0.0
}

/// The step brings all faces to one state.
fn is_arrival(row: &Row) -> bool {
    let n = row.done.state.states.len();
    is_changing(row) && row.done.record.faces.contains(&n)
}

/// Both end in the same states, and both or none are arrivals.
fn is_alike(a: &Row, b: &Row) -> bool {
    kind(a) == kind(b) && is_arrival(a) == is_arrival(b)
}

/// One line per mesh and stretch of steps that end in the same states; the step that brings all faces to one state has its own.
pub(super) fn table(runs: &[Run]) -> Table {
    let mut table = Table::new(
        "e14_phases",
        "Steps in a row that end with faces in the same states, the step that brings all faces to one state by itself; changing: steps \
         in which a face changes its state. Means per step, Krylov iterations per Newton step, preconditioners built.",
        &[
            "cells",
            "n",
            "states",
            "from [s]",
            "to [s]",
            "steps",
            "changing",
            "n_it rounds",
            "n_it Newton",
            "n_it Krylov per Newton step",
            "n_it set-ups",
        ],
    );
    for run in runs {
        let n = run.body.constraints.free_len() + 3 * run.body.fractures.faces.len();
        for phase in run.rows.chunk_by(is_alike) {
            let [Some(first), Some(last)] = [phase.first(), phase.last()] else {
                continue;
            };
            let sum = |count: fn(&Row) -> usize| phase.iter().map(count).sum::<usize>();
            let newton = sum(|r| r.done.record.newton_it) as f64;
            let steps = phase.len() as f64;
            let krylov = sum(|r| r.done.record.lin_it) as f64;
            let cells: [Cell; 11] = [
                run.name.as_str().into(),
                n.into(),
                kind(first).into(),
                first.done.record.time.into(),
                last.done.record.time.into(),
                phase.len().into(),
                phase.iter().filter(|r| is_changing(r)).count().into(),
                (sum(|r| r.done.record.active_it) as f64 / steps).into(),
                (newton / steps).into(),
                (krylov / newton).into(),
                sum(|r| r.done.record.setups).into(),
            ];
            table.push(cells);
        }
    }
    table
}
