//! Claim: a reader that leaves early is no error, and nothing panics.

use crate::run::system_folder;
use std::process::{Command, Stdio};

#[test]
fn a_closed_pipe_ends_quietly() {
    let folder = system_folder("pipe");
    for arguments in [
        &["list"][..],
        &["solve", "--system", folder.to_str().unwrap(), "--json", "-"][..],
    ] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_fracas"))
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {stderr}");
        assert!(
            !stderr.contains("panicked") && !stderr.contains("error"),
            "{stderr}"
        );
    }
}
