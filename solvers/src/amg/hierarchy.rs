//! From the finest matrix to all levels.

use super::coarse::{Coarsener, Frame, Known, NotPositive};
use super::coarsest::{Coarsest, NoInverse};
use super::finest::Finest;
use super::fsai_smoother;
use super::lambda::largest_eigenvalue;
use super::summary::{LevelSummary, Summary};
use super::sweeps::SweepMatrix;
use super::transfer::Transfer;
use super::{Amg, Smoother, Smoothing};
use crate::SetupError;
use crate::fsai::FsaiInverse;
use fracas_operators::Real;

/// Levels beyond which coarsening has plainly failed.
const MOST_LEVELS: usize = 30;

/// Unknowns up to which a level that does not get coarser is solved directly after all, where no larger one was asked for.
const LARGEST_DIRECT: usize = 30_000;

/// One level that smooths.
#[derive(Debug)]
pub(super) struct Level<R> {
    pub(super) matrix: SweepMatrix<R>,
    pub(super) transfer: Transfer<R>,
    /// Upper estimate of `λ_max(D⁻¹A)`.
    pub(super) lambda_max: f64,
    /// `ωGᵀG`, if that smooths.
    pub(super) fsai: Option<FsaiInverse<R>>,
}

/// All levels, finest first, and the direct solver below them.
#[derive(Debug)]
pub(super) struct Hierarchy<R> {
    pub(super) levels: Vec<Level<R>>,
    pub(super) coarsest: Coarsest<R>,
    near_null_space: &'static str,
    /// What smooths, and why.
    pub(super) smoothing: Smoothing,
}

/// A block row of the finest level that stands for each block row of a coarser one, to name rows in errors.
struct Representatives<'a> {
    rows: Vec<u32>,
    unknown: &'a dyn Fn(usize) -> usize,
}

impl<'a> Representatives<'a> {
    /// The block rows of the finest level; `unknown(row)` names the unknown in a scalar row of it.
    fn new(rows: usize, unknown: &'a dyn Fn(usize) -> usize) -> Self {
        Self {
            rows: (0..rows as u32).collect(),
            unknown,
        }
    }

    /// Goes down from nodes of `group` block rows to coarse ones of `next`.
    fn descend(&mut self, frame: &Frame, [group, next]: [usize; 2]) {
        let nodes = frame.aggregates.first_nodes();
        let names = |node| std::iter::repeat_n(self.rows[node * group], next);
        self.rows = nodes.into_iter().flat_map(names).collect();
    }

    /// Unknown of the finest level, from 1, for a scalar row.
    fn name(&self, row: usize) -> usize {
        (self.unknown)(3 * self.rows[row / 3] as usize + row % 3) + 1
    }

    /// A diagonal block of the next level, N unknowns per node, that is not positive definite.
    fn indefinite<const N: usize>(
        &self,
        NotPositive(row): NotPositive,
        frame: &Frame,
        group: usize,
    ) -> SetupError {
        let node = frame.aggregates.first_nodes()[row / N];
        SetupError::NotPositiveDefinite {
            block: "A",
            row: self.name(3 * node * group + row % 3),
            advice: "a coarse matrix lost positivity around this row: the matrix is indefinite, or its coordinates are not those of its nodes".into(),
        }
    }

    /// FSAI of this level's matrix, if that is to smooth.
    fn smoother<S: Real, R: Real>(
        &self,
        settings: &Amg,
        a: &SweepMatrix<S>,
    ) -> Result<Option<FsaiInverse<R>>, SetupError> {
        if settings.smoother != Smoother::Fsai {
            return Ok(None);
        }
        let named = |error| match error {
            SetupError::NotPositiveDefinite { block, row, advice } => {
                let row = self.name(row - 1);
                SetupError::NotPositiveDefinite { block, row, advice }
            }
            other => other,
        };
        fsai_smoother::smoother(a).map(Some).map_err(named)
    }
}

/// Where the steps of coarsening come from.
pub(super) enum Steps<'a, C, const K: usize> {
    /// Planned on the way down, from what is known of the level at hand.
    New { planned: Vec<C>, known: Known<K> },
    /// Of an earlier hierarchy.
    Kept(&'a [C]),
}

impl<C, const K: usize> Steps<'_, C, K> {
    /// The steps planned on the way.
    pub(super) fn planned(self) -> Vec<C> {
        match self {
            Self::New { planned, .. } => planned,
            Self::Kept(_) => Vec::new(),
        }
    }

    /// The step down from `a` at this depth, if another level is worth it.
    ///
    /// Planning is partly sequential: `λ_max(D⁻¹A)`, which the step needs next, is estimated beside it.
    fn next<S: Real, const N: usize>(
        &mut self,
        settings: &Amg,
        depth: usize,
        a: &SweepMatrix<S>,
    ) -> Option<(&C, f64)>
    where
        C: Coarsener<N, K>,
    {
        let (step, lambda_max) =
            rayon::join(|| self.step(settings, depth, a), || largest_eigenvalue(a));
        step.map(|step| (step, lambda_max))
    }

    fn step<S: Real, const N: usize>(
        &mut self,
        settings: &Amg,
        depth: usize,
        a: &SweepMatrix<S>,
    ) -> Option<&C>
    where
        C: Coarsener<N, K>,
    {
        match self {
            Self::Kept(steps) => steps.get(depth),
            Self::New { planned, known } => {
                let last = planned.last();
                let enough = last.map_or(settings.coarsest, |step| step.direct_below(settings));
                if 3 * a.rows() <= enough || depth == MOST_LEVELS {
                    return None;
                }
                let group = if depth == 0 { 1 } else { N / 3 };
                let plan = C::plan(settings, depth, a, known, group)?;
                *known = plan.known;
                planned.push(plan.step);
                planned.last()
            }
        }
    }
}

/// What is known before the levels are.
#[derive(Clone, Copy)]
pub(super) struct About<'a> {
    pub(super) near_null_space: &'static str,
    pub(super) smoothing: Smoothing,
    /// Names the unknown in a scalar row of the finest level.
    pub(super) unknown: &'a dyn Fn(usize) -> usize,
}

impl<R: Real> Hierarchy<R> {
    /// Coarsens until a direct solver takes over.
    ///
    /// # Errors
    /// [`SetupError::NotPositiveDefinite`] or [`SetupError::Singular`] for a coarse matrix.
    pub(super) fn new<C: Coarsener<N, K>, const N: usize, const K: usize>(
        settings: &Amg,
        finest: Finest<R>,
        steps: &mut Steps<'_, C, K>,
        about: &About<'_>,
    ) -> Result<Self, SetupError> {
        let Finest {
            matrix: first,
            defect,
            ..
        } = finest;
        let settings = &about.smoothing.in_settings(settings);
        let mut names = Representatives::new(first.rows(), about.unknown);
        let mut levels = Vec::new();
        let Some((step, lambda_max)) = steps.next(settings, 0, &first) else {
            return Self::ending(settings, levels, &first, &names, about);
        };
        let values = step.values::<R, R>(&first, &defect, lambda_max);
        let values = values.map_err(|e| names.indefinite::<N>(e, step.frame(), 1))?;
        drop(defect);
        levels.push(Level {
            fsai: names.smoother(settings, &first)?,
            matrix: first,
            transfer: values.transfer,
            lambda_max,
        });
        let next = N / 3;
        names.descend(step.frame(), [1, next]);
        let mut matrix = values.matrix;
        while let Some((step, lambda_max)) = steps.next(settings, levels.len(), &matrix) {
            let values = step.values::<f64, R>(&matrix, &[], lambda_max);
            let values = values.map_err(|e| names.indefinite::<N>(e, step.frame(), next))?;
            levels.push(Level {
                fsai: names.smoother(settings, &matrix)?,
                matrix: matrix.cast(),
                transfer: values.transfer,
                lambda_max,
            });
            names.descend(step.frame(), [next, next]);
            matrix = values.matrix;
        }
        Self::ending(settings, levels, &matrix, &names, about)
    }

    fn ending<S: Real>(
        settings: &Amg,
        levels: Vec<Level<R>>,
        last: &SweepMatrix<S>,
        names: &Representatives<'_>,
        about: &About<'_>,
    ) -> Result<Self, SetupError> {
        let n = 3 * last.rows();
        if n > LARGEST_DIRECT.max(settings.coarsest) {
            return Err(SetupError::NotApplicable {
                method: "amg",
                reason: format!(
                    "coarsening stopped at {n} unknowns because too few connections are strong; lower the strength threshold, \
                     or take the inner solver exact"
                ),
            });
        }
        let coarsest = Coarsest::new(last).map_err(|problem| match problem {
            NoInverse::Failed(error) => error,
            NoInverse::Singular(row) => SetupError::Singular {
                block: "A",
                row: Some(names.name(row)),
                advice: "a rigid-body mode costs no energy: a block of rock is held neither by boundary conditions nor by a fracture".into(),
            },
        })?;
        Ok(Self {
            levels,
            coarsest,
            near_null_space: about.near_null_space,
            smoothing: about.smoothing,
        })
    }

    /// Levels, complexities, bytes.
    pub(super) fn summary(&self) -> Summary {
        let smoothing = self.levels.iter().map(|level| LevelSummary {
            n: 3 * level.matrix.rows(),
            nnz: 9 * level.matrix.block_count(),
            bytes: level.matrix.bytes()
                + level.transfer.bytes()
                + level.fsai.as_ref().map_or(0, FsaiInverse::bytes),
        });
        let last = LevelSummary {
            n: self.coarsest.size(),
            nnz: self.coarsest.entries(),
            bytes: self.coarsest.bytes(),
        };
        let levels: Vec<LevelSummary> = smoothing.chain([last]).collect();
        let total = |of: fn(&LevelSummary) -> usize| {
            levels.iter().map(of).sum::<usize>() as f64 / of(&levels[0]).max(1) as f64
        };
        Summary {
            operator_complexity: total(|level| level.nnz),
            grid_complexity: total(|level| level.n),
            near_null_space: self.near_null_space,
            smoothing: self.smoothing,
            levels,
        }
    }
}
