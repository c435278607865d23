//! The assembled stiffness: rows gathered from the elements around each node, in parallel, the same bits always.

use super::{Constraints, Elastic, ElasticityError, check};
use crate::mesh::HexMesh;
use fracas_operators::LinearOperator;
use fracas_operators::small::{Matrix3, add};
use fracas_operators::sparse::{Block3, Pattern, SparseMatrix, SparseRows};
use rayon::prelude::*;
use std::sync::OnceLock;

/// Free rows that one task copies; the split does not depend on the number of threads.
const ROWS_PER_TASK: usize = 512;

/// For every node the elements around it, increasing, as `8·element + local node`.
struct Neighbours {
    offsets: Vec<usize>,
    corners: Vec<u32>,
}

impl Neighbours {
    fn new(mesh: &HexMesh) -> Self {
        let mut offsets = vec![0; mesh.nodes.len() + 1];
        for node in mesh.elements.iter().flatten() {
            offsets[*node as usize + 1] += 1;
        }
        for a in 0..mesh.nodes.len() {
            offsets[a + 1] += offsets[a];
        }
        let mut next = offsets.clone();
        let mut corners = vec![0; 8 * mesh.elements.len()];
        for (corner, node) in mesh.elements.iter().flatten().enumerate() {
            corners[next[*node as usize]] = corner as u32;
            next[*node as usize] += 1;
        }
        Self { offsets, corners }
    }

    fn around(&self, node: usize) -> &[u32] {
        &self.corners[self.offsets[node]..self.offsets[node + 1]]
    }

    /// Nodes that share an element with `node`, increasing.
    fn columns(&self, mesh: &HexMesh, node: usize, columns: &mut Vec<u32>) {
        columns.clear();
        for corner in self.around(node) {
            columns.extend_from_slice(&mesh.elements[*corner as usize / 8]);
        }
        columns.sort_unstable();
        columns.dedup();
    }
}

/// The stiffness `A` of the whole body in full numbering, before any displacement is prescribed [N/m].
///
/// # Errors
/// [`ElasticityError`] for an inverted element or a region without a material.
pub fn stiffness(mesh: &HexMesh, materials: &[Elastic]) -> Result<Block3<f64>, ElasticityError> {
    stiffness_of_rows(mesh, materials, |_| true)
}

/// The rows of some nodes of the [`stiffness`]; the others stay empty.
///
/// # Errors
/// As [`stiffness`].
pub fn stiffness_of_rows(
    mesh: &HexMesh,
    materials: &[Elastic],
    wanted: impl Fn(usize) -> bool + Sync,
) -> Result<Block3<f64>, ElasticityError> {
    check::elements(mesh, materials.len())?;
    let neighbours = Neighbours::new(mesh);
    let n = mesh.nodes.len();
    let pattern = Pattern::collect(n, Vec::new, |node, row, columns| {
        if wanted(node) {
            neighbours.columns(mesh, node, row);
            columns.extend_from_slice(row);
        }
    });
    let mut values = vec![[[0.0; 3]; 3]; pattern.columns.len()];
    let failed = OnceLock::new();
    pattern.fill(
        &mut values,
        || (),
        |nodes, mut blocks, ()| {
            for node in nodes {
                let (columns, around) = (pattern.row(node), neighbours.around(node));
                let row;
                (row, blocks) = blocks.split_at_mut(columns.len());
                if columns.is_empty() {
                    continue;
                }
                if let Err(error) = assemble_row(mesh, materials, around, columns, row) {
                    let _ = failed.set(error);
                    return;
                }
            }
        },
    );
    match failed.into_inner() {
        Some(error) => Err(error),
        None => Ok(Block3::new(SparseRows { pattern, values }, n)),
    }
}

/// Sums the element blocks (a, b) of one node row; elements in increasing order, so (a, b) and (b, a) agree bit for bit.
fn assemble_row(
    mesh: &HexMesh,
    materials: &[Elastic],
    around: &[u32],
    columns: &[u32],
    blocks: &mut [Matrix3<f64>],
) -> Result<(), ElasticityError> {
    for corner in around {
        let (e, a) = (*corner as usize / 8, *corner as usize % 8);
        let geometry = check::geometry(mesh, e)?;
        let material = materials[usize::from(mesh.regions[e])];
        for (b, node) in mesh.elements[e].iter().enumerate() {
            let position = columns.partition_point(|column| column < node);
            let block = geometry.stiffness_block(a, b, material);
            add(&mut blocks[position], 1.0, &block);
        }
    }
    Ok(())
}

/// The rows and columns of the free unknowns: `A_ff`; exact zeros inside blocks are dropped.
pub fn reduced(full: &Block3<f64>, constraints: &Constraints) -> SparseMatrix<f64> {
    assert_eq!(
        full.shape().rows,
        constraints.full_len(),
        "constraints of another mesh"
    );
    let free = constraints.free();
    let row = |dof: usize| {
        full.row(dof).filter_map(|(column, value)| {
            let column = constraints.free_index(column)?;
            (value != 0.0).then_some((column as u32, value))
        })
    };
    let mut offsets = vec![0; free.len() + 1];
    offsets[1..]
        .par_iter_mut()
        .with_min_len(ROWS_PER_TASK)
        .zip(free)
        .for_each(|(length, dof)| *length = row(*dof as usize).count());
    for i in 0..free.len() {
        offsets[i + 1] += offsets[i];
    }
    let (columns, values) = free
        .par_chunks(ROWS_PER_TASK)
        .flat_map_iter(|rows| rows.iter().flat_map(|dof| row(*dof as usize)))
        .unzip();
    let n = free.len();
    SparseMatrix::new((n, n), offsets, columns, values)
}

/// Moves prescribed displacements to the right-hand side of the free rows: `f_f ← f_f − A_fc u_c`.
pub fn lift(full: &dyn LinearOperator<f64>, constraints: &Constraints, free_force: &mut [f64]) {
    assert_eq!(
        free_force.len(),
        constraints.free_len(),
        "force of another mesh"
    );
    let prescribed = constraints.expand(&vec![0.0; constraints.free_len()]);
    let mut force = vec![0.0; constraints.full_len()];
    full.apply(&prescribed, &mut force, &mut vec![0.0; full.work_len()]);
    for (f, dof) in free_force.iter_mut().zip(constraints.free()) {
        *f -= force[*dof as usize];
    }
}

#[cfg(test)]
mod tests {
    use super::super::element::Geometry;
    use super::super::sample::{self, Sample};
    use super::*;
    use fracas_operators::laws::{check_adjoint, probe};
    use fracas_operators::{Dense, Shape};

    const ROCKS: [Elastic; 2] = [
        Elastic {
            young: 3.0,
            poisson: 0.2,
        },
        Elastic {
            young: 1.0,
            poisson: 0.35,
        },
    ];

    fn distorted() -> HexMesh {
        sample::mesh(Sample {
            cells: [4, 3, 3],
            grading: 0.1,
            distortion: 0.15,
            regions: 2,
            split: true,
        })
    }

    /// Sum of 24×24 element matrices, entry by entry.
    fn oracle(mesh: &HexMesh) -> Dense<f64> {
        let mut dense = Dense::zeros(Shape::square(3 * mesh.nodes.len()));
        for (e, nodes) in mesh.elements.iter().enumerate() {
            let material = ROCKS[usize::from(mesh.regions[e])];
            let k = Geometry::new(&check::corners(mesh, e))
                .unwrap()
                .stiffness(material);
            let dof = |i: usize| 3 * nodes[i / 3] as usize + i % 3;
            for i in 0..24 {
                for j in 0..24 {
                    *dense.entry_mut(dof(i), dof(j)) += k[i][j];
                }
            }
        }
        dense
    }

    #[test]
    fn assembly_agrees_with_the_sum_of_element_matrices() {
        let mesh = distorted();
        let a = stiffness(&mesh, &ROCKS).unwrap();
        check_adjoint("Block3 stiffness", &a, Some(&oracle(&mesh))).unwrap();
        check_adjoint(
            "CSR stiffness",
            &fracas_operators::sparse::Csr::new(a.to_csr()),
            Some(&oracle(&mesh)),
        )
        .unwrap();
    }

    #[test]
    fn the_stiffness_is_symmetric_to_the_last_bit() {
        let a = stiffness(&distorted(), &ROCKS).unwrap().to_csr();
        for (value, (i, j)) in &a {
            assert_eq!(a.get(j as usize, i as usize), Some(value), "({i}, {j})");
        }
    }

    #[test]
    fn a_constant_strain_leaves_inner_nodes_of_a_distorted_mesh_in_balance() {
        let cells = [4, 4, 4];
        let mesh = sample::mesh(Sample {
            cells,
            distortion: 0.2,
            ..Sample::default()
        });
        let a = stiffness(&mesh, &ROCKS).unwrap();
        let u: Vec<f64> = mesh
            .nodes
            .iter()
            .flat_map(|x| [0.1 * x[0] - 0.3 * x[1], 0.2 * x[2], 0.4 * x[0] + 0.1 * x[2]])
            .collect();
        let mut force = vec![0.0; u.len()];
        a.apply(&u, &mut force, &mut []);
        let inner = |n: usize| (1..4).contains(&n);
        for (dof, f) in force.iter().enumerate() {
            let node = dof / 3;
            if inner(node % 5) && inner(node / 5 % 5) && inner(node / 25) {
                assert!(f.abs() < 1e-12, "node {node}: {f}");
            }
        }
    }

    #[test]
    fn reduction_and_lifting_are_a_partition_of_the_matrix() {
        let mesh = distorted();
        let full = stiffness(&mesh, &ROCKS).unwrap();
        let n = 3 * mesh.nodes.len();
        let prescribed = (0..n)
            .map(|i| (i % 7 == 2).then_some((i as f64).sin()))
            .collect();
        let constraints = Constraints::new(prescribed);
        let reduced = fracas_operators::sparse::Csr::new(reduced(&full, &constraints));
        let u_f: Vec<f64> = probe(constraints.free_len(), 5);
        let mut whole = vec![0.0; n];
        full.apply(&constraints.expand(&u_f), &mut whole, &mut []);
        // A_ff u_f − (−A_fc u_c)
        let mut force = vec![0.0; u_f.len()];
        lift(&full, &constraints, &mut force);
        force.iter_mut().for_each(|f| *f = -*f);
        reduced.apply_add(1.0, &u_f, &mut force, &mut []);
        for (i, dof) in constraints.free().iter().enumerate() {
            assert!((force[i] - whole[*dof as usize]).abs() < 1e-13);
        }
    }

    #[test]
    fn errors_name_the_element() {
        let mut mesh = distorted();
        mesh.regions[5] = 9;
        let error = stiffness(&mesh, &ROCKS).unwrap_err();
        assert!(matches!(
            error,
            ElasticityError::NoMaterial { element: 5, .. }
        ));
        mesh.regions[5] = 0;
        mesh.elements[3].swap(0, 6);
        let error = stiffness(&mesh, &ROCKS).unwrap_err();
        assert!(matches!(
            error,
            ElasticityError::Inverted { element: 3, .. }
        ));
    }
}
