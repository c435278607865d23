//! Numbers of an array, as text, base 64 or raw bytes.

use super::base64::decode;
use super::packed::unpacked;
use super::xml::Tag;
use std::borrow::Cow;

/// How numbers stand in a file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub(super) is_big_endian: bool,
    /// Bytes of the number before an array, which is its length.
    pub(super) header: usize,
    /// What is no text is compressed.
    pub(super) is_packed: bool,
}

/// The section behind the last tag.
#[derive(Clone, Copy, Debug)]
pub(super) struct Appended<'b> {
    /// From behind the `_` on.
    pub(super) bytes: &'b [u8],
    pub(super) is_raw: bool,
}

/// An array as it stands in a file.
#[derive(Clone, Debug)]
pub(super) struct Array<'b> {
    pub(super) tag: Tag,
    /// Between its tags.
    pub(super) text: &'b [u8],
}

/// A type of numbers: bytes of one, and how it is read from eight bytes in the order of this machine, the last ones zero.
type Number = (usize, fn([u8; 8]) -> f64);

impl Array<'_> {
    /// Its name, for messages and to be found by.
    pub(super) fn name(&self) -> &str {
        self.tag.get("Name").unwrap_or_default()
    }

    /// All its numbers, of which `count` are needed. Whole ones beyond 2⁵³ lose digits: there are no such counts.
    pub(super) fn numbers(
        &self,
        layout: Layout,
        appended: Option<Appended<'_>>,
        count: usize,
    ) -> Result<Vec<f64>, String> {
        let name = self.name();
        let kind = self.tag.get("type").unwrap_or_default();
        let (size, read) = number(kind)
            .ok_or_else(|| format!("array `{name}` has the type {kind}, which is no number"))?;
        let short = || format!("the numbers of array `{name}` end before its length");
        let (from, is_raw) = match self.tag.get("format").unwrap_or("ascii") {
            "ascii" => return self.words(),
            "binary" => (self.text, false),
            "appended" => {
                let section = appended.ok_or("it has no AppendedData")?;
                let offset = self.tag.number("offset")?;
                let offset = offset.ok_or_else(|| format!("array `{name}` has no offset"))?;
                let from = section.bytes.get(offset..).ok_or_else(short)?;
                (from, section.is_raw)
            }
            other => {
                return Err(format!(
                    "array `{name}` has the format {other}; ascii, binary and appended are read"
                ));
            }
        };
        let first = |length: usize| match is_raw {
            true => from.get(..length).map(Cow::Borrowed),
            false => decode(from, length).map(Cow::Owned),
        };
        let bytes = match layout.is_packed {
            true => unpacked(first, layout, count.saturating_mul(size))
                .map_err(|defect| format!("array `{name}` {defect}"))?,
            false => plain(first, layout),
        };
        let bytes = bytes.ok_or_else(short)?;
        if bytes.len() % size != 0 {
            return Err(format!(
                "array `{name}` has {} bytes, which are no {kind}",
                bytes.len()
            ));
        }
        let of = |own: &[u8]| {
            let mut word = [0; 8];
            word[..size].copy_from_slice(own);
            if layout.is_big_endian {
                word[..size].reverse();
            }
            read(word)
        };
        Ok(bytes.chunks_exact(size).map(of).collect())
    }

    /// Numbers as text.
    fn words(&self) -> Result<Vec<f64>, String> {
        let name = self.name();
        let text = std::str::from_utf8(self.text);
        let text = text.map_err(|_| format!("array `{name}` is no text"))?;
        let number = |word: &str| {
            word.parse()
                .map_err(|_| format!("array `{name}` holds `{word}`, which is no number"))
        };
        text.split_ascii_whitespace().map(number).collect()
    }
}

/// Bytes behind their length; `first(n)` is the first n bytes where they stand.
fn plain<'b>(first: impl Fn(usize) -> Option<Cow<'b, [u8]>>, layout: Layout) -> Option<Vec<u8>> {
    let length = length(&first(layout.header)?, layout)?;
    let mut bytes = first(layout.header.checked_add(length)?)?.into_owned();
    bytes.drain(..layout.header);
    Some(bytes)
}

/// The length that a header says.
pub(super) fn length(header: &[u8], layout: Layout) -> Option<usize> {
    let mut word = [0; 8];
    word[..header.len()].copy_from_slice(header);
    if layout.is_big_endian {
        word[..header.len()].reverse();
    }
    usize::try_from(u64::from_le_bytes(word)).ok()
}

/// The type of that name; words have their lowest byte first.
fn number(kind: &str) -> Option<Number> {
    Some(match kind {
        "Float32" => (4, |[a, b, c, d, ..]| {
            f64::from(f32::from_le_bytes([a, b, c, d]))
        }),
        "Float64" => (8, f64::from_le_bytes),
        "Int8" => (1, |[a, ..]| f64::from(a as i8)),
        "UInt8" => (1, |[a, ..]| f64::from(a)),
        "Int16" => (2, |[a, b, ..]| f64::from(i16::from_le_bytes([a, b]))),
        "UInt16" => (2, |[a, b, ..]| f64::from(u16::from_le_bytes([a, b]))),
        "Int32" => (4, |[a, b, c, d, ..]| {
            f64::from(i32::from_le_bytes([a, b, c, d]))
        }),
        "UInt32" => (4, |[a, b, c, d, ..]| {
            f64::from(u32::from_le_bytes([a, b, c, d]))
        }),
        "Int64" => (8, |word| i64::from_le_bytes(word) as f64),
        "UInt64" => (8, |word| u64::from_le_bytes(word) as f64),
        _ => return None,
    })
}
