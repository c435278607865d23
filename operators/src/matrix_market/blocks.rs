//! A file in blocks of whole lines: what is in memory does not depend on its length.

use super::error::Defect;
use super::header::{Header, parse_header};
use super::lines::{Lines, pieces};
use rayon::prelude::*;
use std::io::{self, Read, Seek, SeekFrom};

/// Bytes read at a time; a longer line makes the buffer longer.
const BLOCK: usize = 8 << 20;

/// Bytes in which banner, comments and sizes are looked for first.
const HEAD: usize = 1 << 12;

/// Why a source gave no matrix.
#[derive(Debug)]
pub(super) enum Failure {
    /// The operating system refuses.
    Io(io::Error),
    /// A line, counted from 1, and what is wrong with it.
    Content(usize, Defect),
    /// Something is wrong; [`diagnose`](super::diagnose::diagnose) finds the line.
    Undiagnosed,
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Walks over blocks of whole lines; the last line may lack its end.
struct Blocks<'a, S> {
    source: &'a mut S,
    buffer: Vec<u8>,
    /// Bytes of the buffer that were handed out.
    used: usize,
    /// Bytes of the buffer that hold text.
    filled: usize,
}

impl<S: Read> Blocks<'_, S> {
    fn next(&mut self) -> io::Result<Option<&[u8]>> {
        self.buffer.copy_within(self.used..self.filled, 0);
        self.filled -= self.used;
        self.used = 0;
        loop {
            let ended = self.fill()?;
            let text = &self.buffer[..self.filled];
            if ended {
                self.used = self.filled;
                break;
            }
            if let Some(end) = text.iter().rposition(|b| *b == b'\n') {
                self.used = end + 1;
                break;
            }
            self.buffer.resize(2 * self.buffer.len(), 0);
        }
        Ok((self.used > 0).then(|| &self.buffer[..self.used]))
    }

    /// Reads until the buffer is full; true at the end of the file.
    fn fill(&mut self) -> io::Result<bool> {
        while self.filled < self.buffer.len() {
            match self.source.read(&mut self.buffer[self.filled..]) {
                Ok(0) => return Ok(true),
                Ok(n) => self.filled += n,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(false)
    }
}

/// Banner and sizes, and the byte at which the body begins.
pub(super) fn header(source: &mut (impl Read + Seek)) -> Result<(Header, u64), Failure> {
    source.seek(SeekFrom::Start(0))?;
    let mut blocks = Blocks {
        source,
        buffer: vec![0; HEAD],
        used: 0,
        filled: 0,
    };
    loop {
        let ended = blocks.fill()?;
        let text = &blocks.buffer[..blocks.filled];
        // a line that is cut off is not looked at
        let whole = match text.iter().rposition(|b| *b == b'\n') {
            Some(end) if !ended => end + 1,
            None if !ended => 0,
            _ => text.len(),
        };
        let mut lines = Lines::new(&text[..whole]);
        match parse_header(&mut lines) {
            Ok(header) => return Ok((header, (whole - lines.rest().len()) as u64)),
            Err((_, Defect::NoSize)) if !ended => {}
            Err(_) if whole == 0 && !ended => {}
            Err((line, defect)) => return Err(Failure::Content(line, defect)),
        }
        let len = blocks.buffer.len();
        blocks.buffer.resize(2 * len, 0);
    }
}

/// Hands the body to `see`, block after block.
pub(super) fn each_block(
    source: &mut (impl Read + Seek),
    body: u64,
    mut see: impl FnMut(&[u8]) -> Result<(), Failure>,
) -> Result<(), Failure> {
    source.seek(SeekFrom::Start(body))?;
    let mut blocks = Blocks {
        source,
        buffer: vec![0; BLOCK],
        used: 0,
        filled: 0,
    };
    while let Some(block) = blocks.next()? {
        see(block)?;
    }
    Ok(())
}

/// Parses the body in pieces, on all threads, and hands the pieces over in the order of the file while the next block is
/// parsed.
pub(super) fn each_piece<T: Send + Sync>(
    source: &mut (impl Read + Seek),
    body: u64,
    parse: impl Fn(&[u8]) -> Option<Vec<T>> + Sync,
    mut take: impl FnMut(&[T]) -> Result<(), Failure> + Send,
) -> Result<(), Failure> {
    let mut waiting: Vec<Vec<T>> = Vec::new();
    each_block(source, body, |block| {
        let pieces = pieces(block);
        let (parsed, taken) = rayon::join(
            || {
                pieces
                    .par_iter()
                    .map(|p| parse(p))
                    .collect::<Option<Vec<_>>>()
            },
            || waiting.iter().try_for_each(|piece| take(piece)),
        );
        taken?;
        waiting = parsed.ok_or(Failure::Undiagnosed)?;
        Ok(())
    })?;
    waiting.iter().try_for_each(|piece| take(piece))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    #[test]
    fn blocks_end_at_line_ends_and_give_back_every_byte() {
        let line = "0123456789 ".repeat(30);
        let mut text: String = (0..40_000).map(|i| format!("{i} {line}\n")).collect();
        text.push_str(&"x".repeat(BLOCK + 7));
        text.push_str("\nlast");
        let (mut seen, mut count) = (Vec::new(), 0);
        each_block(&mut Cursor::new(&text), 3, |block| {
            count += 1;
            let so_far = seen.len();
            seen.extend_from_slice(block);
            assert!(block.ends_with(b"\n") || so_far + block.len() + 3 == text.len());
            Ok(())
        })
        .unwrap();
        assert!(seen == text.as_bytes()[3..] && count > 2);
    }

    #[test]
    fn a_header_may_be_long_and_its_end_is_known() {
        for comments in [0, 10, 100, 1000] {
            let note = "% a remark of some length\n".repeat(comments);
            let head = format!("%%MatrixMarket matrix coordinate real general\n{note}3 3 1\n");
            let (header, body) = header(&mut Cursor::new(format!("{head}1 1 1\n"))).unwrap();
            assert_eq!((header.rows, body as usize), (3, head.len()));
            assert_eq!(header.size_line, comments + 2);
        }
    }
}
