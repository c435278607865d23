//! Parts that Python brings: a C, a preconditioner of the whole system, an inner solver. They enter the iteration as trait objects that
//! call back with the interpreter's lock.
//!
//! The library takes parts that live as long as the process. A part without a name is lent a [`Slot`] that does, and gives it back when
//! the solver goes, so that a thousand solves take no more memory than one.

use crate::arrays::Rows;
use crate::error::{Kind, raise};
use crate::system::System;
use faer::Mat;
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::{Layout, Preconditioner, Properties};
use fracas_solvers::direct::DirectSolver;
use fracas_solvers::saddle::{
    AugmentationChoice, AugmentationMatrix, AugmentationRule, CustomMethod, InnerChoice,
    InnerSolver, SaddleBlocks, SaddleMethod, T,
};
use fracas_solvers::{DofCoordinate, Named, Registered, SetupError};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// What Python brings: `f` takes a system and gives C (`augmentation`), takes a system and gives M⁻¹ as a function (`factory`), is M⁻¹
/// itself (`operator`), or takes `(rows of S_u, coordinates)` and gives S_u⁻¹ as a function (`inner`).
#[pyclass(frozen, module = "fracas._core")]
pub(crate) struct Part {
    family: Family,
    f: Py<PyAny>,
    linear: bool,
    local: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Family {
    Augmentation,
    Factory,
    Operator,
    Inner,
}

#[pymethods]
impl Part {
    #[new]
    #[pyo3(signature = (family, f, *, linear=true, local=false))]
    fn new(family: &str, f: Py<PyAny>, linear: bool, local: bool) -> PyResult<Self> {
        let family = match family {
            "augmentation" => Family::Augmentation,
            "factory" => Family::Factory,
            "operator" => Family::Operator,
            "inner" => Family::Inner,
            _ => return Err(raise(Kind::Input, format!("no family of parts {family:?}"))),
        };
        Ok(Self {
            family,
            f,
            linear,
            local,
        })
    }
}

/// What the library knows a part by.
struct Slot {
    name: &'static str,
    part: Mutex<Option<Py<Part>>>,
    /// The first exception since it was asked for.
    failure: Mutex<Option<PyErr>>,
    /// Of the tractions while iterating, in those that Python counts them in.
    unit: Mutex<f64>,
    /// The system that is solved: it is not copied where it is asked for as it is.
    of: Mutex<Weak<SaddleBlocks>>,
}

/// Slots that nobody has.
static FREE: Mutex<Vec<&'static Slot>> = Mutex::new(Vec::new());

/// Slots with a name, which stay.
static NAMED: Mutex<Vec<&'static Slot>> = Mutex::new(Vec::new());

fn held<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Slot {
    fn leaked(name: &'static str) -> &'static Self {
        Box::leak(Box::new(Self {
            name,
            part: Mutex::new(None),
            failure: Mutex::new(None),
            unit: Mutex::new(1.0),
            of: Mutex::new(Weak::new()),
        }))
    }

    fn with<T>(
        &self,
        work: impl FnOnce(Python<'_>, &Part) -> PyResult<T>,
    ) -> Result<T, SetupError> {
        let result = Python::attach(|py| {
            let part = held(&self.part).as_ref().map(|part| part.clone_ref(py));
            let part = part.ok_or_else(|| raise(Kind::Plain, "a part whose solver is gone"))?;
            work(py, part.get())
        });
        result.map_err(|error| {
            let reason = error.to_string();
            self.failed(error);
            SetupError::NotApplicable {
                method: self.name,
                reason,
            }
        })
    }

    fn failed(&self, error: PyErr) {
        held(&self.failure).get_or_insert(error);
    }

    /// The blocks as Python sees them, in the units that it has given them in; a copy only where they are not those of the system.
    fn system(&self, blocks: &SaddleBlocks) -> System {
        let unit = *held(&self.unit);
        if unit != 1.0 {
            // a power of two: to the last bit
            let own = blocks.clone().into_traction_unit(1.0 / unit);
            return System::of_blocks(own.into());
        }
        let own = held(&self.of).upgrade();
        let own = own.filter(|own| std::ptr::eq(&**own, blocks));
        System::of_blocks(own.unwrap_or_else(|| Arc::new(blocks.clone())))
    }

    /// A function of Python's as M⁻¹, of a vector with this layout in the units of Python where it has tractions.
    fn inverse(
        &'static self,
        f: Py<PyAny>,
        n: usize,
        linear: bool,
        layout: Option<Layout>,
    ) -> Inverse {
        let unit = *held(&self.unit);
        Inverse {
            f,
            n,
            linear,
            scaled: layout.map(|layout| (layout, unit)).filter(|_| unit != 1.0),
            slot: self,
        }
    }
}

impl fmt::Debug for Slot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl Named for Slot {
    fn name(&self) -> &'static str {
        self.name
    }
}

impl AugmentationRule for Slot {
    fn is_local(&self) -> bool {
        Python::attach(|_| {
            held(&self.part)
                .as_ref()
                .is_some_and(|part| part.get().local)
        })
    }

    fn compute(
        &self,
        blocks: &SaddleBlocks,
        _: &dyn DirectSolver,
    ) -> Result<AugmentationMatrix, SetupError> {
        let entries = self.with(|py, part| {
            let answer = part.f.bind(py).call1((self.system(blocks),))?;
            Entries::of(&answer)
        })?;
        entries.matrix(held(&self.unit).powi(2))
    }
}

/// C as Python gives it.
enum Entries {
    Diagonal(Vec<f64>),
    Faces(Vec<f64>),
    Dense(Mat<f64>),
    Sparse(SparseMatrix<f64>),
}

impl Entries {
    fn of(answer: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (kind, entries): (String, Bound<'_, PyAny>) = answer.extract()?;
        let one = || -> PyResult<Vec<f64>> {
            let entries: PyReadonlyArray1<'_, f64> = entries.extract()?;
            Ok(entries.as_slice()?.to_vec())
        };
        Ok(match kind.as_str() {
            "diagonal" => Self::Diagonal(one()?),
            "faces" => Self::Faces(one()?),
            "dense" => {
                let table: PyReadonlyArray2<'_, f64> = entries.extract()?;
                let table = table.as_array();
                Self::Dense(Mat::from_fn(table.nrows(), table.ncols(), |i, j| {
                    table[[i, j]]
                }))
            }
            _ => Self::Sparse(entries.extract::<Rows<'_>>()?.matrix("C")?),
        })
    }

    /// C times a factor.
    fn matrix(mut self, factor: f64) -> Result<AugmentationMatrix, SetupError> {
        let scale = |v: &mut f64| *v *= factor;
        match &mut self {
            Self::Diagonal(c) | Self::Faces(c) => c.iter_mut().for_each(scale),
            Self::Dense(c) => *c *= faer::Scale(factor),
            Self::Sparse(c) => c.data_mut().iter_mut().for_each(scale),
        }
        match self {
            Self::Diagonal(c) => AugmentationMatrix::from_diagonal(c),
            Self::Faces(c) => {
                let block =
                    |c: &[f64; 9]| [[c[0], c[1], c[2]], [c[3], c[4], c[5]], [c[6], c[7], c[8]]];
                AugmentationMatrix::from_face_blocks(c.as_chunks().0.iter().map(block).collect())
            }
            Self::Dense(c) => AugmentationMatrix::from_dense(c),
            Self::Sparse(c) => AugmentationMatrix::from_sparse(c),
        }
    }
}

impl CustomMethod for Slot {
    fn prepare(&self, blocks: &SaddleBlocks) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
        let slot = alive(self)?;
        let inverse = self.with(|py, part| {
            let f = match part.family {
                Family::Operator => part.f.clone_ref(py),
                _ => part.f.bind(py).call1((self.system(blocks),))?.unbind(),
            };
            Ok(slot.inverse(f, blocks.size(), part.linear, Some(blocks.layout())))
        })?;
        Ok(Box::new(inverse))
    }

    fn takes_flow(&self) -> bool {
        true
    }

    fn takes_local_rows(&self) -> bool {
        true
    }
}

impl InnerSolver for Slot {
    fn of_matrix(
        &self,
        a: &SparseMatrix<f64>,
        coordinates: Option<&[DofCoordinate]>,
    ) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
        let slot = alive(self)?;
        let inverse = self.with(|py, part| {
            let starts = a.indptr().raw_storage().iter().map(|s| *s as i64).collect();
            let columns = a.indices().iter().map(|j| *j as i32).collect();
            let rows = (
                a.rows(),
                a.cols(),
                PyArray1::from_vec(py, starts),
                PyArray1::<i32>::from_vec(py, columns),
                PyArray1::from_slice(py, a.data()),
            );
            let places = coordinates
                .map(|c| crate::system::places(py, c))
                .transpose()?;
            let f = part.f.bind(py).call1((rows, places))?;
            Ok(slot.inverse(f.unbind(), a.rows(), part.linear, None))
        })?;
        Ok(Box::new(inverse))
    }
}

/// The same slot, known to live as long as the process.
fn alive(slot: &Slot) -> Result<&'static Slot, SetupError> {
    let all = held(&NAMED);
    let found = all
        .iter()
        .find(|known| std::ptr::eq(**known, slot))
        .copied();
    drop(all);
    let lent = held(&LENT);
    let found = found.or_else(|| {
        lent.iter()
            .find(|known| std::ptr::eq(**known, slot))
            .copied()
    });
    found.ok_or_else(|| SetupError::NotApplicable {
        method: slot.name,
        reason: "its solver is gone".into(),
    })
}

/// Slots that somebody has.
static LENT: Mutex<Vec<&'static Slot>> = Mutex::new(Vec::new());

/// `z ← M⁻¹ r` by a function of Python's.
struct Inverse {
    f: Py<PyAny>,
    n: usize,
    linear: bool,
    /// Fields and unit of the tractions, where the function counts them in 1: `M'⁻¹ = D⁻¹ M⁻¹ D⁻¹`.
    scaled: Option<(Layout, f64)>,
    slot: &'static Slot,
}

impl Inverse {
    fn call(&self, py: Python<'_>, r: &[f64], z: &mut [f64]) -> PyResult<()> {
        let r = PyArray1::from_slice(py, r);
        let over = |v: &mut [f64]| {
            if let Some((layout, unit)) = &self.scaled {
                let [v_t] = layout.split_mut([T], v);
                v_t.iter_mut().for_each(|v| *v /= unit);
            }
        };
        if self.scaled.is_some() {
            over(r.readwrite().as_slice_mut()?);
        }
        let answer = self.f.bind(py).call1((r,))?;
        let answer: PyReadonlyArray1<'_, f64> = answer.extract()?;
        let answer = crate::arrays::vector("M⁻¹r", &answer, self.n)?;
        z.copy_from_slice(&answer);
        over(z);
        Ok(())
    }
}

impl Preconditioner<f64> for Inverse {
    fn size(&self) -> usize {
        self.n
    }

    fn solve(&self, r: &[f64], z: &mut [f64], _: &mut [f64]) {
        if held(&self.slot.failure).is_some() {
            z.fill(f64::NAN);
            return;
        }
        if let Err(error) = Python::attach(|py| self.call(py, r, z)) {
            // the iteration breaks down, and the exception is raised in its place
            z.fill(f64::NAN);
            self.slot.failed(error);
        }
    }

    fn flops(&self) -> u64 {
        // unknown: it counts as one product with the identity
        2 * self.n as u64
    }

    fn properties(&self) -> Properties {
        Properties {
            linear: self.linear,
            ..Properties::LINEAR
        }
    }
}

/// A slot on loan.
pub(crate) struct Lent(&'static Slot);

impl Lent {
    fn new(part: &Py<Part>, families: &[Family], role: &str) -> PyResult<Self> {
        if !families.contains(&part.get().family) {
            return Err(raise(Kind::Input, format!("this part is no {role}")));
        }
        let free = held(&FREE).pop();
        let slot = free.unwrap_or_else(|| Slot::leaked("python"));
        *held(&slot.part) = Some(Python::attach(|py| part.clone_ref(py)));
        held(&LENT).push(slot);
        Ok(Self(slot))
    }

    pub(crate) fn augmentation(part: &Py<Part>, unit: f64) -> PyResult<(Self, AugmentationChoice)> {
        let lent = Self::new(part, &[Family::Augmentation], "augmentation")?;
        *held(&lent.0.unit) = unit;
        let choice = AugmentationChoice::Other(Registered(lent.0));
        Ok((lent, choice))
    }

    pub(crate) fn method(part: &Py<Part>, unit: f64) -> PyResult<(Self, SaddleMethod)> {
        let lent = Self::new(part, &[Family::Factory, Family::Operator], "preconditioner")?;
        *held(&lent.0.unit) = unit;
        let choice = SaddleMethod::Other(Registered(lent.0));
        Ok((lent, choice))
    }

    pub(crate) fn inner(part: &Py<Part>) -> PyResult<(Self, InnerChoice)> {
        let lent = Self::new(part, &[Family::Inner], "inner solver")?;
        let choice = InnerChoice::Other(Registered(lent.0));
        Ok((lent, choice))
    }
}

impl Drop for Lent {
    fn drop(&mut self) {
        let part = held(&self.0.part).take();
        let failure = held(&self.0.failure).take();
        *held(&self.0.unit) = 1.0;
        *held(&self.0.of) = Weak::new();
        // references to Python's objects go with the lock at hand
        Python::attach(|_| drop((part, failure)));
        held(&LENT).retain(|slot| !std::ptr::eq(*slot, self.0));
        held(&FREE).push(self.0);
    }
}

/// Lets parts see this system without a copy.
pub(crate) fn show(lent: &[Lent], blocks: &Arc<SaddleBlocks>) {
    let named = held(&NAMED).clone();
    let slots = lent.iter().map(|lent| lent.0).chain(named);
    slots.for_each(|slot| *held(&slot.of) = Arc::downgrade(blocks));
}

/// The result, unless a part raised.
pub(crate) fn end<T>(lent: &[Lent], result: PyResult<T>) -> PyResult<T> {
    let named = held(&NAMED).clone();
    let slots = lent.iter().map(|lent| lent.0).chain(named);
    let mut failures = slots.filter_map(|slot| held(&slot.failure).take());
    failures.next().map_or(result, Err)
}

/// Makes a part known by its name to scenes, studies and every call from here on.
#[pyfunction]
pub(crate) fn register(name: String, part: Py<Part>) -> PyResult<()> {
    let family = part.get().family;
    let slot = Slot::leaked(Box::leak(name.into_boxed_str()));
    *held(&slot.part) = Some(part);
    let taken = match family {
        Family::Augmentation => AugmentationChoice::register(slot).map(drop),
        Family::Factory | Family::Operator => SaddleMethod::register(slot).map(drop),
        Family::Inner => InnerChoice::register(slot).map(drop),
    };
    taken.map_err(|error| raise(Kind::Input, error.to_string()))?;
    held(&NAMED).push(slot);
    Ok(())
}
