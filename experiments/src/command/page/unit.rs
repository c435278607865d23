//! Units that leave few digits before and none far behind the point.

/// The largest value in a unit that is taken is no smaller. Unit: 1.
const LEAST: f64 = 0.1;

/// What a quantity measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// m.
    Length,
    /// Pa.
    Stress,
    /// A share.
    Share,
    /// m³.
    Volume,
    /// m³/s.
    Rate,
}

impl Kind {
    /// Unit and factor for values up to `largest` in SI.
    pub(super) fn unit(self, largest: f64) -> (&'static str, f64) {
        let units: &[(&str, f64)] = match self {
            Self::Length => &[("m", 1.0), ("mm", 1e3), ("µm", 1e6)],
            Self::Stress => &[("GPa", 1e-9), ("MPa", 1e-6), ("kPa", 1e-3), ("Pa", 1.0)],
            Self::Share => &[("1", 1.0)],
            Self::Volume => &[("m³", 1.0), ("L", 1e3), ("mL", 1e6)],
            Self::Rate => &[("m³/s", 1.0), ("L/s", 1e3), ("mL/s", 1e6)],
        };
        let fits = units.iter().find(|(_, factor)| largest * factor >= LEAST);
        let (unit, factor) = fits.or(units.last()).copied().unwrap_or(("1", 1.0));
        (unit, factor)
    }
}

/// Seconds in a day and in a year of 365.25 days.
const DAY: f64 = 86_400.0;
const YEAR: f64 = 365.25 * DAY;

/// Unit of times up to `largest` [s], and how many seconds it has.
pub(super) fn of_times(largest: f64) -> (&'static str, f64) {
    match largest.abs() {
        s if s >= 2.0 * YEAR => ("years", YEAR),
        s if s >= 2.0 * DAY => ("days", DAY),
        _ => ("s", 1.0),
    }
}

/// A time as people say it.
pub(super) fn time(seconds: f64) -> String {
    let (unit, length) = of_times(seconds);
    let value = seconds / length;
    let digits = (3.0 - value.abs().max(1e-300).log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.digits$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    format!("{text} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_fit_their_values() {
        assert_eq!(Kind::Length.unit(0.0123), ("mm", 1e3));
        assert_eq!(Kind::Length.unit(3e-9), ("µm", 1e6));
        assert_eq!(Kind::Stress.unit(2.5e7), ("MPa", 1e-6));
        assert_eq!(Kind::Stress.unit(0.5), ("Pa", 1.0));
        assert_eq!(time(0.75), "0.75 s");
        assert_eq!(time(0.0), "0 s");
        assert_eq!(time(6.0 * YEAR), "6 years");
        assert_eq!(time(3.5 * DAY), "3.5 days");
        assert_eq!(of_times(18.0 * YEAR), ("years", YEAR));
        assert_eq!(of_times(0.0), ("s", 1.0));
    }
}
