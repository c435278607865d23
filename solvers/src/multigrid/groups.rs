//! Nodes that a smoother takes together.
//!
//! Where a fracture leaves a coarse cell in pieces, the corner functions of a piece are restricted to a part of the cell and
//! nearly dependent: on a quarter of it the condition of their matrix is about 50, on a sixteenth about 10³. A polynomial
//! in 3×3 blocks then smooths nothing; one in blocks of all corners of the piece does not see the basis.
#![allow(unsafe_code, reason = "writes of tasks that share no entry")]

use super::block_jacobi::SINGULAR;
use fracas_operators::Real;
use fracas_operators::shared::Shared;
use fracas_operators::small::{Matrix3, Symmetric, full, invert_equilibrated, norm_squared};
use fracas_operators::sparse::Block3;
use rayon::prelude::*;

/// `‖A_ij‖_F / √(‖A_ii‖_F ‖A_jj‖_F)` from which two nodes are taken together; chains of flat cells have at most 0.5. Unit: 1.
const TOGETHER: f64 = 0.6;

/// Nodes of the largest group: the corners of a piece.
const LARGEST: usize = 8;

/// Groups that one task updates.
const GROUPS_PER_TASK: usize = 256;

/// Disjoint groups of nodes with the inverses of their diagonal blocks.
#[derive(Clone, Debug, Default)]
pub(super) struct Groups<R> {
    /// First node of every group, and one more.
    first: Vec<usize>,
    nodes: Vec<u32>,
    /// First entry of every inverse, and one more.
    start: Vec<usize>,
    /// By rows, zero in fixed components.
    inverse: Vec<R>,
}

impl<R: Real> Groups<R> {
    /// Groups by descending strength of coupling. `diagonal` holds the diagonal blocks, `couplings` those beside them,
    /// `fixed` the components that are no unknowns, ascending.
    ///
    /// # Cost
    /// One pass over the couplings, `O(g³)` per group of g nodes.
    pub(super) fn new(diagonal: &[Symmetric<f64>], couplings: &Block3<f64>, fixed: &[u32]) -> Self {
        let mut groups = Self {
            first: vec![0],
            start: vec![0],
            ..Self::default()
        };
        let members = together(diagonal, couplings);
        let inverse = |nodes: &Vec<u32>| {
            let (mut block, mut scale) = matrix(nodes, diagonal, couplings, fixed);
            let done = invert_equilibrated(&mut block, &mut scale, SINGULAR);
            done.is_ok().then_some(block)
        };
        let inverses: Vec<Option<Vec<f64>>> = members.par_iter().map(inverse).collect();
        for (nodes, inverse) in members.iter().zip(inverses) {
            // nearly singular, or beyond the range of R: its nodes stay alone
            let Some(inverse) = inverse else { continue };
            let inverse: Vec<R> = inverse.into_iter().map(R::of).collect();
            if !inverse.iter().all(|v| v.is_finite()) {
                continue;
            }
            groups.nodes.extend(nodes);
            groups.first.push(groups.nodes.len());
            groups.inverse.extend(inverse);
            groups.start.push(groups.inverse.len());
        }
        groups
    }

    /// Nodes that belong to a group.
    pub(super) fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.inverse) + 2 * size_of_val(&*self.first)
    }

    /// Flops of one update.
    pub(super) fn flops(&self) -> u64 {
        2 * self.inverse.len() as u64 + 9 * self.nodes.len() as u64
    }

    /// `d ← d + c G⁻¹ r`, `x ← x + c G⁻¹ r`; x may be empty, then it is not touched.
    pub(super) fn add(&self, c: R, r: &[R], d: &mut [R], x: &mut [R]) {
        let count = self.first.len().saturating_sub(1);
        let has_x = !x.is_empty();
        let (d, x) = (Shared::new(d), Shared::new(x));
        (0..count.div_ceil(GROUPS_PER_TASK))
            .into_par_iter()
            .for_each(|task| {
                for g in task * GROUPS_PER_TASK..count.min((task + 1) * GROUPS_PER_TASK) {
                    let nodes = &self.nodes[self.first[g]..self.first[g + 1]];
                    let inverse = &self.inverse[self.start[g]..self.start[g + 1]];
                    let n = 3 * nodes.len();
                    let mut own = [R::zero(); 3 * LARGEST];
                    for (own, node) in own.chunks_exact_mut(3).zip(nodes) {
                        own.copy_from_slice(&r[3 * *node as usize..][..3]);
                    }
                    for (a, node) in nodes.iter().enumerate() {
                        let rows = inverse[3 * a * n..][..3 * n].chunks_exact(n);
                        let mut z = [R::zero(); 3];
                        for (z, row) in z.iter_mut().zip(rows) {
                            *z = row
                                .iter()
                                .zip(&own)
                                .fold(R::zero(), |s, (m, r)| s + *m * *r);
                        }
                        let plus = |v: &Shared<'_, R>| {
                            // SAFETY: a node belongs to one group, a group to one task.
                            let v = unsafe { v.part(3 * *node as usize, 3) };
                            (0..3).for_each(|i| v[i] += c * z[i]);
                        };
                        plus(&d);
                        if has_x {
                            plus(&x);
                        }
                    }
                }
            });
    }
}

/// The blocks beside the diagonal of row i.
fn row(a: &Block3<f64>, i: usize) -> impl Iterator<Item = (usize, &Matrix3<f64>)> {
    a.block_row(i).filter(move |(j, _)| *j != i)
}

/// Groups of two nodes and more, each ascending.
fn together(diagonal: &[Symmetric<f64>], couplings: &Block3<f64>) -> Vec<Vec<u32>> {
    let square = |v: &f64| v * v;
    let size = |b: &Symmetric<f64>| {
        let [xx, xy, xz, yy, yz, zz] = b.each_ref().map(square);
        xx + yy + zz + 2.0 * (xy + xz + yz)
    };
    let sizes: Vec<f64> = diagonal.iter().map(size).collect();
    let strong = |i: usize| {
        let of_pair = |(j, block): (usize, &Matrix3<f64>)| {
            let s = norm_squared(block);
            let strength = s * s / (sizes[i] * sizes[j]);
            (j > i && strength >= TOGETHER.powi(4)).then_some((strength, i, j))
        };
        row(couplings, i).filter_map(of_pair).collect::<Vec<_>>()
    };
    let mut pairs: Vec<(f64, usize, usize)> = (0..couplings.block_rows())
        .into_par_iter()
        .flat_map_iter(strong)
        .collect();
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut group: Vec<u32> = (0..diagonal.len() as u32).collect();
    let mut members: Vec<Vec<u32>> = Vec::new();
    let mut list = vec![u32::MAX; diagonal.len()];
    for (_, i, j) in pairs {
        let of = |group: &[u32], i: usize| group[i] as usize;
        let (a, b) = (of(&group, i), of(&group, j));
        if a == b {
            continue;
        }
        for k in [a, b] {
            if list[k] == u32::MAX {
                list[k] = members.len() as u32;
                members.push(vec![k as u32]);
            }
        }
        let (la, lb) = (list[a] as usize, list[b] as usize);
        if members[la].len() + members[lb].len() <= LARGEST {
            let joined = std::mem::take(&mut members[lb]);
            joined.iter().for_each(|k| group[*k as usize] = a as u32);
            members[la].extend(joined);
        }
    }
    members.retain(|nodes| nodes.len() > 1);
    members.iter_mut().for_each(|nodes| nodes.sort_unstable());
    members
}

/// The diagonal block of a group, by rows, zero in rows and columns of fixed components, and 0 for these, 1 for the others.
fn matrix(
    nodes: &[u32],
    diagonal: &[Symmetric<f64>],
    couplings: &Block3<f64>,
    fixed: &[u32],
) -> (Vec<f64>, Vec<f64>) {
    let n = 3 * nodes.len();
    let mut m = vec![0.0; n * n];
    let mut set = |a: usize, b: usize, block: Matrix3<f64>| {
        for (r, row) in block.iter().enumerate() {
            m[(3 * a + r) * n + 3 * b..][..3].copy_from_slice(row);
        }
    };
    for (a, node) in nodes.iter().enumerate() {
        let own = &diagonal[*node as usize];
        set(a, a, full(own));
        for (j, block) in row(couplings, *node as usize) {
            if let Ok(b) = nodes.binary_search(&(j as u32)) {
                set(a, b, *block);
            }
        }
    }
    let dof = |i: usize| 3 * nodes[i / 3] + (i % 3) as u32;
    let is_free = |i: usize| fixed.binary_search(&dof(i)).is_err();
    let free: Vec<f64> = (0..n).map(|i| f64::from(u8::from(is_free(i)))).collect();
    for i in 0..n {
        for j in 0..=i {
            // the mean of both triangles: they were rounded apart
            let mean = 0.5 * (m[i * n + j] + m[j * n + i]);
            let kept = if free[i] * free[j] == 0.0 { 0.0 } else { mean };
            m[i * n + j] = kept;
            m[j * n + i] = kept;
        }
    }
    (m, free)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::multigrid::BlockJacobi;
    use fracas_operators::sparse::{Pattern, SparseRows};

    /// All n² blocks.
    fn all(n: usize, values: Vec<Matrix3<f64>>) -> Block3<f64> {
        let pattern = Pattern {
            offsets: (0..=n).map(|i| i * n).collect(),
            columns: (0..n * n).map(|k| (k % n) as u32).collect(),
        };
        Block3::new(SparseRows { pattern, values }, n)
    }

    /// Nodes 0, 1, 2 nearly dependent in every component, 3 alone, couplings from 3 weak; unit diagonal blocks.
    fn sample() -> (Vec<Symmetric<f64>>, Block3<f64>) {
        let identity = [1.0, 0.0, 0.0, 1.0, 0.0, 1.0];
        let coupling = |i: usize, j: usize| match (i, j) {
            (i, j) if i == j => 1.0,
            (3, _) | (_, 3) => 0.1,
            _ => -0.45 - 0.4 * f64::from(u8::from(i + j == 1)),
        };
        // weaker between 1 and 2: strong enough only through 0
        let value = |i: usize, j: usize| {
            if i + j == 3 && i != 3 && j != 3 {
                0.4
            } else {
                coupling(i, j)
            }
        };
        let value = move |i: usize, j: usize| {
            if i + j == 2 && i != j {
                -0.7
            } else {
                value(i, j)
            }
        };
        let blocks = (0..16).map(|k| {
            let v = value(k / 4, k % 4);
            fracas_operators::small::diagonal([v; 3])
        });
        let a = all(4, blocks.collect());
        (vec![identity; 4], a)
    }

    #[test]
    fn a_group_is_inverted_as_a_whole_and_the_others_stay_alone() {
        let (diagonal, a) = sample();
        let groups = Groups::<f64>::new(&diagonal, &a, &[]);
        assert_eq!(groups.nodes(), [0, 1, 2]);
        let m = BlockJacobi::<f64>::with_couplings(&diagonal, &a, &[]).unwrap();
        let r: Vec<f64> = (0..12).map(|i| (i as f64 + 0.3).sin()).collect();
        let mut z = vec![f64::NAN; 12];
        m.solve(&r, &mut z);
        for i in 0..12 {
            // principal block of the group, the identity for node 3
            let product: f64 = (0..4)
                .filter(|j| (i / 3 < 3) == (*j < 3))
                .map(|j| a.block(i / 3, j).unwrap()[0][0] * z[3 * j + i % 3])
                .sum();
            assert!((product - r[i]).abs() < 1e-12, "row {i}");
        }
    }

    #[test]
    fn fixed_components_of_a_group_stay_zero_and_the_rest_is_inverted() {
        let (diagonal, a) = sample();
        let m = BlockJacobi::<f64>::with_couplings(&diagonal, &a, &[4]).unwrap();
        let r = vec![1.0; 12];
        let mut z = vec![f64::NAN; 12];
        m.solve(&r, &mut z);
        assert_eq!(z[4], 0.0);
        let product: f64 = [0, 2]
            .iter()
            .map(|j| a.block(0, *j).unwrap()[0][0] * z[3 * j + 1])
            .sum();
        assert!((product - 1.0).abs() < 1e-12);
    }

    #[test]
    fn fused_steps_with_groups_are_their_formulas() {
        let (diagonal, a) = sample();
        let m = BlockJacobi::<f64>::with_couplings(&diagonal, &a, &[]).unwrap();
        let wave = |s: f64| (0..12).map(|i| (i as f64 * s).sin()).collect::<Vec<_>>();
        let (r, d0, x0) = (wave(0.3), wave(0.7), wave(1.1));
        let mut z = vec![0.0; 12];
        m.solve(&r, &mut z);
        let (mut d, mut x) = (d0.clone(), x0.clone());
        m.step(0.5, 2.0, &r, &mut d, &mut x);
        for i in 0..12 {
            assert!((d[i] - (0.5 * d0[i] + 2.0 * z[i])).abs() < 1e-13);
            assert!((x[i] - (x0[i] + d[i])).abs() < 1e-13);
        }
        m.start(3.0, &r, &mut d, &mut x);
        assert!((0..12).all(|i| (d[i] - 3.0 * z[i]).abs() < 1e-13 && x[i] == d[i]));
    }

    #[test]
    fn no_group_is_larger_than_its_limit() {
        let n = 40;
        let blocks: Vec<Matrix3<f64>> = (0..n * n)
            .map(|k| {
                let v = if k / n == k % n { 1.0 } else { 0.9 };
                fracas_operators::small::diagonal([v; 3])
            })
            .collect();
        let a = all(n, blocks);
        let groups = Groups::<f64>::new(&vec![[1.0, 0.0, 0.0, 1.0, 0.0, 1.0]; n], &a, &[]);
        assert!(groups.first.windows(2).all(|w| w[1] - w[0] <= LARGEST));
        let mut nodes = groups.nodes().to_vec();
        nodes.sort_unstable();
        nodes.dedup();
        assert_eq!(nodes.len(), groups.nodes().len());
        assert!(nodes.len() >= n - 1);
    }
}
