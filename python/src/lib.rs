//! `fracas._core`: what the Python package `fracas` is made on. Shapes and kinds of arrays are settled in `python/lib/fracas`, which
//! wraps every class here; nothing is computed that the library does not compute.
//!
//! | file | what it brings |
//! |---|---|
//! | `error` | exceptions with the sentences of the library |
//! | `call` | what functions of Python's raise during a call |
//! | `work` | work without the interpreter's lock, which Ctrl-C ends |
//! | `arrays`, `shared` | numpy arrays: copied in, shared out |
//! | `parts` | a C, a preconditioner or an inner solver that Python brings |
//! | `settings` | how a system is solved |
//! | `system`, `scene` | blocks; scenes |
//! | `solver`, `operator` | a preconditioner that is set up; products with 𝒜 and M⁻¹ |
//! | `run`, `running`, `study` | steps in time; studies |

mod arrays;
mod call;
mod error;
mod operator;
mod parts;
mod run;
mod running;
mod scene;
mod settings;
mod shared;
mod solver;
mod spectrum;
mod study;
mod system;
mod watch;
mod work;

use pyo3::prelude::*;

/// The extension module.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    work::begin();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("has_suitesparse", cfg!(feature = "suitesparse"))?;
    module.add_class::<parts::Part>()?;
    module.add_class::<watch::Event>()?;
    module.add_class::<system::System>()?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<solver::Solver>()?;
    module.add_class::<operator::Operator>()?;
    module.add_class::<operator::Preconditioner>()?;
    module.add_class::<run::Steps>()?;
    module.add_function(wrap_pyfunction!(parts::register, module)?)?;
    module.add_function(wrap_pyfunction!(scene::gallery, module)?)?;
    module.add_function(wrap_pyfunction!(study::study, module)?)?;
    module.add_function(wrap_pyfunction!(work::set_threads, module)?)?;
    Ok(())
}
