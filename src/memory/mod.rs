//! Memory of this process: what it took, and whether there is enough for what it is asked.

mod free;

use crate::mesh::MAX_NODES;
use crate::scene::{Scene, SceneSize};
use fracas_operators::{LinearOperator, Preconditioner};
use fracas_solvers::krylov::{Fitted, KrylovChoice};
use fracas_solvers::multigrid::Summary;
use free::kibibytes;
use std::path::Path;

pub use free::{available_bytes, limits_addresses};

/// What the parts of a mesh take [bytes].
#[derive(Clone, Copy, Debug)]
struct Parts {
    /// A node before fractures split them.
    node: f64,
    /// A copy that they make.
    copy: f64,
    /// A fracture face.
    face: f64,
    /// A copy beyond one per face: where fractures cross.
    crossing: f64,
    /// A copy beyond two per face: around cells that fractures enclose on all sides, which no grid coarsens.
    enclosed: f64,
}

/// What a piece of work takes at its peak.
#[derive(Clone, Copy, Debug)]
pub struct Work {
    /// Where no map moves the nodes.
    bricks: Parts,
    /// Where one does.
    mapped: Parts,
    /// What to do where it does not fit.
    remedy: &'static str,
}

/// The process itself [bytes].
const PROCESS: f64 = 10e6;

/// Parts of three sorts, whatever the network.
const fn parts([node, copy, face]: [f64; 3]) -> Parts {
    Parts {
        node,
        copy,
        face,
        crossing: 0.0,
        enclosed: 0.0,
    }
}

/// The same with what a hierarchy takes beside them for dense networks: what blocks leave of its coarsest grid.
const fn with_hierarchy(sizes: [f64; 3]) -> Parts {
    Parts {
        crossing: CROSSING,
        enclosed: ENCLOSED,
        ..parts(sizes)
    }
}

const fn both(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

const FEWER_CELLS: &str = "use fewer cells, e.g. mesh.x.cells=8";

/// Mesh, fractures, sides and their audit.
pub const CHECK: Work = Work {
    bricks: parts(CHECKED),
    mapped: parts(CHECKED),
    remedy: FEWER_CELLS,
};

/// The same with the bound of the inf-sup constant from the elements at the fractures.
pub const CERTIFICATE: Work = Work {
    bricks: parts(CERTIFIED),
    mapped: parts(CERTIFIED),
    remedy: FEWER_CELLS,
};

/// Mesh and assembled blocks, without any factorization.
pub const BLOCKS: Work = Work {
    bricks: parts(ASSEMBLED),
    mapped: parts(ASSEMBLED),
    remedy: "use fewer cells, e.g. mesh.x.cells=8, or solve with inner = \"geometric\", which assembles no A",
};

/// Mesh on each rank of this machine, `beside` of `ranks`, and what these have of blocks, hierarchy and vectors.
#[cfg(feature = "petsc")]
pub fn over_ranks(ranks: usize, beside: usize) -> Work {
    let spread = |k: usize| beside as f64 * (REPLICATED[k] + SPREAD[k] / ranks as f64);
    let parts = parts([spread(0), spread(1), spread(2)]);
    Work {
        bricks: parts,
        mapped: parts,
        remedy: "use fewer cells, or more machines",
    }
}

/// Mesh, numbering and what every rank holds of the fractures.
#[cfg(feature = "petsc")]
const REPLICATED: [f64; 3] = [500.0, 500.0, 3000.0];

/// Rows of A, those of S_u in PETSc, its hierarchy, a basis of GMRES.
#[cfg(feature = "petsc")]
const SPREAD: [f64; 3] = [13_000.0, 13_000.0, 0.0];

/// Mesh, operator, hierarchy and the vectors of one solve, without an assembled A.
pub const MATRIX_FREE: Work = Work {
    bricks: with_hierarchy(ON_BRICKS),
    mapped: with_hierarchy(ON_HEXAHEDRA),
    remedy: FEWER_CELLS,
};

/// The same with assembled blocks beside it.
pub const EXPLAINED: Work = Work {
    bricks: with_hierarchy(both(ON_BRICKS, ASSEMBLED)),
    mapped: with_hierarchy(both(ON_HEXAHEDRA, ASSEMBLED)),
    remedy: "use fewer cells, e.g. mesh.x.cells=8, or ask for no explanation",
};

/// Measured on 23 thousand to 1.8 million nodes, networks with up to 1.3 faces per node and a bar of 1:100,000: 0.96 to 1.45 of the peak.
const CHECKED: [f64; 3] = [130.0, 100.0, 500.0];

/// As [`CHECKED`], with B, H and vectors per face.
const CERTIFIED: [f64; 3] = [140.0, 110.0, 3000.0];

/// Measured on 120 thousand nodes.
const ASSEMBLED: [f64; 3] = [4200.0, 4200.0, 1000.0];

/// Measured on 0.9 million nodes with few fractures, and on a network of 147 thousand faces; with the vectors of SQMR, the least that
/// a solve takes.
const ON_BRICKS: [f64; 3] = [400.0, 400.0, 3000.0];

/// As [`ON_BRICKS`].
const ON_HEXAHEDRA: [f64; 3] = [870.0, 870.0, 3000.0];

/// What a hierarchy takes per copy beyond one per face, and per copy beyond two [bytes]. Measured on held networks of fractures on every
/// line (16³ and 24³ cells: 0.97 and 1.01 of the peak), every second (24³: 1.09), third (24³: 0.44) and fourth one (24³ and 40³: 0.90 and 0.95).
const CROSSING: f64 = 8000.0;

/// See [`CROSSING`].
const ENCLOSED: f64 = 60_000.0;

/// What reading and checking a mesh file takes per node at its peak [bytes]: 305 to 320 measured on 1.0 million nodes, in
/// text and binary.
const PER_NODE_OF_FILE: f64 = 400.0;

impl Work {
    /// At its peak [bytes].
    pub fn bytes(&self, size: SceneSize, bricks: bool) -> f64 {
        let Parts {
            node,
            copy,
            face,
            crossing,
            enclosed,
        } = if bricks { self.bricks } else { self.mapped };
        let [nodes, copies, faces] = [size.nodes, size.copies, size.faces].map(|n| n as f64);
        let beyond = |per_face: f64| (copies - per_face * faces).max(0.0);
        let hierarchy = crossing * beyond(1.0) + enclosed * beyond(2.0);
        PROCESS + node * nodes + copy * copies + face * faces + hierarchy
    }
}

/// A scene that does not fit.
#[derive(Debug, thiserror::Error)]
#[error(
    "{scene}: {nodes} grid nodes{} take about {needed:.1} GB and {available:.1} GB are free; {remedy}", and_faces(*faces)
)]
pub struct TooLarge {
    /// Its name.
    pub scene: String,
    /// Nodes before fractures split them.
    pub nodes: u128,
    /// Fracture faces.
    pub faces: u128,
    /// What it takes [GB].
    pub needed: f64,
    /// What is free [GB].
    pub available: f64,
    remedy: &'static str,
}

fn and_faces(faces: u128) -> String {
    match faces {
        0 => String::new(),
        faces => format!(" and {faces} fracture faces"),
    }
}

/// Refuses a scene that takes more memory than there is to take, before any of it is taken.
///
/// # Errors
/// [`TooLarge`] with what it takes and what is free.
pub fn room_for(name: &str, scene: &Scene, work: Work) -> Result<(), TooLarge> {
    // beyond the numbering of the mesh, which has its own message
    if scene.nodes() > MAX_NODES {
        return Ok(());
    }
    // nodes alone first: lines of an axis take memory, too
    let nodes = SceneSize {
        nodes: scene.nodes(),
        ..SceneSize::default()
    };
    room(name, scene, work, nodes)?;
    room(name, scene, work, scene.size())
}

fn room(name: &str, scene: &Scene, work: Work, size: SceneSize) -> Result<(), TooLarge> {
    let mesh = &scene.sections().mesh;
    let mut needed = work.bytes(size, mesh.file.is_none() && mesh.map.is_none());
    let mut remedy = work.remedy;
    // as many elements as nodes, at most
    let pores = scene.pore_room();
    needed += pores.per_element * size.nodes as f64 + pores.reading;
    if mesh.file.is_some() {
        needed = needed.max(PER_NODE_OF_FILE * size.nodes as f64);
        remedy = "use a coarser mesh";
    }
    match available_bytes() {
        Some(available) if needed > available as f64 => Err(TooLarge {
            scene: name.to_owned(),
            nodes: size.nodes,
            faces: size.faces,
            needed: needed * 1e-9,
            available: available as f64 * 1e-9,
            remedy,
        }),
        _ => Ok(()),
    }
}

/// A second hierarchy that does not fit.
#[derive(Debug, thiserror::Error)]
#[error("it takes about {needed:.1} GB and {available:.1} GB are free")]
pub struct NoRoomInDouble {
    /// What it takes [GB].
    pub needed: f64,
    /// What is free [GB].
    pub available: f64,
}

/// Refuses the hierarchy in f64 beside the one in f32 where its numbers alone, twice as long, do not fit.
///
/// # Errors
/// [`NoRoomInDouble`] with what it takes and what is free.
pub fn room_in_double(single: Option<&Summary>) -> Result<(), NoRoomInDouble> {
    let levels = single.iter().flat_map(|summary| &summary.levels);
    let needed = 2.0 * levels.map(|level| level.bytes).sum::<usize>() as f64;
    match available_bytes() {
        Some(available) if needed > SHARE * available as f64 => Err(NoRoomInDouble {
            needed: needed * 1e-9,
            available: available as f64 * 1e-9,
        }),
        _ => Ok(()),
    }
}

/// A factorization that does not fit.
#[derive(Debug, thiserror::Error)]
#[error(
    "a factorization of {displacements} displacements takes about {needed:.1} GB and {available:.1} GB are free"
)]
pub struct NoRoomToFactorize {
    /// How many there are.
    pub displacements: usize,
    /// What it takes [GB].
    pub needed: f64,
    /// What is free [GB].
    pub available: f64,
}

/// What S_u and its factors take beside A, per displacement to the power of 4/3 [bytes]: with nested dissection the factors of a body in three
/// dimensions grow so. Measured peaks of whole solves, cubes with one fracture and networks of 9 to 156 thousand displacements: 260 to 430.
const FACTORS: f64 = 350.0;

/// Refuses a factorization of so many displacements that would not fit into what is `available`, where that is known.
///
/// # Errors
/// [`NoRoomToFactorize`] with what it takes and what is free.
pub fn room_to_factorize(
    displacements: usize,
    available: Option<u64>,
) -> Result<(), NoRoomToFactorize> {
    let needed = FACTORS * (displacements as f64).powf(4.0 / 3.0);
    match available {
        Some(available) if needed > SHARE * available as f64 => Err(NoRoomToFactorize {
            displacements,
            needed: needed * 1e-9,
            available: available as f64 * 1e-9,
        }),
        _ => Ok(()),
    }
}

/// Share of the free memory that vectors may take: the rest is for what the estimate does not know.
const SHARE: f64 = 0.9;

/// Vectors of `n` numbers that fit into memory now; as many as anybody wants where the system does not tell.
fn vectors_that_fit(n: usize) -> usize {
    let bytes = 8.0 * n.max(1) as f64;
    available_bytes().map_or(usize::MAX, |free| (SHARE * free as f64 / bytes) as usize)
}

/// Vectors that no iteration has room for.
#[derive(Debug, thiserror::Error)]
#[error(
    "memory holds {vectors} more vectors of {n} unknowns ({:.1} MB each) and the shortest iteration takes 8; use fewer cells, or free memory", 8e-6 * *n as f64
)]
pub struct NoRoom {
    /// That fit.
    pub vectors: usize,
    /// Length of one.
    pub n: usize,
}

/// The iteration whose vectors fit, beside the scratch of the product and of the preconditioner.
///
/// # Errors
/// [`NoRoom`] where not even the shortest recurrence fits.
pub fn krylov_that_fits(
    operator: &dyn LinearOperator<f64>,
    preconditioner: &dyn Preconditioner<f64>,
    symmetric: bool,
) -> Result<Fitted, NoRoom> {
    let vectors = vectors_beside(operator, preconditioner);
    krylov_of(vectors, preconditioner, symmetric)
}

/// Vectors that fit beside the scratch memory of both and the solution.
pub fn vectors_beside(
    operator: &dyn LinearOperator<f64>,
    preconditioner: &dyn Preconditioner<f64>,
) -> usize {
    let n = preconditioner.size();
    let scratch = operator.work_len().max(preconditioner.work_len());
    let taken = 1 + scratch.div_ceil(n.max(1));
    vectors_that_fit(n).saturating_sub(taken)
}

/// The iteration for which so many vectors suffice.
///
/// # Errors
/// [`NoRoom`] where none does.
pub fn krylov_of(
    vectors: usize,
    preconditioner: &dyn Preconditioner<f64>,
    symmetric: bool,
) -> Result<Fitted, NoRoom> {
    let n = preconditioner.size();
    let fitted = KrylovChoice::fitted(vectors, symmetric, preconditioner);
    fitted.ok_or(NoRoom { vectors, n })
}

/// High-water mark of the resident set [bytes], where the system tells (Linux).
pub fn peak_bytes() -> Option<u64> {
    kibibytes(Path::new("/proc/self/status"), "VmHWM:")
}

/// Lets the high-water mark start again from what is resident now, where the system allows it (Linux).
pub fn reset_peak() {
    // elsewhere the mark is that of the whole process, as before
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Peaks of `solve` with geometric multigrid [MiB] behind the nodes, copies and faces of networks.
    const PEAKS: [(u128, u128, u128, f64); 6] = [
        (4913, 27_855, 11_520, 473.0),
        (15_625, 94_967, 39_744, 1464.0),
        (15_625, 31_031, 19_008, 159.0),
        (15_625, 17_143, 12_096, 218.0),
        (15_625, 11_375, 8640, 73.0),
        (68_921, 56_079, 43_200, 294.0),
    ];

    /// Networks of 16³, 24³ and 40³ cells with fractures on every, every second, third and fourth line, sides held.
    #[test]
    fn the_estimate_of_a_dense_network_is_near_its_measured_peak() {
        for (nodes, copies, faces, peak) in PEAKS {
            let size = SceneSize {
                nodes,
                copies,
                faces,
            };
            let ratio = MATRIX_FREE.bytes(size, true) / (peak * 1_048_576.0);
            assert!((0.4..1.2).contains(&ratio), "{size:?}: {ratio}");
        }
    }
}
