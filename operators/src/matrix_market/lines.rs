//! Lines and words of a byte buffer, with line numbers, and cuts at line ends for parallel reading.

/// Walks over lines; knows the number (from 1) of the line returned last. CR before LF is dropped.
#[derive(Clone, Debug)]
pub(super) struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Lines<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            rest: bytes,
            number: 0,
        }
    }

    pub(super) fn number(&self) -> usize {
        self.number
    }

    /// What has not been read.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.rest
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let end = self.rest.iter().position(|b| *b == b'\n');
        let (line, rest) = match end {
            Some(end) => (&self.rest[..end], &self.rest[end + 1..]),
            None => (self.rest, &[][..]),
        };
        self.rest = rest;
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }
}

/// Bytes of a piece that one thread parses: about 15k entries.
const PIECE: usize = 1 << 19;

/// Cuts a block into pieces that end at line ends.
pub(super) fn pieces(block: &[u8]) -> Vec<&[u8]> {
    let mut pieces = Vec::with_capacity(block.len() / PIECE + 1);
    let mut rest = block;
    while rest.len() > PIECE {
        let Some(end) = rest[PIECE..].iter().position(|b| *b == b'\n') else {
            break;
        };
        let (piece, tail) = rest.split_at(PIECE + end + 1);
        pieces.push(piece);
        rest = tail;
    }
    if !rest.is_empty() {
        pieces.push(rest);
    }
    pieces
}

/// True for lines that hold no data.
pub(super) fn is_blank(line: &[u8]) -> bool {
    match line.iter().find(|b| !b.is_ascii_whitespace()) {
        None => true,
        Some(first) => *first == b'%',
    }
}

/// Takes the next word of a line.
pub(super) fn word<'a>(line: &mut &'a [u8]) -> &'a [u8] {
    let start = line
        .iter()
        .position(|b| !b.is_ascii_whitespace())
        .unwrap_or(line.len());
    let tail = &line[start..];
    let end = tail
        .iter()
        .position(u8::is_ascii_whitespace)
        .unwrap_or(tail.len());
    let (word, rest) = tail.split_at(end);
    *line = rest;
    word
}

/// A line for an error message: at most 60 characters.
pub(super) fn shorten(line: &[u8]) -> String {
    // control characters would break the sentence into lines, or command the terminal
    let text = String::from_utf8_lossy(line.trim_ascii()).replace(|c: char| c.is_control(), "·");
    match text.char_indices().nth(60) {
        None => text,
        Some((end, _)) => format!("{}…", &text[..end]),
    }
}
