//! A symmetric matrix that is kept by half, in 3×3 blocks of nodes: a third of the memory of its rows.

use super::finest::Sum;
use super::half::{Half, retain};
use super::node_map::{NONE, NodeMap};
use super::schedule::Schedule;
use crate::{DofCoordinate, SetupError};
use fracas_operators::small::Matrix3;
use fracas_operators::sparse::{Pattern, SparseMatrix, Transposed};
use fracas_operators::{LinearOperator, Shape};
use rayon::prelude::*;
use std::sync::Arc;

/// A in f64, its unknowns in the slots of nodes.
///
/// # Cost
/// 38 bytes per entry of a block row that is full, for 108 of compressed rows. A product reads them once.
#[derive(Clone, Debug)]
pub struct HalvedMatrix {
    pub(super) half: Half<f64>,
    pub(super) map: Arc<NodeMap>,
    /// Stored entries of the rows that it was made from.
    entries: usize,
}

impl HalvedMatrix {
    /// Half of `a`, whose rows are given back before the blocks are made. Lᵀ is not looked at.
    ///
    /// # Errors
    /// [`SetupError`] for a matrix that is not square or not by rows, or an entry that is no number.
    pub fn new(
        a: SparseMatrix<f64>,
        coordinates: Option<&[DofCoordinate]>,
    ) -> Result<Self, SetupError> {
        let map = Arc::new(NodeMap::new(&a, coordinates));
        let all = Sum::new(&a, None)?.pattern(&map);
        let schedule = Schedule::new(&all.offsets, &all.columns);
        let pattern = Pattern::collect(
            map.nodes(),
            || (),
            |i, (), columns| {
                let row = all.row(i).iter().copied();
                columns.extend(row.filter(|j| schedule.before(*j as usize, i)));
            },
        );
        drop(all);
        let entries = a.nnz();
        let slots = map.slots();
        let a = retained(a, |i, j| {
            let (i, j) = (slots[i] as usize / 3, slots[j] as usize / 3);
            i == j || schedule.before(j, i)
        });
        let count = pattern.columns.len();
        let mut blocks = vec![[[0.0; 3]; 3]; count + 1];
        let fill = |rows: std::ops::Range<usize>, part: &mut [Matrix3<f64>], (): &mut ()| {
            let start = pattern.offsets[rows.start];
            for i in rows {
                let columns = pattern.row(i);
                let own = &mut part[pattern.offsets[i] - start..][..columns.len()];
                node_row(&a, &map, i, |j, c, k, value| {
                    // unknowns of a node follow each other, and so do columns
                    if let Ok(at) = columns.binary_search(&(j as u32)) {
                        own[at][c][k] += value;
                    }
                });
            }
        };
        pattern.fill(&mut blocks[..count], || (), fill);
        let of_node = |i: usize| {
            let mut own = [[0.0; 3]; 3];
            node_row(&a, &map, i, |j, c, k, value| {
                if j == i {
                    own[c][k] += value;
                }
            });
            own
        };
        let diagonal = (0..map.nodes()).into_par_iter().map(of_node).collect();
        drop(a);
        Ok(Self {
            half: Half::new((pattern, blocks), diagonal, schedule),
            map,
            entries,
        })
    }

    /// Rows of the blocks that stand in a column of L, and where.
    pub(super) fn transposed(&self) -> Transposed {
        self.half.pattern.transposed(self.map.nodes())
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.half.bytes()
    }

    /// The diagonal, unknown by unknown.
    pub fn diagonal(&self) -> impl Iterator<Item = f64> + Clone + '_ {
        let entry = |slot: &u32| {
            let (node, c) = (*slot as usize / 3, *slot as usize % 3);
            self.half.diagonal[node][c][c]
        };
        self.map.slots().iter().map(entry)
    }

    /// `sums_i ← sums_i + Σ_j |a_ij|`.
    pub fn add_row_sums(&self, sums: &mut [f64]) {
        assert_eq!(sums.len(), self.map.unknowns_len(), "sums, unknowns");
        let mut slots = vec![0.0; 3 * self.map.nodes()];
        for i in 0..self.half.rows() {
            for c in 0..3 {
                slots[3 * i + c] += self.half.diagonal[i][c]
                    .iter()
                    .map(|v| v.abs())
                    .sum::<f64>();
            }
            for (j, block) in self.half.before(i) {
                for (c, k) in (0..9).map(|at| (at / 3, at % 3)) {
                    slots[3 * i + c] += block[c][k].abs();
                    slots[3 * j + k] += block[c][k].abs();
                }
            }
        }
        for (sum, slot) in sums.iter_mut().zip(self.map.slots()) {
            *sum += slots[*slot as usize];
        }
    }

    /// Slots, where they are not the unknowns in their order.
    fn places(&self) -> Option<&[u32]> {
        let slots = self.map.slots();
        let is_plain = slots.len() == 3 * self.map.nodes()
            && (slots.iter().enumerate()).all(|(i, slot)| i == *slot as usize);
        (!is_plain).then_some(slots)
    }
}

/// Entries `(column node, component, component of the column, value)` of the rows of a node.
fn node_row(
    a: &SparseMatrix<f64>,
    map: &NodeMap,
    node: usize,
    mut see: impl FnMut(usize, usize, usize, f64),
) {
    let (columns, values) = (a.indices(), a.data());
    for (c, i) in map.of_node(node).iter().enumerate() {
        if *i != NONE {
            for k in a.indptr().outer_inds_sz(*i as usize) {
                let slot = map.slots()[columns[k] as usize] as usize;
                see(slot / 3, c, slot % 3, values[k]);
            }
        }
    }
}

/// The entries that are to stay, in the memory of all; what is left over is given back.
fn retained(a: SparseMatrix<f64>, stays: impl Fn(usize, usize) -> bool) -> SparseMatrix<f64> {
    let shape = a.shape();
    let (mut offsets, mut columns, mut values) = a.into_raw_storage();
    let end = retain((&mut offsets, &mut columns), &mut values, stays);
    values.truncate(end);
    values.shrink_to_fit();
    SparseMatrix::new(shape, offsets, columns, values)
}

impl LinearOperator<f64> for HalvedMatrix {
    fn shape(&self) -> Shape {
        Shape::square(self.map.unknowns_len())
    }

    fn apply_add(&self, alpha: f64, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        let Some(slots) = self.places() else {
            return self.half.apply_add(alpha, x, y);
        };
        let n = 3 * self.map.nodes();
        let (x_s, y_s) = work[..2 * n].split_at_mut(n);
        x_s.fill(0.0);
        y_s.fill(0.0);
        for (x, slot) in x.iter().zip(slots) {
            x_s[*slot as usize] = *x;
        }
        self.half.apply_add(alpha, x_s, y_s);
        for (y, slot) in y.iter_mut().zip(slots) {
            *y += y_s[*slot as usize];
        }
    }

    fn work_len(&self) -> usize {
        self.places().map_or(0, |_| 6 * self.map.nodes())
    }

    /// Those of compressed rows, so that costs do not depend on how A is kept.
    fn flops(&self) -> u64 {
        2 * (self.entries + self.map.unknowns_len()) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elastic_sample::clamped_box;
    use fracas_operators::laws::probe;
    use fracas_operators::sparse::{Csr, Triplets};

    /// Layers in a box whose sides of x are rollers, so that nodes have empty slots; unknowns shuffled where asked for.
    fn sample(shuffled: bool) -> (SparseMatrix<f64>, Vec<DofCoordinate>) {
        let young = |cell: [usize; 3]| 10f64.powi((cell[2] % 3) as i32);
        let (a, at) = clamped_box([13, 9, 21], [1.0, 0.8, 1.2], young);
        let free = |i: &usize| at[*i].component > 0 || at[*i].position[0] != 1.0;
        let mut kept: Vec<usize> = (0..at.len()).filter(free).collect();
        assert!(kept.len() < at.len());
        if shuffled {
            let n = kept.len();
            kept = (0..n).map(|i| kept[(i * 7919) % n]).collect();
        }
        let mut place = vec![usize::MAX; at.len()];
        (kept.iter().enumerate()).for_each(|(k, i)| place[*i] = k);
        let mut triplets = Triplets::new((kept.len(), kept.len()));
        for (value, (i, j)) in a.iter() {
            let (i, j) = (place[i as usize], place[j as usize]);
            // symmetric to the last bit, as a file that lists one triangle
            if i <= j && j != usize::MAX {
                triplets.add_triplet(i, j, *value);
                if i < j {
                    triplets.add_triplet(j, i, *value);
                }
            }
        }
        (triplets.to_csr(), kept.iter().map(|i| at[*i]).collect())
    }

    #[test]
    fn half_of_a_matrix_multiplies_and_tells_as_all_of_it_does() {
        for (shuffled, known) in [(false, true), (true, true), (false, false)] {
            let (a, at) = sample(shuffled);
            let half = HalvedMatrix::new(a.clone(), known.then_some(&at)).unwrap();
            let n = a.rows();
            let (x, y) = (probe::<f64>(n, 1), probe::<f64>(n, 2));
            let size = a.data().iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            let (mut found, mut expected) = (y.clone(), y);
            half.apply_add(-0.7, &x, &mut found, &mut vec![f64::NAN; half.work_len()]);
            let csr = Csr::new(a.clone());
            csr.apply_add(-0.7, &x, &mut expected, &mut []);
            let close = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-13 * size;
            assert!(found.iter().zip(&expected).all(close));
            assert_eq!(half.flops(), csr.flops());
            assert!(half.diagonal().eq((0..n).map(|i| *a.get(i, i).unwrap())));
            let mut sums = vec![1.0; n];
            half.add_row_sums(&mut sums);
            let of_row = |i: usize| -> f64 {
                let row = a.outer_view(i).unwrap();
                row.iter().map(|(_, v)| v.abs()).sum()
            };
            let rows: Vec<f64> = (0..n).map(|i| 1.0 + of_row(i)).collect();
            assert!(sums.iter().zip(&rows).all(close));
            if known {
                assert!(
                    half.bytes() < 5 * a.nnz(),
                    "{} for {}",
                    half.bytes(),
                    a.nnz()
                );
            }
        }
    }

    #[test]
    fn the_finest_level_of_half_a_matrix_is_that_of_all_of_it() {
        for shuffled in [false, true] {
            let (a, at) = sample(shuffled);
            let n = a.rows();
            let mut triplets = Triplets::new((n, 5));
            (0..n)
                .step_by(97)
                .for_each(|i| triplets.add_triplet(i, i % 5, 30.0 + (i as f64).sin()));
            let f: SparseMatrix<f64> = triplets.to_csr();
            let half = HalvedMatrix::new(a.clone(), Some(&at)).unwrap();
            for factor in [None, Some(&f)] {
                let (whole, sum) = (Sum::new(&a, factor).unwrap(), Sum::of_half(&half, factor));
                let map = whole.map(Some(&at));
                let of = |sum: &Sum<'_>| {
                    let finest = sum.blocks::<f64>(&map, sum.pattern(&map)).unwrap();
                    let matrix = finest.matrix.to_csr(|_| true);
                    (matrix, finest.scale, sum.bonds(&map))
                };
                assert!(of(&sum).0 == of(&whole).0);
                assert_eq!((of(&sum).1, of(&sum).2), (of(&whole).1, of(&whole).2));
            }
        }
    }
}
