//! Numbers as a page shows them, and fields of CSV.

/// A CSV field (RFC 4180).
pub fn quote(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.into()
    }
}

/// Four significant digits; powers of ten as `1.234×10⁻⁵` outside 10⁻³…10⁵.
pub fn format_real(value: f64) -> String {
    if !value.is_finite() {
        return if value.is_nan() {
            "–".into()
        } else {
            format!("{}∞", if value < 0.0 { "−" } else { "" })
        };
    }
    if value == 0.0 {
        return "0".into();
    }
    let scientific = format!("{:.3e}", value.abs());
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if value < 0.0 { "−" } else { "" };
    if (-3..5).contains(&exponent) {
        let decimals = usize::try_from(3 - exponent).unwrap_or(0);
        let digits = format!("{:.decimals$}", value.abs());
        return format!("{sign}{}", trim_zeros(&digits));
    }
    format!("{sign}{}×10{}", trim_zeros(mantissa), superscript(exponent))
}

fn trim_zeros(digits: &str) -> &str {
    if digits.contains('.') {
        digits.trim_end_matches('0').trim_end_matches('.')
    } else {
        digits
    }
}

/// A whole number in raised digits.
pub(crate) fn superscript(n: i32) -> String {
    const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    n.to_string()
        .chars()
        .map(|c| c.to_digit(10).map_or('⁻', |d| RAISED[d as usize]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_printed_as_people_write_them() {
        let written: Vec<String> = [
            0.0,
            1.0,
            -0.5,
            317.81,
            12345.6,
            1e5,
            2.5e-7,
            -1.0e9,
            f64::INFINITY,
            0.99999,
        ]
        .map(format_real)
        .into();
        assert_eq!(
            written,
            [
                "0",
                "1",
                "−0.5",
                "317.8",
                "12346",
                "1×10⁵",
                "2.5×10⁻⁷",
                "−1×10⁹",
                "∞",
                "1"
            ]
        );
    }
}
