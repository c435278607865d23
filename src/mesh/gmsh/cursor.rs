//! Numbers and words of a Gmsh file, with the place of whatever is wrong.

use std::fmt;

use super::GmshDefect;

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spot {
    /// In text: the line, counted from 1.
    Line(usize),
    /// In a binary file: the byte, counted from 0.
    Byte(usize),
}

impl fmt::Display for Spot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

/// Longest piece of a file that a message quotes.
const QUOTED: usize = 40;

/// Reads from front to back; numbers are text or little-endian binary.
#[derive(Clone, Debug)]
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Numbers are binary.
    pub(super) binary: bool,
}

impl<'a> Cursor<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: 0,
            binary: false,
        }
    }

    /// Where byte `at` is.
    fn spot(&self, at: usize) -> Spot {
        match self.binary {
            true => Spot::Byte(at),
            false => Spot::Line(1 + self.bytes[..at].iter().filter(|b| **b == b'\n').count()),
        }
    }

    /// Where the last number was.
    pub(super) fn before(&self) -> Spot {
        self.spot(self.at.saturating_sub(1))
    }

    fn truncated(&self, expected: &'static str) -> GmshDefect {
        GmshDefect::Truncated {
            spot: self.spot(self.bytes.len().saturating_sub(1)),
            expected,
        }
    }

    fn malformed(&self, at: usize, expected: &'static str, found: &[u8]) -> GmshDefect {
        let found = &found[..found.len().min(QUOTED)];
        GmshDefect::Malformed {
            spot: self.spot(at),
            expected,
            found: String::from_utf8_lossy(found).into_owned(),
        }
    }

    fn skip_spaces(&mut self) {
        let rest = &self.bytes[self.at..];
        self.at += rest
            .iter()
            .position(|b| !b.is_ascii_whitespace())
            .unwrap_or(rest.len());
    }

    /// Whether only white space is left.
    pub(super) fn is_at_end(&mut self) -> bool {
        self.skip_spaces();
        self.at == self.bytes.len()
    }

    /// The next word of text.
    pub(super) fn word(&mut self, expected: &'static str) -> Result<&'a [u8], GmshDefect> {
        if self.is_at_end() {
            return Err(self.truncated(expected));
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(u8::is_ascii_whitespace);
        let word = &rest[..length.unwrap_or(rest.len())];
        self.at += word.len();
        Ok(word)
    }

    /// The next word of text, as a number.
    fn parse<T: std::str::FromStr>(&mut self, expected: &'static str) -> Result<T, GmshDefect> {
        let word = self.word(expected)?;
        let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        number.ok_or_else(|| self.malformed(self.at - word.len(), expected, word))
    }

    /// A whole number written as text in either kind of file.
    pub(super) fn text_integer(&mut self, expected: &'static str) -> Result<i64, GmshDefect> {
        self.parse(expected)
    }

    /// A count written as text in either kind of file.
    pub(super) fn text_count(&mut self, expected: &'static str) -> Result<u64, GmshDefect> {
        self.parse(expected)
    }

    /// Text between double quotes on this line.
    pub(super) fn quoted(&mut self, expected: &'static str) -> Result<String, GmshDefect> {
        if self.is_at_end() {
            return Err(self.truncated(expected));
        }
        let start = self.at;
        let rest = &self.bytes[start..];
        let line = rest.split(|b| *b == b'\n').next().unwrap_or_default();
        let inner = line.strip_prefix(b"\"");
        let length = inner.and_then(|i| i.iter().rposition(|b| *b == b'"'));
        let (Some(inner), Some(length)) = (inner, length) else {
            return Err(self.malformed(start, expected, line.trim_ascii_end()));
        };
        self.at += length + 2;
        Ok(String::from_utf8_lossy(&inner[..length]).into_owned())
    }

    /// Leaves the line: binary numbers start right behind it.
    pub(super) fn end_line(&mut self) -> Result<(), GmshDefect> {
        let rest = &self.bytes[self.at..];
        match rest.iter().position(|b| *b == b'\n') {
            Some(length) if rest[..length].trim_ascii().is_empty() => {
                self.at += length + 1;
                Ok(())
            }
            Some(length) => Err(self.malformed(self.at, "the end of the line", &rest[..length])),
            None => Err(self.truncated("the end of a line")),
        }
    }

    /// The next `N` bytes.
    fn take<const N: usize>(&mut self, expected: &'static str) -> Result<[u8; N], GmshDefect> {
        let found = self.bytes[self.at..].first_chunk::<N>().copied();
        let found = found.ok_or_else(|| self.truncated(expected))?;
        self.at += N;
        Ok(found)
    }

    /// A whole number: `int` of C.
    pub(super) fn integer(&mut self, expected: &'static str) -> Result<i64, GmshDefect> {
        match self.binary {
            true => Ok(i32::from_le_bytes(self.take(expected)?).into()),
            false => self.parse(expected),
        }
    }

    /// A whole number that is not negative: `int` of C.
    pub(super) fn natural(&mut self, expected: &'static str) -> Result<u64, GmshDefect> {
        let found = self.integer(expected)?;
        u64::try_from(found).map_err(|_| GmshDefect::Malformed {
            spot: self.before(),
            expected,
            found: found.to_string(),
        })
    }

    /// The number of a physical group, or another tag.
    pub(super) fn tag(&mut self, expected: &'static str) -> Result<i32, GmshDefect> {
        let found = self.integer(expected)?;
        self.narrow(found, expected)
    }

    /// The same written as text in either kind of file.
    pub(super) fn text_tag(&mut self, expected: &'static str) -> Result<i32, GmshDefect> {
        let found = self.text_integer(expected)?;
        self.narrow(found, expected)
    }

    fn narrow(&self, found: i64, expected: &'static str) -> Result<i32, GmshDefect> {
        i32::try_from(found).map_err(|_| GmshDefect::Malformed {
            spot: self.before(),
            expected,
            found: found.to_string(),
        })
    }

    /// A number or a count: `size_t` of C, 8 bytes.
    pub(super) fn size(&mut self, expected: &'static str) -> Result<u64, GmshDefect> {
        match self.binary {
            true => Ok(u64::from_le_bytes(self.take(expected)?)),
            false => self.parse(expected),
        }
    }

    /// A real number: `double` of C.
    pub(super) fn real(&mut self, expected: &'static str) -> Result<f64, GmshDefect> {
        match self.binary {
            true => Ok(f64::from_le_bytes(self.take(expected)?)),
            false => self.parse(expected),
        }
    }

    /// Room worth reserving for `count` records: no more than the rest of the file can hold at two bytes each.
    pub(super) fn room(&self, count: u64) -> usize {
        let most = (self.bytes.len() - self.at) / 2;
        usize::try_from(count).map_or(most, |count| count.min(most))
    }

    /// The name of the section that starts here.
    pub(super) fn section(&mut self) -> Result<&'a str, GmshDefect> {
        const EXPECTED: &str = "a section such as $Nodes";
        let word = self.word(EXPECTED)?;
        let name = word.strip_prefix(b"$");
        name.and_then(|name| std::str::from_utf8(name).ok())
            .ok_or_else(|| self.malformed(self.at - word.len(), EXPECTED, word))
    }

    /// Passes `$EndNAME`, which must be next.
    pub(super) fn end(&mut self, section: &str) -> Result<(), GmshDefect> {
        const EXPECTED: &str = "the end of the section";
        let word = self.word(EXPECTED)?;
        match word.strip_prefix(b"$End") == Some(section.as_bytes()) {
            true => Ok(()),
            false => Err(self.malformed(self.at - word.len(), EXPECTED, word)),
        }
    }

    /// Passes everything up to `$EndNAME`.
    pub(super) fn skip_to_end(&mut self, section: &str) -> Result<(), GmshDefect> {
        let mark = format!("$End{section}");
        let rest = &self.bytes[self.at..];
        match rest.windows(mark.len()).position(|w| w == mark.as_bytes()) {
            Some(position) => {
                self.at += position + mark.len();
                Ok(())
            }
            None => Err(self.truncated("the end of a section")),
        }
    }

    /// The next four bytes as they stand.
    pub(super) fn four(&mut self) -> Result<[u8; 4], GmshDefect> {
        self.take("the number one that shows the order of bytes")
    }
}
