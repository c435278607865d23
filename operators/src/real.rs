//! The scalars: `f64`, and `f32` inside preconditioners; [`Tally`](crate::tally::Tally) counts for tests.

use num_traits::{Float, FromPrimitive, NumAssign};
use std::fmt::{Debug, Display, LowerExp};
use std::iter::Sum;

pub(crate) mod sealed {
    #[cfg(target_arch = "x86_64")]
    pub(crate) use crate::simd::Dispatch as Sealed;

    #[cfg(not(target_arch = "x86_64"))]
    pub trait Sealed {}
    #[cfg(not(target_arch = "x86_64"))]
    impl Sealed for f64 {}
    #[cfg(not(target_arch = "x86_64"))]
    impl Sealed for f32 {}
}

/// What is made for any scalar. Behind [`Real::make`] the two that work is done in are compiled where this is written, once; a generic
/// function is compiled again by every crate that calls it.
pub trait Make {
    /// What is made.
    type Made<R: Real>;

    /// In double precision.
    fn double(self) -> Self::Made<f64>;

    /// In single precision.
    fn single(self) -> Self::Made<f32>;

    /// In any other scalar.
    fn other<R: Real>(self) -> Self::Made<R>;
}

/// A real scalar: `f64` (the default everywhere) or `f32` (inside preconditioners). Sealed.
pub trait Real:
    sealed::Sealed
    + Float
    + NumAssign
    + FromPrimitive
    + Sum
    + Default
    + Debug
    + Display
    + LowerExp
    + Send
    + Sync
    + 'static
{
    /// Name used in reports: `"f64"` or `"f32"`.
    const NAME: &'static str;

    /// Nearest value of this precision to `value`.
    fn of(value: f64) -> Self;

    /// This value in double precision (exact).
    fn to_f64_exact(self) -> f64;

    /// What is made for this scalar.
    fn make<M: Make>(of: M) -> M::Made<Self> {
        of.other()
    }
}

impl Real for f64 {
    const NAME: &'static str = "f64";
    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn to_f64_exact(self) -> f64 {
        self
    }
    #[inline(always)]
    fn make<M: Make>(of: M) -> M::Made<Self> {
        of.double()
    }
}

impl Real for f32 {
    const NAME: &'static str = "f32";
    #[inline(always)]
    fn of(value: f64) -> Self {
        value as f32
    }
    #[inline(always)]
    fn to_f64_exact(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn make<M: Make>(of: M) -> M::Made<Self> {
        of.single()
    }
}
