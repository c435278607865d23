//! What the systems and the fluid of a run tell, from the rows of its `solver.csv` and `flow.csv`.

use super::csv::{columns, number};
use crate::rates::{self, median, to_eight_digits};

/// Median of the iterations per factor of 1e-8 of the residual, of all systems from step `first` on; none where none tells it.
///
/// # Errors
/// Of a column that is missing, and of what is no number.
pub(super) fn krylov_median(text: &str, first: usize) -> anyhow::Result<Option<usize>> {
    const FILE: &str = "solver.csv";
    const NAMES: [&str; 4] = ["step", "krylov", "iterations", "relative_residual"];
    let mut told = Vec::new();
    for (k, row) in columns(FILE, text, NAMES)?.iter().enumerate() {
        let [step, krylov, iterations, residual] = row;
        let step: usize = number(FILE, k, NAMES[0], step)?;
        let iterations = number(FILE, k, NAMES[2], iterations)?;
        let residual = number(FILE, k, NAMES[3], residual)?;
        if step >= first {
            told.extend(to_eight_digits(krylov, iterations, residual));
        }
    }
    Ok(median(told))
}

/// Balance errors of all steps together over what was injected; none where nothing flows or nothing was injected. Unit: 1.
///
/// # Errors
/// Of a column that is missing, and of what is no number.
pub(super) fn lost(text: &str) -> anyhow::Result<Option<f64>> {
    const FILE: &str = "flow.csv";
    const NAMES: [&str; 2] = ["injected_m3", "balance_error_m3"];
    let mut steps = Vec::new();
    for (k, [injected, error]) in columns(FILE, text, NAMES)?.iter().enumerate() {
        steps.push([
            number(FILE, k, NAMES[0], injected)?,
            number(FILE, k, NAMES[1], error)?,
        ]);
    }
    Ok(rates::lost(steps))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn systems_that_tell_nothing_are_left_out() {
        let heading = "step,krylov,iterations,relative_residual\n";
        let rows = "0,fgmres,90,1e-8\n1,fgmres,10,1e-8\n1,direct,1,1e-15\n2,fgmres,30,1e-3\n2,fgmres,12,1e-6\n2,fgmres,20,1e-8\n";
        assert_eq!(
            krylov_median(&format!("{heading}{rows}"), 1).unwrap(),
            Some(16)
        );
        assert_eq!(krylov_median(heading, 1).unwrap(), None);
        assert_eq!(krylov_median("", 1).unwrap(), None);
        let torn = format!("{heading}1,fgmres,x,1e-8\n");
        let error = krylov_median(&torn, 1).unwrap_err().to_string();
        assert_eq!(
            error,
            "solver.csv, line 2: iterations is \"x\", not a number"
        );
    }

    #[test]
    fn fluid_is_counted_over_the_whole_run() {
        let heading = "step,injected_m3,balance_error_m3\n";
        let rows = "1,2.0,1e-3\n2,2.0,-3e-3\n";
        assert_eq!(lost(&format!("{heading}{rows}")).unwrap(), Some(5e-4));
        assert_eq!(lost(heading).unwrap(), None);
        assert_eq!(lost("").unwrap(), None);
    }
}
