//! Scenes.

use crate::arrays::table;
use crate::error::{Kind, Raise, of_any, raise};
use crate::run::{Asked as Steps, Steps as Iterator};
use crate::settings::Asked;
use crate::solver::{self, Solver};
use crate::spectrum;
use crate::system::System;
use crate::watch::Watch;
use crate::work::apart;
use fracas::scene::Scene as Inner;
use fracas::solve::{Problem, StuckBody};
use fracas_experiments::scenes;
use fracas_solvers::saddle::folder::Manifest;
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// A scene that is read.
#[pyclass(frozen, module = "fracas._core")]
pub(crate) struct Scene {
    scene: Inner,
    /// What messages call it.
    name: String,
}

/// Names and questions of the scenes of the gallery.
#[pyfunction]
pub(crate) fn gallery() -> Vec<(&'static str, &'static str)> {
    let all = fracas::scene::gallery().iter();
    all.map(|scene| (scene.name, scene.question)).collect()
}

impl Scene {
    fn stuck(&self, stabilization: f64) -> PyResult<StuckBody> {
        if !(stabilization >= 0.0 && stabilization.is_finite()) {
            return Err(raise(
                Kind::Input,
                format!("stabilization = {stabilization}: the factor is a number ≥ 0"),
            ));
        }
        let mut stuck = StuckBody::of_scene(self.name.as_str(), self.scene.clone());
        stuck.stabilization = stabilization;
        Ok(stuck)
    }

    /// Parts that Python brings need the units of the blocks.
    fn problem(&self, stabilization: f64) -> PyResult<Problem> {
        Ok(Problem::Body(self.stuck(stabilization)?))
    }
}

#[pymethods]
impl Scene {
    /// Of text; `name` is for messages, and its folder is where paths start.
    #[staticmethod]
    fn from_toml(text: &str, name: &str) -> PyResult<Self> {
        let scene = Inner::from_toml(text, name).raised()?;
        Ok(Self {
            scene,
            name: name.into(),
        })
    }

    /// A file, or a name of the gallery (`:small` behind it is its small version).
    #[staticmethod]
    fn load(name: &str) -> PyResult<Self> {
        let scene = scenes::load(name).map_err(|error| of_any(Kind::Scene, &error))?;
        Ok(Self {
            scene,
            name: name.into(),
        })
    }

    /// With values replaced, `key=value` each.
    fn with_overrides(&self, overrides: Vec<String>) -> PyResult<Self> {
        Ok(Self {
            scene: self.scene.with_overrides(&overrides).raised()?,
            name: self.name.clone(),
        })
    }

    /// TOML, defaults left out.
    fn to_toml(&self) -> PyResult<String> {
        self.scene.to_toml().raised()
    }

    #[getter]
    fn title(&self) -> &str {
        self.scene.title()
    }

    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// Nodes of the mesh before fractures split them; 0 where a mesh file does not tell.
    #[getter]
    fn nodes(&self) -> u128 {
        self.scene.nodes()
    }

    /// The system with every face in stick.
    fn system(
        &self,
        py: Python<'_>,
        stabilization: f64,
        observer: Option<Py<PyAny>>,
    ) -> PyResult<System> {
        let stuck = self.stuck(stabilization)?;
        let stop = AtomicBool::new(false);
        apart(py, &stop, || {
            let mut watch = Watch::new(&stop, observer);
            let assembled = stuck.assemble(&mut watch).raised();
            let (body, blocks) = watch.end(assembled)?;
            let mut manifest = Manifest {
                scene: Some(self.name.clone()),
                step: Some(0),
                newton: Some(0),
                states: Some(vec![0; body.fractures.faces.len()]),
                units: Some("SI".into()),
                ..Manifest::default()
            };
            let other = &mut manifest.other;
            other.insert("stabilization".into(), stabilization.into());
            Ok(System::of_scene(blocks.into(), manifest))
        })
    }

    /// Sets up and solves as `fracas solve` does, without an assembled A where that serves.
    #[pyo3(signature = (asked, stabilization, b=None, observer=None))]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        asked: Asked,
        stabilization: f64,
        b: Option<PyReadonlyArray1<'py, f64>>,
        observer: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let settings = asked.settings(None)?;
        solver::solve(py, &settings, &self.problem(stabilization)?, b, observer)
    }

    /// A preconditioner that is set up, for many right-hand sides.
    #[pyo3(signature = (asked, stabilization, observer=None))]
    fn set_up(
        &self,
        py: Python<'_>,
        asked: Asked,
        stabilization: f64,
        observer: Option<Py<PyAny>>,
    ) -> PyResult<Solver> {
        let settings = asked.settings(None)?;
        Solver::new(py, settings, &self.problem(stabilization)?, observer)
    }

    /// Eigenvalues of M⁻¹𝒜, as JSON.
    #[pyo3(signature = (asked, stabilization, dense_limit, observer=None))]
    fn spectrum(
        &self,
        py: Python<'_>,
        asked: Asked,
        stabilization: f64,
        dense_limit: Option<usize>,
        observer: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let settings = asked.settings(None)?;
        let from = spectrum::From::Problem;
        let problem = self.problem(stabilization)?;
        spectrum::spectrum(py, &settings, &problem, from, dense_limit, observer)
    }

    /// Nodes, elements and fracture faces as arrays.
    fn mesh<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let stop = AtomicBool::new(false);
        let body = apart(py, &stop, || self.scene.build().raised())?;
        let arrays = PyDict::new(py);
        let (mesh, faces) = (&body.mesh, &body.fractures.faces);
        arrays.set_item("nodes", table(py, mesh.nodes.as_flattened().to_vec(), 3)?)?;
        let elements = mesh.elements.iter().flatten().map(|n| i64::from(*n));
        arrays.set_item("elements", table(py, elements.collect(), 8)?)?;
        let regions = mesh.regions.iter().map(|r| i32::from(*r)).collect();
        arrays.set_item("regions", crate::arrays::given::<i32>(py, regions))?;
        let sides = |plus: bool| {
            let side = move |f: &fracas::mesh::FractureFace| match plus {
                true => f.plus.nodes,
                false => f.minus.nodes,
            };
            let nodes = faces.iter().flat_map(side).map(i64::from);
            table(py, nodes.collect(), 4)
        };
        arrays.set_item("faces_minus", sides(false)?)?;
        arrays.set_item("faces_plus", sides(true)?)?;
        let centers = faces.iter().flat_map(|f| f.center).collect::<Vec<f64>>();
        arrays.set_item("centers", table(py, centers, 3)?)?;
        let frames = faces.iter().flat_map(|f| f.frame).flatten();
        arrays.set_item("frames", table(py, frames.collect(), 9)?)?;
        let areas = faces.iter().map(|f| f.area).collect();
        arrays.set_item("areas", crate::arrays::given::<f64>(py, areas))?;
        let fractures = faces.iter().map(|f| i32::from(f.fracture)).collect();
        arrays.set_item("fractures", crate::arrays::given::<i32>(py, fractures))?;
        arrays.set_item("fracture_names", body.fractures.names.clone())?;
        arrays.set_item("material_names", body.material_names)?;
        Ok(arrays)
    }

    /// Steps in time, each computed when it is asked for.
    #[pyo3(signature = (out, restart, steps, fields_every, clock, fields, observer=None))]
    fn run(
        &self,
        out: Option<PathBuf>,
        restart: Option<PathBuf>,
        steps: Option<usize>,
        fields_every: usize,
        clock: bool,
        fields: bool,
        observer: Option<Py<PyAny>>,
    ) -> PyResult<Iterator> {
        if fields_every == 0 || steps == Some(0) {
            return Err(raise(
                Kind::Input,
                "steps and fields_every are numbers from 1 on",
            ));
        }
        Iterator::new(Steps {
            scene: self.scene.clone(),
            name: self.name.clone(),
            out,
            restart,
            steps,
            fields_every,
            clock,
            fields,
            observer,
        })
    }
}
