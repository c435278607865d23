//! Which points an element takes.

use super::PoreProblem;
use super::cells::{CellTree, Centered, Shapes};
use super::cloud::{Cloud, Origin};
use super::lattice::Lattice;
use super::nearest::Tree;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What of its own diameter, or of the spacing of points, an element may be away from the points. Unit: 1.
const REACH: f64 = 1.5;

/// What an element takes of the points, or cells, of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Interpolation {
    /// The trilinear value between the points, or the centres of cells, of a full lattice.
    Linear,
    /// The pressure of the cell that holds its centre, else of the nearest cell or point.
    Nearest,
}

/// Points where they lie.
pub(super) struct Places {
    points: Vec<[f64; 3]>,
    numbers: Vec<usize>,
    shapes: Option<Shapes>,
    order: Order,
    spacing: f64,
}

enum Order {
    Lattice(Lattice),
    Cells(CellTree),
    Scattered(Tree),
}

/// What an element takes, and how far from its centre that is [m].
pub(super) enum Taken {
    /// The pressure of a point.
    One(u32, f64),
    /// What lies between the points of a lattice.
    Between(f64),
}

impl Places {
    /// Whether points are a lattice, and how far apart they are: the median diameter of the cells of a file, the diagonal of the median
    /// steps of a lattice, or the median distance to the nearest neighbour. Takes the points out of the cloud.
    ///
    /// # Errors
    /// [`PoreProblem::NoLattice`] where linear values are asked for and points are none.
    pub(super) fn new(
        cloud: &mut Cloud,
        asked: Option<Interpolation>,
    ) -> Result<Self, PoreProblem> {
        let points = &cloud.points[..];
        let cells = cloud.cells.filter(|cells| *cells > 0.0);
        let lattice = Lattice::of(points);
        if lattice.is_none() && asked == Some(Interpolation::Linear) {
            return Err(PoreProblem::NoLattice {
                file: cloud.file.clone(),
                points: points.len(),
                what: match cloud.origin {
                    Origin::Cell => "the centres of its cells",
                    Origin::Point | Origin::Record => "its points",
                },
            });
        }
        let of_lattice = lattice
            .as_ref()
            .map(|own| own.spacing().max(cells.unwrap_or(0.0)));
        let order = match (&cloud.shapes, lattice) {
            (None, Some(lattice)) if asked != Some(Interpolation::Nearest) => {
                Order::Lattice(lattice)
            }
            (Some(_), Some(lattice)) if asked == Some(Interpolation::Linear) => {
                Order::Lattice(lattice)
            }
            (Some(shapes), _) => Order::Cells(CellTree::new(Centered {
                shapes,
                centers: points,
                numbers: &cloud.numbers,
            })),
            (None, _) => Order::Scattered(Tree::new(points)),
        };
        let apart = |tree: &Tree| {
            let apart = (0..points.len() as u32).into_par_iter().map(|p| {
                let found = tree.nearest(points, points[p as usize], |other| other != p);
                found.map_or(0.0, |(_, distance)| distance)
            });
            median(apart.collect())
        };
        Ok(Self {
            spacing: of_lattice.or(cells).unwrap_or_else(|| match &order {
                Order::Scattered(tree) => apart(tree),
                Order::Lattice(_) | Order::Cells(_) => 0.0,
            }),
            points: std::mem::take(&mut cloud.points),
            numbers: std::mem::take(&mut cloud.numbers),
            shapes: cloud.shapes.take(),
            order,
        })
    }

    /// Whether the points are those of a cloud.
    pub(super) fn are_of(&self, cloud: &Cloud) -> bool {
        self.points == cloud.points && self.numbers == cloud.numbers && self.shapes == cloud.shapes
    }

    /// What an element with its centre at x [m] takes.
    pub(super) fn at(&self, x: [f64; 3]) -> Taken {
        match (&self.order, &self.shapes) {
            (Order::Lattice(lattice), _) => Taken::Between(lattice.weights(x).1),
            (Order::Cells(tree), Some(shapes)) => {
                let (p, distance) = tree.at(
                    Centered {
                        shapes,
                        centers: &self.points,
                        numbers: &self.numbers,
                    },
                    x,
                );
                Taken::One(p, distance)
            }
            (Order::Scattered(tree), _) => {
                let found = tree.nearest(&self.points, x, |_| true);
                let (p, distance) = found.unwrap_or_default();
                Taken::One(p, distance)
            }
            (Order::Cells(_), None) => unreachable!("a tree is of shapes"),
        }
    }

    /// The value at x [m] between points of a lattice; `None` where they are none.
    pub(super) fn between(&self, x: [f64; 3], pressures: &[f64]) -> Option<f64> {
        let Order::Lattice(lattice) = &self.order else {
            return None;
        };
        let (weights, _) = lattice.weights(x);
        let each = weights.iter().filter(|(_, weight)| *weight != 0.0);
        Some(
            each.map(|(p, weight)| weight * pressures[*p as usize])
                .sum(),
        )
    }

    /// How far from the points the centre of an element of this diameter may be [m].
    pub(super) fn bound(&self, diameter: f64) -> f64 {
        REACH * diameter.max(self.spacing)
    }

    /// For a person.
    pub(super) fn text(&self) -> String {
        match &self.order {
            Order::Lattice(lattice) => {
                let [x, y, z] = lattice.counts();
                format!("the linear value between points of a lattice of {x} x {y} x {z}")
            }
            Order::Cells(_) => {
                format!("the cell of {} that holds their centre", self.points.len())
            }
            Order::Scattered(_) => format!("the nearest of {} points", self.points.len()),
        }
    }
}

/// The middle one of some numbers; 0 of none.
pub(super) fn median(mut numbers: Vec<f64>) -> f64 {
    let middle = numbers.len() / 2;
    match numbers.is_empty() {
        true => 0.0,
        false => *numbers.select_nth_unstable_by(middle, f64::total_cmp).1,
    }
}
