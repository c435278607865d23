//! What is solved, and how it becomes matrices.

use super::{Finding, SolveError, SystemKind};
use crate::contact::JumpStabilization;
use crate::memory::{self, Work};
use crate::mesh::Grid;
use crate::scene::{Body, Scene};
use crate::undetermined::undetermined;
use fracas_operators::Layout;
use fracas_operators::matrix_market::read_sizes;
use fracas_solvers::Observer;
use fracas_solvers::saddle::folder::read_folder;
use fracas_solvers::saddle::{Measure, P, SaddleBlocks, T, U};
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

/// What is solved.
#[derive(Clone, Debug)]
pub enum Problem {
    /// A scene or a body with every face in stick.
    Body(StuckBody),
    /// A system folder (`A.mtx`, `B1.mtx`, …).
    Folder(PathBuf),
    /// Matrices, in the units that they are solved in unless another one is asked for.
    Blocks(Arc<SaddleBlocks>),
}

/// A body with every face in stick.
#[derive(Clone, Debug)]
pub struct StuckBody {
    /// What messages call it.
    pub name: String,
    /// Factor of the jump stabilization H; 0 leaves it out. Unit: 1.
    pub stabilization: f64,
    mesh: Mesh,
}

#[derive(Clone, Debug)]
enum Mesh {
    /// Made where it is needed, and given back.
    Scene(Box<Scene>),
    Made(Arc<Body>),
}

impl StuckBody {
    /// Of a scene; its mesh is made when it is needed, does not outlive the set-up where nothing is assembled, and is made again where
    /// f32 fails.
    pub fn of_scene(name: impl Into<String>, scene: Scene) -> Self {
        Self {
            name: name.into(),
            stabilization: 1.0,
            mesh: Mesh::Scene(Box::new(scene)),
        }
    }

    /// Of a body that is there.
    pub fn of_body(name: impl Into<String>, body: impl Into<Arc<Body>>) -> Self {
        Self {
            name: name.into(),
            stabilization: 1.0,
            mesh: Mesh::Made(body.into()),
        }
    }

    /// True where cells lie on a grid.
    pub(super) fn is_grid(&self) -> bool {
        match &self.mesh {
            Mesh::Scene(scene) => scene.sections().mesh.file.is_none(),
            Mesh::Made(body) => body.mesh.grid.is_some(),
        }
    }

    /// True where the grid is thin beside its cells.
    fn is_thin(&self) -> bool {
        match &self.mesh {
            Mesh::Scene(scene) => scene.is_thin(),
            Mesh::Made(body) => body.mesh.grid.as_ref().is_some_and(Grid::is_thin),
        }
    }

    /// Jump stabilization, unless it is left out.
    pub fn stabilization(&self, body: &Body) -> Option<JumpStabilization> {
        (self.stabilization > 0.0).then_some(JumpStabilization {
            scale: self.stabilization,
            ..body.jump_stabilization()
        })
    }

    /// The mesh, which fits into memory for this work and whose answer is unique.
    ///
    /// # Errors
    /// [`SolveError`].
    pub fn mesh(&self, work: Work, observer: &mut dyn Observer) -> Result<Arc<Body>, SolveError> {
        let body = match &self.mesh {
            Mesh::Made(body) => body.clone(),
            Mesh::Scene(scene) => {
                memory::room_for(&self.name, scene, work)?;
                observer.say(&format_args!("{}: meshing", scene.title()));
                scene.build()?.into()
            }
        };
        if let Some(sentence) = undetermined(&self.name, &body)? {
            observer.say(&format_args!("warning: {sentence}"));
        }
        Ok(body)
    }

    /// The mesh and its blocks.
    ///
    /// # Errors
    /// [`SolveError`].
    pub fn assemble(
        &self,
        observer: &mut dyn Observer,
    ) -> Result<(Arc<Body>, SaddleBlocks), SolveError> {
        let body = self.mesh(memory::BLOCKS, observer)?;
        observer.say(&"assembling");
        let blocks = body
            .saddle_blocks(self.stabilization(&body))
            .map_err(|source| SolveError::Assembly {
                name: self.name.clone(),
                source,
            })?;
        Ok((body, blocks))
    }
}

impl From<Scene> for Problem {
    fn from(scene: Scene) -> Self {
        Self::Body(StuckBody::of_scene(scene.title().to_owned(), scene))
    }
}

impl From<Arc<Body>> for Problem {
    fn from(body: Arc<Body>) -> Self {
        Self::Body(StuckBody::of_body("the body", body))
    }
}

impl From<SaddleBlocks> for Problem {
    fn from(blocks: SaddleBlocks) -> Self {
        Self::Blocks(blocks.into())
    }
}

/// Matrices with what is known of their origin.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// 𝒜 and b, tractions in the units of the system.
    pub blocks: Arc<SaddleBlocks>,
    /// The meshed body, where they come from one.
    pub body: Option<Arc<Body>>,
    /// Remarks of the import.
    pub findings: Vec<Finding>,
    /// False where there is no right-hand side at all.
    pub has_rhs: bool,
    /// True when fracas assembled them, now or before an export: then it chooses the units that they are solved in.
    pub is_ours: bool,
}

impl Loaded {
    fn of_blocks(blocks: Arc<SaddleBlocks>) -> Self {
        Self {
            has_rhs: blocks.rhs().iter().any(|b| *b != 0.0),
            blocks,
            body: None,
            findings: Vec::new(),
            is_ours: false,
        }
    }

    /// The unit of tractions that is taken where none is asked for: the one that balances both rows. A system of another code keeps its own
    /// where residuals are compared, or beside flow.
    pub(crate) fn traction_unit(&self, measure: Measure) -> f64 {
        let is_free = self.is_ours || measure == Measure::Error && self.blocks.flow.is_none();
        if is_free {
            self.blocks.traction_unit()
        } else {
            1.0
        }
    }

    /// n_u, n_t, n_p.
    pub fn sizes(&self) -> Sizes {
        Sizes::of(&self.blocks.layout())
    }
}

impl Problem {
    /// True of a scene with settings for its runs, which are not those of one system.
    pub(super) fn has_own_solver(&self) -> bool {
        match self {
            Self::Body(StuckBody {
                mesh: Mesh::Scene(scene),
                ..
            }) => scene.sections().solver.is_some(),
            _ => false,
        }
    }

    /// About how many displacements it has, those that are held among them, where heads of files and sizes of grids tell.
    pub(super) fn displacements(&self) -> Option<u128> {
        match self {
            Self::Body(stuck) => match &stuck.mesh {
                Mesh::Scene(scene) => Some(3 * scene.nodes()).filter(|n| *n > 0),
                Mesh::Made(body) => Some(body.constraints.free_len() as u128),
            },
            Self::Blocks(blocks) => Some(blocks.n_u() as u128),
            Self::Folder(folder) => {
                let announced = read_sizes(&folder.join("A.mtx"));
                announced.ok().map(|announced| announced.shape.rows as u128)
            }
        }
    }

    /// What decides on the inner solver.
    pub fn kind(&self) -> SystemKind {
        match self {
            Self::Body(body) if !body.is_grid() => SystemKind::Mesh,
            Self::Body(body) if body.is_thin() => SystemKind::Thin,
            Self::Body(_) => SystemKind::Grid,
            Self::Folder(_) | Self::Blocks(_) => SystemKind::Matrices,
        }
    }

    /// Reads or assembles the matrices; remarks go to the observer as well.
    ///
    /// # Errors
    /// [`SolveError`].
    pub fn load(&self, observer: &mut dyn Observer) -> Result<Loaded, SolveError> {
        let folder = match self {
            Self::Body(stuck) => {
                let (body, blocks) = stuck.assemble(observer)?;
                return Ok(Loaded {
                    body: Some(body),
                    is_ours: true,
                    ..Loaded::of_blocks(blocks.into())
                });
            }
            Self::Blocks(blocks) => return Ok(Loaded::of_blocks(blocks.clone())),
            Self::Folder(folder) => folder,
        };
        let imported = read_folder(folder)?;
        for finding in &imported.findings {
            observer.say(&format_args!("note: {finding}"));
        }
        Ok(Loaded {
            blocks: imported.blocks.into(),
            body: None,
            findings: (imported.findings.into_iter())
                .map(Finding::Import)
                .collect(),
            has_rhs: imported.has_rhs,
            is_ours: imported.manifest.is_ours(),
        })
    }
}

/// n_u, n_t, n_p.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes(pub [usize; 3]);

impl Sizes {
    pub(super) fn of(layout: &Layout) -> Self {
        Self([U, T, P].map(|field| layout.length(field)))
    }
}

impl fmt::Display for Sizes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [n_u, n_t, n_p] = self.0;
        write!(f, "n_u = {n_u}, n_t = {n_t}, n_p = {n_p}")
    }
}
