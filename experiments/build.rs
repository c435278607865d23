//! Tells the program which commit it was built from, for the heads of its pages; nothing where there is no repository.

use std::path::Path;
use std::process::Command;

/// What `git` answers here, without the line end.
fn git(arguments: &[&str]) -> Option<String> {
    let answer = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(answer.stdout).ok()?;
    (answer.status.success() && !text.trim().is_empty()).then(|| text.trim().to_owned())
}

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // A package below another repository's tree would name that one's commit.
    let is_ours = git(&["ls-files", "build.rs"]).is_some();
    let commit = is_ours.then(|| git(&["rev-parse", "--short=10", "HEAD"]));
    println!(
        "cargo::rustc-env=FRACAS_COMMIT={}",
        commit.flatten().unwrap_or_default()
    );
    // Every commit adds a line to this log; a path that is missing would build the crate again each time.
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"]).filter(|log| Path::new(log).exists());
    if let Some(log) = log {
        println!("cargo::rerun-if-changed={log}");
    }
}
