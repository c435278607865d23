//! A tree of points that finds the nearest.
//!
//! # Source
//! J. L. Bentley, Comm. ACM 18 (1975) 509–517: k-d trees.

/// Points in the order of a balanced tree: the middle one of a range splits it, along x, y and z in turn.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    /// Numbers of points.
    order: Vec<u32>,
}

impl Tree {
    /// Sorts points into a tree.
    ///
    /// # Cost
    /// O(n log n).
    pub(super) fn new(points: &[[f64; 3]]) -> Self {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        split(&mut order, points, 0);
        Self { order }
    }

    /// The point nearest to x that `admits` takes, the one with the lowest number of several, and its distance.
    pub(super) fn nearest(
        &self,
        points: &[[f64; 3]],
        x: [f64; 3],
        admits: impl Fn(u32) -> bool,
    ) -> Option<(u32, f64)> {
        let mut best: Option<(f64, u32)> = None;
        let mut ranges = vec![(0, self.order.len(), 0, 0.0)];
        while let Some((from, to, axis, beyond)) = ranges.pop() {
            if from >= to || best.is_some_and(|(square, _)| beyond > square) {
                continue;
            }
            let middle = from + (to - from) / 2;
            let p = self.order[middle];
            let at = points[p as usize];
            let square: f64 = (0..3).map(|d| (at[d] - x[d]) * (at[d] - x[d])).sum();
            if admits(p) && best.is_none_or(|best| (square, p) < best) {
                best = Some((square, p));
            }
            let ahead = x[axis] - at[axis];
            let next = (axis + 1) % 3;
            let (low, high) = ((from, middle), (middle + 1, to));
            let [near, far] = if ahead < 0.0 {
                [low, high]
            } else {
                [high, low]
            };
            // the nearer half is looked at first
            ranges.push((far.0, far.1, next, ahead * ahead));
            ranges.push((near.0, near.1, next, 0.0));
        }
        best.map(|(square, p)| (p, square.sqrt()))
    }
}

/// Puts the middle one of a range in its place, then of its halves.
fn split(range: &mut [u32], points: &[[f64; 3]], axis: usize) {
    if range.len() < 2 {
        return;
    }
    let middle = range.len() / 2;
    range.select_nth_unstable_by(middle, |a, b| {
        let [a, b] = [a, b].map(|p| points[*p as usize][axis]);
        a.total_cmp(&b)
    });
    let (low, high) = range.split_at_mut(middle);
    split(low, points, (axis + 1) % 3);
    split(&mut high[1..], points, (axis + 1) % 3);
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::random::Random;

    #[test]
    fn the_nearest_is_that_of_a_search_through_all() {
        for seed in 0..60 {
            let r = &mut Random::new(seed);
            // few values, so that many points tie
            let coarse = r.chance(0.4);
            let mut number = || match coarse {
                true => f64::from(r.whole(0, 4)),
                false => r.between(-3.0, 3.0),
            };
            let points: Vec<[f64; 3]> = (0..1 + seed * 7)
                .map(|_| std::array::from_fn(|_| number()))
                .collect();
            let tree = Tree::new(&points);
            for _ in 0..40 {
                let x = std::array::from_fn(|_| number());
                let left_out = number() as u32;
                let square = |p: u32| -> f64 {
                    let at = points[p as usize];
                    (0..3).map(|d| (at[d] - x[d]) * (at[d] - x[d])).sum()
                };
                let all = (0..points.len() as u32).filter(|p| *p != left_out);
                let expected = all.min_by(|a, b| square(*a).total_cmp(&square(*b)));
                let found = tree.nearest(&points, x, |p| p != left_out);
                assert_eq!(
                    found,
                    expected.map(|p| (p, square(p).sqrt())),
                    "seed {seed}"
                );
            }
        }
    }
}
