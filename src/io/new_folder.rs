//! A folder that is made for results, and goes again without them.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// A folder that goes again where nothing was written into it, with those above it that were made for it.
#[derive(Debug)]
pub struct NewFolder {
    /// Made by us, deepest first.
    made: Vec<PathBuf>,
}

impl NewFolder {
    /// Creates a folder and those above it.
    ///
    /// # Errors
    /// What the file system says; what was made until then goes again.
    pub fn create(path: &Path) -> io::Result<Self> {
        let new = path.ancestors().take_while(|folder| !folder.exists());
        let made = new.map(Path::to_path_buf).collect();
        let created = Self { made };
        fs::create_dir_all(path)?;
        Ok(created)
    }
}

impl Drop for NewFolder {
    fn drop(&mut self) {
        // the first that holds something refuses to go, and so do those above it
        for folder in &self.made {
            if fs::remove_dir(folder).is_err() {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_stays_empty_goes_with_those_made_for_it() {
        let base = std::env::temp_dir().join(format!("fracas-folder-{}", std::process::id()));
        fs::create_dir_all(&base).unwrap();
        let deep = base.join("a/b");
        drop(NewFolder::create(&deep).unwrap());
        assert!(base.is_dir() && !base.join("a").exists());
        let kept = NewFolder::create(&deep).unwrap();
        fs::write(base.join("a/file"), "").unwrap();
        drop(kept);
        assert!(base.join("a/file").is_file() && !deep.exists());
        // one that was there before is not ours
        drop(NewFolder::create(&base).unwrap());
        fs::remove_file(base.join("a/file")).unwrap();
        drop(NewFolder::create(&base.join("a")).unwrap());
        assert!(base.join("a").is_dir());
        fs::remove_dir_all(&base).unwrap();
    }
}
