//! Only what is not there counts as absent.

use super::super::tests::{folder, sparse, system};
use super::super::write_folder;
use super::*;
use std::os::unix::fs::symlink;
use std::os::unix::net::UnixListener;

/// Files without which a folder is a system all the same, or another one.
const OPTIONAL: [&str; 7] = [
    "H.mtx",
    "B2.mtx",
    "rhs_u.mtx",
    "rhs_t.mtx",
    "coords.mtx",
    "manifest.json",
    "Q1.mtx",
];

/// What can stand under the name of a file and is none.
#[derive(Clone, Copy, Debug)]
enum Defect {
    BrokenLink,
    LinkToItself,
    LinkThroughAFile,
    Folder,
    LinkToAFolder,
    Socket,
    Pipe,
}

const DEFECTS: [Defect; 7] = [
    Defect::BrokenLink,
    Defect::LinkToItself,
    Defect::LinkThroughAFile,
    Defect::Folder,
    Defect::LinkToAFolder,
    Defect::Socket,
    Defect::Pipe,
];

/// Puts a defect in the place of a file, or where none is.
fn spoil(folder: &Path, file: &str, defect: Defect) {
    let path = folder.join(file);
    if path.exists() {
        std::fs::remove_file(&path).unwrap();
    }
    match defect {
        Defect::BrokenLink => symlink("nowhere.mtx", &path).unwrap(),
        Defect::LinkToItself => symlink(file, &path).unwrap(),
        Defect::LinkThroughAFile => symlink("A.mtx/H.mtx", &path).unwrap(),
        Defect::Folder => std::fs::create_dir(&path).unwrap(),
        Defect::LinkToAFolder => symlink(".", &path).unwrap(),
        Defect::Socket => drop(UnixListener::bind(&path).unwrap()),
        // nobody writes into it: who opens it waits
        Defect::Pipe => {
            let made = std::process::Command::new("mkfifo").arg(&path).status();
            assert!(made.unwrap().success());
        }
    }
}

fn with_b2() -> SaddleBlocks {
    SaddleBlocks {
        b2: Some(sparse(3, 6, |i, j| 1.0 / (2 + i + j) as f64)),
        ..system()
    }
}

#[test]
fn whatever_cannot_be_opened_is_named_and_never_absent() {
    let mut read = 0;
    for subset in 1..1_usize << OPTIONAL.len() {
        for turn in 0..DEFECTS.len() {
            let folder = folder("defects");
            write_folder(&folder, &with_b2(), &Manifest::default()).unwrap();
            let spoiled: Vec<_> = (0..OPTIONAL.len())
                .filter(|k| subset >> k & 1 == 1)
                .map(|k| (OPTIONAL[k], DEFECTS[(k + turn) % DEFECTS.len()]))
                .collect();
            for (file, defect) in &spoiled {
                spoil(&folder, file, *defect);
            }
            let error = read_folder(&folder).unwrap_err();
            let message = error.to_string();
            let named = (spoiled.iter())
                .find(|(file, _)| message.contains(&folder.join(file).display().to_string()));
            let (file, defect) = named.unwrap_or_else(|| panic!("{spoiled:?}: {message}"));
            let fits = match defect {
                Defect::BrokenLink | Defect::LinkToItself | Defect::LinkThroughAFile => {
                    matches!(error, FolderError::BrokenLink { .. })
                }
                _ => matches!(error, FolderError::NotAFile { .. }),
            };
            assert!(fits, "{file}, {defect:?}: {message}");
            assert!(message.contains("or remove it"), "{message}");
            read += 1;
        }
    }
    assert_eq!(read, 127 * 7);
}

#[test]
fn a_needed_file_that_cannot_be_opened_is_not_missing() {
    for file in ["A.mtx", "B1.mtx"] {
        for defect in DEFECTS {
            let folder = folder("needed");
            write_folder(&folder, &with_b2(), &Manifest::default()).unwrap();
            spoil(&folder, file, defect);
            let error = read_folder(&folder).unwrap_err();
            assert!(!matches!(error, FolderError::Missing { .. }), "{error}");
            assert!(error.to_string().contains(file), "{error}");
        }
    }
}

#[test]
fn links_to_files_are_files_and_what_is_gone_is_absent() {
    let (original, linked) = (folder("original"), folder("linked"));
    write_folder(&original, &with_b2(), &Manifest::default()).unwrap();
    for file in FILES {
        if original.join(file).exists() {
            symlink(original.join(file), linked.join(file)).unwrap();
        }
    }
    let (a, b) = (
        read_folder(&original).unwrap(),
        read_folder(&linked).unwrap(),
    );
    assert_eq!((&a.blocks.h, &a.blocks.b2), (&b.blocks.h, &b.blocks.b2));
    assert!(b.blocks.h.is_some() && b.blocks.b2.is_some() && b.has_rhs);
    for file in ["manifest.json", "H.mtx", "B2.mtx", "rhs_u.mtx"] {
        std::fs::remove_file(linked.join(file)).unwrap();
    }
    let rest = read_folder(&linked).unwrap();
    assert!(rest.blocks.h.is_none() && rest.blocks.b2.is_none());
    assert_eq!(rest.blocks.rhs_u, [0.0; 6]);
}

#[test]
fn a_written_folder_keeps_no_dead_link_of_an_earlier_one() {
    let folder = folder("stale");
    spoil(&folder, "H.mtx", Defect::BrokenLink);
    let blocks = SaddleBlocks {
        h: None,
        ..system()
    };
    write_folder(&folder, &blocks, &Manifest::default()).unwrap();
    assert!(read_folder(&folder).unwrap().blocks.h.is_none());
    std::fs::create_dir(folder.join("B2.mtx")).unwrap();
    let error = write_folder(&folder, &blocks, &Manifest::default()).unwrap_err();
    assert!(error.to_string().contains("B2.mtx"), "{error}");
}
