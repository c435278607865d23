//! Tractions that no displacement feels: the kernel of B on the free displacements, with and without H.

use std::collections::HashMap;

use super::fracture_patches::joined;
use super::rank::gram_rank;
use super::{FractureFace, FractureMesh, HexMesh};

/// Faces beyond which the dense rank of B is not computed (three n×n Gram matrices, n³/3 each: about a second).
const DENSE_FACES: usize = 1200;

/// Edge-connected patches beyond which their joint rank is not computed, only that of each patch alone.
const DENSE_PATCHES: usize = 1200;

/// Pivots of Gram matrices below this share of the largest one count as zero.
const RANK_TOLERANCE: f64 = 1e-10;

/// Why tractions have no effect.
#[derive(Clone, Debug, PartialEq)]
pub enum KernelReason {
    /// All four corners are tips: the face is not split, so it cannot open and its three columns of B are empty.
    NotSplit,
    /// The column of B is empty: all displacements that it acts on are prescribed.
    EmptyColumn {
        /// Component 0–2: t_N, t_1, t_2.
        component: usize,
    },
    /// A uniform traction on a connected patch of faces does no work: H does not help, the system is singular.
    UniformPatch {
        /// Faces in the patch.
        faces: usize,
        /// Global direction of the traction (0–2).
        direction: usize,
    },
    /// More tractions than free jumps in a patch: only H makes the system regular.
    Counting {
        /// Faces in the patch.
        faces: usize,
        /// Global direction (0–2).
        direction: usize,
        /// Free jumps of the nodes of the patch in that direction.
        jumps: usize,
    },
}

/// One finding, with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct KernelFinding {
    /// Index of the fracture.
    pub fracture: u16,
    /// The face, or the first face of the patch.
    pub face: u32,
    /// Its centre [m].
    pub center: [f64; 3],
    /// What is wrong.
    pub reason: KernelReason,
}

/// What is known of ker B (B on free displacements, all faces closed).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CouplingKernel {
    /// dim ker B, where the fractures are small enough for a dense rank (1,200 faces).
    pub dimension: Option<usize>,
    /// dim (ker B ∩ ker H): with jump stabilization the tractions are unique exactly if this is 0. Beyond 1,200 patches
    /// a lower bound, from each patch alone.
    pub stabilized_dimension: usize,
    /// How many of these push on prescribed displacements or tips only: displacements and all other tractions are unique, and
    /// these stay where they start.
    pub idle_dimension: usize,
    /// Where and why.
    pub findings: Vec<KernelFinding>,
}

/// Whether no corner of a face is split.
fn is_whole(face: &FractureFace) -> bool {
    face.plus.nodes == face.minus.nodes
}

/// Column of B for a unit traction of one global direction on a face: (free displacement's node, ±∫N_a).
type Column = Vec<(u32, f64)>;

/// Entries of the column of face `f` in direction `d`. The two contributions of a tip node cancel exactly.
fn entries<'a>(
    fractures: &'a FractureMesh,
    prescribed: &'a [bool],
    f: usize,
    d: usize,
) -> impl Iterator<Item = (u32, f64)> + 'a {
    let face = &fractures.faces[f];
    (0..4)
        .filter(|a| face.plus.nodes[*a] != face.minus.nodes[*a])
        .flat_map(|a| {
            let area = face.node_areas[a];
            [(face.plus.nodes[a], area), (face.minus.nodes[a], -area)]
        })
        .filter(move |(node, _)| !prescribed[3 * *node as usize + d])
}

/// Rank of the matrix whose sparse columns are given, by the Gram matrix.
fn rank(columns: &[Column]) -> usize {
    let n = columns.len();
    let mut rows: HashMap<u32, Vec<(usize, f64)>> = HashMap::new();
    for (c, column) in columns.iter().enumerate() {
        for (row, value) in column {
            rows.entry(*row).or_default().push((c, *value));
        }
    }
    // fixed order of additions: same bits on every run
    let mut order: Vec<&u32> = rows.keys().collect();
    order.sort_unstable();
    let mut gram = vec![0.0; n * n];
    for entries in order.iter().map(|row| &rows[*row]) {
        for (i, x) in entries {
            for (j, y) in entries {
                gram[i * n + j] += x * y;
            }
        }
    }
    // columns of unit length, so that large and small faces count alike
    let norm: Vec<f64> = (0..n).map(|i| gram[i * n + i].sqrt()).collect();
    for i in 0..n {
        for j in 0..n {
            if norm[i] > 0.0 && norm[j] > 0.0 {
                gram[i * n + j] /= norm[i] * norm[j];
            }
        }
    }
    gram_rank(&mut gram, n, RANK_TOLERANCE)
}

/// Patches: faces of one fracture connected over inner edges, in order of their first face.
pub(super) fn patches(fractures: &FractureMesh) -> Vec<Vec<u32>> {
    let edges = fractures.edges.iter().map(|edge| edge.faces);
    let patches = joined(fractures.faces.len(), edges, |_| true).into_iter();
    let numbers = |patch: Vec<usize>| patch.into_iter().map(|f| f as u32).collect();
    patches.map(numbers).collect()
}

/// Sum of columns.
fn sum_columns(entries: impl Iterator<Item = (u32, f64)>) -> Column {
    let mut list: Column = entries.collect();
    // stable: the entries of a row are added in the order of the columns
    list.sort_by_key(|(row, _)| *row);
    let size = list.iter().fold(0.0f64, |m, (_, v)| m.max(v.abs()));
    list.chunk_by(|a, b| a.0 == b.0)
        .map(|row| (row[0].0, row.iter().fold(0.0, |sum, (_, v)| sum + v)))
        .filter(|(_, sum)| sum.abs() > 1e-12 * size)
        .collect()
}

/// `(node before splitting, copy)` of both sides of a patch, increasing, each once.
fn copies(mesh: &HexMesh, fractures: &FractureMesh, patch: &[u32]) -> Vec<(u32, u32)> {
    let faces = patch.iter().map(|f| &fractures.faces[*f as usize]);
    let nodes = faces.flat_map(|face| face.plus.nodes.into_iter().chain(face.minus.nodes));
    let mut copies: Vec<(u32, u32)> = nodes.map(|n| (mesh.origin[n as usize], n)).collect();
    copies.sort_unstable();
    copies.dedup();
    copies
}

/// Free jumps of the nodes of a patch in direction `d`: an upper bound of the rank of its columns.
fn free_jumps(copies: &[(u32, u32)], prescribed: &[bool], d: usize) -> usize {
    copies
        .chunk_by(|a, b| a.0 == b.0)
        .map(|list| {
            let is_free = |(_, n): &&(u32, u32)| !prescribed[3 * *n as usize + d];
            // rows of one node sum to zero unless a copy is prescribed
            list.iter().filter(is_free).count().min(list.len() - 1)
        })
        .sum()
}

/// Finds tractions without effect; `prescribed[3·node + component]` marks the displacements that are given.
///
/// # Cost
/// O(faces), and two dense ranks where the fractures are small enough.
pub fn coupling_kernel(
    mesh: &HexMesh,
    fractures: &FractureMesh,
    prescribed: &[bool],
) -> CouplingKernel {
    let n = fractures.faces.len();
    let place = |f: u32, reason| KernelFinding {
        fracture: fractures.faces[f as usize].fracture,
        face: f,
        center: fractures.faces[f as usize].center,
        reason,
    };
    let mut kernel = CouplingKernel::default();
    for (f, face) in fractures.faces.iter().enumerate() {
        if is_whole(face) {
            kernel
                .findings
                .push(place(f as u32, KernelReason::NotSplit));
            continue;
        }
        let empty = [0, 1, 2].map(|d: usize| entries(fractures, prescribed, f, d).next().is_none());
        for component in 0..3 {
            if (0..3).all(|d| empty[d] || face.frame[component][d].abs() < 1e-12) {
                kernel
                    .findings
                    .push(place(f as u32, KernelReason::EmptyColumn { component }));
            }
        }
    }
    if n <= DENSE_FACES {
        kernel.dimension = Some(
            (0..3)
                .map(|d| {
                    let columns: Vec<Column> = (0..n)
                        .map(|f| entries(fractures, prescribed, f, d).collect())
                        .collect();
                    n - rank(&columns)
                })
                .sum(),
        );
    }
    let patches = patches(fractures);
    let whole: Vec<bool> = patches
        .iter()
        .map(|p| p.iter().all(|f| is_whole(&fractures.faces[*f as usize])))
        .collect();
    let copies: Vec<Vec<(u32, u32)>> = patches
        .iter()
        .map(|patch| copies(mesh, fractures, patch))
        .collect();
    for d in 0..3 {
        let columns: Vec<Column> = patches
            .iter()
            .map(|p| {
                let faces = p.iter().map(|f| *f as usize);
                sum_columns(faces.flat_map(|f| entries(fractures, prescribed, f, d)))
            })
            .collect();
        let mut alone = 0;
        for (((patch, column), whole), copies) in
            patches.iter().zip(&columns).zip(&whole).zip(&copies)
        {
            let (faces, direction) = (patch.len(), d);
            alone += usize::from(column.is_empty());
            if *whole {
                continue;
            }
            if column.is_empty() {
                kernel.findings.push(place(
                    patch[0],
                    KernelReason::UniformPatch { faces, direction },
                ));
            }
            let jumps = free_jumps(copies, prescribed, d);
            if jumps < faces {
                kernel.findings.push(place(
                    patch[0],
                    KernelReason::Counting {
                        faces,
                        direction,
                        jumps,
                    },
                ));
            }
        }
        kernel.idle_dimension += alone;
        kernel.stabilized_dimension += match patches.len() <= DENSE_PATCHES {
            true => patches.len() - rank(&columns),
            false => alone,
        };
    }
    kernel
}
