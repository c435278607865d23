//! What happens to files on their way: bytes, lines and numbers that are not what they were.

use fracas_operators::random::Random;

/// Numbers and words that readers stumble over.
const NASTY: [&str; 30] = [
    "0",
    "-1",
    "-0",
    "1",
    "2",
    "1e999",
    "-1e999",
    "1e-400",
    "nan",
    "NaN",
    "inf",
    "-inf",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "9223372036854775808",
    "18446744073709551615",
    "18446744073709551616",
    "99999999999999999999999999",
    "1e18",
    "1e308",
    "0x10",
    "1_000",
    "1,5",
    "",
    " ",
    "\"",
    "true",
    "[]",
    "\u{e9}\u{2126}",
];

/// What was done to a file, as far as an oracle asks for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Change {
    /// Its end is missing.
    Cut,
    /// Something follows its end.
    Longer,
    /// Anything else.
    Other,
}

/// One to three changes of a file; [`Change::Other`] where they are several.
pub(crate) fn mutate(bytes: &[u8], g: &mut Random) -> (Vec<u8>, Change) {
    let mut bytes = bytes.to_vec();
    let mut what = Change::Other;
    let changes = 1 + usize::from(g.once_in(3)) + usize::from(g.once_in(6));
    for k in 0..changes {
        let now = one(&mut bytes, g);
        what = if k == 0 { now } else { Change::Other };
    }
    (bytes, what)
}

fn one(bytes: &mut Vec<u8>, g: &mut Random) -> Change {
    if bytes.is_empty() {
        bytes.extend_from_slice(g.one_of(&NASTY).as_bytes());
        return Change::Other;
    }
    let n = bytes.len();
    match g.below(12) {
        0 => {
            bytes.truncate(g.below(n));
            return Change::Cut;
        }
        1 => {
            let junk = g.one_of(&[
                "x",
                "1 1 1\n",
                "\n$Nodes\n",
                "[solver]\n",
                "\0",
                "1e999\n",
                "%\n",
            ]);
            bytes.extend_from_slice(junk.as_bytes());
            return Change::Longer;
        }
        2 => bytes[g.below(n)] ^= 1 << g.below(8),
        3 => bytes[g.below(n)] = g.bits() as u8,
        4 => drop(bytes.remove(g.below(n))),
        5 => bytes.insert(
            g.below(n),
            g.one_of(&["0", "-", ".", "e", " ", "\n", "=", "\""])
                .as_bytes()[0],
        ),
        6 => lines(bytes, g, |lines, i, _| drop(lines.remove(i))),
        7 => lines(bytes, g, |lines, i, j| lines.insert(j, lines[i].clone())),
        8 => lines(bytes, g, |lines, i, j| lines.swap(i, j)),
        _ => word(bytes, g),
    }
    Change::Other
}

fn lines(bytes: &mut Vec<u8>, g: &mut Random, change: impl Fn(&mut Vec<Vec<u8>>, usize, usize)) {
    let mut lines: Vec<Vec<u8>> = bytes
        .split_inclusive(|b| *b == b'\n')
        .map(<[u8]>::to_vec)
        .collect();
    let (i, j) = (g.below(lines.len()), g.below(lines.len()));
    change(&mut lines, i, j);
    *bytes = lines.concat();
}

/// Puts a nasty word, or another word of the file, in the place of one.
fn word(bytes: &mut Vec<u8>, g: &mut Random) {
    let ends = |b: &u8| b" \n\t\"=,[]{}".contains(b);
    let at = g.below(bytes.len());
    let from = bytes[..at].iter().rposition(ends).map_or(0, |i| i + 1);
    let to = bytes[at..]
        .iter()
        .position(ends)
        .map_or(bytes.len(), |i| at + i);
    let new = match g.once_in(4) {
        true => {
            let words: Vec<&[u8]> = bytes.split(ends).filter(|w| !w.is_empty()).collect();
            match words.is_empty() {
                true => Vec::new(),
                false => g.one_of(&words).to_vec(),
            }
        }
        false => g.one_of(&NASTY).as_bytes().to_vec(),
    };
    bytes.splice(from..to.max(from), new);
}
