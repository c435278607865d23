//! From the finest matrix to all levels.

use super::Amg;
use super::coarse::{Coarsener, Frame, Known, NotPositive};
use super::finest::Finest;
use super::fsai::{self, FsaiSmoother};
use super::gauss_seidel::GaussSeidel;
use super::matrix::NodeMatrix;
use super::sweeps::Sweeps;
use crate::SetupError;
use crate::fsai::FsaiInverse;
use crate::multigrid::{
    About, BlockChebyshev, BlockJacobi, Bottom, Chebyshev, Direct, Hierarchy, Level, Scaled,
    Smooth, Smoother,
};
use fracas_operators::Real;
use fracas_operators::small::upper;

/// Smallest over largest eigenvalue of the interval on which a Chebyshev polynomial smooths. Unit: 1.
const SMOOTHED_SHARE: f64 = 1.0 / 20.0;

/// Levels beyond which coarsening has plainly failed.
const MOST_LEVELS: usize = 30;

/// Unknowns up to which a level that does not get coarser is solved directly after all, where no larger one was asked for. Without it
/// slabs of flat, graded cells have no hierarchy (`tests/multigrid/graded_slabs.rs`).
const LARGEST_DIRECT: usize = 30_000;

/// Names the unknown in a scalar row of the finest level.
pub(super) type Names<'a> = &'a dyn Fn(usize) -> usize;

/// A block row of the finest level that stands for each block row of a coarser one, to name rows in errors.
struct Representatives<'a> {
    rows: Vec<u32>,
    unknown: Names<'a>,
}

impl<'a> Representatives<'a> {
    /// The block rows of the finest level; `unknown(row)` names the unknown in a scalar row of it.
    fn new(rows: usize, unknown: Names<'a>) -> Self {
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
    fn fsai<S: Real, R: Real>(
        &self,
        settings: &Amg,
        a: &NodeMatrix<S>,
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
        fsai::inverse(a).map(Some).map_err(named)
    }
}

/// What smooths the level of a matrix with this λ_max(D⁻¹A); `fsai` where that does.
fn smoother<R: Real>(
    settings: &Amg,
    a: Sweeps<R>,
    lambda_max: f64,
    fsai: Option<FsaiInverse<R>>,
) -> Box<dyn Smooth<R>> {
    let steps = settings.sweeps.max(1);
    match (settings.smoother, fsai) {
        (_, Some(fsai)) => Box::new(FsaiSmoother::new(a, fsai, steps)),
        (Smoother::Chebyshev, None) => Box::new(chebyshev(a, lambda_max, steps)),
        _ => Box::new(GaussSeidel::new(a, steps)),
    }
}

/// A polynomial of degree `steps` in the D⁻¹A of a level.
fn chebyshev<R: Real>(a: Sweeps<R>, lambda_max: f64, steps: usize) -> BlockChebyshev<R> {
    let inverses = (0..a.rows()).map(|i| upper(a.inverse(i)));
    let jacobi = BlockJacobi::of_inverses(inverses.collect());
    let bytes = a.bytes();
    let polynomial = Chebyshev {
        degree: steps,
        share: SMOOTHED_SHARE,
    };
    BlockChebyshev::new(
        Scaled::new(Box::new(a), bytes, jacobi, lambda_max),
        polynomial,
    )
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
        a: &NodeMatrix<S>,
    ) -> Option<(&C, f64)>
    where
        C: Coarsener<N, K>,
    {
        let (step, lambda_max) =
            rayon::join(|| self.step(settings, depth, a), || a.largest_eigenvalue());
        step.map(|step| (step, lambda_max))
    }

    fn step<S: Real, const N: usize>(
        &mut self,
        settings: &Amg,
        depth: usize,
        a: &NodeMatrix<S>,
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

/// Coarsens until a direct solver takes over.
///
/// # Errors
/// [`SetupError::NotPositiveDefinite`] or [`SetupError::Singular`] for a coarse matrix.
pub(super) fn build<R: Real, C: Coarsener<N, K>, const N: usize, const K: usize>(
    settings: &Amg,
    finest: Finest<R>,
    steps: &mut Steps<'_, C, K>,
    about: About,
    unknown: Names<'_>,
) -> Result<Hierarchy<R>, SetupError> {
    let Finest {
        matrix: first,
        defect,
        ..
    } = finest;
    let settings = &Amg {
        smoother: about.smoothing.smoother,
        ..*settings
    };
    let mut names = Representatives::new(first.rows(), unknown);
    let mut levels = Vec::new();
    let mut most = LARGEST_DIRECT.max(settings.coarsest);
    let Some((step, lambda_max)) = steps.next(settings, 0, &first) else {
        let bottom = bottom(most, &first, &names)?;
        return Ok(Hierarchy::new(levels, bottom, settings.cycle, about));
    };
    most = most.max(step.direct_below(settings));
    let values = step.values::<R, R>(&first, defect, lambda_max);
    let values = values.map_err(|e| names.indefinite::<N>(e, step.frame(), 1))?;
    let fsai = names.fsai(settings, &first)?;
    // what the finest level no longer needs makes room for what it needs
    let smooth = smoother(settings, Sweeps::of(first), lambda_max, fsai);
    let transfer = step.frame().transfer(values.blocks);
    levels.push(Level::new(smooth, Box::new(transfer), Vec::new()));
    let next = N / 3;
    names.descend(step.frame(), [1, next]);
    let mut matrix = values.matrix;
    while let Some((step, lambda_max)) = steps.next(settings, levels.len(), &matrix) {
        most = most.max(step.direct_below(settings));
        let values = step.values::<f64, R>(&matrix, Vec::new(), lambda_max);
        let values = values.map_err(|e| names.indefinite::<N>(e, step.frame(), next))?;
        let fsai = names.fsai(settings, &matrix)?;
        let smooth = smoother(settings, Sweeps::new(&matrix), lambda_max, fsai);
        let transfer = step.frame().transfer(values.blocks);
        levels.push(Level::new(smooth, Box::new(transfer), Vec::new()));
        names.descend(step.frame(), [next, next]);
        matrix = values.matrix;
    }
    let bottom = bottom(most, &matrix, &names)?;
    Ok(Hierarchy::new(levels, bottom, settings.cycle, about))
}

/// The solver below the levels, of `most` unknowns at most.
fn bottom<S: Real, R: Real>(
    most: usize,
    last: &NodeMatrix<S>,
    names: &Representatives<'_>,
) -> Result<Bottom<R>, SetupError> {
    let n = 3 * last.rows();
    if n > most {
        return Err(SetupError::NotApplicable {
            method: "amg",
            reason: format!(
                "coarsening stopped at {n} unknowns because too few connections are strong; lower the strength threshold, \
                 or take the inner solver exact"
            ),
        });
    }
    let direct = Direct::definite(last.to_csr(|_| true)).map_err(|error| match error {
        SetupError::NotPositiveDefinite { row, .. } => SetupError::Singular {
            block: "A",
            row: Some(names.name(row - 1)),
            advice: "a motion costs no energy that rounding leaves: a block of rock is held neither by boundary conditions nor by a fracture, or a body is so slender, or \
                     its stiffness so unequal, that what holds it is lost; the inner solver exact bears more of that".into(),
        },
        other => other,
    })?;
    Ok(Bottom::definite(direct))
}
