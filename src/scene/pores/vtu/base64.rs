//! Bytes written as letters.
//!
//! # Source
//! S. Josefsson, RFC 4648: base 64.

/// The first `length` bytes of a text; `None` where it has fewer, or letters of no base 64. White space counts as none, and what is padded
/// may be followed by more: VTK encodes some lengths apart from the data behind them.
pub(super) fn decode(text: &[u8], length: usize) -> Option<Vec<u8>> {
    // a length that a file announces may be any
    let mut bytes = Vec::with_capacity(length.min(text.len()));
    let mut letters = text.iter().filter(|letter| !letter.is_ascii_whitespace());
    while bytes.len() < length {
        let mut group = [0; 4];
        let mut padded = 0;
        for value in &mut group {
            *value = match (letters.next()?, padded) {
                (b'=', _) => {
                    padded += 1;
                    0
                }
                (letter, 0) => of(*letter)?,
                _ => return None,
            };
        }
        let word = group.iter().fold(0, |word, value| word << 6 | value);
        let own = 3usize.checked_sub(padded).filter(|n| *n > 0)?;
        bytes.extend(&u32::to_be_bytes(word)[1..1 + own]);
    }
    bytes.truncate(length);
    Some(bytes)
}

/// Six bits of a letter.
fn of(letter: u8) -> Option<u32> {
    let value = match letter {
        b'A'..=b'Z' => letter - b'A',
        b'a'..=b'z' => letter - b'a' + 26,
        b'0'..=b'9' => letter - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        _ => return None,
    };
    Some(u32::from(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_words_of_the_standard() {
        for (text, bytes) in [
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg==", "foob"),
            ("Zm9v\n YmE=", "fooba"),
            ("Zm9vYmFy", "foobar"),
            ("Zg==b28=", "foo"),
        ] {
            let found = decode(text.as_bytes(), bytes.len());
            assert_eq!(found.as_deref(), Some(bytes.as_bytes()), "{text}");
            assert_eq!(decode(text.as_bytes(), bytes.len() + 1), None, "{text}");
        }
        assert_eq!(decode(b"Zm9v", 2).as_deref(), Some(&b"fo"[..]));
        for wrong in ["Z===", "====", "Zm9-", "Zm=v"] {
            assert_eq!(decode(wrong.as_bytes(), 3), None, "{wrong}");
        }
    }
}
