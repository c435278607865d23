//! `z ← M⁻¹ r` by a function of Python's.

use crate::call;
use fracas_operators::{Layout, Preconditioner, Properties};
use fracas_solvers::saddle::T;
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;

/// `z ← M⁻¹ r` by a function of Python's.
pub(super) struct Inverse {
    pub(super) f: Py<PyAny>,
    pub(super) n: usize,
    pub(super) linear: bool,
    /// Fields and unit of the tractions, where the function counts them in 1: `M'⁻¹ = D⁻¹ M⁻¹ D⁻¹`.
    pub(super) scaled: Option<(Layout, f64)>,
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
        if call::has_raised() {
            z.fill(f64::NAN);
            return;
        }
        if let Err(error) = Python::attach(|py| self.call(py, r, z)) {
            // the iteration breaks down, and the exception is raised in its place
            z.fill(f64::NAN);
            if let Some(error) = call::keep(error) {
                Python::attach(|py| error.write_unraisable(py, Some(self.f.bind(py))));
            }
        }
    }

    fn flops(&self) -> u64 {
        // unknown: it counts as one product with the identity
        2 * self.n as u64
    }

    fn properties(&self) -> Properties {
        Properties {
            linear: self.linear,
            // not known
            ..Properties::BLIND
        }
    }
}
