//! What all methods share, and what one of your own may stand on: counting, the stopping test, true residuals and restarts.
//!
//! A method is a `cycle` that [`drive`] starts from the true residual: it makes products and solves through its [`Run`], ends every
//! iteration by [`Run::step`], and hands back where that says so and [`Run::ends`] agrees.

use super::{Breakdown, Candidate, Criteria, Judge, Outcome, Report, System, Watch};
use crate::{Observer, Step};
use fracas_operators::Real;
use fracas_operators::vector::{copy, norm_inf};

/// Why a cycle of a method handed back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The recurrence has nothing more to gain from this start: it believes to be below the tolerance or at rounding.
    Believed,
    /// The cycle is full, or its recurrence broke down after progress.
    Restart,
    /// No iterations left.
    Limit,
    /// The observer said stop.
    Stopped,
}

/// One solve in progress.
pub struct Run<'s, R> {
    method: &'static str,
    system: &'s System<'s, R>,
    criteria: &'s Criteria,
    observer: &'s mut dyn Observer,
    judge: Option<&'s mut dyn Judge<R>>,
    scratch: &'s mut [R],
    /// ‖b‖₂.
    norm_b: f64,
    /// ‖b − A x‖₂ where the running cycle began.
    start: f64,
    /// Residual norm that counts as converged.
    target: f64,
    /// ‖b − A x‖₂ of an x that the judge hands back.
    judged: Option<f64>,
    /// Recurrence's residual norm over ‖b‖.
    estimate: f64,
    iterations: usize,
    products: u64,
    solves: u64,
    smallest_ritz: Option<f64>,
}

/// Cuts the first `n` entries off `work`.
pub fn carve<'w, R>(work: &mut &'w mut [R], n: usize) -> &'w mut [R] {
    let (part, rest) = std::mem::take(work).split_at_mut(n);
    *work = rest;
    part
}

/// Scratch entries that [`drive`] needs for a cycle of `vectors` vectors.
pub fn work_len<R: Real>(system: &System<R>, vectors: usize) -> usize {
    system.scratch_len() + (1 + vectors) * system.size()
}

/// Runs `cycle(run, x, r = b − A x, work)` from the true residual until that residual meets the tolerance.
///
/// A cycle that believes in convergence where the true residual disagrees is started again from the current x, and
/// what it costs is counted; if what the residual exceeds the tolerance by did not even halve, it has stagnated at rounding.
pub fn drive<R: Real>(
    method: &'static str,
    system: &System<R>,
    criteria: &Criteria,
    x: &mut [R],
    watch: Watch<'_, R>,
    mut work: &mut [R],
    mut cycle: impl FnMut(&mut Run<R>, &mut [R], &mut [R], &mut [R]) -> Result<End, Breakdown>,
) -> Result<Report, Breakdown> {
    system.assert_fits(x);
    let norm_b = system.norm2(system.rhs).to_f64_exact();
    let mut run = Run {
        method,
        system,
        criteria,
        observer: watch.observer,
        judge: watch.judge.map(|judge| -> &mut dyn Judge<R> { judge }),
        scratch: carve(&mut work, system.scratch_len()),
        norm_b,
        start: 0.0,
        target: criteria.relative_tolerance * norm_b,
        judged: None,
        estimate: 0.0,
        iterations: 0,
        products: 0,
        solves: 0,
        smallest_ritz: None,
    };
    run.check_range()?;
    if run.norm_b == 0.0 {
        x.fill(R::zero());
        return Ok(run.report(Outcome::Converged, 0.0));
    }
    let r = carve(&mut work, system.size());
    let mut end = None;
    loop {
        let rho = match run.judged.take() {
            Some(rho) if rho <= run.target => rho,
            _ => run.residual(x, r)?,
        };
        let relative = rho / run.norm_b;
        if end.is_none() {
            run.estimate = relative;
            end = run.observe().then_some(End::Stopped);
        }
        if rho <= run.target {
            return Ok(run.report(Outcome::Converged, relative));
        }
        match end {
            Some(End::Stopped) => return Ok(run.report(Outcome::Stopped, relative)),
            // counted above the target: a cycle that begins close to it cannot halve all of its residual
            Some(End::Believed) if rho - run.target > 0.5 * (run.start - run.target) => {
                return Err(Breakdown::Stagnation {
                    method,
                    iteration: run.iterations,
                    relative_residual: relative,
                    smallest_ritz: run.smallest_ritz,
                });
            }
            _ if run.iterations >= criteria.max_iterations => {
                return Ok(run.report(Outcome::IterationLimit, relative));
            }
            _ => {}
        }
        run.start = rho;
        end = Some(cycle(&mut run, x, r, work)?);
    }
}

impl<R: Real> Run<'_, R> {
    /// Most iterations over all restarts.
    pub fn max_iterations(&self) -> usize {
        self.criteria.max_iterations
    }

    /// ‖r‖₂ where the running cycle began.
    pub fn start(&self) -> R {
        R::of(self.start)
    }

    /// `xᵀy`.
    pub fn dot(&self, x: &[R], y: &[R]) -> R {
        self.system.dot(x, y)
    }

    /// `‖x‖₂`.
    pub fn norm2(&self, x: &[R]) -> R {
        self.system.norm2(x)
    }

    /// Sums of every part become those of all.
    pub fn sum_over_parts(&self, sums: &mut [R]) {
        self.system.operator.sum_over_parts(sums);
    }

    /// `y ← A x`.
    pub fn product(&mut self, x: &[R], y: &mut [R]) {
        self.products += 1;
        self.system.operator.apply(x, y, self.scratch);
    }

    /// `z ← M⁻¹ r`.
    pub fn solve(&mut self, r: &[R], z: &mut [R]) {
        self.solves += 1;
        self.system.preconditioner.solve(r, z, self.scratch);
    }

    /// `r ← b − A x` and its norm; a zero start costs no product.
    fn residual(&mut self, x: &[R], r: &mut [R]) -> Result<f64, Breakdown> {
        copy(self.system.rhs, r);
        let is_zero = x.iter().all(|v| *v == R::zero());
        if self.system.is_anywhere(!is_zero) {
            self.products += 1;
            self.system
                .operator
                .apply_add(-R::one(), x, r, self.scratch);
        }
        let rho = self.norm2(r).to_f64_exact();
        if rho.is_finite() {
            Ok(rho)
        } else {
            Err(self.not_finite(self.iterations))
        }
    }

    /// Ends an iteration that believes in the residual norm `estimate`: counts, observes, and says whether to hand back.
    pub fn step(&mut self, estimate: R) -> Result<Option<End>, Breakdown> {
        self.finite(estimate)?;
        self.iterations += 1;
        self.estimate = estimate.to_f64_exact() / self.norm_b;
        Ok(if self.observe() {
            Some(End::Stopped)
        } else if self.is_small(estimate) {
            Some(End::Believed)
        } else if self.iterations >= self.criteria.max_iterations {
            Some(End::Limit)
        } else {
            None
        })
    }

    /// Whether a cycle at x is to hand back, as [`step`](Self::step) said; false where a judge lets it go on to a smaller residual.
    pub fn ends(&mut self, end: End, x: &[R]) -> bool {
        let is_met = end == End::Believed && self.estimate * self.norm_b <= self.target;
        let is_last = self.iterations >= self.criteria.max_iterations;
        let Some(judge) = self.judge.as_mut().filter(|_| is_met && !is_last) else {
            return true;
        };
        let candidate = Candidate {
            x,
            iteration: self.iterations,
            estimated_residual: self.estimate,
            smallest_ritz: self.smallest_ritz,
        };
        let verdict = judge.judge(&candidate, self.observer);
        // what is handed back has met what was asked for at first
        let asked = self.criteria.relative_tolerance;
        self.target = verdict.further.unwrap_or(asked) * self.norm_b;
        if verdict.further.is_none() {
            self.judged = Some(verdict.relative_residual * self.norm_b);
        }
        verdict.further.is_none()
    }

    /// Takes note of a Ritz value's modulus.
    pub fn ritz(&mut self, value: Option<R>) {
        if let Some(value) = value.map(|v| v.to_f64_exact()).filter(|v| v.is_finite()) {
            self.smallest_ritz = Some(self.smallest_ritz.map_or(value, |s| s.min(value)));
        }
    }

    /// True when a residual norm meets the tolerance, or is what rounding leaves of the cycle's first one.
    pub fn is_small(&self, norm: R) -> bool {
        let rounding = R::epsilon().to_f64_exact() * self.start;
        norm.to_f64_exact() <= self.target.max(rounding)
    }

    /// True when the observer wants to stop.
    fn observe(&mut self) -> bool {
        let step = Step::Krylov {
            iteration: self.iterations,
            relative_residual: self.estimate,
        };
        self.observer.observe(&step).is_break()
    }

    /// Iteration that is being computed, counted from 1.
    pub fn iteration(&self) -> usize {
        self.iterations + 1
    }

    /// Passes a number on, but not NaN or infinity.
    pub fn finite(&self, value: R) -> Result<R, Breakdown> {
        if value.is_finite() {
            Ok(value)
        } else {
            Err(self.not_finite(self.iteration()))
        }
    }

    fn not_finite(&self, iteration: usize) -> Breakdown {
        Breakdown::NotFinite {
            method: self.method,
            iteration,
        }
    }

    /// A vanished `product` of a short recurrence: start again from x if this cycle halved the residual, else give up.
    pub fn lanczos(&self, product: &'static str) -> Result<End, Breakdown> {
        if self.estimate * self.norm_b <= 0.5 * self.start {
            return Ok(End::Restart);
        }
        Err(Breakdown::Lanczos {
            method: self.method,
            iteration: self.iteration(),
            product,
        })
    }

    /// Refuses entries of b that are no numbers, or whose squares are none.
    fn check_range(&self) -> Result<(), Breakdown> {
        let largest = norm_inf(self.system.rhs).to_f64_exact();
        if self.system.is_anywhere(!largest.is_finite()) {
            return Err(self.not_finite(0));
        }
        // the squares of the residuals must stay normal numbers down to rounding
        let smallest = R::min_positive_value().sqrt().to_f64_exact();
        let is_nonzero = self.system.is_anywhere(largest > 0.0);
        if !self.norm_b.is_finite() || (is_nonzero && self.norm_b < smallest) {
            return Err(Breakdown::OutOfRange {
                method: self.method,
                largest,
                scalar: R::NAME,
            });
        }
        Ok(())
    }

    fn report(&self, outcome: Outcome, relative_residual: f64) -> Report {
        Report {
            outcome,
            iterations: self.iterations,
            relative_residual,
            estimated_residual: self.estimate,
            products: self.products,
            preconditioner_solves: self.solves,
            smallest_ritz: self.smallest_ritz,
        }
    }
}

/// Refuses a preconditioner that is not a fixed linear map.
pub fn require_linear<R: Real>(method: &'static str, system: &System<R>) -> Result<(), Breakdown> {
    if system.preconditioner.properties().linear {
        Ok(())
    } else {
        Err(Breakdown::NonlinearPreconditioner { method })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Silent;
    use fracas_operators::Identity;
    use fracas_operators::sparse::{Csr, SparseMatrix};

    /// Outcome where cycles that believe in convergence leave these true residuals, in units of the target.
    fn outcome(residuals: &[f64]) -> Result<Report, Breakdown> {
        let identity = Identity { n: 1 };
        let system = System {
            operator: &Csr::new(SparseMatrix::new((1, 1), vec![0, 1], vec![0], vec![1.0])),
            preconditioner: &identity,
            rhs: &[1.0],
        };
        let criteria = Criteria {
            relative_tolerance: 1e-8,
            max_iterations: 100,
        };
        let mut work = vec![0.0; work_len(&system, 0)];
        let mut left = residuals.iter();
        let cycle = |run: &mut Run<'_, f64>, x: &mut [f64], _: &mut [f64], _: &mut [f64]| {
            run.iterations += 1;
            x[0] = 1.0 - 1e-8 * left.next().expect("another cycle");
            Ok(End::Believed)
        };
        drive(
            "test",
            &system,
            &criteria,
            &mut [0.0],
            Watch::of(&mut Silent),
            &mut work,
            cycle,
        )
    }

    #[test]
    fn a_cycle_that_begins_close_to_the_target_need_not_halve_its_residual() {
        let report = outcome(&[1.6, 1.2, 1.0003, 0.9]).expect("progress in every cycle");
        assert_eq!((report.outcome, report.iterations), (Outcome::Converged, 4));
    }

    #[test]
    fn a_cycle_without_progress_has_stagnated() {
        for residuals in [&[1.6, 1.5][..], &[1e7, 0.9e7], &[1.6, 1.2, 1.15]] {
            let stagnated = matches!(outcome(residuals), Err(Breakdown::Stagnation { .. }));
            assert!(stagnated, "{residuals:?}");
        }
    }
}
