//! A system survives the round trip; every defect of a folder is named with its file and place.

use super::*;
use crate::saddle::{DofCoordinate, FlowBlocks, SaddleBlocks};
use fracas_operators::sparse::{SparseMatrix, Triplets};
use std::path::{Path, PathBuf};

/// A folder that is gone with this value.
pub(super) struct Folder(PathBuf);

impl std::ops::Deref for Folder {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

pub(super) fn folder(name: &str) -> Folder {
    let folder = std::env::temp_dir().join(format!("fracas-folder-{}-{name}", std::process::id()));
    if folder.exists() {
        std::fs::remove_dir_all(&folder).unwrap();
    }
    std::fs::create_dir_all(&folder).unwrap();
    Folder(folder)
}

pub(super) fn sparse(
    rows: usize,
    cols: usize,
    f: impl Fn(usize, usize) -> f64,
) -> SparseMatrix<f64> {
    let mut triplets = Triplets::new((rows, cols));
    for i in 0..rows {
        for j in 0..cols {
            if f(i, j) != 0.0 {
                triplets.add_triplet(i, j, f(i, j));
            }
        }
    }
    triplets.to_csr()
}

/// n_u = 6, n_t = 3.
pub(super) fn system() -> SaddleBlocks {
    let coordinate = |i: usize| DofCoordinate {
        position: [(i / 3) as f64, 0.1, -1e-3],
        component: (i % 3) as u8,
    };
    SaddleBlocks {
        a: sparse(6, 6, |i, j| {
            if i == j {
                4.0
            } else {
                1.0 / (1 + i + j) as f64
            }
        }),
        b1: sparse(6, 3, |i, j| if i % 3 == j { 1.0 / 3.0 } else { 0.0 }),
        b2: None,
        h: Some(sparse(3, 3, |i, j| if i == j { 0.1 } else { 0.0 })),
        rhs_u: (0..6).map(|i| (i as f64).sin()).collect(),
        rhs_t: vec![0.5; 3],
        coordinates: Some((0..6).map(coordinate).collect()),
        flow: None,
    }
}

/// Writes the system, replaces some files, and reads it again.
fn with_files(name: &str, files: &[(&str, &str)]) -> Result<Imported, FolderError> {
    let folder = folder(name);
    write_folder(&folder, &system(), &Manifest::default()).unwrap();
    // files come on top that a list of blocks would leave out
    std::fs::write(folder.join("manifest.json"), "{}").unwrap();
    for (file, text) in files {
        std::fs::write(folder.join(file), text).unwrap();
    }
    read_folder(&folder)
}

fn refusal(name: &str, files: &[(&str, &str)]) -> String {
    with_files(name, files).unwrap_err().to_string()
}

const REAL: &str = "%%MatrixMarket matrix coordinate real general\n";
const ARRAY: &str = "%%MatrixMarket matrix array real general\n";

fn coordinate(rows: usize, cols: usize, entries: &[(usize, usize, f64)]) -> String {
    let mut text = format!("{REAL}{rows} {cols} {}\n", entries.len());
    for (i, j, v) in entries {
        text.push_str(&format!("{i} {j} {v}\n"));
    }
    text
}

#[test]
fn a_system_survives_the_round_trip_bit_for_bit() {
    let mut blocks = system();
    blocks.flow = Some(FlowBlocks {
        q1: sparse(6, 2, |i, j| -((i * j) as f64) / 7.0),
        q2: sparse(2, 6, |i, j| (1 + i + j) as f64 / 9.0),
        t: sparse(2, 2, |i, j| if i == j { 1e-17 } else { 0.0 }),
        rhs_p: vec![1.0, -2.0],
    });
    blocks.b2 = Some(sparse(3, 6, |i, j| 1.0 / (2 + i + j) as f64));
    let mut manifest = Manifest {
        scene: Some("two_blocks".into()),
        states: Some(vec![2]),
        ..Manifest::default()
    };
    manifest.other.insert("mesher".into(), "other code".into());
    let folder = folder("round");
    write_folder(&folder, &blocks, &manifest).unwrap();
    let read = read_folder(&folder).unwrap();
    let b = &read.blocks;
    assert!(read.has_rhs);
    assert_eq!(
        (&b.a, &b.b1, &b.b2, &b.h),
        (&blocks.a, &blocks.b1, &blocks.b2, &blocks.h)
    );
    assert_eq!(
        (&b.rhs_u, &b.rhs_t, &b.coordinates),
        (&blocks.rhs_u, &blocks.rhs_t, &blocks.coordinates)
    );
    let (flow, written) = (b.flow.as_ref().unwrap(), blocks.flow.as_ref().unwrap());
    assert_eq!(
        (&flow.q1, &flow.q2, &flow.t, &flow.rhs_p),
        (&written.q1, &written.q2, &written.t, &written.rhs_p)
    );
    assert_eq!(
        (read.manifest.n_u, read.manifest.n_t, read.manifest.n_p),
        (Some(6), Some(3), Some(2))
    );
    let mut other = read.manifest.other.clone();
    let listed = other.remove("blocks").unwrap();
    assert_eq!(listed.to_string(), r#"["A","B1","B2","H","Q1","Q2","T"]"#);
    let sides = other.remove("right_hand_sides").unwrap();
    assert_eq!(sides.to_string(), r#"["rhs_u","rhs_t","rhs_p"]"#);
    let norms = other.remove("norms").unwrap();
    let names: Vec<&String> = norms.as_object().unwrap().keys().collect();
    assert_eq!(names.len(), 10, "{names:?}");
    assert_eq!(other, manifest.other);
    assert!(matches!(
        &read.findings[..],
        [Finding {
            remark: Remark::DiffersFromTranspose { .. },
            ..
        }]
    ));

    write_folder(&folder, &system(), &Manifest::default()).unwrap();
    let read = read_folder(&folder).unwrap();
    assert!(
        read.blocks.b2.is_none() && read.blocks.flow.is_none(),
        "files of the earlier system are gone"
    );
    assert_eq!(read.findings, []);
}

#[test]
fn missing_files_are_named() {
    let empty = folder("empty");
    assert!(matches!(
        read_folder(&empty),
        Err(FolderError::Missing {
            file: "A.mtx",
            near: None,
            ..
        })
    ));
    std::fs::write(empty.join("a.mtx"), "").unwrap();
    let message = read_folder(&empty).unwrap_err().to_string();
    assert!(
        message.contains("holds no A.mtx") && message.contains("found a.mtx"),
        "{message}"
    );
    assert!(matches!(
        read_folder(Path::new("/nowhere/at/all")),
        Err(FolderError::NotAFolder { .. })
    ));
    let message = refusal("flow", &[("Q1.mtx", &coordinate(6, 1, &[]))]);
    assert!(message.contains("holds Q1.mtx but no Q2.mtx"), "{message}");
}

#[test]
fn sizes_that_do_not_fit_name_both_files() {
    let message = refusal("b1", &[("B1.mtx", &coordinate(5, 3, &[]))]);
    assert_eq!(message, "B1.mtx is 5×3, expected 6×3 because A.mtx is 6×6");
    let message = refusal("b2", &[("B2.mtx", &coordinate(6, 3, &[]))]);
    assert_eq!(message, "B2.mtx is 6×3, expected 3×6 because B1.mtx is 6×3");
    let message = refusal("h", &[("H.mtx", &coordinate(2, 2, &[]))]);
    assert_eq!(message, "H.mtx is 2×2, expected 3×3 because B1.mtx is 6×3");
    let message = refusal("rhs", &[("rhs_u.mtx", &format!("{ARRAY}1 1\n1\n"))]);
    assert_eq!(
        message,
        "rhs_u.mtx is 1×1, expected 6×1 because A.mtx is 6×6"
    );
    let message = refusal("a", &[("A.mtx", &coordinate(6, 5, &[]))]);
    assert_eq!(message, "A.mtx is 6×5; it must be square");
    let message = refusal("manifest", &[("manifest.json", r#"{"n_t": 4}"#)]);
    assert_eq!(
        message,
        "manifest.json says n_t = 4, but B1.mtx gives 3; one of them is of another system"
    );
    let q = [
        ("Q1.mtx", coordinate(6, 1, &[])),
        ("Q2.mtx", coordinate(2, 6, &[])),
        ("T.mtx", coordinate(1, 1, &[])),
    ];
    let q: Vec<(&str, &str)> = q.iter().map(|(f, t)| (*f, t.as_str())).collect();
    assert_eq!(
        refusal("q", &q),
        "Q2.mtx is 2×6, expected 1×6 because T.mtx is 1×1"
    );
}

#[test]
fn an_unsymmetric_stiffness_is_an_error_with_row_column_and_values() {
    let mut entries: Vec<_> = (1..=6).map(|i| (i, i, 2.0)).collect();
    entries.push((5, 2, 1.0));
    entries.push((2, 5, 1.5));
    let message = refusal("asymmetric", &[("A.mtx", &coordinate(6, 6, &entries))]);
    let start = "A.mtx is not symmetric: entry (2, 5) is 1.5e0, entry (5, 2) is 1e0";
    assert!(message.starts_with(start), "{message}");
    entries.last_mut().unwrap().2 = 1.0 + 1e-14;
    let read = with_files("rounding", &[("A.mtx", &coordinate(6, 6, &entries))]).unwrap();
    assert!(
        read.findings.iter().any(
            |f| matches!(f.remark, Remark::SymmetricToRounding { relative } if relative < 1e-13)
        )
    );
}

#[test]
fn nan_and_broken_files_keep_their_line() {
    let message = refusal("nan", &[("H.mtx", &format!("{REAL}3 3 1\n2 3 NaN\n"))]);
    assert!(
        message
            .ends_with("H.mtx, line 3: the value `NaN` in row 2, column 3 is not a finite number"),
        "{message}"
    );
    let message = refusal("json", &[("manifest.json", "{\n \"n_u\": x\n}")]);
    assert!(
        message.contains("manifest.json: ") && message.contains("line 2"),
        "{message}"
    );
}

#[test]
fn entries_of_which_products_are_no_numbers_are_refused_with_their_place() {
    let [u, t] = [6, 3].map(|n| move |entry: &str| format!("{ARRAY}{n} 1\n{}", entry.repeat(n)));
    for (file, text, place) in [
        (
            "A.mtx",
            format!("{REAL}6 6 1\n1 1 -1e101\n"),
            "row 1, column 1: the entry -1e101",
        ),
        (
            "B1.mtx",
            format!("{REAL}6 3 1\n4 3 1e-101\n"),
            "row 4, column 3: the entry 1e-101",
        ),
        (
            "B2.mtx",
            format!("{REAL}3 6 2\n1 2 1\n3 5 1e200\n"),
            "row 3, column 5: the entry 1e200",
        ),
        (
            "H.mtx",
            format!("{REAL}3 3 1\n2 3 1e150\n"),
            "row 2, column 3: the entry 1e150",
        ),
        (
            "rhs_u.mtx",
            u("1e308\n"),
            "row 1, column 1: the entry 1e308",
        ),
        (
            "rhs_t.mtx",
            t("-1e101\n"),
            "row 1, column 1: the entry -1e101",
        ),
    ] {
        let message = refusal("extreme", &[(file, &text)]);
        let start = format!(
            "{file}, {place} is out of range; choose units in which entries are 0 or from 1e-100 to 1e100 in size"
        );
        assert!(message.starts_with(&start), "{message}");
    }
    // beside a load small ones are zeros, alone they are out of range
    let small = t("1e-200\n");
    let sides = [("rhs_t.mtx", small.as_str())];
    assert!(with_files("small", &sides).is_ok());
    let none = u("0\n");
    let message = refusal("alone", &[sides[0], ("rhs_u.mtx", &none)]);
    let start = "rhs_t.mtx, row 1, column 1: the entry 1e-200 is out of range";
    assert!(message.starts_with(start), "{message}");
    let within = format!("{REAL}3 3 3\n1 1 1e100\n2 2 1e-200\n3 3 0\n");
    assert!(with_files("within", &[("H.mtx", &within)]).is_ok());
    let blocks = SaddleBlocks {
        b1: system().b1.map(|v| 1e101 * v),
        ..system()
    };
    let message = inspect_blocks(blocks).unwrap_err().to_string();
    assert!(
        message.starts_with("B1.mtx, row 1, column 1: the entry 3.3"),
        "{message}"
    );
}

#[test]
fn coordinates_come_in_two_forms_or_are_refused() {
    let by_node = format!("{ARRAY}2 3\n0\n1\n0.1\n0.1\n-1e-3\n-1e-3\n");
    let read = with_files("nodes", &[("coords.mtx", &by_node)]).unwrap();
    assert_eq!(read.blocks.coordinates, system().coordinates);
    let message = refusal(
        "short",
        &[("coords.mtx", &format!("{ARRAY}1 3\n0\n1\n0.1\n"))],
    );
    assert!(
        message.starts_with("coords.mtx is 1×3, expected 6×4"),
        "{message}"
    );
    let mut rows = format!("{ARRAY}6 4\n{}", "0\n".repeat(18));
    rows.push_str("0\n1\n2\n0\n7\n2\n");
    let message = refusal("component", &[("coords.mtx", &rows)]);
    assert_eq!(
        message,
        "coords.mtx, row 5: the component is 7, expected 0, 1 or 2 (x, y, z)"
    );
    let rows = format!("{ARRAY}6 4\n{}1\n2\n3\n1\n2\n3\n", "0\n".repeat(18));
    let message = refusal("from one", &[("coords.mtx", &rows)]);
    assert!(
        message.starts_with("coords.mtx: the components are 1, 2 and 3; they count from 0"),
        "{message}"
    );
}

#[test]
fn more_tractions_than_displacements_are_remarkable_without_h() {
    let b1 = sparse(6, 8, |i, j| f64::from(u8::from(i == j % 6)));
    let h = sparse(8, 8, |i, j| f64::from(u8::from(i == j)));
    let mut findings = Vec::new();
    inspect::rank(&b1, Some(&h), &mut findings);
    assert!(findings.is_empty());
    inspect::rank(&b1, None, &mut findings);
    let text = findings[0].to_string();
    assert!(
        text.starts_with(
            "B1.mtx: 8 tractions on 6 displacements, without H: the system is singular"
        ),
        "{text}"
    );
}

#[test]
fn what_is_remarkable_is_found_with_its_place() {
    let found = |name: &str, files: &[(&str, &str)]| -> Vec<String> {
        with_files(name, files)
            .unwrap()
            .findings
            .iter()
            .map(ToString::to_string)
            .collect()
    };
    let has = |list: &[String], start: &str| {
        assert!(list.iter().any(|f| f.starts_with(start)), "{list:?}")
    };

    let b1 = coordinate(6, 3, &[(1, 1, 1.0), (1, 1, 1.0), (4, 3, 1.0)]);
    let a = coordinate(
        6,
        6,
        &[
            (1, 1, 1.0),
            (2, 2, 3.0),
            (4, 4, -1.0),
            (5, 6, 1.0),
            (6, 5, 1.0),
        ],
    );
    let list = found("blocks", &[("A.mtx", &a), ("B1.mtx", &b1), ("b2.MTX", &b1)]);
    has(
        &list,
        "B1.mtx, row 1, column 1: 1 entry is listed more than once (first in line 4), and added up",
    );
    has(
        &list,
        "A.mtx, row 3: 1 zero row: A is singular there; only B1 can hold this unknown",
    );
    has(
        &list,
        "A.mtx, row 4: 3 diagonal entries are negative, or zero",
    );
    has(
        &list,
        "A.mtx, row 2: 1 row holds only its diagonal and no entry of B1",
    );
    has(
        &list,
        "B1.mtx, column 2: 1 empty column: a traction that touches no displacement",
    );
    has(&list, "b2.MTX: not read");

    let entries = [
        (1, 1, 1.0),
        (4, 1, -3.0),
        (1, 2, 2.0),
        (4, 2, -5.0),
        (1, 3, -0.1),
        (4, 3, 0.3),
    ];
    let b1 = coordinate(6, 3, &entries);
    let h = coordinate(
        3,
        3,
        &[(1, 1, -1.0), (2, 2, -2.0), (3, 1, 0.5), (1, 3, 0.5)],
    );
    let list = found("alike", &[("B1.mtx", &b1), ("H.mtx", &h)]);
    has(
        &list,
        "B1.mtx, column 3: 1 column is a multiple of another (first: of column 1)",
    );
    has(
        &list,
        "H.mtx, row 1: all 2 diagonal entries that are not zero are negative (first: -1e0): is this −H?",
    );

    let third = 1.0 / 3.0;
    let transposed = |s: f64| {
        coordinate(
            3,
            6,
            &[1, 2, 3, 4, 5, 6].map(|j| ((j - 1) % 3 + 1, j, s * third)),
        )
    };
    let same = with_files("same", &[("B2.mtx", &transposed(1.0 + 1e-15))]).unwrap();
    assert!(same.blocks.b2.is_none());
    assert_eq!(same.findings[0].remark, Remark::EqualsTranspose);
    has(
        &found("minus", &[("B2.mtx", &transposed(-1.0))]),
        "B2.mtx: equal to −B1ᵀ",
    );

    let h = coordinate(3, 3, &[(1, 1, 1.0), (1, 2, 0.5), (3, 3, -2.0)]);
    let list = found("slip", &[("H.mtx", &h)]);
    has(&list, "H.mtx, row 1, column 2: unsymmetric");
    has(
        &list,
        "H.mtx, row 3: 1 diagonal entry is negative (first: -2e0)",
    );
    let zero = with_files("zero", &[("H.mtx", &coordinate(3, 3, &[]))]).unwrap();
    assert!(zero.blocks.h.is_none());

    let bare = folder("bare");
    write_folder(
        &bare,
        &SaddleBlocks {
            coordinates: None,
            ..system()
        },
        &Manifest::default(),
    )
    .unwrap();
    for file in ["rhs_u.mtx", "rhs_t.mtx", "manifest.json"] {
        std::fs::remove_file(bare.join(file)).unwrap();
    }
    let read = read_folder(&bare).unwrap();
    assert!(!read.has_rhs && read.blocks.rhs_u == [0.0; 6]);
    let remarks: Vec<_> = read.findings.into_iter().map(|f| f.remark).collect();
    assert_eq!(
        remarks,
        [
            Remark::NoManifest,
            Remark::NoRightHandSide,
            Remark::NoCoordinates
        ]
    );
}

/// Forces that are lost, and right-hand sides of zeros, are said: a solution of zeros is no surprise then.
#[test]
fn a_right_hand_side_of_nothing_is_said() {
    let said = |rhs_u: Option<f64>, rhs_t: f64| {
        let folder = folder("sides");
        let blocks = SaddleBlocks {
            rhs_u: vec![rhs_u.unwrap_or(1.0); 6],
            rhs_t: vec![rhs_t; 3],
            ..system()
        };
        write_folder(&folder, &blocks, &Manifest::default()).unwrap();
        if rhs_u.is_none() {
            std::fs::remove_file(folder.join("rhs_u.mtx")).unwrap();
            let lost = read_folder(&folder).unwrap_err().to_string();
            assert!(lost.contains("holds no rhs_u.mtx"), "{lost}");
            std::fs::write(folder.join("manifest.json"), "{}").unwrap();
        }
        let findings = read_folder(&folder).unwrap().findings;
        findings
            .into_iter()
            .find(|finding| finding.file == "rhs_u.mtx")
            .map(|finding| finding.remark)
    };
    assert_eq!(said(Some(1.0), 0.0), None);
    assert_eq!(said(Some(0.0), 1.0), None);
    assert_eq!(said(Some(0.0), 0.0), Some(Remark::ZeroRightHandSide));
    assert_eq!(said(None, 1.0), Some(Remark::NoForces));
    assert_eq!(said(None, 0.0), Some(Remark::NoForcesAndZero));
}

#[test]
fn an_unsymmetric_stiffness_is_not_exported() {
    let blocks = SaddleBlocks {
        a: sparse(6, 6, |i, j| if i <= j { 1.0 } else { 0.0 }),
        ..system()
    };
    let error = write_folder(&folder("export"), &blocks, &Manifest::default()).unwrap_err();
    assert!(matches!(error, FolderError::Asymmetric { .. }));
}

/// Blocks of flow with a defect each: sizes and NaN are errors, the rest findings.
#[test]
fn what_is_wrong_with_flow_is_named_with_its_place() {
    let written = |name: &str, q2: f64, t: [f64; 2], files: &[(&str, &str)]| {
        let mut blocks = system();
        blocks.flow = Some(FlowBlocks {
            q1: sparse(6, 2, |i, j| if i % 2 == j { -0.5 } else { 0.0 }),
            q2: sparse(2, 6, |j, i| if j == 0 && i % 2 == 0 { q2 } else { 0.0 }),
            t: sparse(2, 2, |i, j| if i == j { t[i] } else { 0.0 }),
            rhs_p: vec![1.0, 0.0],
        });
        let folder = folder(name);
        write_folder(&folder, &blocks, &Manifest::default()).unwrap();
        for (file, text) in files {
            std::fs::write(folder.join(file), text).unwrap();
        }
        read_folder(&folder)
    };
    let findings = |name: &str, q2, t| -> Vec<String> {
        let read: Imported = written(name, q2, t, &[]).unwrap();
        read.findings.iter().map(ToString::to_string).collect()
    };
    assert_eq!(
        findings("flow_sound", 0.5, [1.0, 1.0]),
        Vec::<String>::new()
    );
    let found = findings("flow_sign", -0.5, [1.0, -2.0]);
    assert!(found[0].starts_with("T.mtx, row 2: 1 diagonal entry is negative (first: -2e0)"));
    assert!(found[1].starts_with("Q2.mtx, row 1: 1 row has the sign of its column"));
    let found = findings("flow_free", 0.5, [0.0, 0.0]);
    assert!(found[0].starts_with(
        "T.mtx, row 2: 1 row is zero here and in Q2.mtx: nothing determines this pressure"
    ));
    let said = |name: &str, file: &str, text: &str| {
        let files = [(file, text)];
        written(name, 0.5, [1.0; 2], &files)
            .unwrap_err()
            .to_string()
    };
    let short = said("flow_rhs", "rhs_p.mtx", &format!("{ARRAY}3 1\n1\n1\n1\n"));
    assert_eq!(short, "rhs_p.mtx is 3×1, expected 2×1 because T.mtx is 2×2");
    let wide = said("flow_t", "T.mtx", &coordinate(2, 3, &[]));
    assert_eq!(wide, "T.mtx is 2×3; it must be square");
    let nan = said("flow_nan", "Q2.mtx", &format!("{REAL}2 6 1\n1 3 inf\n"));
    assert!(
        nan.contains("Q2.mtx, line 3") && nan.contains("not a finite number"),
        "{nan}"
    );
    let large = said("flow_large", "T.mtx", &format!("{REAL}2 2 1\n2 2 1e300\n"));
    let start = "T.mtx, row 2, column 2: the entry 1e300 is out of range";
    assert!(large.starts_with(start), "{large}");
    let large = said(
        "flow_rate",
        "rhs_p.mtx",
        &format!("{ARRAY}2 1\n1\n-1e200\n"),
    );
    let start = "rhs_p.mtx, row 2, column 1: the entry -1e200 is out of range";
    assert!(large.starts_with(start), "{large}");
    let n_p = said("flow_n_p", "manifest.json", "{\"n_p\": 5}");
    assert!(n_p.contains("says n_p = 5"), "{n_p}");
}
