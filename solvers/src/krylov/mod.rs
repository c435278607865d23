//! Krylov methods for `A x = b` with a preconditioner M: one method, one file.
//!
//! | method | A | M | products per iteration | vectors |
//! |---|---|---|---|---|
//! | [`Cg`] | symmetric positive definite | symmetric positive definite | 1 | 4 |
//! | [`Minres`] | symmetric | symmetric positive definite | 1 | 7 |
//! | [`Sqmr`] | symmetric | symmetric | 1 | 6 |
//! | [`Gmres`] | any | any linear | 1 | restart + 2 |
//! | [`Fgmres`] | any | any, also changing | 1 | 2 restart + 2 |
//! | [`Bicgstab`] | any | any linear | 2 | 8 |
//!
//! All of them measure the 2-norm of the residual of the *unpreconditioned* system, relative to ‖b‖₂, and recompute it
//! before they return.

mod arnoldi;
mod bicgstab;
mod breakdown;
mod cg;
mod choice;
#[cfg(test)]
mod claims;
mod fgmres;
mod fitted;
mod gmres;
mod judge;
mod minres;
mod narrowed;
#[cfg(test)]
pub(crate) mod oracle;
mod ritz;
pub mod run;
mod sqmr;
mod system;

pub use bicgstab::Bicgstab;
pub use breakdown::{Breakdown, Factor};
pub use cg::Cg;
pub use choice::UnknownMethod;
pub use fgmres::Fgmres;
pub use fitted::Fitted;
pub use gmres::Gmres;
pub use judge::{Candidate, Judge, Verdict, Watch};
pub use minres::Minres;
pub use narrowed::Narrowed;
pub use ritz::least;
pub use sqmr::Sqmr;
pub use system::{Criteria, Outcome, Report, System};

use crate::Observer;
use crate::registry::{NameTaken, Named, Registered, Registry};
use fracas_operators::{Preconditioner, Real};
use serde::Deserialize;
use std::fmt::Debug;

/// An iteration that approximates `x = A⁻¹ b` in a Krylov space.
pub trait KrylovMethod<R: Real>: Debug + Send + Sync {
    /// Plain name: `gmres`.
    fn name(&self) -> &'static str;

    /// Scratch entries that [`solve_in`](Self::solve_in) needs, those of the operator and the preconditioner included.
    fn work_len(&self, system: &System<R>, criteria: &Criteria) -> usize;

    /// Solves in the caller's memory: `x` holds the start on entry and the last iterate on return, also after a
    /// breakdown (GMRES: of the last full cycle); `work` has arbitrary content and is touched only as far as the iteration gets.
    /// A [`Judge`] is asked where the residual is small, and may let the method go on from there; then the tolerance is the judge's.
    ///
    /// # Errors
    /// [`Breakdown`] where the arithmetic cannot continue. Not converging is no error: see [`Outcome`].
    fn solve_in(
        &self,
        system: &System<R>,
        criteria: &Criteria,
        x: &mut [R],
        watch: Watch<'_, R>,
        work: &mut [R],
    ) -> Result<Report, Breakdown>;

    /// The same with memory of its own, allocated once.
    fn solve_watched(
        &self,
        system: &System<R>,
        criteria: &Criteria,
        x: &mut [R],
        watch: Watch<'_, R>,
    ) -> Result<Report, Breakdown> {
        let mut work = vec![R::zero(); self.work_len(system, criteria)];
        self.solve_in(system, criteria, x, watch, &mut work)
    }

    /// The same where residuals alone decide.
    fn solve(
        &self,
        system: &System<R>,
        criteria: &Criteria,
        x: &mut [R],
        observer: &mut dyn Observer,
    ) -> Result<Report, Breakdown> {
        self.solve_watched(system, criteria, x, Watch::of(observer))
    }
}

/// The list of methods. Written as `"gmres"`, `"gmres:50"` or `{ gmres = { restart = 50 } }`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(remote = "Self", rename_all = "snake_case")]
pub enum KrylovChoice {
    /// Conjugate gradients.
    Cg(Cg),
    /// Minimal residuals.
    Minres(Minres),
    /// Symmetric quasi-minimal residuals.
    Sqmr(Sqmr),
    /// Generalized minimal residuals, restarted.
    Gmres(Gmres),
    /// Flexible GMRES.
    Fgmres(Fgmres),
    /// Stabilized bi-conjugate gradients.
    Bicgstab(Bicgstab),
    /// Somebody else's.
    #[serde(skip)]
    Other(Registered<dyn CustomKrylov>),
}

/// A Krylov method of somebody else's; [`register`](KrylovChoice::register) makes its name known.
pub trait CustomKrylov: KrylovMethod<f64> {
    /// Products with A, and solves with M, that one iteration makes.
    fn products_per_iteration(&self) -> usize;

    /// True for a method that takes a preconditioner which is no linear map.
    fn is_flexible(&self) -> bool;
}

impl Named for dyn CustomKrylov {
    fn name(&self) -> &'static str {
        KrylovMethod::name(self)
    }
}

static METHODS: Registry<dyn CustomKrylov> = Registry::new("Krylov method");

impl Default for KrylovChoice {
    fn default() -> Self {
        Self::Gmres(Gmres::default())
    }
}

impl KrylovChoice {
    /// Every method with its default settings.
    pub fn all() -> [Self; 6] {
        [
            Self::Cg(Cg {}),
            Self::Minres(Minres {}),
            Self::Sqmr(Sqmr {}),
            Self::Gmres(Gmres::default()),
            Self::Fgmres(Fgmres::default()),
            Self::Bicgstab(Bicgstab {}),
        ]
    }

    /// Makes a method known by its name.
    ///
    /// # Errors
    /// [`NameTaken`] where another method has it.
    pub fn register(method: &'static dyn CustomKrylov) -> Result<Self, NameTaken> {
        METHODS.register::<Self>(method).map(Self::Other)
    }

    /// The chosen method.
    pub fn method(&self) -> &dyn KrylovMethod<f64> {
        match self {
            Self::Other(method) => method.0,
            own => own.own_method().expect("a method of the house"),
        }
    }

    /// The same in other scalars; `None` for one that is somebody else's.
    pub fn own_method<R: Real>(&self) -> Option<&dyn KrylovMethod<R>> {
        Some(match self {
            Self::Cg(method) => method,
            Self::Minres(method) => method,
            Self::Sqmr(method) => method,
            Self::Gmres(method) => method,
            Self::Fgmres(method) => method,
            Self::Bicgstab(method) => method,
            Self::Other(_) => return None,
        })
    }

    /// Plain name of the method.
    pub fn name(&self) -> &'static str {
        self.method().name()
    }

    /// Products with A, and solves with M, that one iteration makes: 2 for BiCGStab, 1 for the others.
    pub fn products_per_iteration(&self) -> usize {
        match self {
            Self::Bicgstab(_) => 2,
            Self::Other(method) => method.0.products_per_iteration(),
            _ => 1,
        }
    }

    /// True for the method that takes a preconditioner which is no linear map.
    pub fn is_flexible(self) -> bool {
        match self {
            Self::Fgmres(_) => true,
            Self::Other(method) => method.0.is_flexible(),
            _ => false,
        }
    }

    /// GMRES becomes FGMRES with the same restart where `preconditioner` is not linear, or only to the digits of f32;
    /// nothing else changes.
    pub fn flexible_for<R: Real>(self, preconditioner: &dyn Preconditioner<R>) -> Self {
        match self {
            Self::Gmres(Gmres { restart }) if !preconditioner.properties().is_linear_map() => {
                Self::Fgmres(Fgmres { restart })
            }
            other => other,
        }
    }
}
