//! How much of weakening the tangent of damped continuation keeps.

use fracas_operators::vector::dot;

/// Largest θρ, at first and where ρ stands: K − θ W stays definite. Unit: 1.
const DEFINITE: [f64; 2] = [0.9, 0.97];

/// Relative change of ρ from one correction to the next at which it stands. Unit: 1.
const STANDS: f64 = 0.02;

/// Growth of corrections that slip running away is given at most. Unit: 1.
const GROWTH: f64 = 3.0;

/// Steps in a row without a lower residual after which it is taken to lead nowhere: as many as one face takes at most to come to rest
/// wherever it is next to critical. Of 114 continuations that came to rest on random networks one took 39 and the others 13 at most; those that
/// did not took 98 of the 100 that a round allows. Unit: 1.
pub(super) const WANDERS: usize = 60;

/// Damped (pseudo-dynamic) continuation at fixed states: tangents K − θ W keep the share θ of the derivative W of weakening, so that
/// `(1 − θ) W` is the viscosity of an implicit step, and its corrections follow
/// ```text
/// δ' = q δ        q = (1 − θ) ρ/(1 − θ' ρ)        ρ the largest eigenvalue of K⁻¹ W
/// ```
/// Limits of the iterate before, θ = 0, make q = ρ: where the patch is next to critical they come to rest, or run away, by a few per cent a
/// step. With `θρ < 1` slip goes the same way and K − θ W stays definite, so that it rests where W < K alone; the whole W would lead back
/// to the critical state. ρ is what corrections in a row show.
#[derive(Default)]
pub(super) struct Damping {
    /// θ of the next step.
    share: f64,
    /// θ of the last step.
    before: f64,
    /// Last correction.
    last: Vec<f64>,
    /// ρ that it showed.
    ratio: f64,
}

impl Damping {
    /// θ.
    pub(super) fn share(&self) -> f64 {
        self.share
    }

    /// False where this correction shows that K − θ W was not definite: θ is smaller then, and it is to be solved for anew.
    pub(super) fn takes(&mut self, correction: &[f64]) -> bool {
        let mut ratio = f64::NAN;
        if self.last.len() == correction.len() {
            let q = dot(correction, &self.last) / dot(&self.last, &self.last);
            ratio = q / (1.0 - self.before + self.share * q);
            // q < 0 beyond the pole at θρ = 1
            if q < 0.0 && ratio > 0.0 {
                self.share = share(ratio, DEFINITE[0]).min(0.5 * self.share);
                return false;
            }
        }
        self.before = self.share;
        if ratio.is_finite() {
            let stands = (ratio - self.ratio).abs() <= STANDS * ratio;
            self.share = share(ratio, DEFINITE[usize::from(stands)]);
            self.ratio = ratio;
        }
        self.last.clear();
        self.last.extend_from_slice(correction);
        true
    }
}

/// θ for this ρ and largest θρ.
fn share(ratio: f64, most: f64) -> f64 {
    let definite = most / ratio.max(1.0);
    match ratio > 1.0 {
        true => definite
            .min((GROWTH - ratio) / (ratio * (GROWTH - 1.0)))
            .max(0.0),
        false => definite,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `K s − min(W s, W d) = f` of one face, K = 1: at rest below d where W < 1, beyond it where W > 1.
    #[test]
    fn slip_of_one_face_comes_to_rest_wherever_it_is_next_to_critical() {
        for excess in [-0.5, -0.1, -1e-2, 0.0, 1e-3, 1e-2, 0.1, 0.5, 1.0, 4.0] {
            let (w, d, f) = (1.0 + excess, 1.0, 1e-3);
            let residual = |s: f64| f - s + w * f64::min(s, d);
            let (mut damping, mut s, mut steps) = (Damping::default(), 0.0, 0);
            while residual(s).abs() > 1e-10 {
                let rate = if s < d { w } else { 0.0 };
                let correction = residual(s) / (1.0 - damping.share() * rate);
                if damping.takes(&[correction]) {
                    s += correction;
                }
                steps += 1;
                assert!(steps <= WANDERS, "{excess}: {s}");
            }
            let rest = if f / -excess < d && excess < 0.0 {
                f / -excess
            } else {
                f + w * d
            };
            assert!((s - rest).abs() <= 1e-6 * rest, "{excess}: {s} {rest}");
        }
    }
}
