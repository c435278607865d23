//! Tags of a file of VTK.

/// A tag; text and references are those of VTK's files, which have no more of XML.
#[derive(Clone, Debug)]
pub(super) struct Tag {
    /// Its name, with `/` before it where it closes.
    pub(super) name: String,
    attributes: Vec<(String, String)>,
    /// `<name/>`.
    pub(super) is_empty: bool,
    /// Place of the byte behind it.
    pub(super) end: usize,
}

impl Tag {
    /// Value of an attribute.
    pub(super) fn get(&self, name: &str) -> Option<&str> {
        let found = self.attributes.iter().find(|(key, _)| key == name);
        found.map(|(_, value)| value.as_str())
    }

    /// A whole number that an attribute gives.
    pub(super) fn number(&self, name: &str) -> Result<Option<usize>, String> {
        let Some(text) = self.get(name) else {
            return Ok(None);
        };
        let number = text.trim().parse().map(Some);
        number.map_err(|_| format!("<{}> has {name}=\"{text}\", which is no count", self.name))
    }
}

/// The tags of a file from a place on.
pub(super) struct Tags<'b> {
    pub(super) bytes: &'b [u8],
    pub(super) at: usize,
}

impl Tags<'_> {
    /// The next tag; `None` at the end of the file.
    pub(super) fn next(&mut self) -> Result<Option<Tag>, String> {
        loop {
            let rest = &self.bytes[self.at..];
            let Some(start) = rest.iter().position(|byte| *byte == b'<') else {
                return Ok(None);
            };
            let rest = &rest[start..];
            self.at += start;
            let (is_other, end) = match rest {
                [b'<', b'?', ..] => (true, ending(rest, b"?>")),
                [b'<', b'!', b'-', b'-', ..] => (true, ending(rest, b"-->")),
                [b'<', b'!', ..] => return Err("it has a <!…> that is no comment".into()),
                _ => (false, closing(rest)),
            };
            let end = end.ok_or("it ends within a tag")?;
            self.at += end;
            if !is_other {
                return tag(&rest[1..end - 1], self.at).map(Some);
            }
        }
    }
}

/// Length up to the end of a mark.
fn ending(text: &[u8], mark: &[u8]) -> Option<usize> {
    let found = text.windows(mark.len()).position(|w| w == mark);
    found.map(|at| at + mark.len())
}

/// Length up to the `>` that no quotes hold.
fn closing(text: &[u8]) -> Option<usize> {
    let mut quote = None;
    for (n, byte) in text.iter().enumerate() {
        match (quote, byte) {
            (None, b'>') => return Some(n + 1),
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(open), byte) if open == byte => quote = None,
            _ => {}
        }
    }
    None
}

/// The tag between `<` and `>`.
fn tag(inside: &[u8], end: usize) -> Result<Tag, String> {
    let text = std::str::from_utf8(inside).map_err(|_| "it has a tag that is no text")?;
    let (text, is_empty) = match text.strip_suffix('/') {
        Some(text) => (text, true),
        None => (text, false),
    };
    let name_end = text.find(char::is_whitespace).unwrap_or(text.len());
    let (name, mut rest) = text.split_at(name_end);
    let bad = || format!("<{name}> has an attribute without a value in quotes");
    let mut attributes = Vec::new();
    loop {
        rest = rest.trim_start();
        if rest.is_empty() {
            break;
        }
        let (key, after) = rest.split_once('=').ok_or_else(bad)?;
        let after = after.trim_start();
        let quote = after.chars().next().filter(|c| matches!(c, '"' | '\''));
        let after = &after[quote.ok_or_else(bad)?.len_utf8()..];
        let (value, after) = (quote.and_then(|quote| after.split_once(quote))).ok_or_else(bad)?;
        attributes.push((key.trim().to_owned(), plain(value)));
        rest = after;
    }
    Ok(Tag {
        name: name.into(),
        attributes,
        is_empty,
        end,
    })
}

/// Text without references.
fn plain(text: &str) -> String {
    text.replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&quot;", "\"")
        .replace("&apos;", "'")
        .replace("&amp;", "&")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_with_their_attributes() {
        let text =
            b"<?xml version=\"1.0\"?>\n<!-- <no> --><a b = 'x > y' c=\"&lt;&amp;\">text<d/></a> ";
        let mut tags = Tags { bytes: text, at: 0 };
        let a = tags.next().unwrap().unwrap();
        assert_eq!((a.name.as_str(), a.is_empty), ("a", false));
        assert_eq!(
            [a.get("b"), a.get("c"), a.get("d")],
            [Some("x > y"), Some("<&"), None]
        );
        assert!(text[a.end..].starts_with(b"text"));
        let d = tags.next().unwrap().unwrap();
        assert_eq!((d.name.as_str(), d.is_empty), ("d", true));
        assert_eq!(tags.next().unwrap().unwrap().name, "/a");
        assert!(tags.next().unwrap().is_none());
        for wrong in [
            "<a b>",
            "<a b=c>",
            "<a b=\"c>",
            "<a",
            "<!DOCTYPE a>",
            "<a b='1>",
        ] {
            let mut tags = Tags {
                bytes: wrong.as_bytes(),
                at: 0,
            };
            assert!(tags.next().is_err(), "{wrong}");
        }
    }
}
