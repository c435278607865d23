//! A scalar that counts: the oracle of [`flops`](crate::LinearOperator::flops).

use crate::Real;
use num_traits::{Float, FromPrimitive, Num, NumCast, One, ToPrimitive, Zero};
use std::cell::Cell;
use std::fmt::{Display, Formatter, LowerExp};
use std::iter::Sum;
use std::num::FpCategory;
use std::ops::{
    Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Rem, RemAssign, Sub, SubAssign,
};

thread_local! {
    static OPERATIONS: Cell<u64> = const { Cell::new(0) };
}

/// An `f64` that counts additions, subtractions, multiplications, divisions and square roots, each as one.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Tally(f64);

impl Tally {
    /// Operations of this thread during `work`.
    pub fn count(work: impl FnOnce()) -> u64 {
        let before = OPERATIONS.get();
        work();
        OPERATIONS.get() - before
    }

    fn counted(value: f64) -> Self {
        OPERATIONS.set(OPERATIONS.get() + 1);
        Self(value)
    }
}

impl Real for Tally {
    const NAME: &'static str = "counting f64";

    fn of(value: f64) -> Self {
        Self(value)
    }

    fn to_f64_exact(self) -> f64 {
        self.0
    }
}

#[cfg(target_arch = "x86_64")]
mod registers {
    use super::Tally;
    use crate::simd::{Dispatch, Kernel, run_portable};

    #[allow(unsafe_code, reason = "the trait asks for it; nothing is unsafe here")]
    impl Dispatch for Tally {
        unsafe fn run_avx512(kernel: impl Kernel<Self>) {
            run_portable(kernel);
        }

        unsafe fn run_avx2(kernel: impl Kernel<Self>) {
            run_portable(kernel);
        }
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl crate::real::sealed::Sealed for Tally {}

macro_rules! operation {
    ($($trait:ident $method:ident $assign:ident $assign_method:ident;)*) => {$(
        impl $trait for Tally {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self::counted(self.0.$method(other.0))
            }
        }
        impl $assign for Tally {
            fn $assign_method(&mut self, other: Self) {
                *self = self.$method(other);
            }
        }
    )*};
}
operation! {
    Add add AddAssign add_assign;
    Sub sub SubAssign sub_assign;
    Mul mul MulAssign mul_assign;
    Div div DivAssign div_assign;
    Rem rem RemAssign rem_assign;
}

impl Neg for Tally {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Sum for Tally {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self(0.0), Add::add)
    }
}

impl Display for Tally {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        Display::fmt(&self.0, f)
    }
}

impl LowerExp for Tally {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        LowerExp::fmt(&self.0, f)
    }
}

impl Zero for Tally {
    fn zero() -> Self {
        Self(0.0)
    }
    fn is_zero(&self) -> bool {
        self.0 == 0.0
    }
}

impl One for Tally {
    fn one() -> Self {
        Self(1.0)
    }
}

impl Num for Tally {
    type FromStrRadixErr = <f64 as Num>::FromStrRadixErr;
    fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
        f64::from_str_radix(text, radix).map(Self)
    }
}

impl ToPrimitive for Tally {
    fn to_i64(&self) -> Option<i64> {
        self.0.to_i64()
    }
    fn to_u64(&self) -> Option<u64> {
        self.0.to_u64()
    }
    fn to_f64(&self) -> Option<f64> {
        Some(self.0)
    }
}

impl NumCast for Tally {
    fn from<T: ToPrimitive>(value: T) -> Option<Self> {
        value.to_f64().map(Self)
    }
}

impl FromPrimitive for Tally {
    fn from_i64(value: i64) -> Option<Self> {
        Some(Self(value as f64))
    }
    fn from_u64(value: u64) -> Option<Self> {
        Some(Self(value as f64))
    }
    fn from_f64(value: f64) -> Option<Self> {
        Some(Self(value))
    }
}

macro_rules! float {
    (constants: $($constant:ident)*; questions: $($question:ident)*; uncounted: $($free:ident)*; counted: $($one:ident)*;
     of two: $($two:ident)*) => {
        impl Float for Tally {
            $(fn $constant() -> Self {
                Self(<f64 as Float>::$constant())
            })*
            $(fn $question(self) -> bool {
                self.0.$question()
            })*
            $(fn $free(self) -> Self {
                Self(self.0.$free())
            })*
            $(fn $one(self) -> Self {
                Self::counted(self.0.$one())
            })*
            $(fn $two(self, other: Self) -> Self {
                Self(Float::$two(self.0, other.0))
            })*
            fn classify(self) -> FpCategory {
                self.0.classify()
            }
            fn mul_add(self, a: Self, b: Self) -> Self {
                self * a + b
            }
            fn powi(self, n: i32) -> Self {
                Self::counted(self.0.powi(n))
            }
            fn sin_cos(self) -> (Self, Self) {
                (Float::sin(self), Float::cos(self))
            }
            fn integer_decode(self) -> (u64, i16, i8) {
                self.0.integer_decode()
            }
        }
    };
}
float! {
    constants: nan infinity neg_infinity neg_zero min_value min_positive_value max_value epsilon;
    questions: is_nan is_infinite is_finite is_normal is_sign_positive is_sign_negative;
    uncounted: floor ceil round trunc fract abs signum;
    counted: recip sqrt exp exp2 ln log2 log10 cbrt sin cos tan asin acos atan exp_m1 ln_1p sinh cosh tanh asinh acosh atanh;
    of two: powf log max min abs_sub hypot atan2
}
