//! The solver below the coarsest level.

use super::LevelSummary;
use super::direct::{Direct, Factors};
use crate::scratch::doubles_of;
use fracas_operators::{Preconditioner, Properties, Real};

/// `A⁻¹`, or an approximation of it, on the coarsest level.
pub struct Bottom<R> {
    solver: Solver<R>,
    n: usize,
    /// What it consists of.
    levels: Vec<LevelSummary>,
    /// What the coarse matrix maps to rounding, over all unknowns of the level.
    null: Option<Vec<f64>>,
}

enum Solver<R> {
    /// The inverse in the scalar of the levels, row by row.
    Rounded(Vec<R>),
    /// In f64, over the unknowns of the level that are free.
    Double {
        inverse: Box<dyn Preconditioner<f64>>,
        free: Vec<u32>,
    },
}

impl<R: Real> Bottom<R> {
    /// `inverse`, made of `levels`, over the unknowns `free` of a level of n.
    pub fn new(
        inverse: Box<dyn Preconditioner<f64>>,
        levels: Vec<LevelSummary>,
        free: Vec<u32>,
        n: usize,
    ) -> Self {
        assert_eq!(inverse.size(), free.len(), "free unknowns of another level");
        Self {
            solver: Solver::Double { inverse, free },
            n,
            levels,
            null: None,
        }
    }

    /// `A_c⁺` where functions of the coarsest level may depend on each other; in f64 whatever the levels are: an inverse rounded to
    /// f32 is indefinite from a condition of 10⁷ on.
    pub fn semidefinite(direct: Direct, free: Vec<u32>, n: usize) -> Self {
        let full = |null: &[f64]| {
            let mut full = vec![0.0; n];
            free.iter()
                .zip(null)
                .for_each(|(i, v)| full[*i as usize] = *v);
            full
        };
        let null = direct.null().map(full);
        let levels = vec![direct.summary()];
        Self {
            null,
            ..Self::new(Box::new(direct), levels, free, n)
        }
    }

    /// `A_c⁻¹` over all unknowns, in the scalar of the levels where the inverse is stored or its factors have the digits.
    pub fn definite(direct: Direct) -> Self {
        let direct = match size_of::<R>() < size_of::<f64>() {
            true => direct.rounded(),
            false => direct,
        };
        let n = direct.size();
        let summary = direct.summary();
        match direct.factors() {
            Factors::Dense(inverse) => {
                let scale = direct.scale();
                let value = |(k, v): (usize, &f64)| R::of(v * scale[k / n] * scale[k % n]);
                let inverse: Vec<R> = inverse.iter().enumerate().map(value).collect();
                let bytes = size_of_val(&*inverse);
                Self {
                    solver: Solver::Rounded(inverse),
                    n,
                    levels: vec![LevelSummary { bytes, ..summary }],
                    null: None,
                }
            }
            Factors::Sparse(_) | Factors::Single { .. } => {
                let free = (0..n as u32).collect();
                Self::new(Box::new(direct), vec![summary], free, n)
            }
        }
    }

    /// A random vector that the coarse matrix maps to rounding, where some functions are left out.
    pub(super) fn null(&self) -> Option<&[f64]> {
        self.null.as_deref()
    }

    /// Unknowns of the level, fixed ones included.
    pub fn size(&self) -> usize {
        self.n
    }

    /// What it consists of.
    pub(super) fn levels(&self) -> &[LevelSummary] {
        &self.levels
    }

    /// `x ← A⁻¹ b`, zero where fixed.
    pub(super) fn solve(&self, b: &[R], x: &mut [R], work: &mut [R]) {
        match &self.solver {
            Solver::Rounded(inverse) => {
                for (x, row) in x.iter_mut().zip(inverse.chunks_exact(self.n)) {
                    *x = short_dot(row, b);
                }
            }
            Solver::Double { inverse, free } => {
                let m = free.len();
                let (r, work) = doubles_of(work).split_at_mut(m);
                let (z, work) = work.split_at_mut(m);
                for (r, i) in r.iter_mut().zip(free) {
                    *r = b[*i as usize].to_f64_exact();
                }
                inverse.solve(r, z, work);
                x.fill(R::zero());
                for (z, i) in z.iter().zip(free) {
                    x[*i as usize] = R::of(*z);
                }
            }
        }
    }

    pub(super) fn work_len(&self) -> usize {
        match &self.solver {
            Solver::Rounded(_) => 0,
            Solver::Double { inverse, free } => {
                let entries = 2 * free.len() + inverse.work_len();
                // one more, because scratch of R need not start where an f64 may
                (entries + 1) * (size_of::<f64>() / size_of::<R>())
            }
        }
    }

    pub(super) fn properties(&self) -> Properties {
        match &self.solver {
            Solver::Rounded(_) => Properties::LINEAR,
            Solver::Double { inverse, .. } => inverse.properties(),
        }
    }

    pub(super) fn flops(&self) -> u64 {
        match &self.solver {
            Solver::Rounded(inverse) => 2 * inverse.len() as u64,
            Solver::Double { inverse, .. } => inverse.flops(),
        }
    }
}

/// Scalar product in eight independent sums.
fn short_dot<R: Real>(a: &[R], b: &[R]) -> R {
    let (a8, a) = a.as_chunks::<8>();
    let (b8, b) = b.as_chunks::<8>();
    let mut sums = [R::zero(); 8];
    for (a, b) in a8.iter().zip(b8) {
        for lane in 0..8 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let tail: R = a.iter().zip(b).map(|(a, b)| *a * *b).sum();
    sums.iter().copied().sum::<R>() + tail
}
