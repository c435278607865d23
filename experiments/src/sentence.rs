//! From a chain of errors to one sentence, and from settings to flags.

/// [`in_full`], with settings as flags.
pub(crate) fn of(error: &anyhow::Error) -> String {
    with_flags(&in_full(error))
}

/// The error and its causes, without those that the error itself already quotes.
pub fn in_full(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1) {
        let cause = cause.to_string();
        if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

/// Settings that are flags of the command line, too.
const FLAGS: [&str; 6] = [
    "augmentation",
    "engine",
    "inner",
    "krylov",
    "method",
    "restart",
];

/// A sentence of the library with its settings as flags: `inner = "amg"` becomes `--inner amg`. Quoted lines of a file stay as they are.
pub(crate) fn with_flags(text: &str) -> String {
    let lines: Vec<String> = (text.split('\n'))
        .map(|line| match is_quoted(line) {
            true => line.to_owned(),
            false => line_with_flags(line),
        })
        .collect();
    lines.join("\n")
}

/// A line of a file as error messages show it: `10 | inner = "amg"`.
fn is_quoted(line: &str) -> bool {
    let number = line.split_once(" | ").map(|(number, _)| number.trim());
    number.is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
}

fn line_with_flags(line: &str) -> String {
    let mut text = line.to_owned();
    for name in FLAGS {
        let setting = format!("{name} = \"");
        while let Some((before, rest)) = text.split_once(&setting) {
            let Some((value, after)) = rest.split_once('"') else {
                break;
            };
            text = format!("{before}--{name} {value}{after}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{of, with_flags};
    use anyhow::Context;

    #[test]
    fn settings_of_the_library_are_flags_here() {
        let said =
            "inner = \"geometric\" belongs to method = \"racp\"; take name = \"x\" or inner = \"y";
        let shown = "--inner geometric belongs to --method racp; take name = \"x\" or inner = \"y";
        assert_eq!(with_flags(said), shown);
    }

    #[test]
    fn quoted_lines_of_a_file_stay_as_they_are() {
        let said =
            "inner = \"a\" is none\n   |\n10 | values = { inner = \"a\" }\n   |            ^^^^^";
        let shown =
            "--inner a is none\n   |\n10 | values = { inner = \"a\" }\n   |            ^^^^^";
        assert_eq!(with_flags(said), shown);
    }

    #[test]
    fn causes_are_quoted_once() {
        let inner = std::io::Error::new(std::io::ErrorKind::NotFound, "no such file");
        let quoted = Err::<(), _>(inner)
            .context("A.mtx: no such file")
            .unwrap_err();
        assert_eq!(of(&quoted), "A.mtx: no such file");
        let inner = std::io::Error::new(std::io::ErrorKind::NotFound, "no such file");
        let added = Err::<(), _>(inner)
            .context("cannot read A.mtx")
            .unwrap_err();
        assert_eq!(of(&added), "cannot read A.mtx: no such file");
    }
}
