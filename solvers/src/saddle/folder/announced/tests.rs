//! Which manifests fit which files.

use super::super::tests::{folder, sparse, system};
use super::super::{read_folder, write_folder};
use super::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A folder with these blocks and this manifest, whatever it says.
fn with_manifest(blocks: &SaddleBlocks, manifest: &str) -> Result<(), String> {
    // tests that run side by side do not share a folder
    static FOLDERS: AtomicUsize = AtomicUsize::new(0);
    let number = FOLDERS.fetch_add(1, Ordering::Relaxed);
    let folder = folder(&format!("announced-{number}"));
    write_folder(&folder, blocks, &Manifest::default()).unwrap();
    std::fs::write(folder.join("manifest.json"), manifest).unwrap();
    read_folder(&folder)
        .map(|_| ())
        .map_err(|error| error.to_string())
}

fn bare() -> SaddleBlocks {
    SaddleBlocks {
        h: None,
        ..system()
    }
}

#[test]
fn a_stabilization_that_is_said_and_lost_or_denied_and_there_is_an_error() {
    let zero = SaddleBlocks {
        h: Some(sparse(3, 3, |_, _| 0.0)),
        ..system()
    };
    for (blocks, manifest, contradiction) in [
        (
            bare(),
            r#"{"stabilization": 1.0}"#,
            "stabilization = 1.0, but the folder holds no H.mtx",
        ),
        (
            bare(),
            r#"{"stabilization": true}"#,
            "stabilization = true, but the folder holds no H.mtx",
        ),
        (
            system(),
            r#"{"stabilization": 0}"#,
            "stabilization = 0, but H.mtx holds 3 nonzero entries",
        ),
        (
            system(),
            r#"{"stabilization": false}"#,
            "stabilization = false, but H.mtx holds 3",
        ),
        (
            system(),
            r#"{"stabilization": 0, "states": [0]}"#,
            "stabilization = 0, but H.mtx holds 3",
        ),
        (
            system(),
            r#"{"stabilization": -1}"#,
            "`stabilization = -1`: that is true, false or the factor of H, 0 or larger",
        ),
        (
            system(),
            r#"{"stabilization": "x", "version": "fracas 0.1.0"}"#,
            "`stabilization = \"x\"`",
        ),
        (
            bare(),
            r#"{"blocks": ["A", "B1", "H"]}"#,
            "but the folder holds no H.mtx",
        ),
        (
            bare(),
            r#"{"blocks": ["A", "B1", "B2"]}"#,
            "but the folder holds no B2.mtx",
        ),
        (
            bare(),
            r#"{"blocks": ["A", "B1", "T"]}"#,
            "but the folder holds no T.mtx",
        ),
        (
            system(),
            r#"{"blocks": ["A", "B1"]}"#,
            "but H.mtx holds 3 nonzero entries",
        ),
        (
            system(),
            r#"{"right_hand_sides": ["rhs_u", "rhs_p"]}"#,
            "but the folder holds no rhs_p.mtx",
        ),
        (
            system(),
            r#"{"blocks": []}"#,
            "/manifest.json says blocks = [], but A.mtx is there",
        ),
        (
            system(),
            r#"{"right_hand_sides": []}"#,
            "/manifest.json says right_hand_sides = [], but rhs_u.mtx is there",
        ),
        (
            system(),
            r#"{"scene": 7}"#,
            "invalid type: integer `7`, expected a string",
        ),
        (
            system(),
            r#"{"n_p": 2}"#,
            "n_p = 2, but a folder without T.mtx gives 0",
        ),
        (
            system(),
            r#"{"states": [0, 0]}"#,
            "2 states of faces, but B1.mtx has 3 columns",
        ),
        (system(), r#"{"states": [4]}"#, "gives face 1 the state 4"),
        (
            system(),
            r#"{"version": "fracas 9", "states": [0, 0, 0]}"#,
            "3 states of faces",
        ),
    ] {
        let message = with_manifest(&blocks, manifest).unwrap_err();
        assert!(message.contains(contradiction), "{manifest}: {message}");
    }
    for (blocks, manifest) in [
        (system(), r#"{"stabilization": 1.0}"#),
        (zero.clone(), r#"{"stabilization": 1.0}"#),
        (zero, r#"{"stabilization": 0}"#),
        (bare(), r#"{"stabilization": 0.0}"#),
        (bare(), r#"{"stabilization": null}"#),
        (
            bare(),
            r#"{"stabilization": "of another code", "blocks": 2}"#,
        ),
        // names of another code
        (system(), r#"{"blocks": ["K", "C"], "stabilization": 1}"#),
        // rows of opening
        (system(), r#"{"stabilization": 0, "states": [3]}"#),
        // no edge between two faces
        (bare(), r#"{"stabilization": 1.0, "blocks": ["A", "B1"]}"#),
        (system(), r#"{"states": [0, 0, 0]}"#),
    ] {
        assert_eq!(with_manifest(&blocks, manifest), Ok(()), "{manifest}");
    }
}

#[test]
fn an_empty_list_of_right_hand_sides_is_true_where_there_are_none() {
    let folder = folder("no-sides");
    write_folder(&folder, &system(), &Manifest::default()).unwrap();
    std::fs::write(folder.join("manifest.json"), r#"{"right_hand_sides": []}"#).unwrap();
    for (file, next) in [("rhs_u.mtx", Some("rhs_t.mtx")), ("rhs_t.mtx", None)] {
        std::fs::remove_file(folder.join(file)).unwrap();
        let said = read_folder(&folder).map(|_| ()).map_err(|e| e.to_string());
        match next {
            Some(next) => assert!(said.unwrap_err().contains(next)),
            None => assert_eq!(said, Ok(())),
        }
    }
}

#[test]
fn what_is_written_fits_its_manifest_and_a_file_that_is_lost_does_not() {
    let b2 = sparse(3, 6, |i, j| 1.0 / (2 + i + j) as f64);
    for (h, b2) in [(true, true), (true, false), (false, true), (false, false)]
        .map(|(h, two)| (h, two.then(|| b2.clone())))
    {
        let blocks = SaddleBlocks {
            h: system().h.filter(|_| h),
            b2: b2.clone(),
            ..system()
        };
        let folder = folder("written");
        write_folder(&folder, &blocks, &Manifest::default()).unwrap();
        read_folder(&folder).unwrap();
        for (file, is_there) in [("H.mtx", h), ("B2.mtx", b2.is_some())] {
            if is_there {
                let away = folder.join("away");
                std::fs::rename(folder.join(file), &away).unwrap();
                let error = read_folder(&folder).unwrap_err();
                assert!(matches!(error, FolderError::Lost { .. }), "{error}");
                std::fs::rename(&away, folder.join(file)).unwrap();
            }
        }
    }
}

/// A file of another scene, step or iteration has the same sizes.
#[test]
fn a_file_that_was_not_written_beside_the_manifest_is_an_error() {
    let written = folder("own");
    let scene = Manifest {
        scene: Some("cycle".into()),
        ..Manifest::default()
    };
    write_folder(&written, &system(), &scene).unwrap();
    assert!(read_folder(&written).is_ok());
    let other = folder("other");
    let twice = |values: &[f64]| values.iter().map(|v| 2.0 * v).collect::<Vec<f64>>();
    let blocks = SaddleBlocks {
        a: system().a.map(|v| 2.0 * v),
        b1: system().b1.map(|v| 2.0 * v),
        h: system().h.map(|h| h.map(|v| 2.0 * v)),
        rhs_u: twice(&system().rhs_u),
        rhs_t: twice(&system().rhs_t),
        ..system()
    };
    write_folder(&other, &blocks, &scene).unwrap();
    for name in ["A", "B1", "H", "rhs_u", "rhs_t"] {
        let file = format!("{name}.mtx");
        std::fs::copy(other.join(&file), written.join(&file)).unwrap();
        let error = read_folder(&written).unwrap_err().to_string();
        let says = format!("manifest.json says that {file} has the Frobenius norm");
        assert!(error.starts_with(&says), "{error}");
        assert!(error.contains("for scene \"cycle\""), "{error}");
        write_folder(&written, &system(), &scene).unwrap();
    }
    for norm in ["-1", "\"x\"", "null"] {
        let foreign = format!(r#"{{"norms": {{"A": {norm}}}}}"#);
        assert_eq!(with_manifest(&system(), &foreign), Ok(()));
        let ours = format!(r#"{{"norms": {{"A": {norm}}}, "version": "fracas 0.1.0"}}"#);
        let error = with_manifest(&system(), &ours).unwrap_err();
        let says = format!("norms.A = {norm}:");
        assert!(error.contains(&says), "{error}");
    }
    let ours = r#"{"norms": 3, "version": "fracas 0.1.0"}"#;
    let error = with_manifest(&system(), ours).unwrap_err();
    assert!(error.contains("norms = 3:"), "{error}");
    // numbers of another code, to ten digits
    let norm = norms(&system())[0].1 * (1.0 + 1e-11);
    with_manifest(&system(), &format!(r#"{{"norms": {{"A": {norm:e}}}}}"#)).unwrap();
}

/// What the import leaves out is compared, too, and a file that is lost is told as lost.
#[test]
fn norms_of_what_is_left_out_or_lost_are_held() {
    let zero = SaddleBlocks {
        h: Some(sparse(3, 3, |_, _| 0.0)),
        ..system()
    };
    let transposed = SaddleBlocks {
        b2: Some(system().b1.transpose_view().to_csr()),
        ..system()
    };
    for (blocks, name, own, other) in [
        (&zero, "H", 0.0, 0.17),
        (&transposed, "B2", norms(&system())[1].1, 0.5),
    ] {
        let says = |norm: f64| format!(r#"{{"norms": {{"{name}": {norm:e}}}}}"#);
        assert_eq!(with_manifest(blocks, &says(own)), Ok(()));
        let error = with_manifest(blocks, &says(other)).unwrap_err();
        assert!(
            error.contains(&format!("{name}.mtx has the Frobenius norm")),
            "{error}"
        );
    }
    let error = with_manifest(&bare(), r#"{"norms": {"H": 0.17}}"#).unwrap_err();
    let lost = "manifest.json says norms.H = 1.7e-1, but the folder holds no H.mtx";
    assert!(error.starts_with(lost), "{error}");
}

/// Squares of numbers beyond 1e154 are none.
#[test]
fn a_norm_beyond_the_numbers_is_left_out() {
    let folder = folder("beyond");
    let blocks = SaddleBlocks {
        a: system().a.map(|v| 1e160 * v),
        ..system()
    };
    write_folder(&folder, &blocks, &Manifest::default()).unwrap();
    let text = std::fs::read_to_string(folder.join("manifest.json")).unwrap();
    let manifest: Manifest = serde_json::from_str(&text).unwrap();
    let said = manifest.norms().unwrap();
    let said: Vec<&str> = said.iter().map(|(name, _)| name.as_str()).collect();
    assert!(!said.contains(&"A") && said.contains(&"B1"), "{said:?}");
}
