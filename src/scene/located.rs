//! A problem with its place among the keys of a scene.

use super::Problem;

/// A problem and the path of keys to where it is written.
pub(super) struct Located {
    pub(super) path: Vec<String>,
    pub(super) problem: Box<Problem>,
}

/// `problem` at a path.
pub(super) fn at(path: &[&str], problem: impl Into<Problem>) -> Located {
    Located {
        path: path.iter().map(|s| (*s).to_string()).collect(),
        problem: Box::new(problem.into()),
    }
}
