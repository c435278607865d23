//! Products with 𝒜 and with M⁻¹ for iterations of Python's.

use crate::call;
use crate::error::{Kind, Raise, raise};
use crate::parts;
use crate::settings::Settings;
use crate::work::{apart, in_pool};
use fracas::solve::Problem;
use fracas_operators::sparse::{CsrView, SparseMatrix};
use fracas_operators::{LinearOperator, Preconditioner as _};
use fracas_solvers::saddle::{
    InnerChoice, P, Ready, SaddleBlocks, SaddleMethod, SaddleOperator, T, U,
};
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1};
use pyo3::prelude::*;
use self_cell::self_cell;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, TryLockError};

/// Flops of a product below which handing over the interpreter's lock costs more than it gives.
const SHORT: u64 = 200_000;

self_cell!(
    /// 𝒜 with the blocks that it borrows.
    struct Owned {
        owner: Arc<SaddleBlocks>,
        #[covariant]
        dependent: SaddleOperator,
    }
);

/// `y = work(x)` into a new array; `flops` decides on the lock.
fn product<'py>(
    py: Python<'py>,
    x: &PyReadonlyArray1<'py, f64>,
    (rows, columns): (usize, usize),
    flops: u64,
    work: impl FnOnce(&[f64], &mut [f64]) + Send,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let x = x
        .as_slice()
        .map_err(|error| raise(Kind::Input, error.to_string()))?;
    if x.len() != columns {
        return Err(raise(
            Kind::Input,
            format!("x has {} entries, expected {columns}", x.len()),
        ));
    }
    let array = PyArray1::zeros(py, rows, false);
    let mut whole = array.readwrite();
    let y = whole.as_slice_mut()?;
    match flops < SHORT {
        true => work(x, y),
        false => py.detach(|| in_pool(|| work(x, y))),
    }
    drop(whole);
    Ok(array)
}

/// Scratch memory that is there, or new where another thread has it.
fn with_work(kept: &Mutex<Vec<f64>>, length: usize, work: impl FnOnce(&mut [f64])) {
    match kept.try_lock() {
        Ok(mut kept) => {
            kept.resize(length, 0.0);
            work(&mut kept);
        }
        Err(TryLockError::Poisoned(_) | TryLockError::WouldBlock) => work(&mut vec![0.0; length]),
    }
}

/// 𝒜.
#[pyclass(frozen, module = "fracas._core")]
pub(crate) struct Operator {
    cell: Owned,
    work: Mutex<Vec<f64>>,
    size: usize,
    flops: u64,
    length: usize,
}

impl Operator {
    pub(crate) fn new(blocks: Arc<SaddleBlocks>) -> Self {
        let cell = Owned::new(blocks, |blocks| SaddleOperator::new(blocks));
        let operator = cell.borrow_dependent();
        let (size, flops, length) = (operator.shape().rows, operator.flops(), operator.work_len());
        Self {
            work: Mutex::new(Vec::new()),
            cell,
            size,
            flops,
            length,
        }
    }
}

#[pymethods]
impl Operator {
    #[getter]
    fn size(&self) -> usize {
        self.size
    }

    /// Of one product.
    #[getter]
    fn flops(&self) -> u64 {
        self.flops
    }

    /// 𝒜x.
    fn apply<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        product(py, &x, (self.size, self.size), self.flops, |x, y| {
            with_work(&self.work, self.length, |work| {
                self.cell.borrow_dependent().apply_add(1.0, x, y, work);
            });
        })
    }

    /// 𝒜ᵀx, column by column.
    fn apply_adjoint<'py>(
        &self,
        py: Python<'py>,
        x: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let blocks = self.cell.borrow_owner();
        product(py, &x, (self.size, self.size), self.flops, |x, y| {
            adjoint(blocks, x, y);
        })
    }
}

/// `y ← y + 𝒜ᵀ x`.
fn adjoint(blocks: &SaddleBlocks, x: &[f64], y: &mut [f64]) {
    let layout = blocks.layout();
    let ([x_u, x_t], [y_u, y_t]) = (layout.split([U, T], x), layout.split_mut([U, T], y));
    add_transposed(1.0, &blocks.a, x_u, y_u);
    add_transposed(1.0, &blocks.b1, x_u, y_t);
    match &blocks.b2 {
        Some(b2) => add_transposed(1.0, b2, x_t, y_u),
        None => CsrView::new(&blocks.b1).apply_add(1.0, x_t, y_u, &mut []),
    }
    if let Some(h) = &blocks.h {
        add_transposed(-1.0, h, x_t, y_t);
    }
    if let Some(flow) = &blocks.flow {
        let ([x_p], [y_u, y_p]) = (layout.split([P], x), layout.split_mut([U, P], y));
        add_transposed(1.0, &flow.q1, x_u, y_p);
        add_transposed(1.0, &flow.q2, x_p, y_u);
        add_transposed(1.0, &flow.t, x_p, y_p);
    }
}

/// `y ← y + α Mᵀ x` from the rows of M.
fn add_transposed(alpha: f64, m: &SparseMatrix<f64>, x: &[f64], y: &mut [f64]) {
    for (row, x) in m.outer_iterator().zip(x) {
        row.iter().for_each(|(j, m)| y[j] += alpha * m * x);
    }
}

/// M⁻¹.
#[pyclass(frozen, module = "fracas._core")]
pub(crate) struct Preconditioner {
    ready: Ready,
    _lent: Vec<parts::Lent>,
    work: Mutex<Vec<f64>>,
    name: String,
    is_symmetric: bool,
}

impl Preconditioner {
    pub(crate) fn new(
        py: Python<'_>,
        settings: Settings,
        problem: Problem,
        blocks: &SaddleBlocks,
    ) -> PyResult<Self> {
        let stop = AtomicBool::new(false);
        let how = &settings.solve;
        let (ready, method) = apart(py, &stop, || {
            // in turn, as `solve` does
            let route = how.route(&problem).raised()?;
            let mut failure = None;
            for method in std::iter::once(route.method).chain(route.otherwise) {
                match method.ready(blocks) {
                    Ok(ready) => return Ok((ready, method)),
                    Err(error) => failure = failure.or(Some(error)),
                }
            }
            failure.map_or_else(
                || Err(raise(Kind::Setup, "no method that could be set up")),
                |error| Err(error).raised(),
            )
        })?;
        let inner = method.inner();
        let linear = ready.inverse.properties().linear;
        Ok(Self {
            is_symmetric: matches!(method, SaddleMethod::Racp(_))
                && blocks.b2.is_none()
                && blocks.flow.is_none()
                && linear
                // of a part of one's own nothing is known
                && !matches!(inner, Some(InnerChoice::Other(_))),
            name: inner.map_or_else(
                || method.to_string(),
                |inner| format!("{method}, inner {inner}"),
            ),
            ready,
            _lent: settings.lent,
            work: Mutex::new(Vec::new()),
        })
    }
}

#[pymethods]
impl Preconditioner {
    #[getter]
    fn size(&self) -> usize {
        self.ready.inverse.size()
    }

    /// Of one application.
    #[getter]
    fn flops(&self) -> u64 {
        self.ready.inverse.flops()
    }

    /// With its inner solver.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// False where it depends on r other than linearly.
    #[getter]
    fn is_linear(&self) -> bool {
        self.ready.inverse.properties().linear
    }

    /// True where it is rounded to 32 bits inside.
    #[getter]
    fn is_single(&self) -> bool {
        self.ready.inverse.properties().single
    }

    /// True where it is its own adjoint: RACP of a symmetric 𝒜.
    #[getter]
    fn is_symmetric(&self) -> bool {
        self.is_symmetric
    }

    /// M⁻¹r.
    fn apply<'py>(
        &self,
        py: Python<'py>,
        r: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let inverse = &*self.ready.inverse;
        let n = inverse.size();
        let mut raised = None;
        let result = product(py, &r, (n, n), inverse.flops(), |r, z| {
            let ((), error) = call::heard(|| {
                with_work(&self.work, inverse.work_len(), |work| {
                    inverse.solve(r, z, work)
                });
            });
            raised = error;
        });
        raised.map_or(result, Err)
    }
}
