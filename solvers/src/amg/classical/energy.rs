//! Energy minimisation of P.

use super::independent_set::{FINE, Splitting};
use super::least_squares::Modes;
use super::{Interpolation, NodeBlocks};
use crate::amg::tentative::orthonormalise;
use fracas_operators::small::{Matrix3, add_product};
use fracas_operators::sparse::Pattern;
use fracas_operators::vector::{axpy, dot, xpby};

/// Reduction of the residual beyond which steps would only add rounding. Unit: 1.
const CONVERGED: f64 = 1e-10;

/// Lowers `tr(PᵀA P)` by `steps` of conjugate gradients over the fine rows of P: its pattern, its coarse rows and
/// `P V_c` stay as they are.
///
/// A step moves along matrices Z with `Z_i V_C = 0` in every row; `D⁻¹` of the 3×3 diagonal blocks preconditions and
/// commutes with the projection onto them, because one acts from the left and the other from the right.
///
/// # Cost
/// A step costs one product of A with P on the pattern of P.
///
/// # Source
/// J. Mandel, M. Brezina, P. Vaněk, Computing 62 (1999); C. Janna, A. Franceschini, J. B. Schroder, L. Olson, SIAM J. Sci.
/// Comput. 45 (2023).
pub(super) fn minimise<const K: usize>(
    a: &NodeBlocks,
    inverse: &[Matrix3<f64>],
    splitting: &Splitting,
    modes: &Modes<K>,
    p: &mut Interpolation,
    steps: usize,
) {
    let mut x = std::mem::take(&mut p.values);
    let space = Constrained::new(a, inverse, splitting, modes, p);
    let [mut r, mut z, mut d, mut q] = [0; 4].map(|_| vec![[[0.0; 3]; 3]; x.len()]);
    // R = −Π(A P)
    space.product(&x, &mut r);
    r.as_flattened_mut()
        .as_flattened_mut()
        .iter_mut()
        .for_each(|v| *v = -*v);
    space.precondition(&r, &mut z);
    d.copy_from_slice(&z);
    let mut rho = dot(
        r.as_flattened().as_flattened(),
        z.as_flattened().as_flattened(),
    );
    let rounding = CONVERGED * CONVERGED * rho;
    for _ in 0..steps {
        space.product(&d, &mut q);
        let curvature = dot(
            d.as_flattened().as_flattened(),
            q.as_flattened().as_flattened(),
        );
        // nothing left to gain, or a direction without energy
        if curvature <= 0.0 || rho <= rounding {
            break;
        }
        let alpha = rho / curvature;
        axpy(
            alpha,
            d.as_flattened().as_flattened(),
            x.as_flattened_mut().as_flattened_mut(),
        );
        axpy(
            -alpha,
            q.as_flattened().as_flattened(),
            r.as_flattened_mut().as_flattened_mut(),
        );
        space.precondition(&r, &mut z);
        let next = dot(
            r.as_flattened().as_flattened(),
            z.as_flattened().as_flattened(),
        );
        xpby(
            z.as_flattened().as_flattened(),
            next / rho,
            d.as_flattened_mut().as_flattened_mut(),
        );
        rho = next;
    }
    p.values = x;
}

/// Changes of P that keep `P V_c`.
struct Constrained<'a, const K: usize> {
    a: &'a NodeBlocks,
    inverse: &'a [Matrix3<f64>],
    splitting: &'a Splitting,
    pattern: &'a Pattern,
    /// Orthonormal basis of `V_C` of every row, three rows per block of P.
    basis: Vec<[[f64; K]; 3]>,
}

impl<'a, const K: usize> Constrained<'a, K> {
    fn new(
        a: &'a NodeBlocks,
        inverse: &'a [Matrix3<f64>],
        splitting: &'a Splitting,
        modes: &Modes<K>,
        p: &'a Interpolation,
    ) -> Self {
        let of_column = |j: &u32| modes[splitting.nodes[*j as usize] as usize];
        let mut basis: Vec<[[f64; K]; 3]> = p.pattern.columns.iter().map(of_column).collect();
        for_rows(&p.pattern, &mut basis, &|_, rows| {
            orthonormalise(rows.as_flattened_mut());
        });
        Self {
            a,
            inverse,
            splitting,
            pattern: &p.pattern,
            basis,
        }
    }

    /// `q ← Π(A d)` on fine rows, zero on coarse ones.
    fn product(&self, d: &[Matrix3<f64>], q: &mut [Matrix3<f64>]) {
        for_rows(self.pattern, q, &|i, out| {
            out.fill([[0.0; 3]; 3]);
            if self.splitting.number[i] != FINE {
                return;
            }
            let own = self.pattern.offsets[i]..self.pattern.offsets[i + 1];
            let columns = &self.pattern.columns[own.clone()];
            for (k, a_ik) in self.a.row(i) {
                let range = self.pattern.offsets[k]..self.pattern.offsets[k + 1];
                // both lists ascend
                let mut place = 0;
                for (j, block) in self.pattern.columns[range.clone()].iter().zip(&d[range]) {
                    while place < columns.len() && columns[place] < *j {
                        place += 1;
                    }
                    if place == columns.len() {
                        break;
                    }
                    if columns[place] == *j {
                        add_product(&mut out[place], a_ik, block);
                    }
                }
            }
            project(&self.basis[own], out);
        });
    }

    /// `z ← D⁻¹ r`.
    fn precondition(&self, r: &[Matrix3<f64>], z: &mut [Matrix3<f64>]) {
        for_rows(self.pattern, z, &|i, out| {
            let own = self.pattern.offsets[i]..self.pattern.offsets[i + 1];
            for (z, r) in out.iter_mut().zip(&r[own]) {
                *z = [[0.0; 3]; 3];
                add_product(z, &self.inverse[i], r);
            }
        });
    }
}

/// `Z_i ← Z_i (I − Q Qᵀ)` for the blocks of one row and the basis Q of their modes.
fn project<const K: usize>(basis: &[[[f64; K]; 3]], row: &mut [Matrix3<f64>]) {
    for r in 0..3 {
        let mut along = [0.0; K];
        for (block, q) in row.iter().zip(basis) {
            for c in 0..3 {
                (0..K).for_each(|k| along[k] += block[r][c] * q[c][k]);
            }
        }
        for (block, q) in row.iter_mut().zip(basis) {
            for c in 0..3 {
                block[r][c] -= (0..K).map(|k| along[k] * q[c][k]).sum::<f64>();
            }
        }
    }
}

/// `visit(i, values of row i)` for every row, in parallel.
fn for_rows<T: Send>(
    pattern: &Pattern,
    values: &mut [T],
    visit: &(impl Fn(usize, &mut [T]) + Sync),
) {
    pattern.fill(
        values,
        || (),
        |rows, mut part, ()| {
            for i in rows {
                let row;
                (row, part) = part.split_at_mut(pattern.row(i).len());
                visit(i, row);
            }
        },
    );
}
