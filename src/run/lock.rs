//! One process per run folder.

use super::RunError;
use super::error::At;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};

/// Name of the lock in a run folder; it holds the number of its process and goes with it.
pub(super) const NAME: &str = "run.lock";

/// Another process at work.
#[derive(Debug, thiserror::Error)]
#[error("process {pid} is running in {}: wait for it, or choose another folder", out.display())]
pub struct Busy {
    /// Its number.
    pub pid: String,
    /// The folder.
    pub out: PathBuf,
}

/// What taking a folder brought to light.
#[derive(Debug, thiserror::Error)]
pub(super) enum Found {
    /// The lock of a process that did not end by itself.
    #[error("{}: taking over from process {pid}, which is gone", out.display())]
    Stale {
        /// Its number.
        pid: String,
        /// The folder.
        out: PathBuf,
    },
    /// A filesystem without locks.
    #[error("warning: {} cannot be locked ({error}): nothing keeps a second run out of this folder", path.display())]
    NoLocks {
        /// The file.
        path: PathBuf,
        /// What the system says.
        error: std::io::Error,
    },
}

/// A run folder that is ours: the operating system gives the lock back when the process ends, however it does.
#[derive(Debug)]
pub(super) struct Lock {
    path: PathBuf,
    _file: File,
}

impl Lock {
    /// Takes a folder, and tells what there is to be said of that.
    ///
    /// # Errors
    /// Where another process holds it.
    pub(super) fn take(out: &Path) -> Result<(Self, Option<Found>), RunError> {
        Self::take_by(out, File::try_lock)
    }

    fn take_by(
        out: &Path,
        try_lock: impl Fn(&File) -> Result<(), TryLockError>,
    ) -> Result<(Self, Option<Found>), RunError> {
        let path = out.join(NAME);
        loop {
            const LOCK: &str = "cannot lock";
            let mut file = OpenOptions::new()
                .read(true)
                .write(true)
                .create(true)
                .truncate(false)
                .open(&path)
                .at(LOCK, &path)?;
            let mut pid = String::new();
            let locked = match try_lock(&file) {
                Ok(()) => Ok(()),
                Err(TryLockError::WouldBlock) => {
                    file.read_to_string(&mut pid).at(LOCK, &path)?;
                    let out = out.to_path_buf();
                    return Err(Busy { pid, out }.into());
                }
                Err(TryLockError::Error(error)) => Err(error),
            };
            // its last owner removes it: what was locked may be gone from the folder by now
            if !same(&file, &path) {
                continue;
            }
            file.read_to_string(&mut pid).at(LOCK, &path)?;
            file.set_len(0)
                .and_then(|()| file.rewind())
                .and_then(|()| write!(file, "{}", std::process::id()))
                .at(LOCK, &path)?;
            let found = match locked {
                Err(error) => Some(Found::NoLocks {
                    path: path.clone(),
                    error,
                }),
                Ok(()) if pid.is_empty() => None,
                Ok(()) => Some(Found::Stale {
                    pid,
                    out: out.to_path_buf(),
                }),
            };
            return Ok((Self { path, _file: file }, found));
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
        let (lock, found) = Lock::take(&out).unwrap();
        assert!(found.is_none(), "{found:?}");
        let refused = Lock::take(&out).unwrap_err().to_string();
        let own = format!("process {} is running", std::process::id());
        assert!(refused.contains(&own), "{refused}");
        drop(lock);
        assert!(!path.exists());
        std::fs::write(&path, "4194305").unwrap();
        let (_lock, found) = Lock::take(&out).unwrap();
        let said = found.unwrap().to_string();
        assert!(said.contains("taking over from process 4194305"), "{said}");
        std::fs::remove_dir_all(&out).unwrap();
    }

    #[test]
    fn a_filesystem_without_locks_is_told_and_stops_nothing() {
        let out = std::env::temp_dir().join(format!("fracas-no-lock-{}", std::process::id()));
        std::fs::create_dir_all(&out).unwrap();
        let none = |_: &File| {
            let error = std::io::Error::from(std::io::ErrorKind::Unsupported);
            Err(TryLockError::Error(error))
        };
        let (lock, found) = Lock::take_by(&out, none).unwrap();
        let said = found.unwrap().to_string();
        assert!(
            said.starts_with("warning: ")
                && said.contains("run.lock cannot be locked (unsupported)"),
            "{said}"
        );
        let pid = std::fs::read_to_string(out.join(NAME)).unwrap();
        assert_eq!(pid, std::process::id().to_string());
        drop(lock);
        std::fs::remove_dir(&out).unwrap();
    }
}
