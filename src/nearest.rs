//! The known name that somebody probably meant.

/// The known name with the fewest slips to `found`, then the most like it, if any is at all like it (Jaro–Winkler at
/// least 0.6).
pub(crate) fn nearest(found: &str, known: &[String]) -> Option<String> {
    let slips = |k: &String| strsim::damerau_levenshtein(found, k);
    let likeness = |k: &String| strsim::jaro_winkler(found, k);
    known
        .iter()
        .filter(|k| likeness(k) >= 0.6)
        .min_by(|a, b| {
            let by_slips = slips(a).cmp(&slips(b));
            by_slips.then_with(|| likeness(b).total_cmp(&likeness(a)))
        })
        .cloned()
}
