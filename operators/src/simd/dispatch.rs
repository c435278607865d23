//! The compiled versions of a kernel for each scalar.

use super::{Kernel, avx2, avx512};

/// Implemented for `f64`, `f32`, and the scalar that counts.
pub trait Dispatch: Sized {
    /// Runs on 512-bit registers.
    ///
    /// # Safety
    /// The machine has AVX-512F.
    unsafe fn run_avx512(kernel: impl Kernel<Self>);

    /// Runs on 256-bit registers.
    ///
    /// # Safety
    /// The machine has AVX2 and FMA.
    unsafe fn run_avx2(kernel: impl Kernel<Self>);
}

macro_rules! dispatch {
    ($scalar:ty, $registers:ident) => {
        impl Dispatch for $scalar {
            #[target_feature(enable = "avx512f")]
            unsafe fn run_avx512(kernel: impl Kernel<Self>) {
                kernel.run::<avx512::$registers>();
            }

            #[target_feature(enable = "avx2,fma")]
            unsafe fn run_avx2(kernel: impl Kernel<Self>) {
                kernel.run::<avx2::$registers>();
            }
        }
    };
}
dispatch!(f64, Doubles);
dispatch!(f32, Singles);
