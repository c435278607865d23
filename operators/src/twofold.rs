//! Sums of products in twice the digits of f64.

/// A sum `high + low` of products, each without a rounding error of its own: Dot2 of Ogita, Rump and Oishi, *Accurate sum and dot product*,
/// SIAM J. Sci. Comput. 26 (2005). After n terms its value is as good as a sum in twice the digits of f64, rounded once.
///
/// # Cost
/// Some ten additions per product; a fused multiply-add where the machine has one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Twofold {
    high: f64,
    low: f64,
}

impl Twofold {
    /// Adds `a b`.
    pub fn add_product(&mut self, a: f64, b: f64) {
        let product = a * b;
        let rest = a.mul_add(b, -product);
        self.add(product);
        self.low += rest;
    }

    /// Adds `a`.
    pub fn add(&mut self, a: f64) {
        let (sum, rest) = two_sum(self.high, a);
        self.low += rest;
        self.high = sum;
    }

    /// The sum, rounded.
    pub fn value(self) -> f64 {
        self.high + self.low
    }
}

/// `a + b` rounded, and what that lacks, exactly (D. E. Knuth, *The Art of Computer Programming* 2, 4.2.2).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

/// `(x, low) ← (x, low) + z`, entry by entry, in twice the digits; x is the sum rounded.
pub fn add_twofold(z: &[f64], x: &mut [f64], low: &mut [f64]) {
    for ((x, low), z) in x.iter_mut().zip(low).zip(z) {
        let (high, rest) = two_sum(*x, *z);
        (*x, *low) = two_sum(high, *low + rest);
    }
}

impl From<f64> for Twofold {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::signed;

    /// `Σ a_k b_k − Σ b_k a_k` in another order, and what is left of a term 2⁶⁰ times smaller than those that cancel.
    #[test]
    fn what_cancels_leaves_what_is_small() {
        const TERMS: u64 = 1000;
        let small = 1.0 / 3.0;
        let mut sum = Twofold::from(small);
        let mut plain = small;
        for sign in [1.0, -1.0] {
            for k in 0..TERMS {
                let k = if sign > 0.0 { k } else { TERMS - 1 - k };
                let (a, b) = (
                    signed(2 * k) * 2f64.powi(30),
                    signed(2 * k + 1) * 2f64.powi(30),
                );
                sum.add_product(sign * a, b);
                plain += sign * a * b;
            }
        }
        assert!((sum.value() - small).abs() < 1e-12, "{}", sum.value());
        assert!((plain - small).abs() > 1.0, "{plain}");
    }

    #[test]
    fn a_vector_keeps_what_one_number_has_no_room_for() {
        let (mut x, mut low) = ([1.0, -3.0], [0.0; 2]);
        for _ in 0..3 {
            add_twofold(&[2f64.powi(-60), 2f64.powi(-70)], &mut x, &mut low);
        }
        assert_eq!(
            (x, low),
            ([1.0, -3.0], [3.0 * 2f64.powi(-60), 3.0 * 2f64.powi(-70)])
        );
        add_twofold(&[-1.0, 3.0], &mut x, &mut low);
        assert_eq!(
            (x, low),
            ([3.0 * 2f64.powi(-60), 3.0 * 2f64.powi(-70)], [0.0; 2])
        );
    }
}
