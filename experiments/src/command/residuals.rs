//! The residuals of an iteration, kept while something else watches it.

use fracas_solvers::{Observer, Step};
use std::fmt::{Display, Write};
use std::ops::ControlFlow;

/// Passes everything on and keeps the residuals.
pub struct Residuals<'a> {
    watching: &'a mut dyn Observer,
    /// `‖r_k‖ / ‖b‖` of iteration k.
    kept: Vec<(usize, f64)>,
    /// Iterations before the present pass.
    before: usize,
}

impl<'a> Residuals<'a> {
    /// None yet.
    pub fn around(watching: &'a mut dyn Observer) -> Self {
        Self {
            watching,
            kept: Vec::new(),
            before: 0,
        }
    }

    /// Iteration, counted over all passes, and residual; a pass that goes on begins with its own residual.
    pub fn kept(&self) -> &[(usize, f64)] {
        &self.kept
    }

    /// `iteration,residual`.
    pub(super) fn to_csv(&self) -> String {
        let mut csv = String::from("iteration,residual\n");
        for (iteration, residual) in &self.kept {
            // a String takes everything
            let _ = writeln!(csv, "{iteration},{residual:e}");
        }
        csv
    }
}

impl Observer for Residuals<'_> {
    fn observe(&mut self, step: &Step) -> ControlFlow<()> {
        if let Step::Krylov {
            iteration,
            relative_residual,
        } = *step
        {
            if iteration == 0 {
                self.before = self.kept.last().map_or(0, |(last, _)| *last);
            }
            self.kept.push((self.before + iteration, relative_residual));
        }
        self.watching.observe(step)
    }

    fn say(&mut self, line: &dyn Display) {
        self.watching.say(line);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_solvers::Silent;

    #[test]
    fn iterations_are_counted_over_all_passes() {
        let mut silent = Silent;
        let mut residuals = Residuals::around(&mut silent);
        for (iteration, relative_residual) in [(0, 1.0), (1, 0.5), (2, 0.25), (0, 0.26), (1, 0.1)] {
            let step = Step::Krylov {
                iteration,
                relative_residual,
            };
            assert!(residuals.observe(&step).is_continue());
        }
        let expected = "iteration,residual\n0,1e0\n1,5e-1\n2,2.5e-1\n2,2.6e-1\n3,1e-1\n";
        assert_eq!(residuals.to_csv(), expected);
    }
}
