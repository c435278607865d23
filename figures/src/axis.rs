//! Axes: scale, range, ticks.

use crate::text::superscript;

/// How an axis maps values to lengths.
#[derive(Clone, Debug, PartialEq)]
pub enum Scale {
    /// Proportional.
    Linear,
    /// By the logarithm; values ≤ 0 cannot be shown and are counted in the legend.
    Log,
    /// Names at 0, 1, 2, …
    Categories(Vec<String>),
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Scale.
    pub scale: Scale,
    /// Ends; from the data when absent.
    pub range: Option<[f64; 2]>,
}

impl Axis {
    /// A linear axis.
    pub fn linear(label: &str) -> Self {
        Self {
            label: label.into(),
            scale: Scale::Linear,
            range: None,
        }
    }

    /// A logarithmic axis.
    pub fn log(label: &str) -> Self {
        Self {
            scale: Scale::Log,
            ..Self::linear(label)
        }
    }

    /// An axis of names.
    pub fn categories(label: &str, names: Vec<String>) -> Self {
        Self {
            scale: Scale::Categories(names),
            ..Self::linear(label)
        }
    }

    /// The same with fixed ends.
    #[must_use]
    pub fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Some([low, high]);
        self
    }

    /// The coordinate in which the axis is linear; `None` when the value cannot be shown.
    pub(super) fn linearize(&self, value: f64) -> Option<f64> {
        match self.scale {
            Scale::Log => (value > 0.0 && value.is_finite()).then(|| value.log10()),
            _ => value.is_finite().then_some(value),
        }
    }

    /// Ends in linearized coordinates that show `values` with a margin.
    pub(super) fn fit(&self, values: impl Iterator<Item = f64>) -> [f64; 2] {
        if let Scale::Categories(names) = &self.scale {
            return [-0.6, names.len().max(1) as f64 - 0.4];
        }
        if let Some([low, high]) = self.range
            && let (Some(low), Some(high)) = (self.linearize(low), self.linearize(high))
        {
            return [low, high];
        }
        let (low, high) = values
            .filter_map(|v| self.linearize(v))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
                (a.min(v), b.max(v))
            });
        if low > high {
            return [0.0, 1.0];
        }
        // Equal values up to rounding get a window of their own size.
        let least = if self.scale == Scale::Log {
            0.3
        } else {
            (0.1 * low.abs().max(high.abs())).max(1e-300)
        };
        let spread = (high - low).max(
            if high - low < 1e-9 * high.abs().max(low.abs()) || high == low {
                least
            } else {
                0.0
            },
        );
        let (middle, half) = (0.5 * (low + high), 0.5 * spread * 1.1);
        if half == 0.0 {
            [middle - 1.0, middle + 1.0]
        } else {
            [middle - half, middle + half]
        }
    }

    /// The same, more where there would be less than three numbers, which hardly say a length, as long as they fit: every other one of
    /// them keeps its number where all of them do not. Two, or what fits, where three do not.
    pub(super) fn ticks_of_three(
        &self,
        ends: [f64; 2],
        most: usize,
        fit: impl Fn(&[Tick]) -> bool,
    ) -> Vec<Tick> {
        let labelled = |ticks: &[Tick]| ticks.iter().filter(|t| t.label.is_some()).count();
        let more = || (most..most + 4).map(|most| self.ticks(ends, most));
        let thinned = (most..most + 4)
            .filter(|_| self.scale == Scale::Linear)
            .flat_map(|most| {
                let all = self.ticks(ends, most);
                // 0 keeps its number
                let zero = all.iter().position(|t| t.at == 0.0).unwrap_or(0);
                [zero % 2, 1 - zero % 2].map(|first| every_other(&all, first))
            });
        let enough = |least: usize| {
            let (labelled, fit) = (&labelled, &fit);
            move |ticks: &Vec<Tick>| labelled(ticks) >= least && fit(ticks)
        };
        (more().find(enough(3)))
            .or_else(|| thinned.into_iter().find(enough(3)))
            .or_else(|| more().find(enough(2)))
            .unwrap_or_else(|| {
                let fewer = (1..=most).rev().map(|most| self.ticks(ends, most));
                let mut fewer = fewer.filter(|ticks| fit(ticks));
                fewer.next().unwrap_or_else(|| self.ticks(ends, most))
            })
    }

    /// Ticks between the (linearized) ends, at most about `most` with a label.
    pub(super) fn ticks(&self, [low, high]: [f64; 2], most: usize) -> Vec<Tick> {
        match &self.scale {
            Scale::Linear => linear_ticks(low, high, most),
            Scale::Log => log_ticks(low, high, most),
            Scale::Categories(names) => names
                .iter()
                .enumerate()
                .map(|(i, name)| Tick {
                    at: i as f64,
                    label: Some(name.clone()),
                })
                .collect(),
        }
    }
}

/// A tick at a linearized coordinate; minor ones have no label.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    pub(super) at: f64,
    pub(super) label: Option<String>,
}

/// The same, numbers on every other one.
fn every_other(ticks: &[Tick], first: usize) -> Vec<Tick> {
    let keep = |(k, tick): (usize, &Tick)| Tick {
        at: tick.at,
        label: (tick.label.clone()).filter(|_| k % 2 == first),
    };
    ticks.iter().enumerate().map(keep).collect()
}

fn linear_ticks(low: f64, high: f64, most: usize) -> Vec<Tick> {
    let raw = (high - low) / most.max(1) as f64;
    let power = 10.0_f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|m| m * power)
        .into_iter()
        .find(|s| *s >= raw * 0.999)
        .unwrap_or(power);
    let (first, last) = (
        (low / step).ceil() as i64,
        (high / step + 1e-9).floor() as i64,
    );
    let largest = low.abs().max(high.abs());
    (first..=last)
        .map(|k| Tick {
            at: k as f64 * step,
            label: Some(linear_label(k, step, largest)),
        })
        .collect()
}

/// `k · step` with the decimals of the step; as a multiple of a power of ten when that is shorter.
fn linear_label(k: i64, step: f64, largest: f64) -> String {
    if k == 0 {
        return "0".into();
    }
    let (step_power, power) = (
        (step.log10() + 1e-9).floor() as i32,
        (largest.log10() + 1e-9).floor() as i32,
    );
    let value = k as f64 * step;
    let sign = if k < 0 { "−" } else { "" };
    if (-4..5).contains(&power) && step_power >= -5 {
        let decimals = usize::try_from(-step_power).unwrap_or(0);
        return format!("{sign}{:.decimals$}", value.abs());
    }
    let decimals = usize::try_from(power - step_power).unwrap_or(0);
    format!(
        "{sign}{:.decimals$}×10{}",
        value.abs() / 10.0_f64.powi(power),
        superscript(power)
    )
}

fn log_ticks(low: f64, high: f64, most: usize) -> Vec<Tick> {
    let decades = high - low;
    let whole = (high + 1e-9).floor() as i32 - (low - 1e-9).ceil() as i32 + 1;
    if whole < 2 {
        return short_log_ticks(low, high, most);
    }
    let every = (whole.max(1) as usize).div_ceil(most.max(1)) as i32;
    let mut ticks = Vec::new();
    for power in low.floor() as i32..=high.ceil() as i32 {
        let label = (power.rem_euclid(every) == 0).then(|| power_label(power));
        ticks.push(Tick {
            at: f64::from(power),
            label,
        });
        if decades <= 8.0 {
            ticks.extend((2..10).map(|m| Tick {
                at: f64::from(power) + f64::from(m).log10(),
                label: None,
            }));
        }
    }
    ticks.retain(|t| t.at >= low - 1e-9 && t.at <= high + 1e-9);
    ticks
}

/// Less than two decades: plain numbers at 1, 2, 5 or at linear steps.
fn short_log_ticks(low: f64, high: f64, most: usize) -> Vec<Tick> {
    let (a, b) = (10.0_f64.powf(low), 10.0_f64.powf(high));
    if high - low < 0.5 {
        let ticks = linear_ticks(a, b, most.min(6));
        return ticks
            .into_iter()
            .filter(|t| t.at > 0.0)
            .map(|t| Tick {
                at: t.at.log10(),
                ..t
            })
            .collect();
    }
    let mut ticks = Vec::new();
    for power in low.floor() as i32..=high.ceil() as i32 {
        for m in 1..10 {
            let step = 10.0_f64.powi(power);
            let label = [1, 2, 5]
                .contains(&m)
                .then(|| linear_label(m, step, f64::from(m as i32) * step));
            ticks.push(Tick {
                at: f64::from(power) + (m as f64).log10(),
                label,
            });
        }
    }
    ticks.retain(|t| t.at >= low - 1e-9 && t.at <= high + 1e-9);
    ticks
}

fn power_label(power: i32) -> String {
    match power {
        0 => "1".into(),
        1 => "10".into(),
        _ => format!("10{}", superscript(power)),
    }
}
