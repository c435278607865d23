//! From the finest matrix to all levels.

use super::Amg;
use super::coarse::{Coarse, NotPositive, coarsen};
use super::coarsest::{Coarsest, NoInverse};
use super::finest::Finest;
use super::node_map::NONE;
use super::summary::{LevelSummary, Summary};
use super::sweeps::SweepMatrix;
use super::transfer::Transfer;
use crate::SetupError;
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
}

/// All levels, finest first, and the direct solver below them.
#[derive(Debug)]
pub(super) struct Hierarchy<R> {
    pub(super) levels: Vec<Level<R>>,
    pub(super) coarsest: Coarsest<R>,
    near_null_space: &'static str,
}

/// A block row of the finest level that stands for each block row of a coarser one, to name rows in errors.
struct Representatives<'a> {
    rows: Vec<u32>,
    unknown: &'a dyn Fn(usize) -> usize,
}

impl Representatives<'_> {
    fn descend<const K: usize>(&mut self, coarse: &Coarse<K>, group: usize) {
        let parts = K / 3;
        let mut next = vec![0; coarse.aggregates.count * parts];
        for (node, aggregate) in coarse.aggregates.of.iter().enumerate().rev() {
            if *aggregate != NONE {
                next[*aggregate as usize * parts..][..parts].fill(self.rows[node * group]);
            }
        }
        self.rows = next;
    }

    /// Unknown of the finest level, from 1, for a scalar row.
    fn name(&self, row: usize) -> usize {
        (self.unknown)(3 * self.rows[row / 3] as usize + row % 3) + 1
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
        let Finest {
            matrix: first,
            defect,
            bonds,
            ..
        } = finest;
        let mut names = Representatives {
            rows: (0..first.rows() as u32).collect(),
            unknown,
        };
        let mut levels = Vec::new();
        if 3 * first.rows() <= settings.coarsest {
            return Self::ending(levels, &first, &names, near_null_space);
        }
        let indefinite = |names: &Representatives<'_>, row| {
            SetupError::NotPositiveDefinite {
            block: "A",
            row: names.name(row),
            advice: "a coarse matrix lost positivity around this row: the matrix is indefinite, or its coordinates are not those of its nodes".into(),
        }
        };
        let step = coarsen(settings, 0, &first, &defect, bonds.as_ref(), 1, &modes);
        let Some(mut coarse) = step.map_err(|NotPositive(row)| indefinite(&names, row))? else {
            return Self::ending(levels, &first, &names, near_null_space);
        };
        names.descend(&coarse, 1);
        levels.push(Level {
            matrix: first,
            transfer: Transfer::new(&coarse.prolongation, coarse.aggregates.count),
            lambda_max: coarse.lambda_max,
        });
        let group = K / 3;
        while coarse.goes_on(settings) && levels.len() < MOST_LEVELS {
            let depth = levels.len();
            let bonds = coarse.bonds.as_ref();
            let step = coarsen(
                settings,
                depth,
                &coarse.matrix,
                &[],
                bonds,
                group,
                &coarse.modes,
            );
            let Some(next) = step.map_err(|NotPositive(row)| indefinite(&names, row))? else {
                break;
            };
            names.descend(&next, group);
            levels.push(Level {
                matrix: coarse.matrix.cast(),
                transfer: Transfer::new(&next.prolongation, next.aggregates.count),
                lambda_max: next.lambda_max,
            });
            coarse = next;
        }
        Self::ending(levels, &coarse.matrix, &names, near_null_space)
    }

    fn ending<S: Real>(
        levels: Vec<Level<R>>,
        last: &SweepMatrix<S>,
        names: &Representatives<'_>,
        near_null_space: &'static str,
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
        })
    }

    /// Levels, complexities, bytes.
    pub(super) fn summary(&self) -> Summary {
        let smoothing = self.levels.iter().map(|level| LevelSummary {
            n: 3 * level.matrix.rows(),
            nnz: 9 * level.matrix.block_count(),
            bytes: level.matrix.bytes() + level.transfer.bytes(),
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
            levels,
        }
    }
}
