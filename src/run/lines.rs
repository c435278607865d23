//! Text files that grow by whole lines, each of which belongs to a step.

use super::RunError;
use super::error::At;
use crate::io::write_atomically;
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// A file that is appended to.
#[derive(Debug)]
pub(super) struct Lines {
    path: PathBuf,
    file: File,
}

/// A file that does not look like the one we would have written.
#[derive(Debug, thiserror::Error)]
#[error("{}, line {line}: this is not what a run writes here; nothing was changed", path.display())]
pub struct Unreadable {
    /// The file.
    pub path: PathBuf,
    /// Its line, from 1.
    pub line: usize,
}

impl Lines {
    /// A new file with its heading (which ends its line, or is empty).
    pub(super) fn create(path: PathBuf, heading: &str) -> Result<Self, RunError> {
        replace(&path, heading)?;
        Self::open(path)
    }

    /// Goes on with what stays of a file.
    pub(super) fn cut(path: PathBuf, cut: &Cut) -> Result<Self, RunError> {
        if cut.shortened {
            let lines = cut.kept.iter().map(|line| format!("{line}\n"));
            replace(&path, &(cut.heading.clone() + &lines.collect::<String>()))?;
        }
        Self::open(path)
    }

    /// Appends whole lines and brings them to the disk.
    pub(super) fn append(&mut self, lines: &str) -> Result<(), RunError> {
        if lines.is_empty() {
            return Ok(());
        }
        self.file
            .write_all(lines.as_bytes())
            .and_then(|()| self.file.sync_data())
            .at("cannot write", &self.path)
    }

    fn open(path: PathBuf) -> Result<Self, RunError> {
        let file = OpenOptions::new()
            .append(true)
            .open(&path)
            .at("cannot write", &path)?;
        Ok(Self { path, file })
    }
}

/// What stays of a file when a run goes on with a step: the complete lines of the steps before.
#[derive(Debug, PartialEq)]
pub(super) struct Cut {
    heading: String,
    /// Lines that stay, without the heading.
    pub(super) kept: Vec<String>,
    /// Steps of all complete lines, those that go included.
    pub(super) steps: Vec<usize>,
    shortened: bool,
}

impl Cut {
    /// Reads a file that must begin with `heading`; `step_of` finds the step of a line. Changes nothing.
    pub(super) fn read(
        path: &Path,
        heading: &str,
        step: usize,
        step_of: fn(&str) -> Option<usize>,
    ) -> Result<Self, RunError> {
        let text = fs::read_to_string(path).at("cannot read", path)?;
        let unreadable = |line: usize| Unreadable {
            path: path.into(),
            line,
        };
        let body = text.strip_prefix(heading).ok_or_else(|| unreadable(1))?;
        // the line that a killed process did not finish
        let complete = body.rfind('\n').map_or("", |end| &body[..=end]);
        let mut cut = Self {
            heading: heading.into(),
            kept: Vec::new(),
            steps: Vec::new(),
            shortened: complete.len() < body.len(),
        };
        for (number, line) in complete.lines().enumerate() {
            let headings = heading.matches('\n').count();
            let of = step_of(line).ok_or_else(|| unreadable(headings + number + 1))?;
            cut.steps.push(of);
            if of < step {
                cut.kept.push(line.into());
            } else {
                cut.shortened = true;
            }
        }
        Ok(cut)
    }
}

/// Step in the first column of a CSV line.
pub(super) fn first_column(line: &str) -> Option<usize> {
    line.split(',').next()?.parse().ok()
}

/// `step` of a JSON object.
pub(super) fn json_step(line: &str) -> Option<usize> {
    let value: serde_json::Value = serde_json::from_str(line).ok()?;
    value.get("step")?.as_u64()?.try_into().ok()
}

fn replace(path: &Path, text: &str) -> Result<(), RunError> {
    write_atomically(path, |out| out.write_all(text.as_bytes())).at("cannot write", path)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(name: &str, text: &str) -> PathBuf {
        let name = format!("fracas-lines-{}-{name}", std::process::id());
        let path = std::env::temp_dir().join(name);
        fs::write(&path, text).unwrap();
        path
    }

    #[test]
    fn later_steps_and_an_unfinished_line_go() {
        let path = file("cut", "step,x\n1,a\n2,b\n2,c\n3,d\n4,e");
        let cut = Cut::read(&path, "step,x\n", 3, first_column).unwrap();
        assert_eq!(cut.kept, ["1,a", "2,b", "2,c"]);
        assert_eq!(cut.steps, [1, 2, 2, 3]);
        Lines::cut(path.clone(), &cut)
            .unwrap()
            .append("3,z\n")
            .unwrap();
        let text = fs::read_to_string(&path).unwrap();
        fs::remove_file(&path).unwrap();
        assert_eq!(text, "step,x\n1,a\n2,b\n2,c\n3,z\n");
    }

    #[test]
    fn a_file_of_something_else_is_left_alone() {
        let text = "step,x\n1,a\nstep two,b\n";
        let path = file("other", text);
        let said = |heading| {
            let error = Cut::read(&path, heading, 5, first_column).unwrap_err();
            error.to_string()
        };
        assert!(said("step,x\n").contains("line 3"));
        assert!(said("time,x\n").contains("line 1"));
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
        fs::remove_file(&path).unwrap();
    }

    #[test]
    fn steps_of_json_lines() {
        assert_eq!(json_step(r#"{"step":12,"event":"cut"}"#), Some(12));
        assert_eq!(json_step(r#"{"event":"cut"}"#), None);
        assert_eq!(json_step(r#"{"step":12"#), None);
    }
}
