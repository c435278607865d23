//! Which boxes a point lies in.

/// Corners of a box: lowest, highest.
pub(super) type Box3 = [[f64; 3]; 2];

/// Boxes of a leaf.
const LEAF: usize = 8;

/// A tree of boxes: every branch halves its boxes along the axis in which their centres spread most.
#[derive(Clone, Debug)]
pub(super) struct Boxes {
    boxes: Vec<Box3>,
    /// Numbers of boxes, leaf after leaf.
    order: Vec<u32>,
    branches: Vec<Branch>,
}

/// A part of `order` and the box around it.
#[derive(Clone, Debug)]
struct Branch {
    around: Box3,
    range: std::ops::Range<usize>,
    /// Place of the second half; the first one follows directly. Absent in a leaf.
    second: Option<usize>,
}

fn contains([low, high]: &Box3, x: &[f64; 3]) -> bool {
    (0..3).all(|d| low[d] <= x[d] && x[d] <= high[d])
}

/// Box around points.
pub(super) fn around<'a>(points: impl Iterator<Item = &'a [f64; 3]>) -> Box3 {
    points.fold([[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], |b, x| {
        [
            [0, 1, 2].map(|d: usize| b[0][d].min(x[d])),
            [0, 1, 2].map(|d: usize| b[1][d].max(x[d])),
        ]
    })
}

impl Boxes {
    /// # Cost
    /// O(n log n).
    pub(super) fn new(boxes: Vec<Box3>) -> Self {
        let order = (0..boxes.len() as u32).collect();
        let mut tree = Self {
            boxes,
            order,
            branches: Vec::new(),
        };
        tree.grow(0..tree.order.len());
        tree
    }

    fn grow(&mut self, range: std::ops::Range<usize>) {
        let corner = |b: &u32| self.boxes[*b as usize].iter();
        let part = &self.order[range.clone()];
        let around_all = around(part.iter().flat_map(corner));
        let here = self.branches.len();
        self.branches.push(Branch {
            around: around_all,
            range: range.clone(),
            second: None,
        });
        if range.len() <= LEAF {
            return;
        }
        let twice_center = |b: u32, d: usize| {
            let [low, high] = &self.boxes[b as usize];
            low[d] + high[d]
        };
        let spread = |d: usize| {
            let values = part.iter().map(|b| twice_center(*b, d));
            let ends = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| {
                [l.min(v), h.max(v)]
            });
            ends[1] - ends[0]
        };
        let spreads = [0, 1, 2].map(spread);
        let axis = (1..3).fold(0, |m, d| if spreads[d] > spreads[m] { d } else { m });
        let middle = range.len() / 2;
        let mut part = part.to_vec();
        part.select_nth_unstable_by(middle, |a, b| {
            let by_center = twice_center(*a, axis).total_cmp(&twice_center(*b, axis));
            by_center.then(a.cmp(b))
        });
        self.order[range.clone()].copy_from_slice(&part);
        let middle = range.start + middle;
        self.grow(range.start..middle);
        self.branches[here].second = Some(self.branches.len());
        self.grow(middle..range.end);
    }

    /// The first box around `x` that `is_wanted`.
    pub(super) fn find(&self, x: &[f64; 3], is_wanted: impl Fn(u32) -> bool) -> Option<u32> {
        let mut open = vec![0];
        while let Some(here) = open.pop() {
            let branch = &self.branches[here];
            if !contains(&branch.around, x) {
                continue;
            }
            match branch.second {
                Some(second) => open.extend([second, here + 1]),
                None => {
                    let mut leaf = self.order[branch.range.clone()].iter().copied();
                    let wanted = |b: &u32| contains(&self.boxes[*b as usize], x) && is_wanted(*b);
                    if let Some(found) = leaf.find(wanted) {
                        return Some(found);
                    }
                }
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tree_finds_what_a_list_finds() {
        let mut state = 1u64;
        let mut random = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 40) as f64 / (1u64 << 24) as f64
        };
        let boxes: Vec<Box3> = (0..200)
            .map(|_| {
                let low = [random(), random(), random()];
                [low, low.map(|x| x + 0.2 * random())]
            })
            .collect();
        let tree = Boxes::new(boxes.clone());
        let mut hits = 0;
        for _ in 0..500 {
            let x = [random(), random(), random()];
            for (b, at) in boxes.iter().enumerate() {
                let found = tree.find(&x, |found| found as usize == b);
                assert_eq!(found.is_some(), contains(at, &x));
                hits += usize::from(found.is_some());
            }
        }
        assert!(hits > 50, "{hits}");
        assert_eq!(Boxes::new(Vec::new()).find(&[0.0; 3], |_| true), None);
    }
}
