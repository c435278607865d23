//! Lowered indices in SVG text: `S_u` is shown as S with a small u below the line.

use std::fmt::Write as _;

/// True when `text` holds a symbol with an index.
pub(super) fn has_index(text: &str) -> bool {
    text.char_indices().any(|(at, _)| opens(text, at))
}

/// True when an index begins behind byte `at`: `_` between a symbol of one letter and a letter or digit. Longer words
/// with underscores are names of methods.
fn opens(text: &str, at: usize) -> bool {
    text[at..].strip_prefix('_').is_some_and(|rest| {
        let mut before = text[..at].chars().rev();
        before.next().is_some_and(char::is_alphabetic)
            && !before
                .next()
                .is_some_and(|c| c.is_alphanumeric() || c == '_')
            && rest.starts_with(|c: char| c.is_ascii_alphanumeric())
    })
}

/// How far an index lies below the line, over the size of the letters beside it.
pub(super) const INDEX_DROP: f64 = 0.22;
/// Size of an index over that of the letters beside it.
pub(super) const INDEX_SIZE: f64 = 0.75;

/// The parts of a text on the line and, without their underscores and marked, its indices.
pub(super) fn runs(text: &str) -> Vec<(&str, bool)> {
    let (mut runs, mut rest) = (Vec::new(), text);
    while let Some(at) = (rest.char_indices().map(|(at, _)| at)).find(|at| opens(rest, *at)) {
        let index = &rest[at + 1..];
        let end = (index.find(|c: char| !c.is_ascii_alphanumeric())).unwrap_or(index.len());
        runs.extend([(&rest[..at], false), (&index[..end], true)]);
        rest = &index[end..];
    }
    if !rest.is_empty() {
        runs.push((rest, false));
    }
    runs
}

/// The text with every index, less its underscore, as `set` writes it: `S_u` becomes `S<sub>u</sub>` in HTML.
pub fn with_indices(text: &str, set: impl Fn(&str) -> String) -> String {
    let parts = runs(text).into_iter();
    let parts = parts.map(|(part, is_index)| match is_index {
        true => set(part),
        false => part.to_owned(),
    });
    parts.collect()
}

/// Lowers the indices in every text of a page.
pub(super) fn lower(svg: &str) -> String {
    let mut result = String::with_capacity(svg.len());
    let mut size = 0.0;
    let mut tags = svg.split('<');
    result.push_str(tags.next().unwrap_or_default());
    for part in tags {
        let (tag, text) = part.split_once('>').unwrap_or((part, ""));
        size = font_size(tag).unwrap_or(size);
        let _ = write!(result, "<{tag}>");
        set(&mut result, text, size);
    }
    result
}

fn font_size(tag: &str) -> Option<f64> {
    let (_, rest) = tag.split_once("font-size=\"")?;
    rest.split('"').next()?.parse().ok()
}

/// Copies `text`; an index becomes a smaller span below the line, what follows it a span back on the line.
fn set(result: &mut String, text: &str, size: f64) {
    let (drop, small) = (INDEX_DROP * size, INDEX_SIZE * size);
    let mut back = false;
    for (part, is_index) in runs(text) {
        if is_index {
            let _ = write!(
                result,
                "<tspan dy=\"{drop:.1}\" font-size=\"{small:.1}\">{part}</tspan>"
            );
            back = true;
        } else {
            line(result, part, back.then_some(drop));
        }
    }
}

/// Text on the line, lifted by `drop` behind an index.
fn line(result: &mut String, text: &str, drop: Option<f64>) {
    match drop {
        Some(drop) if !text.trim().is_empty() => {
            // some viewers leave out a space with which a span begins
            let (space, text) = match text.strip_prefix(' ') {
                Some(rest) => (" ", rest),
                None => ("", text),
            };
            let _ = write!(result, "{space}<tspan dy=\"-{drop:.1}\">{text}</tspan>");
        }
        _ => result.push_str(text),
    }
}

#[cfg(test)]
mod tests {
    use super::{has_index, lower};

    #[test]
    fn indices_are_spans_that_return_to_the_line() {
        let set = lower("<text font-size=\"10\">n_it and C_s [1]</text>\n");
        let expected = "<text font-size=\"10\">n<tspan dy=\"2.2\" font-size=\"7.5\">it</tspan> <tspan dy=\"-2.2\">and C</tspan>\
                        <tspan dy=\"2.2\" font-size=\"7.5\">s</tspan> <tspan dy=\"-2.2\">[1]</tspan></text>\n";
        assert_eq!(set, expected);
        let plain = "<text font-size=\"10\">file_ name _x</text>";
        assert_eq!(lower(plain), plain);
        assert!(has_index("λ of S_u") && !has_index("a _b c_ local_h"));
    }
}
