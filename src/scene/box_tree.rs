//! Boxes in a tree: which of them are near a place.

use std::ops::Range;

/// Lowest and highest coordinates [m].
pub(super) type Bounds = [[f64; 3]; 2];

/// The bounds of nothing.
pub(super) const NOWHERE: Bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];

/// The box around two.
pub(super) fn union(a: &Bounds, b: &Bounds) -> Bounds {
    [
        [0, 1, 2].map(|d: usize| a[0][d].min(b[0][d])),
        [0, 1, 2].map(|d: usize| a[1][d].max(b[1][d])),
    ]
}

/// Boxes in the order of a balanced tree of their centres, and the box around those of every range.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BoxTree {
    order: Vec<u32>,
    /// At the place of the middle one of a range.
    around: Vec<Bounds>,
}

/// Puts the middle one of a range in its place along the axis of its largest extent, then of its halves. Where many lie on one plane, as in grids,
/// the next axes decide, so that boxes of halves overlap in that plane alone.
fn sort(range: &mut [u32], centers: &[[f64; 3]]) {
    if range.len() < 2 {
        return;
    }
    let all = range.iter().map(|p| centers[*p as usize]);
    let [low, high] = all.fold(NOWHERE, |all, x| union(&all, &[x, x]));
    let extent = [0, 1, 2].map(|d: usize| high[d] - low[d]);
    let axis = (0..3).fold(0, |axis, d| if extent[d] > extent[axis] { d } else { axis });
    let middle = range.len() / 2;
    range.select_nth_unstable_by(middle, |a, b| {
        let [a, b] = [a, b].map(|p| centers[*p as usize]);
        let by = |d: usize| a[(axis + d) % 3].total_cmp(&b[(axis + d) % 3]);
        by(0).then_with(|| by(1)).then_with(|| by(2))
    });
    let (low, high) = range.split_at_mut(middle);
    sort(low, centers);
    sort(&mut high[1..], centers);
}

impl BoxTree {
    /// Of boxes with these centres [m].
    ///
    /// # Cost
    /// O(n log n).
    pub(super) fn new(centers: &[[f64; 3]], bounds: &dyn Fn(u32) -> Bounds) -> Self {
        let mut order: Vec<u32> = (0..centers.len() as u32).collect();
        sort(&mut order, centers);
        let mut tree = Self {
            around: vec![NOWHERE; order.len()],
            order,
        };
        tree.enclose(0..tree.len(), bounds);
        tree
    }

    fn enclose(&mut self, range: Range<usize>, bounds: &dyn Fn(u32) -> Bounds) -> Bounds {
        if range.is_empty() {
            return NOWHERE;
        }
        let middle = middle(&range);
        let low = self.enclose(range.start..middle, bounds);
        let high = self.enclose(middle + 1..range.end, bounds);
        self.around[middle] = union(&bounds(self.order[middle]), &union(&low, &high));
        self.around[middle]
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.order.len()
    }

    /// The one at a place of the tree.
    pub(super) fn at(&self, place: usize) -> u32 {
        self.order[place]
    }

    /// The box around those of a range that begins with all and is halved; `None` of an empty one.
    pub(super) fn around(&self, range: Range<usize>) -> Option<&Bounds> {
        (!range.is_empty()).then(|| &self.around[middle(&range)])
    }

    /// Gives those whose own box, or that of others near them, a vertical line at (x, y) crosses.
    pub(super) fn on_line(&self, at: [f64; 2], give: &mut impl FnMut(u32)) {
        self.on_line_in(0..self.len(), at, give);
    }

    fn on_line_in(&self, range: Range<usize>, at: [f64; 2], give: &mut impl FnMut(u32)) {
        let is_crossed = |[low, high]: &Bounds| (0..2).all(|d| low[d] <= at[d] && at[d] <= high[d]);
        if self.around(range.clone()).is_some_and(is_crossed) {
            let middle = middle(&range);
            give(self.order[middle]);
            self.on_line_in(range.start..middle, at, give);
            self.on_line_in(middle + 1..range.end, at, give);
        }
    }
}

/// Place of the one that halves a range.
fn middle(range: &Range<usize>) -> usize {
    range.start + range.len() / 2
}
