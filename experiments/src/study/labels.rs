//! Values of axes as they are shown.

use super::findings::Findings;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Cut off of a path in legends.
const EXTENSION: &str = "toml";

/// A value in a legend; what is no word of its own says whose value it is.
pub(super) fn named(axis: &str, field: &str, findings: &Findings) -> String {
    let of_its_own = ["refine", "rhs", "tolerance", "stabilization", "threads"];
    match field {
        "" => String::new(),
        "default" if axis == "augmentation" => "default C".into(),
        "default" => format!("default {axis}"),
        _ if axis == "augmentation" => format!("C = {field}"),
        _ if of_its_own.contains(&axis) || axis.contains('.') => {
            let short = axis.rsplit('.').next().unwrap_or(axis);
            format!("{short} = {field}")
        }
        _ => findings.label(field),
    }
}

/// The name of a file in the place of its path, that of a scene without its size.
pub(super) fn label(field: &str) -> String {
    last(field, 1)
}

/// The last `parts` of a path, or the field where it is none.
fn last(field: &str, parts: usize) -> String {
    let field = field.strip_suffix(crate::scenes::SMALL).unwrap_or(field);
    let path = Path::new(field);
    if !path.is_absolute() {
        return field.to_owned();
    }
    let is_scene = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case(EXTENSION));
    let path = if is_scene {
        path.with_extension("")
    } else {
        path.to_path_buf()
    };
    let names: Vec<_> = path
        .iter()
        .skip(1)
        .map(|part| part.to_string_lossy())
        .collect();
    match names.len() {
        0 => field.to_owned(),
        n => names[n - parts.min(n)..].join("/"),
    }
}

/// Labels of those whose file name others have, too: as many folders before it as tell them apart.
pub(super) fn told_apart<'a>(fields: impl Iterator<Item = &'a str>) -> BTreeMap<String, String> {
    let paths: BTreeSet<&str> = fields.filter(|f| Path::new(f).is_absolute()).collect();
    let mut labels = BTreeMap::new();
    let mut left: Vec<&str> = paths.into_iter().collect();
    for parts in 1.. {
        let is_shared = |field: &&str| {
            let own = last(field, parts);
            left.iter()
                .filter(|other| last(other, parts) == own)
                .count()
                > 1
        };
        let (shared, alone): (Vec<&str>, Vec<&str>) =
            left.iter().partition(|field| is_shared(field));
        if parts > 1 {
            labels.extend(alone.iter().map(|f| ((*f).to_owned(), last(f, parts))));
        }
        // two sizes of one scene have one path
        let longest = |field: &&str| parts >= Path::new(field).iter().count();
        if shared.iter().all(longest) {
            return labels;
        }
        left = shared;
    }
    labels
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_one_name_are_told_apart_by_their_folders() {
        let fields = [
            "/a/x/s.toml",
            "/a/y/s.toml",
            "/b/y/s.toml",
            "/a/t.toml",
            "line_crack",
        ];
        let labels = told_apart(fields.into_iter());
        let of = |field: &str| labels.get(field).cloned().unwrap_or(label(field));
        assert_eq!(fields.map(of), ["x/s", "a/y/s", "b/y/s", "t", "line_crack"]);
    }

    #[test]
    fn one_file_alone_has_its_name() {
        assert_eq!(
            told_apart(["/a/s.toml", "/b/t"].into_iter()),
            BTreeMap::new()
        );
        assert_eq!([label("/a/s.toml"), label("/b/t.d")], ["s", "t.d"]);
    }
}
