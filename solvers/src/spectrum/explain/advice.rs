//! One sentence, chosen by the first rule that applies.

use super::Explanation;
use crate::saddle::{InnerChoice, SaddleMethod};

/// Share of rows with `C_ii < H_ii` that matters.
const BELOW: f64 = 0.01;

/// Operator complexity above which the coarse levels cost more than the finest.
const COMPLEX: f64 = 2.0;

/// κ above which iterations are to be gained.
const SPREAD: f64 = 30.0;

/// Outliers that are few: as many iterations as a Krylov method spends on them.
const FEW: usize = 12;

/// Contrast of stiffness above which it is the likely cause; a corner of a uniform body has an eighth of the stiffness
/// inside.
const CONTRAST: f64 = 100.0;

/// Set-up above this multiple of the iterations is worth keeping, if it takes more than a second.
const SETUP: f64 = 5.0;

pub(super) fn of(facts: &Explanation, method: &SaddleMethod) -> String {
    let inner = method.inner();
    let is_amg = matches!(inner, Some(InnerChoice::Amg(_)));
    let is_exact = matches!(inner, None | Some(InnerChoice::Exact { .. }));
    if let Some(rigid) = facts.rigid_body.filter(|r| r.wrong_rows > 0) {
        return format!(
            "the coordinates do not fit A in {} of {} free rows: correct them, multigrid builds on them",
            rigid.wrong_rows, rigid.free_rows
        );
    }
    if let Some(c) = facts.c_over_h.filter(|c| c.share_below > BELOW) {
        let (part, rule) = match c.asked < 1.0 {
            true => (
                format!("{:.0} % of H", 100.0 * c.asked),
                "\"fitted_h\", which adds as much of H to C as the cells need",
            ),
            false => ("H".into(), "\"local_h\", which adds H to C"),
        };
        return format!(
            "C is smaller than {part} in {:.0} % of the rows, by up to {:.1e}: take augmentation = {rule}",
            100.0 * c.share_below,
            c.asked / c.min
        );
    }
    if is_amg && facts.rigid_body.is_none() {
        return "multigrid knows no rotations: give the coordinates of the unknowns (coords.mtx)"
            .into();
    }
    let complex = facts.operator_complexity.filter(|c| is_amg && *c > COMPLEX);
    if let Some(complexity) = complex {
        return format!(
            "the coarse levels cost more than the finest (operator complexity {complexity:.2}): raise the strength threshold of \
             multigrid or take the other coarsening"
        );
    }
    if let Some(seen) = &facts.seen {
        if seen.settled == 0 {
            return format!(
                "no eigenvalue settled in {} steps, the spectrum is spread: take a stronger inner solver, or method = \"direct\"",
                seen.steps
            );
        }
        if let Some(kappa) = seen.kappa.filter(|k| *k > SPREAD) {
            let first = seen.outliers.first();
            let place = first.and_then(|o| o.place);
            let at = place.map_or(String::new(), |p| {
                let [x, y, z] = p.centre;
                let why = if p.contrast > CONTRAST {
                    format!(", where the stiffness varies by {:.0e}", p.contrast)
                } else {
                    String::new()
                };
                format!(" around ({x:.4}, {y:.4}, {z:.4}) m{why}")
            });
            let (part, remedy) = match (first, is_exact) {
                (Some(o), _) if o.pressure_share.is_some_and(|share| share > 0.5) => {
                    ("pressures", "another S_p")
                }
                (Some(o), _) if o.traction_share > 0.5 => ("tractions", "another augmentation"),
                (Some(_), true) => ("displacements", "another augmentation"),
                (Some(_), false) => (
                    "displacements",
                    "a stronger inner solver (exact, if memory allows)",
                ),
                (None, true) => ("", "another augmentation"),
                (None, false) => ("", "a stronger inner solver (exact, if memory allows)"),
            };
            return match first {
                Some(_) if seen.n_outliers <= FEW => format!(
                    "{} outliers stretch κ to {kappa:.1e}, the farthest in the {part}{at}: take {remedy}",
                    seen.n_outliers
                ),
                Some(_) => format!(
                    "κ is {kappa:.1e} with {} outliers, the farthest in the {part}{at}: take {remedy}",
                    seen.n_outliers
                ),
                None => format!(
                    "κ is {kappa:.1e} without outliers, the spectrum is spread: take {remedy}"
                ),
            };
        }
    }
    let time = &facts.time;
    let setup = time.other_setup_s + time.c_s.unwrap_or(0.0) + time.inner_s.unwrap_or(0.0);
    if setup > 1.0 && setup > SETUP * time.iterations_s {
        return format!(
            "set-up takes {:.0} % of the time: keep it for further right-hand sides, or take a cheaper inner solver",
            100.0 * setup / (setup + time.iterations_s)
        );
    }
    if facts.seen.is_none() {
        return "nothing stands out, but the eigenvalues were not measured (M is no linear map)"
            .into();
    }
    "nothing to gain but the tolerance".into()
}
