//! Cells of a file: which of them holds a place, or is the nearest to it.

use crate::scene::box_tree::{Bounds, BoxTree, NOWHERE, union};

/// Corners of cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Shapes {
    /// Points of the file [m].
    pub(super) nodes: Vec<[f64; 3]>,
    /// Corners of one cell after the other.
    pub(super) corners: Vec<u32>,
    /// Where those of each end.
    pub(super) ends: Vec<usize>,
    /// Types of VTK; 0 where the file has none.
    pub(super) types: Vec<u8>,
}

/// Square of the distance of x from a box, 0 inside [m²].
fn gap(bounds: &Bounds, x: [f64; 3]) -> f64 {
    let beyond = |d: usize| (bounds[0][d] - x[d]).max(x[d] - bounds[1][d]).max(0.0);
    (0..3).map(|d| beyond(d) * beyond(d)).sum()
}

/// Faces of tetrahedra, hexahedra, wedges and pyramids, corners in cyclic order; `None` of other types.
///
/// # Source
/// The VTK User's Guide, Kitware, 11th ed. 2010, § 19.3.
fn faces(kind: u8) -> Option<&'static [&'static [usize]]> {
    Some(match kind {
        10 => &[&[0, 1, 2], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
        12 => &[
            &[0, 1, 2, 3],
            &[4, 5, 6, 7],
            &[0, 1, 5, 4],
            &[1, 2, 6, 5],
            &[2, 3, 7, 6],
            &[3, 0, 4, 7],
        ],
        13 => &[
            &[0, 1, 2],
            &[3, 4, 5],
            &[0, 1, 4, 3],
            &[1, 2, 5, 4],
            &[2, 0, 3, 5],
        ],
        14 => &[
            &[0, 1, 2, 3],
            &[0, 1, 4],
            &[1, 2, 4],
            &[2, 3, 4],
            &[3, 0, 4],
        ],
        _ => return None,
    })
}

/// Corners of the types of VTK that have a volume and a number of corners of their own.
///
/// # Source
/// As [`faces`]; quadratic ones § 19.3 as well.
const CORNERS: [(u8, usize); 10] = [
    (10, 4),
    (11, 8),
    (12, 8),
    (13, 6),
    (14, 5),
    (24, 10),
    (25, 20),
    (26, 15),
    (27, 13),
    (29, 27),
];

/// Types of VTK that are vertices, lines and surfaces.
const FLAT: [std::ops::RangeInclusive<u8>; 2] = [1..=9, 21..=23];

/// The mean of some points.
pub(super) fn mean(points: impl ExactSizeIterator<Item = [f64; 3]> + Clone) -> [f64; 3] {
    let n = points.len() as f64;
    [0, 1, 2].map(|d: usize| points.clone().map(|x| x[d]).sum::<f64>() / n)
}

/// Share of a tetrahedron by which a point may lie outside of it and count as inside: rounding. Unit: 1.
const ROUNDING: f64 = 1e-9;

/// Whether x lies in a tetrahedron.
fn in_tetrahedron(corners: [[f64; 3]; 4], x: [f64; 3]) -> bool {
    let volume = |[a, b, c, d]: [[f64; 3]; 4]| -> f64 {
        let [u, v, w] = [b, c, d].map(|p| [0, 1, 2].map(|k: usize| p[k] - a[k]));
        u[0] * (v[1] * w[2] - v[2] * w[1])
            + u[1] * (v[2] * w[0] - v[0] * w[2])
            + u[2] * (v[0] * w[1] - v[1] * w[0])
    };
    let whole = volume(corners);
    let shares = (0..4).map(|k| {
        let mut part = corners;
        part[k] = x;
        volume(part) / whole
    });
    // a flat one has no inside
    whole != 0.0 && shares.into_iter().all(|share| share >= -ROUNDING)
}

impl Shapes {
    /// Corners of a cell.
    fn of(&self, cell: usize) -> impl ExactSizeIterator<Item = [f64; 3]> + Clone + '_ {
        let start = cell.checked_sub(1).map_or(0, |before| self.ends[before]);
        let own = self.corners[start..self.ends[cell]].iter();
        own.map(|a| self.nodes[*a as usize])
    }

    /// Every cell has a volume, and as many corners as its type.
    ///
    /// # Errors
    /// A sentence about the first one that has not.
    pub(super) fn check(&self) -> Result<(), String> {
        for (cell, kind) in self.types.iter().enumerate() {
            let count = self.of(cell).len();
            if FLAT.iter().any(|flat| flat.contains(kind)) {
                return Err(format!(
                    "cell {cell} is of the type {kind}, which has no volume; save cells with a volume alone"
                ));
            }
            let needed = CORNERS.iter().find(|(own, _)| own == kind);
            if let Some((_, needed)) = needed.filter(|(_, needed)| *needed != count) {
                return Err(format!(
                    "cell {cell} of the type {kind} has {count} corners, and {needed} are needed"
                ));
            }
        }
        Ok(())
    }

    /// The mean of the corners of every cell.
    pub(super) fn centers(&self) -> Vec<[f64; 3]> {
        (0..self.ends.len())
            .map(|cell| mean(self.of(cell)))
            .collect()
    }

    /// The box around a cell.
    fn bounds(&self, cell: usize) -> Bounds {
        self.of(cell).fold(NOWHERE, |all, x| union(&all, &[x, x]))
    }

    /// Diameter of the box around a cell [m].
    pub(super) fn diameter(&self, cell: usize) -> f64 {
        let [low, high] = self.bounds(cell);
        let square = (0..3).map(|d| (high[d] - low[d]).powi(2));
        square.sum::<f64>().sqrt()
    }

    /// Adds the cells of another piece.
    pub(super) fn append(&mut self, other: Self) {
        let (nodes, corners) = (self.nodes.len() as u32, self.corners.len());
        self.nodes.extend(other.nodes);
        self.corners.extend(other.corners.iter().map(|a| nodes + a));
        self.ends.extend(other.ends.iter().map(|end| corners + end));
        self.types.extend(other.types);
    }

    /// Whether a cell holds a point of its box: one of the tetrahedra between its centre, the centre of a face and an edge does, which are the
    /// same on both sides of a face. Of a type without faces here, the box is the cell.
    fn holds(&self, cell: usize, x: [f64; 3]) -> bool {
        let Some(faces) = faces(self.types[cell]) else {
            return true;
        };
        let count = self.of(cell).len();
        if faces.iter().any(|face| face.iter().any(|a| *a >= count)) {
            return true;
        }
        let start = self.ends[cell] - count;
        let at = |a: &usize| self.nodes[self.corners[start + a] as usize];
        let center = mean(self.of(cell));
        faces.iter().any(|face| {
            let middle = mean(face.iter().map(at));
            let next = face.iter().cycle().skip(1);
            let mut edges = face.iter().zip(next);
            edges.any(|(a, b)| in_tetrahedron([center, middle, at(a), at(b)], x))
        })
    }
}

/// Cells in a tree of their boxes.
#[derive(Clone, Debug)]
pub(super) struct CellTree(BoxTree);

/// Cells, their centres and their numbers in `shapes`.
#[derive(Clone, Copy)]
pub(super) struct Centered<'c> {
    pub(super) shapes: &'c Shapes,
    pub(super) centers: &'c [[f64; 3]],
    pub(super) numbers: &'c [usize],
}

impl CellTree {
    /// Sorts cells into a tree.
    ///
    /// # Cost
    /// O(n log n).
    pub(super) fn new(cells: Centered<'_>) -> Self {
        let bounds = |p: u32| cells.shapes.bounds(cells.numbers[p as usize]);
        Self(BoxTree::new(cells.centers, &bounds))
    }

    /// The cell that holds x, else the one whose box is nearest; of several the one with the nearest centre. And how far x is from its box [m].
    pub(super) fn at(&self, cells: Centered<'_>, x: [f64; 3]) -> (u32, f64) {
        // outside, squares of distances from box and centre
        let mut best: Option<(bool, f64, f64, u32)> = None;
        let tree = &self.0;
        let range = |from: usize, to: usize| {
            let around = tree.around(from..to);
            around.map(|around| (gap(around, x), from, to))
        };
        let mut ranges: Vec<(f64, usize, usize)> = range(0, tree.len()).into_iter().collect();
        while let Some((beyond, from, to)) = ranges.pop() {
            if best.is_some_and(|(_, least, ..)| beyond > least) {
                continue;
            }
            let middle = from + (to - from) / 2;
            let [low, high] = [range(from, middle), range(middle + 1, to)];
            // the nearer half is looked at first
            match low.zip(high) {
                Some((low, high)) if low.0 < high.0 => ranges.extend([high, low]),
                _ => ranges.extend([low, high].into_iter().flatten()),
            }
            let p = tree.at(middle);
            let (own, at) = (cells.numbers[p as usize], cells.centers[p as usize]);
            let beyond = gap(&cells.shapes.bounds(own), x);
            if best.is_none_or(|(_, least, ..)| beyond <= least) {
                let square: f64 = (0..3).map(|d| (at[d] - x[d]) * (at[d] - x[d])).sum();
                let is_outside = beyond > 0.0 || !cells.shapes.holds(own, x);
                let found = (is_outside, beyond, square, p);
                if best.is_none_or(|best| found < best) {
                    best = Some(found);
                }
            }
        }
        best.map_or((0, 0.0), |(_, beyond, _, p)| (p, beyond.sqrt()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::random::Random;

    /// Hexahedra between lines along x, y and z, moved by `bend`.
    fn hexahedra(lines: &[Vec<f64>; 3], bend: impl Fn([f64; 3]) -> [f64; 3]) -> Shapes {
        let n = [0, 1, 2].map(|d: usize| lines[d].len());
        let mut shapes = Shapes::default();
        for z in &lines[2] {
            for y in &lines[1] {
                let row = lines[0].iter().map(|x| bend([*x, *y, *z]));
                shapes.nodes.extend(row);
            }
        }
        let at = |i: usize, j: usize, k: usize| (i + n[0] * (j + n[1] * k)) as u32;
        for k in 0..n[2] - 1 {
            for j in 0..n[1] - 1 {
                for i in 0..n[0] - 1 {
                    for k in [k, k + 1] {
                        let ring = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                        shapes.corners.extend(ring.map(|(i, j)| at(i, j, k)));
                    }
                    shapes.ends.push(shapes.corners.len());
                    shapes.types.push(12);
                }
            }
        }
        shapes
    }

    fn graded(r: &mut Random, n: usize) -> Vec<f64> {
        let mut line = vec![0.0];
        for k in 0..n {
            line.push(line[k] + r.scale(0.1, 10.0));
        }
        line
    }

    /// Claim: cells that lean, or grow by factors, are found by what they hold and not by their centres; left-out ones by the box beside them.
    #[test]
    fn the_cell_that_holds_a_point_is_found_where_centres_mislead() {
        let (mut misled, mut beside) = (0, 0);
        for seed in 0..40 {
            let r = &mut Random::new(seed);
            let lines = [0; 3].map(|_| {
                let cells = 1 + r.below(5);
                graded(r, cells)
            });
            let lean = [r.between(-1.5, 1.5), r.between(-1.5, 1.5)];
            let bend = |x: [f64; 3]| [x[0], x[1], x[2] + lean[0] * x[0] + lean[1] * x[1]];
            let shapes = hexahedra(&lines, bend);
            let centers = shapes.centers();
            let left_out = shapes.ends.len() > 3 && r.chance(0.3);
            let is_there = |c: &usize| !left_out || *c != 1;
            let numbers: Vec<usize> = (0..centers.len()).filter(is_there).collect();
            let centers: Vec<[f64; 3]> = numbers.iter().map(|c| centers[*c]).collect();
            let cells = Centered {
                shapes: &shapes,
                centers: &centers,
                numbers: &numbers,
            };
            let tree = CellTree::new(cells);
            for _ in 0..50 {
                let x = [0, 1, 2].map(|d: usize| r.between(0.0, lines[d][lines[d].len() - 1]));
                let of = |d: usize| lines[d].partition_point(|line| *line <= x[d]) - 1;
                let counts = [0, 1].map(|d: usize| lines[d].len() - 1);
                let own = of(0) + counts[0] * (of(1) + counts[1] * of(2));
                let x = bend(x);
                let (p, distance) = tree.at(cells, x);
                let square = |c: &[f64; 3]| (0..3).map(|d| (c[d] - x[d]).powi(2)).sum::<f64>();
                let mut nearest = 0..centers.len();
                if is_there(&own) {
                    assert_eq!((numbers[p as usize], distance), (own, 0.0), "seed {seed}");
                    misled += usize::from(
                        nearest.any(|c| square(&centers[c]) < square(&centers[p as usize])),
                    );
                } else {
                    let least = numbers.iter().map(|c| gap(&shapes.bounds(*c), x));
                    let least = least.fold(f64::INFINITY, f64::min).sqrt();
                    assert_eq!(distance, least, "seed {seed}");
                    beside += 1;
                }
            }
        }
        assert!(misled > 100 && beside > 10, "{misled} {beside}");
    }

    #[test]
    fn wedges_pyramids_and_tetrahedra_hold_their_inside_alone() {
        let r = &mut Random::new(5);
        for (kind, n) in [(10, 4), (13, 6), (14, 5)] {
            let wedge = [
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [0.0, 0.0, 1.0],
                [1.0, 0.0, 1.0],
                [0.0, 1.0, 1.0],
            ];
            let pyramid = [
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [1.0, 1.0, 0.0],
                [0.0, 1.0, 0.0],
                [0.0, 0.0, 1.0],
            ];
            let nodes = if kind == 14 {
                pyramid.to_vec()
            } else {
                wedge[..n].to_vec()
            };
            let shapes = Shapes {
                nodes,
                corners: (0..n as u32).collect(),
                ends: vec![n],
                types: vec![kind],
            };
            let mut held = 0;
            for _ in 0..400 {
                let x = [0; 3].map(|_| r.between(0.0, 1.0));
                let inside = match kind {
                    10 => x[0] + x[1] + x[2] < 1.0,
                    13 => x[0] + x[1] < 1.0,
                    _ => x[0].max(x[1]) + x[2] < 1.0,
                };
                assert_eq!(shapes.holds(0, x), inside, "{kind} {x:?}");
                held += usize::from(inside);
            }
            assert!(held > 30 && held < 370);
        }
    }
}
