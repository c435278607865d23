//! Systems `[A B1; B2 −H]`: from matrices, from folders, to folders; solved, analysed, multiplied with.

use crate::arrays::{Rows, coordinates, table, vector};
use crate::error::{Kind, Raise, raise};
use crate::operator::{Operator, Preconditioner};
use crate::settings::{Asked, Settings, augmentation};
use crate::shared::{self, Keeps};
use crate::solver::{self, Solver};
use crate::spectrum;
use crate::work::apart;
use fracas::solve::{Finding, Loaded, Problem, RightHandSide};
use fracas_operators::sparse::SparseMatrix;
use fracas_solvers::DofCoordinate;
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::saddle::folder::{self, Manifest, inspect_blocks, read_folder, write_folder};
use fracas_solvers::saddle::{FlowBlocks, SaddleBlocks};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Blocks with what is known of their origin.
#[pyclass(frozen, module = "fracas._core")]
pub(crate) struct System {
    pub(crate) blocks: Arc<SaddleBlocks>,
    manifest: Manifest,
    has_rhs: bool,
    findings: Vec<Finding>,
}

impl Keeps for System {
    fn matrix(&self, name: &str) -> Option<&SparseMatrix<f64>> {
        let (blocks, flow) = (&*self.blocks, self.blocks.flow.as_ref());
        match name {
            "A" => Some(&blocks.a),
            "B1" => Some(&blocks.b1),
            "B2" => blocks.b2.as_ref(),
            "H" => blocks.h.as_ref(),
            "Q1" => flow.map(|flow| &flow.q1),
            "Q2" => flow.map(|flow| &flow.q2),
            "T" => flow.map(|flow| &flow.t),
            _ => None,
        }
    }
}

impl System {
    /// Blocks as they are.
    pub(crate) fn of_blocks(blocks: Arc<SaddleBlocks>) -> Self {
        Self {
            has_rhs: blocks.rhs().iter().any(|b| *b != 0.0),
            blocks,
            manifest: Manifest::default(),
            findings: Vec::new(),
        }
    }

    /// Blocks of a scene.
    pub(crate) fn of_scene(blocks: Arc<SaddleBlocks>, manifest: Manifest) -> Self {
        Self {
            manifest,
            ..Self::of_blocks(blocks)
        }
    }

    fn problem(&self) -> Problem {
        Problem::Blocks(self.blocks.clone())
    }

    /// How it is solved; a right-hand side that was given counts, also where it is 0.
    fn settings(&self, asked: &Asked) -> PyResult<Settings> {
        let mut settings = asked.settings(self.unit())?;
        let own = self.has_rhs.then_some(RightHandSide::System);
        settings.solve.rhs = settings.solve.rhs.or(own);
        crate::parts::show(&settings.lent, &self.blocks);
        Ok(settings)
    }

    /// The unit of tractions that `fracas solve` takes: balanced for systems of ours.
    fn unit(&self) -> Option<f64> {
        self.is_ours().then(|| self.blocks.traction_unit())
    }
}

#[pymethods]
impl System {
    /// From copies of compressed rows.
    #[new]
    fn new(
        py: Python<'_>,
        a: Rows<'_>,
        b1: Rows<'_>,
        b2: Option<Rows<'_>>,
        h: Option<Rows<'_>>,
        flow: Option<(Rows<'_>, Rows<'_>, Rows<'_>)>,
        rhs: Option<PyReadonlyArray1<'_, f64>>,
        places: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<Self> {
        let (a, b1) = (a.matrix("A")?, b1.matrix("B1")?);
        let optional =
            |rows: Option<Rows<'_>>, name| rows.map(|rows| rows.matrix(name)).transpose();
        let (b2, h) = (optional(b2, "B2")?, optional(h, "H")?);
        let flow = match flow {
            None => None,
            Some((q1, q2, t)) => {
                let (q1, q2, t) = (q1.matrix("Q1")?, q2.matrix("Q2")?, t.matrix("T")?);
                let rhs_p = vec![0.0; t.rows()];
                Some(FlowBlocks { q1, q2, t, rhs_p })
            }
        };
        let mut blocks = SaddleBlocks {
            rhs_u: vec![0.0; a.rows()],
            rhs_t: vec![0.0; b1.cols()],
            a,
            b1,
            b2,
            h,
            coordinates: places.map(|places| coordinates(&places)).transpose()?,
            flow,
        };
        let has_rhs = rhs.is_some();
        if let Some(rhs) = rhs {
            let mut rhs = vector("rhs", &rhs, blocks.size())?;
            let mut rest = rhs.split_off(blocks.n_u());
            let rhs_p = rest.split_off(blocks.n_t());
            (blocks.rhs_u, blocks.rhs_t) = (rhs, rest);
            if let Some(flow) = &mut blocks.flow {
                flow.rhs_p = rhs_p;
            }
        }
        let stop = AtomicBool::new(false);
        apart(py, &stop, move || {
            let wrong = |error: fracas_solvers::SetupError| raise(Kind::System, error.to_string());
            blocks.check().map_err(wrong)?;
            let (blocks, findings) = inspect_blocks(blocks)
                .map_err(|error| raise(Kind::System, without_files(&error.to_string())))?;
            Ok(Self {
                blocks: blocks.into(),
                manifest: Manifest {
                    version: Some(concat!("python fracas ", env!("CARGO_PKG_VERSION")).into()),
                    ..Manifest::default()
                },
                has_rhs,
                findings: findings.into_iter().map(Finding::Import).collect(),
            })
        })
    }

    /// Of a system folder.
    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let stop = AtomicBool::new(false);
        apart(py, &stop, move || {
            let imported: folder::Imported = read_folder(&path).raised()?;
            Ok(Self {
                blocks: imported.blocks.into(),
                manifest: imported.manifest,
                has_rhs: imported.has_rhs,
                findings: (imported.findings.into_iter())
                    .map(Finding::Import)
                    .collect(),
            })
        })
    }

    /// Writes a system folder.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let stop = AtomicBool::new(false);
        apart(py, &stop, || {
            write_folder(&path, &self.blocks, &self.manifest).raised()
        })
    }

    /// n_u, n_t, n_p.
    #[getter]
    fn sizes(&self) -> (usize, usize, usize) {
        (self.blocks.n_u(), self.blocks.n_t(), self.blocks.n_p())
    }

    /// True for systems of scenes, before and after an export.
    #[getter]
    fn is_ours(&self) -> bool {
        self.manifest.scene.is_some() && self.manifest.version.is_none() || self.manifest.is_ours()
    }

    /// True where it has a right-hand side of its own.
    #[getter]
    fn has_rhs(&self) -> bool {
        self.has_rhs
    }

    /// What is remarkable, a sentence each.
    #[getter]
    fn findings(&self) -> Vec<String> {
        (self.findings.iter())
            .map(|finding| without_files(&finding.to_string()))
            .collect()
    }

    /// `(rows, columns, starts, columns, values)` of a block, shared; None where it is absent.
    fn block<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Option<Bound<'py, PyTuple>>> {
        shared::rows(slf, name)
    }

    /// (rhs_u, rhs_t, rhs_p) as one vector.
    #[getter]
    fn rhs<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        crate::arrays::given(py, self.blocks.rhs()).into_any()
    }

    /// Rows `x y z component`, if known.
    #[getter]
    fn coordinates<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let known = self.blocks.coordinates.as_deref();
        known.map(|known| places(py, known)).transpose()
    }

    /// The power of two in which both block rows are of one size.
    #[getter]
    fn traction_unit(&self) -> f64 {
        self.blocks.traction_unit()
    }

    /// The same with tractions counted in `unit`.
    fn in_traction_unit(&self, unit: f64) -> PyResult<Self> {
        if !(unit > 0.0 && unit.is_finite()) {
            return Err(raise(
                Kind::Input,
                format!("the unit of tractions is a positive number, not {unit}"),
            ));
        }
        let blocks = SaddleBlocks::clone(&self.blocks).into_traction_unit(unit);
        Ok(Self {
            has_rhs: self.has_rhs,
            ..Self::of_blocks(blocks.into())
        })
    }

    /// C by name, as compressed rows.
    fn augmentation(&self, py: Python<'_>, name: &str) -> PyResult<Matrix> {
        let choice = augmentation(name)?;
        let stop = AtomicBool::new(false);
        let entries = apart(py, &stop, || {
            let direct = DirectChoice::default().solver().raised()?;
            let c = choice.compute(&self.blocks, &*direct).raised()?;
            Ok(c.matrix.entries())
        })?;
        Ok(Matrix(entries))
    }

    /// Sets up, solves, reports: `(JSON, x, iterations, residuals)`.
    #[pyo3(signature = (asked, b=None, observer=None))]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        asked: Asked,
        b: Option<PyReadonlyArray1<'py, f64>>,
        observer: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyTuple>> {
        let settings = self.settings(&asked)?;
        solver::solve(py, &settings, &self.problem(), b, observer)
    }

    /// A preconditioner that is set up, for many right-hand sides.
    #[pyo3(signature = (asked, observer=None))]
    fn set_up(
        &self,
        py: Python<'_>,
        asked: Asked,
        observer: Option<Py<PyAny>>,
    ) -> PyResult<Solver> {
        let settings = self.settings(&asked)?;
        Solver::new(py, settings, &self.problem(), observer)
    }

    /// Eigenvalues of M⁻¹𝒜, as JSON.
    #[pyo3(signature = (asked, dense_limit, observer=None))]
    fn spectrum(
        &self,
        py: Python<'_>,
        asked: Asked,
        dense_limit: Option<usize>,
        observer: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let settings = asked.settings(None)?;
        crate::parts::show(&settings.lent, &self.blocks);
        let loaded = Loaded {
            blocks: self.blocks.clone(),
            body: None,
            findings: self.findings.clone(),
            has_rhs: self.has_rhs,
            is_ours: self.is_ours(),
        };
        let from = spectrum::From::Loaded(Box::new(loaded));
        spectrum::spectrum(py, &settings, &self.problem(), from, dense_limit, observer)
    }

    /// 𝒜 for products.
    fn operator(&self) -> Operator {
        Operator::new(self.blocks.clone())
    }

    /// M⁻¹ in the units of the system.
    fn preconditioner(&self, py: Python<'_>, asked: Asked) -> PyResult<Preconditioner> {
        let settings = asked.settings(None)?;
        crate::parts::show(&settings.lent, &self.blocks);
        Preconditioner::new(py, settings, self.problem(), &self.blocks)
    }
}

/// A matrix of its own, which shares its arrays.
#[pyclass(frozen, module = "fracas._core")]
pub(crate) struct Matrix(SparseMatrix<f64>);

impl Keeps for Matrix {
    fn matrix(&self, _: &str) -> Option<&SparseMatrix<f64>> {
        Some(&self.0)
    }
}

#[pymethods]
impl Matrix {
    /// `(rows, columns, starts, columns, values)`.
    fn rows<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyTuple>>> {
        shared::rows(slf, "")
    }
}

/// Rows `x y z component`.
pub(crate) fn places<'py>(py: Python<'py>, known: &[DofCoordinate]) -> PyResult<Bound<'py, PyAny>> {
    let row = |c: &DofCoordinate| {
        let [x, y, z] = c.position;
        [x, y, z, f64::from(c.component)]
    };
    table(py, known.iter().flat_map(row).collect(), 4)
}

/// What is a file of a folder is a matrix here.
fn without_files(sentence: &str) -> String {
    sentence
        .replace("coords.mtx", "coordinates")
        .replace(".mtx", "")
}
