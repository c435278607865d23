//! The 3×3 diagonal blocks of a level, inverted.

use super::groups::Groups;
use fracas_operators::Real;
use fracas_operators::small::{Symmetric, equilibrated_inverse, full, times, upper};
use fracas_operators::sparse::Block3;

/// Nodes that one task updates.
const NODES_PER_TASK: usize = 4096;

/// Pivot of a block with unit diagonal below which it counts as singular. Unit: 1.
pub(super) const SINGULAR: f64 = 1e-6;

/// A diagonal block without an inverse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoInverse {
    /// Not positive definite on its free components.
    #[error("the diagonal block of node {node} is not positive definite")]
    Indefinite {
        /// The node, from 0.
        node: usize,
    },
    /// The block or its inverse leaves the range of the level's scalar.
    #[error("the diagonal block of node {node} or its inverse leaves the range of {scalar}")]
    Overflow {
        /// The node, from 0.
        node: usize,
        /// `f32` or `f64`.
        scalar: &'static str,
    },
}

/// D⁻¹, zero in the rows and columns of fixed components; D has a block per node, or per group of nodes that hardly differ.
#[derive(Clone, Debug)]
pub struct BlockJacobi<R> {
    /// Zero for nodes of groups.
    inverse: Vec<Symmetric<R>>,
    groups: Groups<R>,
}

impl<R: Real> BlockJacobi<R> {
    /// Inverts `blocks` in f64 and rounds; `fixed` lists the components `3·node + i` that are no unknowns, ascending.
    ///
    /// # Errors
    /// [`NoInverse`] for the first block without an inverse.
    pub fn new(blocks: &[Symmetric<f64>], fixed: &[u32]) -> Result<Self, NoInverse> {
        let mut fixed = fixed.iter().peekable();
        let inverse_of = |(node, block): (usize, &Symmetric<f64>)| {
            let mut free = [true; 3];
            while let Some(dof) = fixed.next_if(|dof| **dof as usize / 3 == node) {
                free[*dof as usize % 3] = false;
            }
            let is_finite = |v: &f64| R::of(*v).is_finite();
            let overflow = NoInverse::Overflow {
                node,
                scalar: R::NAME,
            };
            if !block.iter().all(is_finite) {
                return Err(overflow);
            }
            let inverse = equilibrated_inverse(full(block), free, SINGULAR)
                .map_err(|_| NoInverse::Indefinite { node })?;
            let inverse = upper(&inverse);
            match inverse.iter().all(is_finite) {
                true => Ok(inverse.map(R::of)),
                false => Err(overflow),
            }
        };
        let inverse = blocks.iter().enumerate().map(inverse_of);
        Ok(Self::of_inverses(inverse.collect::<Result<_, _>>()?))
    }

    /// The same with one block for nodes that `couplings`, the blocks beside the diagonal, tie together.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_couplings(
        blocks: &[Symmetric<f64>],
        couplings: &Block3<f64>,
        fixed: &[u32],
    ) -> Result<Self, NoInverse> {
        let groups = Groups::new(blocks, couplings, fixed);
        let mut jacobi = Self::new(blocks, fixed)?;
        for node in groups.nodes() {
            jacobi.inverse[*node as usize] = [R::zero(); 6];
        }
        Ok(Self { groups, ..jacobi })
    }

    /// From inverse blocks.
    pub fn of_inverses(inverse: Vec<Symmetric<R>>) -> Self {
        Self {
            inverse,
            groups: Groups::default(),
        }
    }

    /// Nodes.
    pub fn nodes(&self) -> usize {
        self.inverse.len()
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.inverse) + self.groups.bytes()
    }

    /// Flops of one update of two vectors.
    pub(super) fn flops(&self) -> u64 {
        27 * self.inverse.len() as u64 + self.groups.flops()
    }

    /// `z ← D⁻¹ r`.
    pub fn solve(&self, r: &[R], z: &mut [R]) {
        pass(&self.inverse, r, z, &mut [], &|z, _, v| {
            z.copy_from_slice(&v)
        });
        self.groups.add(R::one(), r, z, &mut []);
    }

    /// `d ← c D⁻¹ r, x ← d`.
    pub(super) fn start(&self, c: R, r: &[R], d: &mut [R], x: &mut [R]) {
        pass(&self.inverse, r, d, x, &|d, x, v| {
            for i in 0..3 {
                d[i] = c * v[i];
                x[i] = d[i];
            }
        });
        self.groups.add(c, r, d, x);
    }

    /// `d ← c D⁻¹ r, x ← x + d`.
    pub(super) fn restart(&self, c: R, r: &[R], d: &mut [R], x: &mut [R]) {
        pass(&self.inverse, r, d, x, &|d, x, v| {
            for i in 0..3 {
                d[i] = c * v[i];
                x[i] += d[i];
            }
        });
        self.groups.add(c, r, d, x);
    }

    /// `d ← a d + c D⁻¹ r, x ← x + d`.
    pub(super) fn step(&self, a: R, c: R, r: &[R], d: &mut [R], x: &mut [R]) {
        pass(&self.inverse, r, d, x, &|d, x, v| {
            for i in 0..3 {
                d[i] = a * d[i] + c * v[i];
                x[i] += d[i];
            }
        });
        self.groups.add(c, r, d, x);
    }
}

/// `update(d_i, x_i, D_i⁻¹ r_i)` for every node, in parallel; x may be empty, then it is not touched.
fn pass<R: Real>(
    inverse: &[Symmetric<R>],
    r: &[R],
    d: &mut [R],
    x: &mut [R],
    update: &(impl Fn(&mut [R], &mut [R], [R; 3]) + Sync),
) {
    let n = inverse.len();
    assert!(r.len() == 3 * n && d.len() == 3 * n && (x.is_empty() || x.len() == 3 * n));
    if n > NODES_PER_TASK {
        let m = (n / NODES_PER_TASK).div_ceil(2) * NODES_PER_TASK;
        let at = x.len().min(3 * m);
        let ((d0, d1), (x0, x1)) = (d.split_at_mut(3 * m), x.split_at_mut(at));
        rayon::join(
            || pass(&inverse[..m], &r[..3 * m], d0, x0, update),
            || pass(&inverse[m..], &r[3 * m..], d1, x1, update),
        );
        return;
    }
    let (r, d, x) = (
        r.as_chunks::<3>().0,
        d.as_chunks_mut::<3>().0,
        x.as_chunks_mut::<3>().0,
    );
    if x.is_empty() {
        for ((b, r), d) in inverse.iter().zip(r).zip(d) {
            update(d, &mut [], times(&full(b), r));
        }
    } else {
        for (((b, r), d), x) in inverse.iter().zip(r).zip(d).zip(x) {
            update(d, x, times(&full(b), r));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fixed_component_is_left_out_and_the_others_are_inverted() {
        let block = [4.0, 1.0, 0.5, 3e3, -2.0, 9.0];
        let m = BlockJacobi::<f64>::new(&[block, block], &[4]).unwrap();
        let b = |i: usize, j: usize| full(&block)[i][j];
        let r = [1.0, -2.0, 3.0, 1.0, -2.0, 3.0];
        let mut z = [f64::NAN; 6];
        m.solve(&r, &mut z);
        for i in 0..3 {
            let product: f64 = (0..3).map(|j| b(i, j) * z[j]).sum();
            assert!((product - r[i]).abs() < 1e-12);
        }
        assert_eq!(z[4], 0.0);
        for i in [0, 2] {
            let product: f64 = [0, 2].iter().map(|j| b(i, *j) * z[3 + j]).sum();
            assert!((product - r[i]).abs() < 1e-12);
        }
        let bad = BlockJacobi::<f64>::new(&[block, [1.0; 6]], &[]).unwrap_err();
        assert_eq!(bad, NoInverse::Indefinite { node: 1 });
        // an inverse of 1e40 is a number in f64 alone
        let soft = [1e-40, 0.0, 0.0, 1e-40, 0.0, 1e-40];
        assert!(BlockJacobi::<f64>::new(&[block, soft], &[]).is_ok());
        let lost = BlockJacobi::<f32>::new(&[block, soft], &[]).unwrap_err();
        let scalar = "f32";
        assert_eq!(lost, NoInverse::Overflow { node: 1, scalar });
    }

    #[test]
    fn the_fused_steps_are_their_formulas() {
        let n = NODES_PER_TASK + 37;
        let block = [2.0, 0.5, -0.25, 4.0, 0.125, 8.0];
        let m = BlockJacobi::<f64>::new(&vec![block; n], &[]).unwrap();
        let wave = |s: f64| (0..3 * n).map(|i| (i as f64 * s).sin()).collect::<Vec<_>>();
        let (r, d0, x0) = (wave(0.3), wave(0.7), wave(1.1));
        let mut z = vec![0.0; 3 * n];
        m.solve(&r, &mut z);
        let (mut d, mut x) = (d0.clone(), x0.clone());
        m.step(0.5, 2.0, &r, &mut d, &mut x);
        for i in 0..3 * n {
            assert!((d[i] - (0.5 * d0[i] + 2.0 * z[i])).abs() < 1e-14);
            assert!((x[i] - (x0[i] + d[i])).abs() < 1e-14);
        }
        let (mut d, mut x) = (vec![f64::NAN; 3 * n], x0.clone());
        m.restart(3.0, &r, &mut d, &mut x);
        assert!((0..3 * n).all(|i| d[i] == 3.0 * z[i] && x[i] == x0[i] + d[i]));
        x.fill(f64::NAN);
        m.start(3.0, &r, &mut d, &mut x);
        assert!((0..3 * n).all(|i| d[i] == 3.0 * z[i] && x[i] == d[i]));
    }
}
