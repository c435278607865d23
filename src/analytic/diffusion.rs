//! Diffusion into a layer whose face changes its pressure.

use super::error_function::integrals_of_erfc;
use std::f64::consts::PI;

/// What holds at the face that nobody drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FarSide {
    /// Nothing flows through it.
    Closed,
    /// Its pressure does not change.
    Held,
    /// It is driven as the near one is.
    Driven,
}

/// A layer at rest, `∂p/∂t = κ ∂²p/∂z²`, in which z counts from the driven face.
///
/// # Source
/// H. S. Carslaw, J. C. Jaeger, Conduction of Heat in Solids, 2nd ed., Oxford 1959, §§ 3.4, 12.5: series of sines, and images for early
/// times; here their means over intervals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diffusion {
    /// Thickness L [m].
    pub thickness: f64,
    /// Diffusivity κ [m²/s].
    pub diffusivity: f64,
    /// The other face.
    pub far: FarSide,
}

/// `κ t/L²` up to which images are summed, and from which on sines: a few of either are enough. Unit: 1.
const EARLY: f64 = 0.15;

/// Decay beyond which a term is none. Unit: 1.
const DECAYED: f64 = 45.0;

/// Argument of erfc beyond which an image is none. Unit: 1.
const REACH: f64 = 7.0;

/// How the driven face changes from time 0 on.
#[derive(Clone, Copy, PartialEq)]
enum Drive {
    /// By 1, at once.
    Step,
    /// By 1 per unit of time.
    Ramp,
}

impl Diffusion {
    /// Mean over an interval of z [m] of the change that a step of 1 at the face makes in a time [s]. Unit: 1.
    pub fn step(&self, interval: [f64; 2], time: f64) -> f64 {
        self.mean(Drive::Step, interval, time)
    }

    /// The same for a face that rises by 1 per second [s].
    pub fn ramp(&self, interval: [f64; 2], time: f64) -> f64 {
        let [length, kappa] = [self.length(), self.diffusivity];
        length * length / kappa * self.mean(Drive::Ramp, interval, time)
    }

    /// Length over which the pressure evens out [m].
    fn length(&self) -> f64 {
        match self.far {
            FarSide::Driven => 0.5 * self.thickness,
            FarSide::Closed | FarSide::Held => self.thickness,
        }
    }

    fn mean(&self, drive: Drive, interval: [f64; 2], time: f64) -> f64 {
        let length = self.length();
        let t = self.diffusivity * time / (length * length);
        if t <= 0.0 {
            return 0.0;
        }
        let [a, b] = interval.map(|z| z / length);
        let own = |ends: [f64; 2]| self.own(drive, ends, t);
        if self.far != FarSide::Driven || b <= 1.0 {
            return own([a, b]);
        }
        if a >= 1.0 {
            return own([2.0 - b, 2.0 - a]);
        }
        // both halves mirror each other
        ((1.0 - a) * own([a, 1.0]) + (b - 1.0) * own([2.0 - b, 1.0])) / (b - a)
    }

    fn own(&self, drive: Drive, ends: [f64; 2], t: f64) -> f64 {
        match t < EARLY {
            true => self.images(drive, ends, t),
            false => self.sines(drive, ends, t),
        }
    }

    /// `Σ (±1)^k (erfc((2k + ζ)/2√t) ± erfc((2k + 2 − ζ)/2√t))`, integrated.
    fn images(&self, drive: Drive, [a, b]: [f64; 2], t: f64) -> f64 {
        let width = 2.0 * t.sqrt();
        let (order, size) = match drive {
            Drive::Step => (1, 1.0),
            Drive::Ramp => (3, 4.0 * t),
        };
        let of = |from: f64, to: f64| {
            let [low, high] = [from, to].map(|x| integrals_of_erfc(x / width)[order]);
            low - high
        };
        let is_held = self.far == FarSide::Held;
        let (mut sum, mut k) = (0.0, 0.0);
        let mut sign = 1.0;
        while 2.0 * k + a < REACH * width {
            let mirrored = of(2.0 * k + 2.0 - b, 2.0 * k + 2.0 - a);
            let own = of(2.0 * k + a, 2.0 * k + b);
            sum += match is_held {
                true => own - mirrored,
                false => sign * (own + mirrored),
            };
            sign = -sign;
            k += 1.0;
        }
        size * width / (b - a) * sum
    }

    /// The steady part less `Σ 2/μ sin μζ e^(−μ²t)`, or its integral over time.
    fn sines(&self, drive: Drive, [a, b]: [f64; 2], t: f64) -> f64 {
        let (middle, width) = (0.5 * (a + b), b - a);
        // means of ζ² and ζ³
        let square = middle * middle + width * width / 12.0;
        let cube = middle * (middle * middle + 0.25 * width * width);
        let is_held = self.far == FarSide::Held;
        let steady = match (drive, is_held) {
            (Drive::Step, false) => 1.0,
            (Drive::Step, true) => 1.0 - middle,
            (Drive::Ramp, false) => t - (middle - 0.5 * square),
            (Drive::Ramp, true) => (1.0 - middle) * t - (cube / 6.0 - 0.5 * square + middle / 3.0),
        };
        let first = if is_held { PI } else { 0.5 * PI };
        let rates = (0..).map(|n| first + PI * f64::from(n));
        let left: f64 = rates
            .take_while(|mu| mu * mu * t < DECAYED)
            .map(|mu: f64| {
                let half = 0.5 * mu * width;
                let mean = (mu * middle).sin() * (half.sin() / half);
                match drive {
                    Drive::Step => -2.0 / mu * mean * (-mu * mu * t).exp(),
                    Drive::Ramp => 2.0 / (mu * mu * mu) * mean * (-mu * mu * t).exp(),
                }
            })
            .sum();
        steady + left
    }
}

#[cfg(test)]
mod tests;
