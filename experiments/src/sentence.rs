//! From a chain of errors to one sentence.

/// The error and its causes, without those that the error itself already quotes.
pub(crate) fn of(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1) {
        let cause = cause.to_string();
        if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::of;
    use anyhow::Context;

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
