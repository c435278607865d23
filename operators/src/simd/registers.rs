//! What all register types of x86-64 share: arithmetic, loads, stores and the reordering of triples.

/// Implements [`Lanes`](super::Lanes) for a register type that has `blend`, `permuted`, `after` and `first_three`.
macro_rules! registers {
    ($name:ident, $scalar:ty, $width:literal, $set1:ident, $load:ident, $store:ident, $add:ident, $sub:ident, $mul:ident,
     $fma:ident, $fnma:ident, $div:ident) => {
        impl std::ops::Add for $name {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                // SAFETY: see the type.
                unsafe { Self($add(self.0, other.0)) }
            }
        }

        impl std::ops::Sub for $name {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                // SAFETY: see the type.
                unsafe { Self($sub(self.0, other.0)) }
            }
        }

        impl std::ops::Mul for $name {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                // SAFETY: see the type.
                unsafe { Self($mul(self.0, other.0)) }
            }
        }

        impl std::ops::Div for $name {
            type Output = Self;
            #[inline(always)]
            fn div(self, other: Self) -> Self {
                // SAFETY: see the type.
                unsafe { Self($div(self.0, other.0)) }
            }
        }

        impl super::Lanes<$scalar> for $name {
            const WIDTH: usize = $width;

            #[inline(always)]
            fn splat(value: $scalar) -> Self {
                // SAFETY: see the type.
                unsafe { Self($set1(value)) }
            }

            #[inline(always)]
            fn load(from: &[$scalar]) -> Self {
                let from = &from[..$width];
                // SAFETY: see the type; the slice has WIDTH entries.
                unsafe { Self($load(from.as_ptr())) }
            }

            #[inline(always)]
            fn store(self, to: &mut [$scalar]) {
                let to = &mut to[..$width];
                // SAFETY: see the type; the slice has WIDTH entries.
                unsafe { $store(to.as_mut_ptr(), self.0) }
            }

            #[inline(always)]
            fn mul_add(self, factor: Self, term: Self) -> Self {
                // SAFETY: see the type.
                unsafe { Self($fma(self.0, factor.0, term.0)) }
            }

            #[inline(always)]
            fn minus_product(self, a: Self, b: Self) -> Self {
                // SAFETY: see the type.
                unsafe { Self($fnma(a.0, b.0, self.0)) }
            }

            #[inline(always)]
            fn shifted(self, before: Self) -> Self {
                self.after(before)
            }

            #[inline(always)]
            fn lowered(self, after: Self, lane: usize) -> Self {
                let down = self.permuted(|p| (p + 1) % $width);
                let top = after.permuted(|_| lane);
                Self::blend([down, top, top], |v, p| v == 1 && p + 1 == $width)
            }

            // Entry k of component c sits at position 3k + c, which is lane (3k + c) mod WIDTH of one of the three.
            #[inline(always)]
            fn deinterleave(triples: [Self; 3]) -> [Self; 3] {
                [
                    Self::blend(triples, |v, p| ($width * v + p) % 3 == 0)
                        .permuted(|k| 3 * k % $width),
                    Self::blend(triples, |v, p| ($width * v + p) % 3 == 1)
                        .permuted(|k| (3 * k + 1) % $width),
                    Self::blend(triples, |v, p| ($width * v + p) % 3 == 2)
                        .permuted(|k| (3 * k + 2) % $width),
                ]
            }

            #[inline(always)]
            fn repeat(from: &[$scalar], start: usize) -> Self {
                Self::first_three(&from[..3]).permuted(|p| (start + p) % 3)
            }

            // The inverse of k ↦ (3k + c) mod WIDTH is p ↦ (p − c)/3, and 1/3 = INVERSE modulo WIDTH.
            #[inline(always)]
            fn interleave(components: [Self; 3]) -> [Self; 3] {
                const INVERSE: usize = if $width % 3 == 1 {
                    (2 * $width + 1) / 3
                } else {
                    ($width + 1) / 3
                };
                let [x, y, z] = components;
                let spread = [
                    x.permuted(|p| p * INVERSE % $width),
                    y.permuted(|p| (p + $width - 1) * INVERSE % $width),
                    z.permuted(|p| (p + $width - 2) * INVERSE % $width),
                ];
                [
                    Self::blend(spread, |c, p| p % 3 == c),
                    Self::blend(spread, |c, p| ($width + p) % 3 == c),
                    Self::blend(spread, |c, p| (2 * $width + p) % 3 == c),
                ]
            }
        }
    };
}
pub(super) use registers;
