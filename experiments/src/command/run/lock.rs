//! One process per run folder.

use anyhow::Context;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};

/// Name of the lock in a run folder; it holds the number of its process and goes with it.
pub(super) const NAME: &str = "run.lock";

/// Another process at work.
#[derive(Debug, thiserror::Error)]
#[error("process {pid} is running in {}: wait for it, or choose another --out", out.display())]
struct Busy {
    pid: String,
    out: PathBuf,
}

/// A run folder that is ours: the operating system gives the lock back when the process ends, however it does.
#[derive(Debug)]
pub(super) struct Lock {
    path: PathBuf,
    _file: File,
}

impl Lock {
    /// Takes a folder, and tells the process that left its lock there, if one did.
    ///
    /// # Errors
    /// Where another process holds it.
    pub(super) fn take(out: &Path) -> anyhow::Result<(Self, Option<String>)> {
        let path = out.join(NAME);
        loop {
            let failed = || format!("cannot lock {}", path.display());
            let mut file = OpenOptions::new()
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .open(&path)
                .with_context(failed)?;
            let mut pid = String::new();
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    file.read_to_string(&mut pid).with_context(failed)?;
                    let out = out.to_path_buf();
                    return Err(Busy { pid, out }.into());
                }
                Err(TryLockError::Error(error)) => return Err(error).with_context(failed),
            }
            // its last owner removes it: what was locked may be gone from the folder by now
            if !same(&file, &path) {
                continue;
            }
            file.read_to_string(&mut pid).with_context(failed)?;
            file.set_len(0)
                .and_then(|()| file.rewind())
                .and_then(|()| write!(file, "{}", std::process::id()))
                .with_context(failed)?;
            let stale = Some(pid).filter(|pid| !pid.is_empty());
            return Ok((Self { path, _file: file }, stale));
        }
    }
}

/// True where the path still leads to the open file.
#[cfg(unix)]
fn same(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), std::fs::metadata(path)) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => false,
    }
}

/// An open file cannot be removed.
#[cfg(not(unix))]
fn same(_: &File, _: &Path) -> bool {
    true
}

impl Drop for Lock {
    fn drop(&mut self) {
        // one that stays is taken over by the next run
        let _ = std::fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_has_one_owner_and_a_stale_lock_is_told() {
        let out = std::env::temp_dir().join(format!("fracas-lock-{}", std::process::id()));
        std::fs::create_dir_all(&out).unwrap();
        let path = out.join(NAME);
        let (lock, stale) = Lock::take(&out).unwrap();
        assert_eq!(stale, None);
        let refused = Lock::take(&out).unwrap_err().to_string();
        let own = format!("process {} is running", std::process::id());
        assert!(refused.contains(&own), "{refused}");
        drop(lock);
        assert!(!path.exists());
        std::fs::write(&path, "4194305").unwrap();
        let (_lock, stale) = Lock::take(&out).unwrap();
        assert_eq!(stale.as_deref(), Some("4194305"));
        std::fs::remove_dir_all(&out).unwrap();
    }
}
