//! Preconditioners solve: `z ← M⁻¹ r`.

use crate::Real;

/// An approximate solver: `z ← M⁻¹ r`.
///
/// A preconditioner is deliberately *not* a [`LinearOperator`](crate::LinearOperator), so "is this the matrix or its inverse?" is a
/// question for the compiler.
pub trait Preconditioner<R: Real>: Send + Sync {
    /// Length of `r` and `z`.
    fn size(&self) -> usize;

    /// `z ← M⁻¹ r`; `z` and `work` arrive with arbitrary content.
    fn solve(&self, r: &[R], z: &mut [R], work: &mut [R]);

    /// Scratch entries that one solve needs.
    fn work_len(&self) -> usize {
        0
    }

    /// Floating-point operations of one solve (a multiply-add counts two).
    fn flops(&self) -> u64;

    /// What those who use `M⁻¹` have to know. Without a default: what is made of parts says [`and`](Properties::and) of theirs.
    fn properties(&self) -> Properties;
}

/// How far an `M⁻¹` is a linear map, and how far it reaches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Properties {
    /// False when `M⁻¹` changes from call to call or depends non-linearly on `r` (then use FGMRES).
    pub linear: bool,
    /// True when `M⁻¹ r` is rounded to 32 bits: a linear map to seven digits only. GMRES then keeps every `M⁻¹v`
    /// (FGMRES), because it would lose those digits in `M⁻¹(V y)`.
    pub single: bool,
    /// True for one level: an entry of `M⁻¹r` depends on entries of r a few rows away. `M⁻¹𝒜` then has eigenvalues close to zero
    /// that an iteration may not see, whose right-hand side has little of their vectors.
    pub local: bool,
    /// True where the unknowns of one field do not see the residuals of another, as of a block-diagonal or block-triangular `M`, or where
    /// nothing is known of that. `M⁻¹r` then says nothing of errors that one field passes on to the other.
    pub blind: bool,
}

impl Properties {
    /// Linear up to the rounding of the scalars.
    pub const LINEAR: Self = Self {
        linear: true,
        single: false,
        local: false,
        blind: false,
    };

    /// Linear, of one level.
    pub const LOCAL: Self = Self {
        local: true,
        ..Self::LINEAR
    };

    /// Linear up to 32 bits.
    pub const SINGLE: Self = Self {
        single: true,
        ..Self::LINEAR
    };

    /// No linear map.
    pub const NONLINEAR: Self = Self {
        linear: false,
        ..Self::LINEAR
    };

    /// Linear, one field blind to the residuals of another.
    pub const BLIND: Self = Self {
        blind: true,
        ..Self::LINEAR
    };

    /// Linear to the rounding of the scalars: `M⁻¹(V y)` is as good as `(M⁻¹V) y`.
    pub const fn is_linear_map(self) -> bool {
        self.linear && !self.single
    }

    /// Of a whole that applies this and another part: linear if both are, rounded, local or blind if one is.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self {
            linear: self.linear && other.linear,
            single: self.single || other.single,
            local: self.local || other.local,
            blind: self.blind || other.blind,
        }
    }
}

macro_rules! forward_preconditioner {
    ($($pointer:ty),*) => {$(
        impl<R: Real, M: Preconditioner<R> + ?Sized> Preconditioner<R> for $pointer {
            fn size(&self) -> usize {
                (**self).size()
            }
            fn solve(&self, r: &[R], z: &mut [R], work: &mut [R]) {
                (**self).solve(r, z, work);
            }
            fn work_len(&self) -> usize {
                (**self).work_len()
            }
            fn flops(&self) -> u64 {
                (**self).flops()
            }
            fn properties(&self) -> Properties {
                (**self).properties()
            }
        }
    )*};
}
forward_preconditioner!(&M, Box<M>, std::sync::Arc<M>);

/// No preconditioner: `z ← r`.
#[derive(Clone, Copy, Debug)]
pub struct Identity {
    /// Length of the vectors.
    pub n: usize,
}

impl<R: Real> Preconditioner<R> for Identity {
    fn size(&self) -> usize {
        self.n
    }
    fn solve(&self, r: &[R], z: &mut [R], _work: &mut [R]) {
        z.copy_from_slice(r);
    }
    fn flops(&self) -> u64 {
        0
    }
    fn properties(&self) -> Properties {
        Properties::LOCAL
    }
}
