//! The table of unit symbols and the grammar that combines them.

use super::Dimension;

/// `factor` SI units make one of `name`.
struct Symbol {
    name: &'static str,
    factor: f64,
    dimension: Dimension,
}

const fn symbol(name: &'static str, factor: f64, dimension: Dimension) -> Symbol {
    Symbol {
        name,
        factor,
        dimension,
    }
}

const MASS: Dimension = Dimension::new(0, 1, 0);
const FORCE: Dimension = Dimension::new(1, 1, -2);
const VOLUME: Dimension = Dimension::VOLUME;
const VISCOSITY: Dimension = Dimension::VISCOSITY;

/// Every symbol that is understood. The year is the Julian one of 365.25 days; psi, darcy and foot as defined by NIST
/// SP 811.
const SYMBOLS: &[Symbol] = &[
    symbol("m", 1.0, Dimension::LENGTH),
    symbol("um", 1e-6, Dimension::LENGTH),
    symbol("mm", 1e-3, Dimension::LENGTH),
    symbol("cm", 1e-2, Dimension::LENGTH),
    symbol("km", 1e3, Dimension::LENGTH),
    symbol("ft", 0.3048, Dimension::LENGTH),
    symbol("L", 1e-3, VOLUME),
    symbol("kg", 1.0, MASS),
    symbol("g", 1e-3, MASS),
    symbol("t", 1e3, MASS),
    symbol("s", 1.0, Dimension::TIME),
    symbol("ms", 1e-3, Dimension::TIME),
    symbol("min", 60.0, Dimension::TIME),
    symbol("h", 3600.0, Dimension::TIME),
    symbol("day", 86400.0, Dimension::TIME),
    symbol("year", 365.25 * 86400.0, Dimension::TIME),
    symbol("N", 1.0, FORCE),
    symbol("kN", 1e3, FORCE),
    symbol("MN", 1e6, FORCE),
    symbol("Pa", 1.0, Dimension::STRESS),
    symbol("kPa", 1e3, Dimension::STRESS),
    symbol("MPa", 1e6, Dimension::STRESS),
    symbol("GPa", 1e9, Dimension::STRESS),
    symbol("bar", 1e5, Dimension::STRESS),
    symbol("psi", 6894.757293168361, Dimension::STRESS),
    symbol("P", 0.1, VISCOSITY),
    symbol("cP", 1e-3, VISCOSITY),
    symbol("darcy", 9.869233e-13, Dimension::AREA),
    symbol("mD", 9.869233e-16, Dimension::AREA),
    symbol("rad", 1.0, Dimension::ANGLE),
    symbol("deg", std::f64::consts::PI / 180.0, Dimension::ANGLE),
    symbol("°", std::f64::consts::PI / 180.0, Dimension::ANGLE),
    symbol("%", 1e-2, Dimension::NONE),
];

/// Factor and dimension of `a*b/c^n…` (also `m3` for `m^3`), or the symbol that is unknown.
pub(super) fn parse(unit: &str) -> Result<(f64, Dimension), String> {
    let (mut factor, mut dimension) = (1.0, Dimension::NONE);
    if unit.is_empty() {
        return Ok((factor, dimension));
    }
    let mut rest = unit;
    let mut sign = 1i8;
    loop {
        let end = rest.find(['*', '/', '·']).unwrap_or(rest.len());
        let (f, d) = power(rest[..end].trim())?;
        factor *= f.powi(i32::from(sign));
        dimension = dimension + d * sign;
        let mut tail = rest[end..].chars();
        match tail.next() {
            None => return Ok((factor, dimension)),
            Some(operator) => sign = if operator == '/' { -1 } else { 1 },
        }
        rest = tail.as_str();
    }
}

/// `name`, `name2`, `name^2`, `name^-2` or `name²`.
fn power(text: &str) -> Result<(f64, Dimension), String> {
    let plain = text.replace('²', "2").replace('³', "3");
    let end = plain
        .find(|c: char| c == '^' || c == '-' || c.is_ascii_digit())
        .unwrap_or(plain.len());
    let (name, exponent) = (
        plain[..end].trim(),
        plain[end..].trim_start_matches('^').trim(),
    );
    let exponent: i8 = match exponent {
        "" if !plain[end..].contains('^') => 1,
        digits => digits.parse().map_err(|_| text.to_string())?,
    };
    match SYMBOLS.iter().find(|s| s.name == name) {
        Some(s) if exponent.abs() < 10 => {
            Ok((s.factor.powi(i32::from(exponent)), s.dimension * exponent))
        }
        _ if plain == "1" => Ok((1.0, Dimension::NONE)),
        _ => Err(text.to_string()),
    }
}

/// The three known symbols most like `text` (case is ignored first).
pub(super) fn nearest(text: &str) -> Vec<&'static str> {
    let mut ranked: Vec<(usize, usize, &'static str)> = SYMBOLS
        .iter()
        .map(|s| {
            let folded = strsim::levenshtein(&text.to_lowercase(), &s.name.to_lowercase());
            (folded, strsim::levenshtein(text, s.name), s.name)
        })
        .collect();
    ranked.sort_by_key(|(folded, exact, _)| (*folded, *exact));
    ranked.iter().take(3).map(|(_, _, name)| *name).collect()
}
