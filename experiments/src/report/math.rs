//! Formulas in sentences, set as formulas: from the characters of plain text to MathML.
//!
//! A word is a formula where it has what words do not have: an index (`S_u`), a transpose or an inverse (`M⁻¹𝒜`), a Greek letter, a
//! norm, a root. Operators join what stands beside it: `S_u = A + B C⁻¹Bᵀ` is one formula. What is none stays text.

mod set;

use super::html::escape;
use fracas_figures::with_indices;
use set::set;
use std::fmt::Write as _;

/// Names of more than one letter that are set upright.
const FUNCTIONS: &[&str] = &[
    "sin", "cos", "tan", "exp", "log", "ln", "det", "tr", "diag", "blkdiag", "eig", "max", "min",
    "sup", "inf", "Re", "Im", "fl", "rank", "ker",
];

/// Operators that stand alone between spaces.
const OPERATORS: &str = "=≤≥<>+−-·×/≈≠∈≻⪰∝→←~±≪≫";

/// Raised characters and what they are.
const RAISED: &[(char, char)] = &[
    ('⁰', '0'),
    ('¹', '1'),
    ('²', '2'),
    ('³', '3'),
    ('⁴', '4'),
    ('⁵', '5'),
    ('⁶', '6'),
    ('⁷', '7'),
    ('⁸', '8'),
    ('⁹', '9'),
    ('⁻', '−'),
    ('⁺', '+'),
    ('ᵀ', 'T'),
    ('ⁿ', 'n'),
];

/// Lowered characters and what they are.
const LOWERED: &[(char, char)] = &[
    ('₀', '0'),
    ('₁', '1'),
    ('₂', '2'),
    ('₃', '3'),
    ('₄', '4'),
    ('ₙ', 'n'),
    ('ₖ', 'k'),
    ('ᵢ', 'i'),
    ('ⱼ', 'j'),
];

/// A tilde over the letter before it.
const TILDE: char = '\u{303}';

fn found(table: &[(char, char)], c: char) -> Option<char> {
    table
        .iter()
        .find(|(shown, _)| *shown == c)
        .map(|(_, is)| *is)
}

fn is_greek(c: char) -> bool {
    ('α'..='ω').contains(&c) || "ΔΓΘΛΞΠΣΦΨΩ∂∇".contains(c)
}

/// A sentence in HTML: formulas as MathML, what stands between backticks as code, unless it is a formula, too.
pub(super) fn prose(text: &str) -> String {
    let mut html = String::new();
    for (k, part) in text.split('`').enumerate() {
        if k % 2 == 0 {
            sentence(&mut html, part);
        } else if let Some(formula) = code(part) {
            html += &formula;
        } else {
            // Writing to a string cannot fail.
            let _ = write!(html, "<code>{}</code>", escape(part));
        }
    }
    html
}

/// What stands between backticks, where it is a formula.
fn code(text: &str) -> Option<String> {
    (is_strong(text) || has_relation(text))
        .then(|| set(text))
        .flatten()
}

fn plain(html: &mut String, text: &str) {
    *html += &with_indices(&escape(text), |index| format!("<sub>{index}</sub>"));
}

/// `x = 1`: letters and numbers with a relation between them.
fn has_relation(text: &str) -> bool {
    let words: Vec<&str> = text.split(' ').collect();
    words.len() > 2
        && words.iter().any(|w| "=≤≥<>≈≠".contains(w))
        && words.iter().all(|w| is_part(w))
}

/// Text without formulas, with formulas between.
fn sentence(html: &mut String, text: &str) {
    let words: Vec<&str> = text.split(' ').collect();
    let mut k = 0;
    let mut first = true;
    while k < words.len() {
        if !std::mem::replace(&mut first, false) {
            html.push(' ');
        }
        match formula_at(&words[k..]) {
            Some((before, formula, after, count)) => {
                plain(html, before);
                *html += &formula;
                plain(html, after);
                k += count;
            }
            None => {
                plain(html, words[k]);
                k += 1;
            }
        }
    }
}

/// The longest formula that begins with the first word: text before and after it, MathML, and words that it takes.
fn formula_at<'a>(words: &[&'a str]) -> Option<(&'a str, String, &'a str, usize)> {
    let (before, start) = opened(words[0]);
    if !is_part(closed(start, 0).0) || is_operator(start) {
        return None;
    }
    // ends that are possible, longest last
    let mut ends = Vec::new();
    let (mut taken, mut depth) = (String::new(), 0i32);
    let mut word = start;
    let mut k = 0;
    loop {
        let (core, after) = closed(word, depth);
        depth += balance(core);
        if depth < 0 || !is_part(core) {
            break;
        }
        if k > 0 {
            taken.push(' ');
        }
        taken += core;
        if depth == 0 && !is_operator(core) {
            ends.push((taken.clone(), after, k + 1));
        }
        let ends_here = depth == 0 && !after.is_empty();
        let Some(next) = words.get(k + 1).filter(|_| !ends_here) else {
            break;
        };
        if !after.is_empty() {
            taken += after;
        }
        let next_core = closed(next, depth).0;
        let joins = depth > 0
            || is_operator(core)
            || is_operator(next)
            || (is_strong(core) || is_symbol(core)) && (is_strong(next_core) || is_symbol(next_core))
            || FUNCTIONS.contains(&core) && (next.starts_with('(') || next_core.chars().count() == 1 || is_strong(next_core))
            // (1 − x)² (1 + x)
            || next.starts_with('(') && core.ends_with(|c| c == ')' || found(RAISED, c).is_some());
        if !joins {
            break;
        }
        word = next;
        k += 1;
    }
    ends.into_iter().rev().find_map(|(text, after, count)| {
        // one letter that is not spelled as a formula is a word
        let counts = is_strong(&text) || has_relation(&text);
        let formula = counts.then(|| set(&text)).flatten()?;
        Some((before, formula, after, count))
    })
}

/// A bracket in front of a word that does not close in it.
fn opened(word: &str) -> (&str, &str) {
    match word.starts_with(['(', '"']) && balance(word) > 0 && !word.ends_with(')') {
        true => word.split_at(1),
        false => (&word[..0], word),
    }
}

/// A word and the punctuation behind it, brackets that nothing has opened among it.
fn closed(word: &str, depth: i32) -> (&str, &str) {
    let mut core = word;
    loop {
        let last = core.chars().next_back();
        let is_loose = match last {
            Some(',' | ';' | ':' | '.' | '?' | '"' | '…') => true,
            Some(')' | ']') => depth + balance(core) < 0,
            _ => false,
        };
        match last {
            Some(c) if is_loose => core = &core[..core.len() - c.len_utf8()],
            _ => return (core, &word[core.len()..]),
        }
    }
}

fn balance(text: &str) -> i32 {
    let count = |of: [char; 2]| text.matches(of).count() as i32;
    count(['(', '[']) - count([')', ']'])
}

fn is_operator(word: &str) -> bool {
    let mut chars = word.chars();
    matches!((chars.next(), chars.next()), (Some(c), None) if OPERATORS.contains(c))
}

/// One capital letter, as matrices are.
fn is_symbol(word: &str) -> bool {
    let mut chars = word.chars();
    matches!((chars.next(), chars.next()), (Some(c), None) if c.is_ascii_uppercase())
}

/// True for what can be part of a formula.
fn is_part(word: &str) -> bool {
    !word.is_empty() && (is_operator(word) || reads(word))
}

/// True where every run of letters is short, or a function, and nothing foreign stands between.
fn reads(word: &str) -> bool {
    let mut run = String::new();
    let mut is_index = false;
    for c in word.chars().chain([' ']) {
        if c.is_ascii_alphabetic() {
            run.push(c);
            continue;
        }
        let is_known = is_index || run.len() <= 2 || FUNCTIONS.contains(&run.as_str());
        if !is_known {
            return false;
        }
        run.clear();
        is_index = c == '_' || is_index && c.is_ascii_digit();
        let is_known = c.is_ascii_digit()
            || is_greek(c)
            || found(RAISED, c).or(found(LOWERED, c)).is_some()
            || OPERATORS.contains(c)
            || c == TILDE
            || " _^(){}[]|‖√𝒜½∫∮∞.,ℓ⟨⟩'′!∑Σ∅⊥".contains(c);
        if !is_known {
            return false;
        }
    }
    true
}

/// True for what no word of a sentence has.
fn is_strong(text: &str) -> bool {
    if !text.split(' ').all(is_part) {
        return false;
    }
    let chars: Vec<char> = text.chars().collect();
    let at = |k: usize| chars.get(k).copied().unwrap_or(' ');
    let spelled = (0..chars.len()).any(|k| match chars[k] {
        '𝒜' | 'ᵀ' | '‖' | '√' | '∫' | '∮' | TILDE => true,
        // an inverse, no power of ten
        '⁻' => {
            k > 0
                && !at(k - 1).is_ascii_digit()
                && at(k - 1).is_ascii_uppercase() | (at(k - 1) == ')')
        }
        '_' => {
            k > 0
                && (at(k - 1).is_alphabetic() || at(k - 1) == TILDE || at(k - 1) == ')')
                && at(k + 1).is_ascii_alphanumeric()
        }
        c if found(LOWERED, c).is_some() => true,
        // µm is a unit and another character
        c => is_greek(c),
    });
    let called = FUNCTIONS.iter().any(|f| text.contains(&format!("{f}(")));
    spelled || called
}

#[cfg(test)]
mod tests;
