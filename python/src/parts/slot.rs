//! What the library knows a part of Python's by, for as long as the process lives.

use super::entries::Entries;
use super::inverse::Inverse;
use super::{Family, Part, held};
use crate::call;
use crate::error::{Kind, raise};
use crate::system::System;
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::{Layout, Preconditioner};
use fracas_solvers::direct::DirectSolver;
use fracas_solvers::saddle::{
    AugmentationMatrix, AugmentationRule, CustomMethod, InnerSolver, SaddleBlocks,
};
use fracas_solvers::{DofCoordinate, Named, SetupError};
use numpy::PyArray1;
use pyo3::prelude::*;
use std::fmt;
use std::sync::{Arc, Mutex, Weak};

/// What the library knows a part by.
pub(super) struct Slot {
    pub(super) name: &'static str,
    pub(super) part: Mutex<Option<Py<Part>>>,
    /// Of the tractions while iterating, in those that Python counts them in.
    pub(super) unit: Mutex<f64>,
    /// The system that is solved: it is not copied where it is asked for as it is.
    pub(super) of: Mutex<Weak<SaddleBlocks>>,
}

impl Slot {
    pub(super) fn leaked(name: &'static str) -> &'static Self {
        Box::leak(Box::new(Self {
            name,
            part: Mutex::new(None),
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
            // without a call the row of a study says the reason
            let _ = call::keep(error);
            SetupError::NotApplicable {
                method: self.name,
                reason,
            }
        })
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
    fn inverse(&self, f: Py<PyAny>, n: usize, linear: bool, layout: Option<Layout>) -> Inverse {
        let unit = *held(&self.unit);
        Inverse {
            f,
            n,
            linear,
            scaled: layout.map(|layout| (layout, unit)).filter(|_| unit != 1.0),
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

impl CustomMethod for Slot {
    fn prepare(&self, blocks: &SaddleBlocks) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
        let inverse = self.with(|py, part| {
            let f = match part.family {
                Family::Operator => part.f.clone_ref(py),
                _ => part.f.bind(py).call1((self.system(blocks),))?.unbind(),
            };
            Ok(self.inverse(f, blocks.size(), part.linear, Some(blocks.layout())))
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
            Ok(self.inverse(f.unbind(), a.rows(), part.linear, None))
        })?;
        Ok(Box::new(inverse))
    }
}
