//! The same fault many times, with what is uncertain drawn at random.

use super::FaultFile;
use super::uncertain::SamplingSection;
use fracas::analytic::NoState;
use fracas_operators::random::Random;
use fracas_solvers::words::by_number;
use rayon::prelude::*;

/// One fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Δp at which slip runs away [Pa], if it does within the change of pressure.
    pub runaway: Option<f64>,
    /// Length that slides at the end, or before it runs away [m].
    pub length: f64,
    /// G ∫ |δ| ds there [N].
    pub moment: f64,
}

/// All of them, in the order of their numbers.
#[derive(Clone, Debug)]
pub struct Sampled {
    /// A sample per number.
    pub samples: Vec<Sample>,
    /// Faults whose elements did not settle; they are left out.
    pub unsettled: usize,
    /// Faults that are not in equilibrium before the pressure changes; they are left out.
    pub loose: usize,
}

/// Why a sample is left out.
enum LeftOut {
    Unsettled,
    Loose,
}

/// Draws the samples of a file; each from a seed of its own, so that they do not depend on threads.
///
/// # Errors
/// None once the file was read.
pub fn sample(file: &FaultFile, sampling: &SamplingSection) -> anyhow::Result<Sampled> {
    let given = file.given()?;
    let one = |number: u64| -> anyhow::Result<Result<Sample, LeftOut>> {
        let mut random = Random::new(sampling.seed.wrapping_mul(SPREAD).wrapping_add(number));
        let drawn = sampling.drawn(&given, || random.between(0.0, 1.0));
        let fault = file.build(&drawn)?;
        if fault.loose(drawn.strength).is_some() {
            return Ok(Err(LeftOut::Loose));
        }
        let mut path = fault.path(drawn.strength);
        let ended = path.advance(1.0);
        let state = path.state();
        let runaway = match ended {
            Ok(_) => None,
            Err(NoState::Runaway { .. }) => Some(path.share() * file.change()),
            Err(NoState::Unsettled) => return Ok(Err(LeftOut::Unsettled)),
        };
        Ok(Ok(Sample {
            runaway,
            length: state.slipping_length(fault.h),
            moment: fault.rock.shear() * state.slip_integral(fault.h),
        }))
    };
    let all: Vec<Result<Sample, LeftOut>> = (0..sampling.samples as u64)
        .into_par_iter()
        .map(one)
        .collect::<anyhow::Result<_>>()?;
    let left_out = |of: fn(&LeftOut) -> bool| {
        let reasons = all.iter().filter_map(|sample| sample.as_ref().err());
        reasons.filter(|reason| of(reason)).count()
    };
    Ok(Sampled {
        unsettled: left_out(|reason| matches!(reason, LeftOut::Unsettled)),
        loose: left_out(|reason| matches!(reason, LeftOut::Loose)),
        samples: all.into_iter().flatten().collect(),
    })
}

/// Seeds lie this far apart (Knuth's multiplier of a linear congruential generator).
const SPREAD: u64 = 6_364_136_223_846_793_005;

impl Sampled {
    /// A sentence per reason for which samples are left out.
    pub fn left_out(&self) -> Vec<String> {
        let reasons = [
            (self.unsettled, ["sample did", "samples did"], "not settle"),
            (
                self.loose,
                ["sample is", "samples are"],
                "not in equilibrium before the pressure changes",
            ),
        ];
        let some = reasons.into_iter().filter(|(count, ..)| *count > 0);
        some.map(|(count, [one, other], why)| {
            let (samples, are) = (by_number(count, one, other), by_number(count, "is", "are"));
            format!("{count} {samples} {why} and {are} left out.")
        })
        .collect()
    }

    /// Share of samples in which slip has run away at a change of pressure of this size [Pa].
    pub fn share_before(&self, change: f64) -> f64 {
        let gone = |s: &&Sample| s.runaway.is_some_and(|at| at.abs() <= change.abs());
        self.samples.iter().filter(gone).count() as f64 / self.samples.len().max(1) as f64
    }

    /// The quantile of a value, 0 ≤ q ≤ 1; `None` without a sample.
    pub fn quantile(&self, q: f64, of: impl Fn(&Sample) -> f64) -> Option<f64> {
        let mut values: Vec<f64> = self.samples.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        let last = values.len().checked_sub(1)?;
        values.get((q * last as f64).round() as usize).copied()
    }
}
