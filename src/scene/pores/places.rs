//! Which points an element takes.

use super::cloud::Cloud;
use super::lattice::Lattice;
use super::nearest::Tree;
use rayon::prelude::*;

/// What of its own diameter, or of the spacing of points, an element may be away from the points. Unit: 1.
const REACH: f64 = 1.5;

/// Points where they lie.
pub(super) struct Places<'c> {
    points: &'c [[f64; 3]],
    order: Order,
    spacing: f64,
}

enum Order {
    Lattice(Lattice),
    Scattered(Tree),
}

/// The points that an element takes, with weights that add up to 1, and how far they are [m].
pub(super) type Taken = ([(u32, f64); 8], f64);

impl<'c> Places<'c> {
    /// Whether points are a lattice, and how far apart they are: the median diameter of the cells of a file, the diagonal of the median
    /// steps of a lattice, or the median distance to the nearest neighbour.
    pub(super) fn new(cloud: &'c Cloud) -> Self {
        let points = &cloud.points[..];
        let cells = cloud.cells.filter(|cells| *cells > 0.0);
        if let Some(lattice) = Lattice::of(points) {
            return Self {
                spacing: lattice.spacing().max(cells.unwrap_or(0.0)),
                order: Order::Lattice(lattice),
                points,
            };
        }
        let tree = Tree::new(points);
        let spacing = cells.unwrap_or_else(|| {
            let apart = (0..points.len() as u32).into_par_iter().map(|p| {
                let found = tree.nearest(points, points[p as usize], |other| other != p);
                found.map_or(0.0, |(_, distance)| distance)
            });
            median(apart.collect())
        });
        Self {
            spacing,
            order: Order::Scattered(tree),
            points,
        }
    }

    /// What an element with its centre at x [m] takes.
    pub(super) fn at(&self, x: [f64; 3]) -> Taken {
        match &self.order {
            Order::Lattice(lattice) => lattice.weights(x),
            Order::Scattered(tree) => {
                let (p, distance) = tree.nearest(self.points, x, |_| true).unwrap_or_default();
                let mut taken = [(p, 0.0); 8];
                taken[0].1 = 1.0;
                (taken, distance)
            }
        }
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
