//! Arrays that zlib has compressed, block by block.
//!
//! # Source
//! P. Deutsch, J.-L. Gailly, RFC 1950: zlib. Headers as in VTK's `vtkXMLDataReader`: blocks, bytes of one, bytes of the last one if it is
//! not whole, compressed bytes of each.

use super::array::{Layout, length};
use miniz_oxide::inflate::decompress_to_vec_zlib_with_limit as inflated;
use std::borrow::Cow;

/// Words of a header before the sizes of its blocks.
const BEFORE: usize = 3;

/// The bytes of an array, of which `needed` are asked for; `first(n)` is the first n bytes where it stands. `None` where these end too early.
///
/// # Errors
/// Another length than the one needed, and blocks that are damaged.
pub(super) fn unpacked<'b>(
    first: impl Fn(usize) -> Option<Cow<'b, [u8]>>,
    layout: Layout,
    needed: usize,
) -> Result<Option<Vec<u8>>, String> {
    let Some(header) = header(&first, layout) else {
        return Ok(None);
    };
    let [blocks, whole, last] = [0, 1, 2].map(|k: usize| header[k]);
    let last = if last == 0 { whole } else { last };
    let of_block = |k: usize| if k + 1 < blocks { whole } else { last };
    let all = blocks.checked_sub(1).map_or(Some(0), |before| {
        whole.checked_mul(before)?.checked_add(last)
    });
    // before any memory is taken
    if all != Some(needed) {
        let all = all.map_or("far more".into(), |all| all.to_string());
        return Err(format!("has {all} bytes, and {needed} are needed"));
    }
    let sizes = &header[BEFORE..];
    let start = header.len() * layout.header;
    let end = (sizes.iter()).try_fold(start, |sum, size| usize::checked_add(sum, *size));
    let Some(packed) = end.and_then(first) else {
        return Ok(None);
    };
    let (mut bytes, mut at) = (Vec::new(), start);
    for (k, size) in sizes.iter().enumerate() {
        let own = inflated(&packed[at..at + size], of_block(k));
        let own = own.ok().filter(|own| own.len() == of_block(k));
        let own = own.ok_or_else(|| format!("is damaged in block {k} of {blocks}"))?;
        bytes.extend(own);
        at += size;
    }
    Ok(Some(bytes))
}

/// The words of a header: three and one per block; three zeros where it has no block.
fn header<'b>(
    first: impl Fn(usize) -> Option<Cow<'b, [u8]>>,
    layout: Layout,
) -> Option<Vec<usize>> {
    let blocks = length(&first(layout.header)?, layout)?;
    if blocks == 0 {
        return Some(vec![0; BEFORE]);
    }
    let words = blocks.checked_add(BEFORE)?;
    let bytes = first(words.checked_mul(layout.header)?)?;
    let of = |word: &[u8]| length(word, layout);
    bytes.chunks_exact(layout.header).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::super::read;
    use super::super::tests::{Style, example, styles, written};
    use super::*;
    use fracas_operators::random::Random;

    fn zipped() -> impl Iterator<Item = Style> {
        styles().into_iter().filter(|style| style.block.is_some())
    }

    /// Claim: whatever bytes are wrong, it is said, or what they stand for is not asked for; nothing else comes out as numbers.
    #[test]
    fn damaged_blocks_are_said() {
        let mut said = 0;
        for (seed, style) in zipped().filter(|style| style.format == "raw").enumerate() {
            let r = &mut Random::new(seed as u64);
            let bytes = written(&[example(r)], style);
            let known = read(&bytes, "a.vtu", "pressure").unwrap();
            let data = bytes
                .windows(13)
                .position(|w| w == b"<AppendedData")
                .unwrap();
            for _ in 0..400 {
                let mut wrong = bytes.clone();
                for _ in 0..1 + r.below(3) {
                    let at = data + 30 + r.below(bytes.len() - data - 60);
                    wrong[at] = r.below(256) as u8;
                }
                match read(&wrong, "a.vtu", "pressure") {
                    Ok(found) => assert_eq!(
                        (found.points, found.pressures),
                        (known.points.clone(), known.pressures.clone())
                    ),
                    Err(error) => {
                        let text = error.to_string();
                        said += usize::from(text.contains("is damaged in block"));
                    }
                }
            }
        }
        assert!(said > 1000, "{said}");
    }

    #[test]
    fn sizes_that_lie_take_no_memory() {
        let layout = Layout {
            is_big_endian: false,
            header: 8,
            is_packed: true,
        };
        let huge = u64::MAX / 2;
        for (words, needed, expected) in [
            (vec![huge], 8, None),
            (vec![1 << 40, 8, 8], 8, None),
            (
                vec![1, huge, 0, 20],
                8,
                Some(format!("has {huge} bytes, and 8 are needed")),
            ),
            (
                vec![3, huge, huge, 1, 1, 1],
                8,
                Some("has far more bytes".into()),
            ),
            (vec![1, huge, 0, 20], huge as usize, None),
            (vec![2, 4, 0, huge, huge], 8, None),
            (vec![2, 4, 0, u64::MAX, u64::MAX], 8, None),
            (
                vec![1, huge, 0, 4],
                huge as usize,
                Some("is damaged in block 0 of 1".into()),
            ),
        ] {
            let bytes: Vec<u8> = words.iter().flat_map(|w| w.to_le_bytes()).collect();
            let bytes = [bytes, vec![7; 12]].concat();
            let first = |n: usize| bytes.get(..n).map(Cow::Borrowed);
            match (unpacked(first, layout, needed), expected) {
                (Ok(None), None) => {}
                (Err(text), Some(expected)) => assert!(text.contains(&expected), "{text}"),
                (found, expected) => panic!("{found:?} {expected:?} {words:?}"),
            }
        }
        // an array without numbers has no block
        let none = [0; 24];
        let first = |n: usize| none.get(..n).map(Cow::Borrowed);
        assert_eq!(unpacked(first, layout, 0), Ok(Some(Vec::new())));
        assert!(unpacked(first, layout, 8).is_err());
    }
}
