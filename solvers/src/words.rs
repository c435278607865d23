//! Words that agree with a number.

/// `one` for 1, else `other`: nouns and verbs beside a count.
pub fn by_number<'w>(n: usize, one: &'w str, other: &'w str) -> &'w str {
    match n {
        1 => one,
        _ => other,
    }
}
