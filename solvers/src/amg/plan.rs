//! What of a hierarchy outlives a change of values.

use super::chains::smoothing;
use super::classical::Classical;
use super::coarse::{Coarsener, Known};
use super::finest::{Finest, Sum};
use super::hierarchy::{Names, Steps, build};
use super::matrix::NodeMatrix;
use super::node_map::{NONE, NodeMap};
use super::rigid_body::{constants, rigid_body_modes};
use super::smoothed::SmoothedAggregation;
use super::{Amg, Coarsening};
use crate::multigrid::{About, Hierarchy, MultigridInverse, Precision, SomeHierarchy};
use crate::{DofCoordinate, SetupError};
use fracas_operators::Real;
use fracas_operators::sparse::{Pattern, SparseMatrix};
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
    ) -> Result<MultigridInverse, SetupError> {
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
            Precision::F32 => self.built(&sum, SomeHierarchy::Single),
            Precision::F64 => self.built(&sum, SomeHierarchy::Double),
        }
    }

    fn built<R: Real>(
        &self,
        sum: &Sum<'_>,
        either: fn(Hierarchy<R>) -> SomeHierarchy,
    ) -> Result<MultigridInverse, SetupError> {
        let finest = sum.blocks::<R>(&self.map, self.pattern.clone())?;
        let scale = finest.scale;
        let unknown = |row| unknown(&self.map, row);
        let settings = &self.settings;
        let about = about(settings, &finest.matrix, &self.map);
        let hierarchy = match &self.steps {
            Planned::Rigid(steps) => again(settings, finest, steps, about, &unknown),
            Planned::Constants(steps) => again(settings, finest, steps, about, &unknown),
            Planned::ClassicalRigid(steps) => again(settings, finest, steps, about, &unknown),
            Planned::ClassicalConstants(steps) => again(settings, finest, steps, about, &unknown),
        }?;
        Ok(inverse(settings, &self.map, scale, either(hierarchy)))
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
    about: About,
    unknown: Names<'_>,
) -> Result<Hierarchy<R>, SetupError> {
    build(settings, finest, &mut Steps::Kept(steps), about, unknown)
}

/// One cycle of a hierarchy of the finest matrix divided by `scale`.
fn inverse(
    settings: &Amg,
    map: &NodeMap,
    scale: f64,
    hierarchy: SomeHierarchy,
) -> MultigridInverse {
    MultigridInverse::new(hierarchy, map.places(), scale, settings.over_correction)
}

/// The first hierarchy of a matrix, the steps that it took, and what `keep` makes of its nodes and the finest pattern.
pub(super) fn first<P>(
    settings: &Amg,
    sum: Sum<'_>,
    coordinates: Option<&[DofCoordinate]>,
    keep: impl FnOnce(&Arc<NodeMap>, &Pattern) -> P,
) -> Result<(MultigridInverse, Planned, P), SetupError> {
    let map = sum.map(coordinates);
    let pattern = sum.pattern(&map);
    let kept = keep(&map, &pattern);
    let (inverse, steps) = match settings.precision {
        Precision::F32 => new(settings, sum, &map, pattern, SomeHierarchy::Single),
        Precision::F64 => new(settings, sum, &map, pattern, SomeHierarchy::Double),
    }?;
    Ok((inverse, steps, kept))
}

fn new<R: Real>(
    settings: &Amg,
    sum: Sum<'_>,
    map: &NodeMap,
    pattern: Pattern,
    either: fn(Hierarchy<R>) -> SomeHierarchy,
) -> Result<(MultigridInverse, Planned), SetupError> {
    let finest = sum.blocks::<R>(map, pattern)?;
    let scale = finest.scale;
    let bonds = sum.bonds(map);
    drop(sum);
    let unknown = |row| unknown(map, row);
    let way = Way {
        settings,
        bonds,
        positions: map.positions().map(<[_]>::to_vec).unwrap_or_default(),
        about: about(settings, &finest.matrix, map),
        unknown: &unknown,
        finest,
    };
    let (hierarchy, steps) = match (settings.coarsening, map.positions()) {
        (Coarsening::SmoothedAggregation, Some(positions)) => {
            way.down(rigid_body_modes(map, positions), Planned::Rigid)
        }
        (Coarsening::SmoothedAggregation, None) => way.down(constants(map), Planned::Constants),
        (Coarsening::Classical, Some(positions)) => {
            way.down(rigid_body_modes(map, positions), Planned::ClassicalRigid)
        }
        (Coarsening::Classical, None) => way.down(constants(map), Planned::ClassicalConstants),
    }?;
    Ok((inverse(settings, map, scale, either(hierarchy)), steps))
}

/// What the first way down starts from.
struct Way<'a, R> {
    settings: &'a Amg,
    finest: Finest<R>,
    bonds: Option<Pattern>,
    positions: Vec<[f64; 3]>,
    about: About,
    unknown: Names<'a>,
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
        let hierarchy = build(
            self.settings,
            self.finest,
            &mut steps,
            self.about,
            self.unknown,
        )?;
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

/// What the coarse spaces hold, and what smooths the levels below this matrix; only aggregates heed where nodes are.
fn about<R: Real>(settings: &Amg, finest: &NodeMatrix<R>, map: &NodeMap) -> About {
    let positions = match settings.coarsening {
        Coarsening::SmoothedAggregation => map.positions().unwrap_or_default(),
        Coarsening::Classical => &[],
    };
    About {
        near_null_space: match map.positions() {
            Some(_) => "rigid-body modes",
            None => CONSTANTS,
        },
        smoothing: smoothing(settings, finest, positions),
    }
}
