//! What of a hierarchy outlives a change of values.

use super::classical::Classical;
use super::coarse::{Coarsener, Known};
use super::finest::{Finest, Sum};
use super::hierarchy::{About, Hierarchy, Steps};
use super::inverse::Either;
use super::node_map::{NONE, NodeMap};
use super::rigid_body::{constants, rigid_body_modes};
use super::rows::Pattern;
use super::smoothed::SmoothedAggregation;
use super::sweeps::SweepMatrix;
use super::{Amg, AmgInverse, Coarsening, Precision, Smoothing};
use crate::{DofCoordinate, SetupError};
use fracas_operators::Real;
use fracas_operators::sparse::SparseMatrix;
use std::sync::Arc;

/// Without coordinates nothing but translations is known of the rigid-body modes.
const CONSTANTS: &str = "constants (no coordinates)";

/// Nodes, patterns, coarse unknowns and the bases of their modes: the symbolic part of a hierarchy, kept to build others of the
/// same pattern. Strong connections stay those of the first matrix.
#[derive(Clone, Debug)]
pub struct AmgPlan {
    pub(super) settings: Amg,
    pub(super) map: Arc<NodeMap>,
    /// Of the finest level.
    pub(super) pattern: Pattern,
    pub(super) steps: Planned,
}

/// The steps down, by kind of coarsening and number of modes.
#[derive(Clone, Debug)]
pub(super) enum Planned {
    Rigid(Vec<SmoothedAggregation<6>>),
    Constants(Vec<SmoothedAggregation<3>>),
    ClassicalRigid(Vec<Classical<6>>),
    ClassicalConstants(Vec<Classical<3>>),
}

impl AmgPlan {
    /// The hierarchy of other values: `A + F Fᵀ` with node blocks where the first matrix had them; absent ones count as zero.
    ///
    /// # Cost
    /// Values alone: no aggregates, no modes, no patterns are looked for.
    ///
    /// # Errors
    /// [`SetupError::NotApplicable`] for an entry outside the pattern or another size; else as [`Amg::build`].
    pub fn refresh(
        &self,
        a: &SparseMatrix<f64>,
        f: Option<&SparseMatrix<f64>>,
    ) -> Result<AmgInverse, SetupError> {
        let sum = Sum::new(a, f)?;
        let n = self.map.unknowns_len();
        if a.rows() != n {
            return Err(SetupError::NotApplicable {
                method: "refreshing a hierarchy",
                reason: format!(
                    "it has {n} unknowns, the matrix {}; build a new one",
                    a.rows()
                ),
            });
        }
        match self.settings.precision {
            Precision::F32 => self.built(&sum, Either::Single),
            Precision::F64 => self.built(&sum, Either::Double),
        }
    }

    fn built<R: Real>(
        &self,
        sum: &Sum<'_>,
        either: fn(Hierarchy<R>) -> Either,
    ) -> Result<AmgInverse, SetupError> {
        let finest = sum.blocks::<R>(&self.map, self.pattern.clone())?;
        let scale = finest.scale;
        let unknown = |row| unknown(&self.map, row);
        let about = About {
            near_null_space: near_null_space(&self.map),
            smoothing: smoothing(&self.settings, &finest.matrix, &self.map),
            unknown: &unknown,
        };
        let settings = &self.settings;
        let hierarchy = match &self.steps {
            Planned::Rigid(steps) => again(settings, finest, steps, &about),
            Planned::Constants(steps) => again(settings, finest, steps, &about),
            Planned::ClassicalRigid(steps) => again(settings, finest, steps, &about),
            Planned::ClassicalConstants(steps) => again(settings, finest, steps, &about),
        }?;
        let map = self.map.clone();
        Ok(AmgInverse::new(settings, map, scale, either(hierarchy)))
    }

    /// Those of the first hierarchy.
    pub fn settings(&self) -> Amg {
        self.settings
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let steps: usize = match &self.steps {
            Planned::Rigid(steps) => steps.iter().map(Coarsener::bytes).sum(),
            Planned::Constants(steps) => steps.iter().map(Coarsener::bytes).sum(),
            Planned::ClassicalRigid(steps) => steps.iter().map(Coarsener::bytes).sum(),
            Planned::ClassicalConstants(steps) => steps.iter().map(Coarsener::bytes).sum(),
        };
        self.pattern.bytes() + steps
    }
}

fn again<R: Real, C: Coarsener<N, K>, const N: usize, const K: usize>(
    settings: &Amg,
    finest: Finest<R>,
    steps: &[C],
    about: &About<'_>,
) -> Result<Hierarchy<R>, SetupError> {
    Hierarchy::new(settings, finest, &mut Steps::Kept(steps), about)
}

/// The first hierarchy of a matrix, the steps that it took, and what `keep` makes of the finest pattern.
pub(super) fn first<P>(
    settings: &Amg,
    sum: &Sum<'_>,
    coordinates: Option<&[DofCoordinate]>,
    keep: impl FnOnce(&Pattern) -> P,
) -> Result<(AmgInverse, Planned, P), SetupError> {
    let map = Arc::new(NodeMap::new(sum.a, coordinates));
    let pattern = sum.pattern(&map);
    let kept = keep(&pattern);
    let (inverse, steps) = match settings.precision {
        Precision::F32 => new(settings, sum, map, pattern, Either::Single),
        Precision::F64 => new(settings, sum, map, pattern, Either::Double),
    }?;
    Ok((inverse, steps, kept))
}

fn new<R: Real>(
    settings: &Amg,
    sum: &Sum<'_>,
    map: Arc<NodeMap>,
    pattern: Pattern,
    either: fn(Hierarchy<R>) -> Either,
) -> Result<(AmgInverse, Planned), SetupError> {
    let finest = sum.blocks::<R>(&map, pattern)?;
    let scale = finest.scale;
    let unknown = |row| unknown(&map, row);
    let way = Way {
        settings,
        bonds: sum.bonds(&map),
        positions: map.positions().map(<[_]>::to_vec).unwrap_or_default(),
        about: About {
            near_null_space: near_null_space(&map),
            smoothing: smoothing(settings, &finest.matrix, &map),
            unknown: &unknown,
        },
        finest,
    };
    let (hierarchy, steps) = match (settings.coarsening, map.positions()) {
        (Coarsening::SmoothedAggregation, Some(positions)) => {
            way.down(rigid_body_modes(&map, positions), Planned::Rigid)
        }
        (Coarsening::SmoothedAggregation, None) => way.down(constants(&map), Planned::Constants),
        (Coarsening::Classical, Some(positions)) => {
            way.down(rigid_body_modes(&map, positions), Planned::ClassicalRigid)
        }
        (Coarsening::Classical, None) => way.down(constants(&map), Planned::ClassicalConstants),
    }?;
    let inverse = AmgInverse::new(settings, map, scale, either(hierarchy));
    Ok((inverse, steps))
}

/// What the first way down starts from.
struct Way<'a, R> {
    settings: &'a Amg,
    finest: Finest<R>,
    bonds: Option<Pattern>,
    positions: Vec<[f64; 3]>,
    about: About<'a>,
}

impl<R: Real> Way<'_, R> {
    fn down<C: Coarsener<N, K>, const N: usize, const K: usize>(
        self,
        modes: Vec<[[f64; K]; 3]>,
        kind: fn(Vec<C>) -> Planned,
    ) -> Result<(Hierarchy<R>, Planned), SetupError> {
        let mut steps = Steps::New {
            planned: Vec::new(),
            known: Known {
                bonds: self.bonds,
                modes,
                positions: self.positions,
            },
        };
        let hierarchy = Hierarchy::new(self.settings, self.finest, &mut steps, &self.about)?;
        Ok((hierarchy, kind(steps.planned())))
    }
}

/// The unknown in a scalar row of node blocks; an empty slot is named by a neighbour in its node.
fn unknown(map: &NodeMap, row: usize) -> usize {
    let of_node = map.of_node(row / 3);
    let own = of_node[row % 3];
    let any = of_node.iter().copied().min().unwrap_or(0);
    if own == NONE {
        any as usize
    } else {
        own as usize
    }
}

/// What smooths the levels below this matrix; only aggregates heed where nodes are.
fn smoothing<R: Real>(settings: &Amg, finest: &SweepMatrix<R>, map: &NodeMap) -> Smoothing {
    let positions = match settings.coarsening {
        Coarsening::SmoothedAggregation => map.positions().unwrap_or_default(),
        Coarsening::Classical => &[],
    };
    Smoothing::new(settings, finest, positions)
}

fn near_null_space(map: &NodeMap) -> &'static str {
    match map.positions() {
        Some(_) => "rigid-body modes",
        None => CONSTANTS,
    }
}
