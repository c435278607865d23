//! Parts that Python brings: a C, a preconditioner of the whole system, an inner solver. They enter the iteration as trait objects that
//! call back with the interpreter's lock.
//!
//! The library takes parts that live as long as the process. A part without a name is lent a [`Slot`] that does, and gives it back when
//! the solver goes, so that a thousand solves take no more memory than one.

mod entries;
mod inverse;
mod slot;

use crate::error::{Kind, raise};
use fracas_solvers::Registered;
use fracas_solvers::saddle::{AugmentationChoice, InnerChoice, SaddleBlocks, SaddleMethod};
use pyo3::prelude::*;
use slot::Slot;
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

/// Slots that nobody has.
static FREE: Mutex<Vec<&'static Slot>> = Mutex::new(Vec::new());

/// Slots with a name, which stay.
static NAMED: Mutex<Vec<&'static Slot>> = Mutex::new(Vec::new());

fn held<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
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
        *held(&self.0.unit) = 1.0;
        *held(&self.0.of) = Weak::new();
        // a reference to an object of Python's goes with the lock at hand
        Python::attach(|_| drop(part));
        held(&FREE).push(self.0);
    }
}

/// Lets parts see this system without a copy.
pub(crate) fn show(lent: &[Lent], blocks: &Arc<SaddleBlocks>) {
    let named = held(&NAMED).clone();
    let slots = lent.iter().map(|lent| lent.0).chain(named);
    slots.for_each(|slot| *held(&slot.of) = Arc::downgrade(blocks));
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
