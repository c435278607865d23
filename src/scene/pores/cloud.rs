//! Points and their pressures.

use super::PoreProblem;
use super::cells::Shapes;

/// What a point of a file is, for messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    /// The centre of a cell, counted from 0 as VTK does.
    Cell,
    /// A point, counted from 0.
    Point,
    /// A record of a CSV file.
    Record,
}

/// Points with a pressure at each of some times.
#[derive(Clone, Debug)]
pub(super) struct Cloud {
    /// The file that they stand in.
    pub(super) file: String,
    pub(super) origin: Origin,
    /// Where each stands in the file: number of its cell or point, or its row.
    pub(super) numbers: Vec<usize>,
    /// Places [m].
    pub(super) points: Vec<[f64; 3]>,
    /// Per time a pressure per point [Pa].
    pub(super) pressures: Vec<Vec<f64>>,
    /// Median diameter of the cells around them [m], where there are cells.
    pub(super) cells: Option<f64>,
    /// The cells themselves, by their numbers, where the points are their centres.
    pub(super) shapes: Option<Shapes>,
}

impl Cloud {
    /// Name of a point for messages.
    pub(super) fn name(origin: Origin, number: usize) -> String {
        let what = match origin {
            Origin::Cell => "cell",
            Origin::Point => "point",
            Origin::Record => "row",
        };
        format!("{what} {number}")
    }

    /// One point per place.
    ///
    /// # Errors
    /// [`PoreProblem::NoPoint`], or [`PoreProblem::SamePlace`] where two at one place differ in pressure; those of meshes with split nodes
    /// agree.
    pub(super) fn distinct(mut self) -> Result<Self, PoreProblem> {
        if self.points.is_empty() {
            return Err(PoreProblem::NoPoint { file: self.file });
        }
        // 0 and −0 are one place
        (self.points.iter_mut().flatten()).for_each(|x| *x += 0.0);
        let mut order: Vec<usize> = (0..self.points.len()).collect();
        let key = |p: usize| self.points[p];
        order.sort_by(|a, b| {
            let pairs = key(*a).into_iter().zip(key(*b));
            let by_place = pairs.map(|(a, b)| a.total_cmp(&b));
            by_place
                .reduce(std::cmp::Ordering::then)
                .unwrap_or(std::cmp::Ordering::Equal)
                .then(a.cmp(b))
        });
        let mut keep = vec![true; self.points.len()];
        for pair in order.windows(2) {
            let [first, second] = [pair[0], pair[1]];
            if key(first) != key(second) {
                continue;
            }
            if self.pressures.iter().any(|p| p[first] != p[second]) {
                return Err(PoreProblem::SamePlace {
                    first: Self::name(self.origin, self.numbers[first]),
                    second: Self::name(self.origin, self.numbers[second]),
                    at: key(first),
                    file: self.file,
                });
            }
            keep[second] = false;
        }
        retain(&mut self.points, &keep);
        retain(&mut self.numbers, &keep);
        (self.pressures.iter_mut()).for_each(|pressures| retain(pressures, &keep));
        Ok(self)
    }
}

fn retain<T>(list: &mut Vec<T>, keep: &[bool]) {
    let mut flags = keep.iter();
    list.retain(|_| flags.next().is_some_and(|keep| *keep));
}
