use super::energy::minimise;
use super::independent_set::{FINE, splitting};
use super::least_squares::interpolation;
use super::*;
use crate::DofCoordinate;
use crate::elastic_sample::cube;
use faer::linalg::solvers::DenseSolveCore;
use fracas_operators::small::{Matrix3, norm_squared};
use fracas_operators::sparse::{SparseMatrix, Triplets};

type Modes6 = Vec<[[f64; 6]; 3]>;

/// A matrix of whole triples by nodes.
fn by_nodes(a: &SparseMatrix<f64>) -> NodeBlocks {
    let row = |i: usize, (): &mut (), out: &mut Vec<(u32, Matrix3<f64>)>| {
        let mut blocks = std::collections::BTreeMap::<u32, Matrix3<f64>>::new();
        for r in 0..3 {
            for (j, value) in a.outer_view(3 * i + r).unwrap().iter() {
                blocks.entry(j as u32 / 3).or_default()[r][j % 3] = *value;
            }
        }
        out.extend(blocks);
    };
    SparseRows::collect(a.rows() / 3, || (), row)
}

fn rigid(coordinates: &[DofCoordinate]) -> Modes6 {
    let of_node = |node: &[DofCoordinate]| {
        let [x, y, z] = node[0].position;
        [
            [1.0, 0.0, 0.0, 0.0, z, -y],
            [0.0, 1.0, 0.0, -z, 0.0, x],
            [0.0, 0.0, 1.0, y, -x, 0.0],
        ]
    };
    coordinates.chunks_exact(3).map(of_node).collect()
}

/// Coarse nodes and P.
struct Coarse {
    nodes: Vec<u32>,
    interpolation: Interpolation,
}

fn coarsen<const K: usize>(
    a: &NodeBlocks,
    inverse: &[Matrix3<f64>],
    bonds: Option<&Pattern>,
    modes: &[[[f64; K]; 3]],
) -> Coarse {
    let start = Start::new(a, bonds, modes);
    Coarse {
        interpolation: start.minimised(a, inverse, modes),
        nodes: start.splitting.nodes,
    }
}

fn inverses(a: &NodeBlocks) -> Vec<Matrix3<f64>> {
    let of_node = |i: usize| {
        let b = diagonal(a, i);
        let inverse = faer::Mat::from_fn(3, 3, |r, c| b[r][c])
            .partial_piv_lu()
            .inverse();
        std::array::from_fn(|r| std::array::from_fn(|c| inverse[(r, c)]))
    };
    (0..a.pattern.rows()).map(of_node).collect()
}

/// P entry by entry.
fn scalar(p: &Interpolation, coarse: usize) -> SparseMatrix<f64> {
    let (mut offsets, mut columns, mut values) = (vec![0], vec![], vec![]);
    for i in 0..p.pattern.rows() {
        for r in 0..3 {
            for (j, block) in p.row(i) {
                columns.extend((0..3).map(|c| (3 * j + c) as u32));
                values.extend(&block[r]);
            }
            offsets.push(columns.len());
        }
    }
    SparseMatrix::new((3 * p.pattern.rows(), 3 * coarse), offsets, columns, values)
}

/// `tr(PᵀA P)`.
fn energy(a: &SparseMatrix<f64>, p: &SparseMatrix<f64>) -> f64 {
    let entry = |i: u32, j: u32| p.get(i as usize, j as usize).copied().unwrap_or(0.0);
    (a * p).iter().map(|(v, (i, j))| v * entry(i, j)).sum()
}

#[test]
fn coarse_nodes_are_independent_and_maximal() {
    for (name, a, _) in crate::elastic_sample::bodies(7) {
        let graph = Strength::new(&by_nodes(&a), None);
        let split = splitting(&graph);
        for i in 0..graph.len() {
            let coarse = |j: &u32| split.number[*j as usize] != FINE;
            assert!(
                graph
                    .neighbours(i)
                    .iter()
                    .all(|j| graph.neighbours(*j as usize).contains(&(i as u32)))
            );
            let beside = graph.neighbours(i).iter().any(coarse);
            assert!(
                !graph.neighbours(i).is_empty() && beside != coarse(&(i as u32)),
                "{name}"
            );
        }
        let numbers: Vec<u32> = split
            .nodes
            .iter()
            .map(|i| split.number[*i as usize])
            .collect();
        assert!(
            numbers
                .iter()
                .enumerate()
                .all(|(k, number)| k == *number as usize)
        );
    }
}

/// Largest part of the modes of a node that P misses, and the largest row.
fn missed(p: &Interpolation, nodes: &[u32], modes: &Modes6) -> (f64, f64) {
    let (mut worst, mut largest) = (0.0f64, 0.0f64);
    for i in 0..p.pattern.rows() {
        let norm = p.row(i).map(|(_, b)| norm_squared(b)).sum::<f64>().sqrt();
        largest = largest.max(norm);
        for r in 0..3 {
            for k in 0..6 {
                let term = |(j, b): (usize, &Matrix3<f64>)| {
                    let v = &modes[nodes[j] as usize];
                    (0..3).map(|c| b[r][c] * v[c][k]).sum::<f64>()
                };
                let sum: f64 = p.row(i).map(term).sum();
                let size = modes[i].iter().map(|row| row[k].abs()).fold(1.0, f64::max);
                worst = worst.max((sum - modes[i][r][k]).abs() / size);
            }
        }
    }
    (worst, largest)
}

#[test]
fn p_reproduces_the_modes_and_is_the_identity_on_coarse_nodes() {
    for (name, a, coordinates) in crate::elastic_sample::bodies(7) {
        let (nodes, modes) = (by_nodes(&a), rigid(&coordinates));
        let coarse = coarsen(&nodes, &inverses(&nodes), None, &modes);
        let p = &coarse.interpolation;
        let (worst, largest) = missed(p, &coarse.nodes, &modes);
        assert!(worst < 1e-9, "{name}: {worst:e}");
        assert!(
            largest <= 10.0 + 1e-12 && 8 * coarse.nodes.len() < 3 * p.pattern.rows(),
            "{name}"
        );
        for (k, i) in coarse.nodes.iter().enumerate() {
            let row: Vec<_> = p.row(*i as usize).collect();
            assert_eq!(row, [(k, &fracas_operators::small::diagonal([1.0; 3]))]);
        }
    }
}

#[test]
fn a_row_that_would_be_too_large_is_scaled_to_norm_ten() {
    // a chain of nodes that bend away from the line through the coarse ones: rotations about it cannot be carried
    let n = 9;
    let mut triplets = Triplets::new((3 * n, 3 * n));
    for i in 0..3 * n {
        triplets.add_triplet(i, i, 2.0);
        if i + 3 < 3 * n {
            triplets.add_triplet(i, i + 3, -1.0);
            triplets.add_triplet(i + 3, i, -1.0);
        }
    }
    let nodes = by_nodes(&triplets.to_csr());
    let graph = Strength::new(&nodes, None);
    let split = splitting(&graph);
    let position = |i: usize| {
        let off = if split.number[i] == FINE {
            1.0
        } else {
            1e-3 * (i * i) as f64
        };
        [i as f64, off, 0.0]
    };
    let coordinates: Vec<DofCoordinate> = (0..3 * n)
        .map(|i| DofCoordinate {
            position: position(i / 3),
            component: (i % 3) as u8,
        })
        .collect();
    let modes = rigid(&coordinates);
    let p = interpolation([&graph; 2], &split, &modes);
    let (worst, largest) = missed(&p, &split.nodes, &modes);
    assert!((largest - 10.0).abs() < 1e-9 && worst > 1e-3);
}

#[test]
fn held_components_and_lonely_nodes_are_not_interpolated() {
    let (a, coordinates) = cube(4);
    let held = [4, 40, 125];
    let mut triplets = Triplets::new((a.rows() + 3, a.rows() + 3));
    for (value, (i, j)) in a.iter() {
        let kept = i == j || !(held.contains(&i) || held.contains(&j));
        triplets.add_triplet(i as usize, j as usize, if kept { *value } else { 0.0 });
    }
    (a.rows()..a.rows() + 3).for_each(|i| triplets.add_triplet(i, i, 1.0));
    let nodes = by_nodes(&triplets.to_csr());
    let mut modes = rigid(&coordinates);
    modes.push([[1.0; 6]; 3]);
    held.iter()
        .for_each(|i| modes[*i as usize / 3][*i as usize % 3] = [0.0; 6]);
    let coarse = coarsen(&nodes, &inverses(&nodes), None, &modes);
    let p = &coarse.interpolation;
    assert!(p.row(nodes.pattern.rows() - 1).next().is_none());
    for i in held.map(|i| i as usize) {
        let number = coarse.nodes.iter().position(|c| *c as usize == i / 3);
        for node in (0..p.pattern.rows())
            .filter(|node| Some(*node) != number.map(|k| coarse.nodes[k] as usize))
        {
            for (j, block) in p.row(node) {
                let row = node == i / 3;
                let column = Some(j) == number;
                let values = (0..3).map(|k| match (row, column) {
                    (true, _) => block[i % 3][k],
                    (_, true) => block[k][i % 3],
                    _ => 0.0,
                });
                assert!(values.into_iter().all(|v| v.abs() < 1e-12));
            }
        }
    }
}

#[test]
fn energy_falls_with_every_step_to_the_constrained_minimum() {
    for (name, a, coordinates) in crate::elastic_sample::bodies(5) {
        let (nodes, modes) = (by_nodes(&a), rigid(&coordinates));
        let graph = Strength::new(&nodes, None);
        let split = splitting(&graph);
        let start = interpolation([&graph; 2], &split, &modes);
        let inverse = inverses(&nodes);
        let after = |steps| {
            let mut p = start.clone();
            minimise(&nodes, &inverse, &split, &modes, &mut p, steps);
            p
        };
        let energies: Vec<f64> = (0..6)
            .map(|k| energy(&a, &scalar(&after(k), split.nodes.len())))
            .collect();
        assert!(
            energies.windows(2).all(|e| e[1] < e[0]),
            "{name}: {energies:?}"
        );
        assert!(energies[1] < 0.97 * energies[0], "{name}: {energies:?}");
        // at the minimum every fine row of A P, on the pattern of P, is a combination of the modes: (A P)_i = X V_Cᵀ
        let p = after(300);
        let image = &a * &scalar(&p, split.nodes.len());
        for i in (0..p.pattern.rows()).filter(|i| split.number[*i] == FINE) {
            let columns = p.pattern.row(i);
            let of =
                |k: usize, m: usize| modes[split.nodes[columns[k / 3] as usize] as usize][k % 3][m];
            let v = faer::Mat::from_fn(3 * columns.len(), 6, of);
            let svd = v.thin_svd().unwrap();
            let basis: Vec<usize> = (0..6.min(3 * columns.len()))
                .filter(|m| svd.S().column_vector()[*m] > 1e-9 * svd.S().column_vector()[0])
                .collect();
            for r in 0..3 {
                let row: Vec<f64> = (0..3 * columns.len())
                    .map(|k| {
                        image
                            .get(3 * i + r, 3 * columns[k / 3] as usize + k % 3)
                            .copied()
                            .unwrap_or(0.0)
                    })
                    .collect();
                let mut rest = row.clone();
                for m in &basis {
                    let part: f64 = (0..row.len()).map(|k| row[k] * svd.U()[(k, *m)]).sum();
                    (0..row.len()).for_each(|k| rest[k] -= part * svd.U()[(k, *m)]);
                }
                let size = diagonal(&nodes, i)[0][0];
                assert!(
                    rest.iter().all(|v| v.abs() < 1e-5 * size),
                    "{name} {i} {rest:?}"
                );
            }
        }
        assert!(missed(&p, &split.nodes, &modes).0 < 1e-9, "{name}");
        assert_eq!(p.pattern, start.pattern);
    }
}

#[test]
fn one_and_two_threads_give_the_same_bits() {
    let (a, coordinates) = cube(9);
    let (nodes, modes) = (by_nodes(&a), rigid(&coordinates));
    let inverse = inverses(&nodes);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let coarse = pool.install(|| coarsen(&nodes, &inverse, None, &modes));
        let bits: Vec<u64> = coarse
            .interpolation
            .values
            .as_flattened()
            .as_flattened()
            .iter()
            .map(|v| v.to_bits())
            .collect();
        (coarse.nodes, coarse.interpolation.pattern.columns, bits)
    };
    assert!(run(1) == run(2));
}
