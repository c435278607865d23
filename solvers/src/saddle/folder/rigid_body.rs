//! Do the coordinates belong to A? Rigid motions of free material cost no force.

use super::finding::{Finding, Remark};
use crate::saddle::DofCoordinate;
use fracas_operators::sparse::SparseMatrix;
use std::collections::HashMap;

const FILE: &str = "coords.mtx";

/// Force of a translation below which a row counts as free of constraints. Unit: `Σ_j |a_ij|`.
const FREE: f64 = 1e-8;

/// Force of a rotation above which the coordinates do not fit. Unit: `Σ_j |a_ij| |x_j − x_i|`; room for coordinates
/// written with seven digits.
const MISFIT: f64 = 1e-5;

/// Unknowns from which on a matrix without a single free row is remarkable: in a smaller one every row may touch a
/// constrained unknown.
const MANY: usize = 1000;

/// `A·r` for the rigid-body modes r.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RigidMotions {
    /// Rows where translations cost no force.
    pub(crate) free: usize,
    /// Rows among them where a rotation costs force.
    pub(crate) wrong: usize,
    /// Largest force of a rotation in a free row. Unit: `Σ_j |a_ij| |x_j − x_i|`.
    pub(crate) worst: f64,
    /// First wrong row.
    first: Option<usize>,
}

/// `A·r` row by row: where the three translations cost no force (no constrained unknown is near), the three rotations
/// about the node of the row must cost none either.
///
/// Multigrid and deflation build on these modes; wrong ones cost iterations and raise no error.
pub(crate) fn rigid_motions(a: &SparseMatrix<f64>, coordinates: &[DofCoordinate]) -> RigidMotions {
    let (mut free, mut wrong, mut worst) = (0, 0, 0.0f64);
    let mut first = None;
    let whole = whole_nodes(coordinates);
    for (i, row) in a.outer_iterator().enumerate() {
        let here = coordinates[i].position;
        // a roller near the row: its missing forces may cancel for a translation, not for a rotation
        if row.iter().any(|(j, _)| !whole[j]) {
            continue;
        }
        let (mut translation, mut size) = ([0.0; 3], 0.0);
        let (mut rotation, mut lever) = ([0.0; 3], 0.0);
        for (j, a_ij) in row.iter() {
            let DofCoordinate {
                position,
                component,
            } = coordinates[j];
            let c = usize::from(component);
            let x = [0, 1, 2].map(|k| position[k] - here[k]);
            translation[c] += a_ij;
            size += a_ij.abs();
            // (e_k × x)_c = x_{c+2} for k = c + 1, −x_{c+1} for k = c + 2 (indices modulo 3)
            rotation[(c + 2) % 3] -= a_ij * x[(c + 1) % 3];
            rotation[(c + 1) % 3] += a_ij * x[(c + 2) % 3];
            lever += a_ij.abs() * x.iter().map(|v| v * v).sum::<f64>().sqrt();
        }
        if size == 0.0 || translation.iter().any(|f| f.abs() > FREE * size) {
            continue;
        }
        free += 1;
        let moment = rotation.iter().fold(0.0f64, |m, f| m.max(f.abs()));
        if moment > 0.0 {
            worst = worst.max(moment / lever);
        }
        if moment > MISFIT * lever {
            wrong += 1;
            first.get_or_insert(i);
        }
    }
    RigidMotions {
        free,
        wrong,
        worst,
        first,
    }
}

/// True for the unknowns at positions where every component is unknown that is unknown anywhere: two of them in a plane problem.
fn whole_nodes(coordinates: &[DofCoordinate]) -> Vec<bool> {
    // + 0.0 makes one zero of two
    let key = |c: &DofCoordinate| c.position.map(|x| (x + 0.0).to_bits());
    let mut components: HashMap<[u64; 3], u8> = HashMap::new();
    for c in coordinates {
        *components.entry(key(c)).or_default() |= 1 << c.component;
    }
    let all = components.values().fold(0, |all, here| all | here);
    let is_whole = |c| components.get(&key(c)) == Some(&all);
    coordinates.iter().map(is_whole).collect()
}

/// Remarks coordinates that do not fit.
pub(super) fn coordinates(
    a: &SparseMatrix<f64>,
    coordinates: &[DofCoordinate],
    findings: &mut Vec<Finding>,
) {
    let RigidMotions {
        free,
        wrong,
        worst,
        first,
    } = rigid_motions(a, coordinates);
    if let Some(first) = first {
        let remark = Remark::RotationsCostForce { wrong, free, worst };
        findings.push(Finding::at_row(FILE, first, remark));
    } else if free == 0 && a.rows() >= MANY {
        findings.push(Finding::file(FILE, Remark::TranslationsCostForce));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elastic_sample::clamped_box;
    use fracas_operators::sparse::Triplets;

    fn said(a: &SparseMatrix<f64>, at: &[DofCoordinate]) -> Vec<Remark> {
        let mut findings = Vec::new();
        coordinates(a, at, &mut findings);
        findings.into_iter().map(|f| f.remark).collect()
    }

    #[test]
    fn true_coordinates_pass_in_any_unit_and_with_seven_digits() {
        let (a, at) = clamped_box([5, 4, 3], [1.0, 0.3, 2.0], |c| 10f64.powi(c[2] as i32));
        assert_eq!(said(&a, &at), []);
        let moved = |f: &dyn Fn(f64) -> f64| -> Vec<DofCoordinate> {
            let move_one = |c: &DofCoordinate| DofCoordinate {
                position: c.position.map(f),
                ..*c
            };
            at.iter().map(move_one).collect()
        };
        assert_eq!(said(&a, &moved(&|x| 1e3 * x + 1e5)), []);
        assert_eq!(said(&a, &moved(&|x| (x * 1e6).round() * 1e-6 + 7e-7)), []);
    }

    #[test]
    fn a_plane_problem_has_two_components_everywhere() {
        // out of the plane a clamped box is held by springs of its own: the rows and columns of x and y alone, on a mesh one cell thick,
        // are those of plane strain where the sides do not move in z
        let (a, at) = clamped_box([9, 8, 1], [1.0, 0.5, 1.0], |_| 1.0);
        let low = at
            .iter()
            .map(|c| c.position[2])
            .fold(f64::INFINITY, f64::min);
        // u_z = 0, u_x and u_y the same on both sides: the sum over pairs of nodes
        let in_plane: Vec<usize> = (0..at.len())
            .filter(|i| at[*i].component < 2 && at[*i].position[2] == low)
            .collect();
        let pair = |i: usize| {
            let same = |j: &usize| {
                at[*j].component == at[i].component && at[*j].position[..2] == at[i].position[..2]
            };
            (0..at.len()).filter(same).collect::<Vec<_>>()
        };
        let mut triplets = Triplets::new((in_plane.len(), in_plane.len()));
        for (row, i) in in_plane.iter().enumerate() {
            for (column, j) in in_plane.iter().enumerate() {
                for (i, j) in pair(*i)
                    .iter()
                    .flat_map(|i| pair(*j).into_iter().map(move |j| (*i, j)))
                {
                    if let Some(value) = a.get(i, j) {
                        triplets.add_triplet(row, column, *value);
                    }
                }
            }
        }
        let places: Vec<DofCoordinate> = in_plane.iter().map(|i| at[*i]).collect();
        let plane: SparseMatrix<f64> = triplets.to_csr();
        let found = rigid_motions(&plane, &places);
        assert!(found.free > 20 && found.wrong == 0, "{found:?}");
        let mut stretched = places.clone();
        stretched.iter_mut().for_each(|c| c.position[1] *= 2.0);
        assert!(rigid_motions(&plane, &stretched).wrong > 20);
    }

    #[test]
    fn coordinates_of_another_mesh_are_remarked() {
        let (a, at) = clamped_box([5, 4, 3], [1.0, 0.3, 2.0], |_| 1.0);
        let mut stretched = at.clone();
        stretched.iter_mut().for_each(|c| c.position[1] *= 2.0);
        let mut swapped = at.clone();
        for k in 0..3 {
            let (p, q) = (swapped[60 + k].position, swapped[120 + k].position);
            (swapped[60 + k].position, swapped[120 + k].position) = (q, p);
        }
        let mut relabelled = at.clone();
        relabelled
            .iter_mut()
            .for_each(|c| c.component = (c.component + 1) % 3);
        for wrong in [stretched, swapped, relabelled] {
            let remarks = said(&a, &wrong);
            assert!(
                matches!(remarks[..], [Remark::RotationsCostForce { wrong, free, worst }]
                    if wrong > 0 && wrong <= free && worst > 1e-2),
                "{remarks:?}"
            );
        }
    }

    #[test]
    fn components_in_another_order_are_remarked() {
        for cells in [[3, 2, 2], [8, 7, 7]] {
            let (a, at) = clamped_box(cells, [1.0; 3], |_| 1.0);
            let n = at.len();
            // node by node in A, direction by direction in the table
            let by_direction: Vec<DofCoordinate> = (0..n)
                .map(|i| at[3 * (i % (n / 3)) + i / (n / 3)])
                .collect();
            assert_eq!(said(&a, &by_direction).len(), 1);
        }
    }

    #[test]
    fn a_matrix_that_no_translation_leaves_without_force_is_remarked_when_it_is_large() {
        for (cells, expected) in [([3, 2, 2], 0), ([8, 7, 7], 1)] {
            let (a, at) = clamped_box(cells, [1.0; 3], |_| 1.0);
            let identity: SparseMatrix<f64> = SparseMatrix::eye(at.len());
            let bedded = &a + &identity;
            let remarks = said(&bedded, &at);
            assert_eq!(remarks, vec![Remark::TranslationsCostForce; expected]);
        }
    }
}
