//! Raised and lowered indices in SVG text, set by position: fonts without `⁻` or `ᵤ` show them all the same.

use std::fmt::Write as _;

/// Sets `S_u` as S with a lowered u and `10⁻³` as 10 with a raised −3, in every text of the page.
pub(super) fn shift(svg: &str) -> String {
    let mut result = String::with_capacity(svg.len());
    let mut size = 0.0;
    let mut tags = svg.split('<');
    result.push_str(tags.next().unwrap_or_default());
    for part in tags {
        result.push('<');
        let (tag, text) = part.split_once('>').unwrap_or((part, ""));
        if let Some(found) = font_size(tag) {
            size = found;
        }
        result.push_str(tag);
        result.push('>');
        set(&mut result, text, size);
    }
    result
}

fn font_size(tag: &str) -> Option<f64> {
    let (_, rest) = tag.split_once("font-size=\"")?;
    rest.split('"').next()?.parse().ok()
}

/// Where a run of characters stands.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Line,
    Raised,
    Lowered,
}

/// Copies `text`, its indices as shifted and smaller spans.
fn set(result: &mut String, text: &str, size: f64) {
    let mut place = Place::Line;
    let mut characters = text.chars().peekable();
    let mut before = ' ';
    while let Some(c) = characters.next() {
        let raised = plain(c);
        let next = match (raised, place) {
            (Some(_), _) => Place::Raised,
            (None, Place::Lowered) if c.is_ascii_alphanumeric() => Place::Lowered,
            _ => Place::Line,
        };
        move_to(result, &mut place, next, size);
        let opens = c == '_'
            && before.is_alphanumeric()
            && characters.peek().is_some_and(char::is_ascii_alphanumeric);
        if opens {
            move_to(result, &mut place, Place::Lowered, size);
        } else {
            result.push(raised.unwrap_or(c));
        }
        before = c;
    }
    move_to(result, &mut place, Place::Line, size);
}

/// Ends one run and begins another; vertical shifts are relative to the run before.
fn move_to(result: &mut String, place: &mut Place, next: Place, size: f64) {
    if *place == next {
        return;
    }
    let height = |p: Place| match p {
        Place::Line => 0.0,
        Place::Raised => -0.36 * size,
        Place::Lowered => 0.22 * size,
    };
    if *place != Place::Line {
        result.push_str("</tspan>");
    }
    let dy = height(next) - height(*place);
    // Back on the line a span is needed too: the shift stays in force to the end of the text.
    let small = if next == Place::Line {
        size
    } else {
        0.72 * size
    };
    if next == Place::Line {
        let _ = write!(
            result,
            "<tspan dy=\"{dy:.1}\" font-size=\"{small:.1}\">\u{200b}</tspan>"
        );
    } else {
        let _ = write!(result, "<tspan dy=\"{dy:.1}\" font-size=\"{small:.1}\">");
    }
    *place = next;
}

/// The character on the line for a raised one.
fn plain(c: char) -> Option<char> {
    const RAISED: &str = "⁰¹²³⁴⁵⁶⁷⁸⁹";
    match c {
        '⁻' => Some('−'),
        _ => RAISED
            .chars()
            .position(|r| r == c)
            .and_then(|d| char::from_digit(d as u32, 10)),
    }
}

#[cfg(test)]
mod tests {
    use super::shift;

    #[test]
    fn indices_are_spans_that_return_to_the_line() {
        let set = shift("<text font-size=\"10\">10⁻³ S_u x</text>");
        let expected = "<text font-size=\"10\">10<tspan dy=\"-3.6\" font-size=\"7.2\">−3</tspan>\
                        <tspan dy=\"3.6\" font-size=\"10.0\">\u{200b}</tspan> S\
                        <tspan dy=\"2.2\" font-size=\"7.2\">u</tspan>\
                        <tspan dy=\"-2.2\" font-size=\"10.0\">\u{200b}</tspan> x</text>";
        assert_eq!(set, expected);
        assert_eq!(
            shift("<text font-size=\"10\">file_ name _x</text>"),
            "<text font-size=\"10\">file_ name _x</text>"
        );
    }
}
