//! From the finest matrix to all levels.

use super::classical::Classical;
use super::coarse::{Coarse, Coarsener, NotPositive, SmoothedAggregation};
use super::coarsest::{Coarsest, NoInverse};
use super::finest::Finest;
use super::fsai_smoother;
use super::summary::{LevelSummary, Summary};
use super::sweeps::SweepMatrix;
use super::transfer::Transfer;
use super::{Amg, Coarsening, Smoother, Smoothing};
use crate::SetupError;
use crate::fsai::FsaiInverse;
use fracas_operators::Real;

/// Levels beyond which coarsening has plainly failed.
const MOST_LEVELS: usize = 30;

/// Unknowns up to which a level that does not get coarser is solved directly after all.
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

    /// Goes down from nodes of `group` block rows to coarse ones of N/3.
    fn descend<const N: usize, const K: usize>(&mut self, coarse: &Coarse<N, K>, group: usize) {
        let nodes = coarse.aggregates.first_nodes();
        let names = |node| std::iter::repeat_n(self.rows[node * group], N / 3);
        self.rows = nodes.into_iter().flat_map(names).collect();
    }

    /// Unknown of the finest level, from 1, for a scalar row.
    fn name(&self, row: usize) -> usize {
        (self.unknown)(3 * self.rows[row / 3] as usize + row % 3) + 1
    }

    /// A coarse diagonal block that is not positive definite.
    fn indefinite(&self, row: usize) -> SetupError {
        SetupError::NotPositiveDefinite {
            block: "A",
            row: self.name(row),
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

impl<R: Real> Hierarchy<R> {
    /// Coarsens until a direct solver takes over. `modes`: K near-null vectors, three rows per block row; `unknown(row)`
    /// names the unknown in a scalar row of the finest level.
    ///
    /// # Errors
    /// [`SetupError::NotPositiveDefinite`] or [`SetupError::Singular`] for a coarse matrix.
    pub(super) fn new<const K: usize>(
        settings: &Amg,
        finest: Finest<R>,
        modes: Vec<[[f64; K]; 3]>,
        near_null_space: &'static str,
        unknown: &dyn Fn(usize) -> usize,
    ) -> Result<Self, SetupError> {
        let build = match settings.coarsening {
            Coarsening::SmoothedAggregation => Self::coarsened::<SmoothedAggregation, K, K>,
            Coarsening::Classical => Self::coarsened::<Classical, 3, K>,
        };
        build(settings, finest, modes, near_null_space, unknown)
    }

    fn coarsened<C: Coarsener<N, K>, const N: usize, const K: usize>(
        settings: &Amg,
        finest: Finest<R>,
        modes: Vec<[[f64; K]; 3]>,
        near_null_space: &'static str,
        unknown: &dyn Fn(usize) -> usize,
    ) -> Result<Self, SetupError> {
        let Finest {
            matrix: first,
            defect,
            bonds,
            ..
        } = finest;
        let mut names = Representatives::new(first.rows(), unknown);
        let smoothing = Smoothing::new(settings, &first);
        let settings = &smoothing.in_settings(settings);
        let about = (near_null_space, smoothing);
        let mut levels = Vec::new();
        if 3 * first.rows() <= settings.coarsest {
            return Self::ending(levels, &first, &names, about);
        }
        let step = C::coarsen(settings, 0, &first, &defect, bonds.as_ref(), 1, &modes);
        let Some(mut coarse) = step.map_err(|NotPositive(row)| names.indefinite(row))? else {
            return Self::ending(levels, &first, &names, about);
        };
        levels.push(Level {
            fsai: names.smoother(settings, &first)?,
            matrix: first,
            transfer: Transfer::new(&coarse.prolongation, coarse.aggregates.count),
            lambda_max: coarse.lambda_max,
        });
        names.descend(&coarse, 1);
        let group = N / 3;
        while coarse.goes_on(settings) && levels.len() < MOST_LEVELS {
            let depth = levels.len();
            let bonds = coarse.bonds.as_ref();
            let step = C::coarsen(
                settings,
                depth,
                &coarse.matrix,
                &[],
                bonds,
                group,
                &coarse.modes,
            );
            let Some(next) = step.map_err(|NotPositive(row)| names.indefinite(row))? else {
                break;
            };
            levels.push(Level {
                fsai: names.smoother(settings, &coarse.matrix)?,
                matrix: coarse.matrix.cast(),
                transfer: Transfer::new(&next.prolongation, next.aggregates.count),
                lambda_max: next.lambda_max,
            });
            names.descend(&next, group);
            coarse = next;
        }
        Self::ending(levels, &coarse.matrix, &names, about)
    }

    fn ending<S: Real>(
        levels: Vec<Level<R>>,
        last: &SweepMatrix<S>,
        names: &Representatives<'_>,
        (near_null_space, smoothing): (&'static str, Smoothing),
    ) -> Result<Self, SetupError> {
        let n = 3 * last.rows();
        if n > LARGEST_DIRECT {
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
            near_null_space,
            smoothing,
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
