//! Arithmetic over measures and axes: `100 * n_t / n_u`, `log10(n_it)`.

/// Value of a formula; `of` gives that of a name.
///
/// # Errors
/// What cannot be read, in a few words.
pub(super) fn value(text: &str, of: &mut dyn FnMut(&str) -> f64) -> Result<f64, String> {
    let mut reader = Reader {
        rest: text,
        of,
        depth: 0,
    };
    let value = reader.sum()?;
    match reader.peek() {
        None => Ok(value),
        Some(c) => Err(format!("`{c}` is not expected in `{text}`")),
    }
}

/// Brackets and signs within each other, at most: each takes a frame of the stack. Unit: 1.
const DEPTH: usize = 100;

struct Reader<'a> {
    rest: &'a str,
    of: &'a mut dyn FnMut(&str) -> f64,
    depth: usize,
}

impl<'a> Reader<'a> {
    fn peek(&mut self) -> Option<char> {
        self.rest = self.rest.trim_start();
        self.rest.chars().next()
    }

    /// True where the next sign is this one, which is taken.
    fn take(&mut self, sign: char) -> bool {
        let found = self.peek() == Some(sign);
        if found {
            self.rest = &self.rest[1..];
        }
        found
    }

    fn sum(&mut self) -> Result<f64, String> {
        let mut sum = self.product()?;
        loop {
            if self.take('+') {
                sum += self.product()?;
            } else if self.take('-') {
                sum -= self.product()?;
            } else {
                return Ok(sum);
            }
        }
    }

    fn product(&mut self) -> Result<f64, String> {
        let mut product = self.factor()?;
        loop {
            if self.take('*') {
                product *= self.factor()?;
            } else if self.take('/') {
                product /= self.factor()?;
            } else {
                return Ok(product);
            }
        }
    }

    fn factor(&mut self) -> Result<f64, String> {
        self.depth += 1;
        if self.depth > DEPTH {
            return Err(format!(
                "more than {DEPTH} brackets or signs lie within each other"
            ));
        }
        let value = self.bare_factor();
        self.depth -= 1;
        value
    }

    fn bare_factor(&mut self) -> Result<f64, String> {
        if self.take('-') {
            return Ok(-self.factor()?);
        }
        if self.take('(') {
            let inside = self.sum()?;
            return match self.take(')') {
                true => Ok(inside),
                false => Err("a bracket is not closed".into()),
            };
        }
        let of_number = |c: char| c.is_ascii_digit() || c == '.';
        match self.peek() {
            Some(c) if of_number(c) => {
                let mut before = ' ';
                let text = self.word(|c| {
                    let belongs = of_number(c) || c == 'e' || (before == 'e' && "+-".contains(c));
                    before = c;
                    belongs
                });
                (text.parse()).map_err(|_| format!("`{text}` is no number"))
            }
            Some(c) if c.is_alphabetic() => {
                let name = self.word(|c| c.is_alphanumeric() || c == '_' || c == '.');
                match (name, self.peek()) {
                    ("log10", Some('(')) => Ok(self.factor()?.log10()),
                    _ => Ok((self.of)(name)),
                }
            }
            Some(c) => Err(format!("`{c}` is neither a name nor a number")),
            None => Err("it ends too early".into()),
        }
    }

    fn word(&mut self, mut belongs: impl FnMut(char) -> bool) -> &'a str {
        let end = self.rest.find(|c| !belongs(c)).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(end);
        self.rest = rest;
        word
    }
}

#[cfg(test)]
mod tests {
    use super::value;

    #[test]
    fn products_before_sums_and_what_is_no_formula_is_said() {
        let of = |text: &str| value(text, &mut |name| if name == "C_s" { 7.0 } else { f64::NAN });
        assert_eq!(of("1 + 2 * (C_s - 4) / 3"), Ok(3.0));
        assert_eq!(of("1e3*C_s - 1 - 1"), Ok(6998.0));
        assert_eq!(of("2 * log10(100 * (C_s - 6))"), Ok(4.0));
        assert_eq!(of("-C_s + 1e-3*-2 - 25e-1"), of("-(7 + 2/1000) - 2.5"));
        assert_eq!(of("- -2*-C_s"), Ok(-14.0));
        assert!(of("published.n_it").unwrap().is_nan());
        let deep = |n: usize| format!("{}1{}", "(".repeat(n), ")".repeat(n));
        assert_eq!(of(&deep(90)), Ok(1.0));
        assert!(of(&deep(20_000)).is_err());
        for wrong in ["", "1 +", "(1", "1 2", "1..2", "n $ 2"] {
            assert!(of(wrong).is_err(), "{wrong}");
        }
    }
}
