//! Scenes: what is written in a TOML file, checked, and turned into a [`Body`] that can be assembled.

mod acting;
mod body;
mod box_tree;
mod build;
mod csv_table;
mod error;
mod flow;
mod flow_problem;
mod flow_sections;
mod from_file;
mod gallery;
mod geology;
mod geometry;
mod group_names;
mod history;
mod hold;
mod inventory;
mod latest;
mod located;
mod mesh_sections;
mod one_or_many;
mod onset;
mod outline;
mod overrides;
mod part_of_side;
mod pore_pressure;
mod pores;
mod profile;
mod rocks;
mod rounds;
#[cfg(test)]
pub(crate) mod sample;
mod sections;
mod sides;
mod size;
mod solver_section;
mod source;
mod surface_section;
mod table_problem;
mod used;
mod weight;
mod weight_above;
mod wells;
mod whole_lists;

use std::path::{Path, PathBuf};

pub use crate::contact::{Friction, Weakening, WeakeningBy};
pub use body::{Body, InitialStress, PoreChange, Pull, SurfaceTraction};
pub use error::{Place, Problem, SceneError};
pub use flow_problem::FlowProblem;
pub use flow_sections::{FluidSection, SourceSection, WellSection};
pub use gallery::{GalleryScene, gallery, named};
pub use geology::{
    CompartmentSection, Geology, GeologyProblem, GeologySection, LayerSection, Moved, Piece, Remark,
};
pub use group_names::GroupNames;
pub use history::{History, TimeTable};
pub use inventory::{Inventory, Push, Stock};
pub use mesh_sections::{
    AxisName, AxisSection, DiscSection, DistortSection, FractureSection, InclineSection,
    MapSection, MeshSection, RotateSection, ShearSection,
};
pub use one_or_many::OneOrMany;
pub use onset::{Onset, OnsetProblem, OnsetSection};
pub use part_of_side::PartProblem;
pub use pore_pressure::{Between, Points, PorePressureSection};
pub use pores::{
    DrawdownSection, FarFace, FromFace, Interpolation, PoreField, PoreProblem, PoreRoom,
};
pub use profile::{LevelSection, Profile, ProfileProblem};
pub use rounds::Rounds;
pub use sections::{
    BoundarySection, BoxSection, ComponentsSection, HoldSection, InitialStressSection,
    MaterialSection, SceneSections, SideName, TensorSection,
};
pub use sides::PressureFrom;
pub use size::SceneSize;
pub use solver_section::{
    AugmentedLagrangian, FACTORIZED, Method, Penalty, RunInner, SolverSection, TimeSection,
    Unstable,
};
pub use surface_section::{LiftSection, SurfacePoints, SurfaceProblem, SurfaceSection};
pub use table_problem::TableProblem;
pub use weight::{WeightSection, WeightStress};

pub(crate) use latest::Latest;

use crate::mesh::{GmshFile, is_thin};
use serde::de::DeserializeOwned;
use source::Source;

/// A scene: its sections and the text that they came from.
///
/// ```
/// use fracas::prelude::*;
///
/// let scene = named("crossing").ok_or("a scene of the gallery")?.scene()?;
/// let finer = scene.with_overrides(&["mesh.x.cells=20", "material.rock.young=20 GPa"])?;
/// assert!(finer.size().nodes > scene.size().nodes);
/// // an unknown key is an error that names the nearest one
/// assert!(scene.with_overrides(&["mesh.x.cell=20"]).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene {
    sections: SceneSections,
    /// What its `[geology]` has become in `sections`.
    geology: Option<Geology>,
    source: Source,
    /// Where paths in the scene start.
    folder: PathBuf,
}

/// What the name of a scene with overrides ends with.
const OVERRIDDEN: &str = " with overrides";

impl Scene {
    /// Reads a scene from text; `file_name` is for messages, and its folder is where the path of a mesh file starts.
    ///
    /// # Errors
    /// [`SceneError`] with line, column and excerpt: syntax, unknown keys with their nearest match, values out of range.
    pub fn from_toml(text: &str, file_name: &str) -> Result<Self, SceneError> {
        let folder = Path::new(file_name).parent().unwrap_or(Path::new(""));
        Self::read(text, file_name, folder)
    }

    fn read(text: &str, file_name: &str, folder: &Path) -> Result<Self, SceneError> {
        let source = Source::new(text, file_name);
        let mut sections = source.parse()?;
        let placed = |e| build::placed(e, &source);
        pore_pressure::read_files(&mut sections, folder).map_err(placed)?;
        let geology = geology::expand(&mut sections).map_err(placed)?;
        Ok(Self {
            sections,
            geology,
            source,
            folder: folder.into(),
        })
    }

    /// Reads a scene from a file.
    ///
    /// # Errors
    /// [`SceneError`], also if the file cannot be read.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        let name = path.as_ref().display().to_string();
        let text = std::fs::read_to_string(&path).map_err(|source| SceneError::Read {
            file: name.clone(),
            source,
        })?;
        let folder = path.as_ref().parent().unwrap_or(Path::new(""));
        Self::read(&text, &name, folder)
    }

    /// The same scene with values replaced: `mesh.x.cells=8`, `material.rock.young=20 GPa`, `boundary.0.side=z+`.
    ///
    /// # Errors
    /// [`SceneError`] if an override has no `=`, leads nowhere, or makes the scene invalid.
    pub fn with_overrides<S: AsRef<str>>(&self, overrides: &[S]) -> Result<Self, SceneError> {
        if overrides.is_empty() {
            return Ok(self.clone());
        }
        let text = overrides::apply(&self.source, overrides)?;
        let file = self.source.file();
        let name = match file.ends_with(OVERRIDDEN) {
            true => file.to_owned(),
            false => format!("{file}{OVERRIDDEN}"),
        };
        Self::read(&text, &name, &self.folder)
    }

    /// What the `[geology]` of the scene has become, where it has one.
    pub fn geology(&self) -> Option<&Geology> {
        self.geology.as_ref()
    }

    /// The sections, as typed data; grid lines, boxes and a shear in the place of `[geology]`.
    pub fn sections(&self) -> &SceneSections {
        &self.sections
    }

    /// Title.
    pub fn title(&self) -> &str {
        &self.sections.title
    }

    /// The scene as TOML with every default left out, and with what `[geology]` has become in its place; reads back as the same sections from any folder: paths of
    /// meshes and fields of pressure become absolute.
    ///
    /// # Errors
    /// [`SceneError::Write`] if a value has no TOML form.
    pub fn to_toml(&self) -> Result<String, SceneError> {
        let mut sections = self.sections.clone();
        if let Some(file) = &mut sections.mesh.file {
            let path = self.folder.join(&*file);
            // without a current folder the path stays as good as it was
            *file = std::path::absolute(&path).unwrap_or(path);
        }
        pore_pressure::make_absolute(&mut sections, &self.folder);
        Ok(toml::to_string(&sections)?)
    }

    /// Nodes of the mesh before fractures split them; 0 as in [`Scene::size`].
    pub fn nodes(&self) -> u128 {
        match &self.sections.mesh.file {
            Some(file) => {
                let announced = GmshFile::announced_nodes(&self.folder.join(file));
                announced.map_or(0, u128::from)
            }
            None => self.sections.mesh.nodes(),
        }
    }

    /// How large the mesh will be, as the grid and its fractures or the head of the mesh file say; 0 where they say nothing, which
    /// [`Scene::build`] explains.
    pub fn size(&self) -> SceneSize {
        match &self.sections.mesh.file {
            Some(_) => SceneSize {
                nodes: self.nodes(),
                ..SceneSize::default()
            },
            None => SceneSize::of_grid(&self.sections),
        }
    }

    /// True where the mesh is a grid that is [thin](crate::mesh::is_thin); false where its lines cannot be made, which [`Scene::build`] explains.
    ///
    /// # Cost
    /// O(lines).
    pub fn is_thin(&self) -> bool {
        let mesh = &self.sections.mesh;
        mesh.file.is_none() && size::mesh_lines(mesh).is_some_and(|lines| is_thin(&lines))
    }

    /// What pressures that differ from element to element take of memory.
    ///
    /// # Cost
    /// The first line of CSV files is read.
    pub fn pore_room(&self) -> PoreRoom {
        PoreRoom::new(&self.sections, &self.folder)
    }

    /// Mesh, materials, boundary conditions and loads.
    ///
    /// # Cost
    /// O(elements).
    ///
    /// # Errors
    /// [`SceneError`] with the line of the section that cannot be met, or [`SceneError::NotHeld`].
    pub fn build(&self) -> Result<Body, SceneError> {
        build::build(&self.sections, &self.source, &self.folder)
    }
}

/// Data of another kind from TOML, with the same messages as a scene: line, column, nearest match; `file_name` is for them.
///
/// # Errors
/// [`SceneError`]: syntax, unknown keys, values out of range.
pub fn read_toml<D: DeserializeOwned>(text: &str, file_name: &str) -> Result<D, SceneError> {
    Source::new(text, file_name).parse()
}

/// JSON Schema of the scene file.
pub fn schema() -> schemars::Schema {
    schemars::schema_for!(SceneSections)
}
