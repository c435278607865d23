//! Runs the `fracas` binary and keeps what it says.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot run its program fails"
)]

use std::path::{Path, PathBuf};
use std::process::Command;

/// What a run left.
pub(crate) struct Ran {
    /// Exit status.
    pub(crate) status: i32,
    /// Standard output.
    pub(crate) stdout: String,
    /// Standard error.
    pub(crate) stderr: String,
}

/// Runs `fracas` with these arguments.
pub(crate) fn fracas(arguments: &[&str]) -> Ran {
    fracas_in(Path::new("."), arguments)
}

/// The same in this folder.
pub(crate) fn fracas_in(folder: &Path, arguments: &[&str]) -> Ran {
    let output = Command::new(env!("CARGO_BIN_EXE_fracas"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    Ran {
        status: output.status.code().unwrap(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

/// A fresh folder for one test, beside what is built.
pub(crate) fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("cli-{name}"));
    if folder.exists() {
        std::fs::remove_dir_all(&folder).unwrap();
    }
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Writes a file.
pub(crate) fn write(path: &Path, text: &str) {
    std::fs::write(path, text).unwrap();
}

/// A folder with n_u = 4, n_t = 2: A tridiagonal, no right-hand side.
pub(crate) fn system_folder(name: &str) -> PathBuf {
    let folder = scratch(name);
    let a = "%%MatrixMarket matrix coordinate real symmetric\n4 4 7\n1 1 4\n2 2 4\n3 3 4\n4 4 4\n2 1 -1\n3 2 -1\n4 3 -1\n";
    let b = "%%MatrixMarket matrix coordinate real general\n4 2 4\n1 1 -1\n2 1 1\n3 2 -1\n4 2 1\n";
    write(&folder.join("A.mtx"), a);
    write(&folder.join("B1.mtx"), b);
    folder
}
