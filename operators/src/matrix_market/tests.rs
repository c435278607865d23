//! Round trips to the last bit, and every defect with its line.

use super::blocks::Failure;
use super::read::dense_from;
use super::*;
use crate::Dense;
use crate::Shape;
use crate::sparse::{SparseMatrix, Triplets};
use proptest::prelude::*;
use std::io::Cursor;

fn scratch(name: &str) -> std::path::PathBuf {
    let folder = std::env::temp_dir().join(format!("fracas-mm-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}

fn dense(text: &str) -> Vec<f64> {
    dense_from(&mut Cursor::new(text)).unwrap().into_columns()
}

fn sparse_from(text: &[u8]) -> Result<SparseFile, Failure> {
    read::sparse_from(&mut Cursor::new(text))
}

/// Line and defect of a file that must be refused.
fn refusal(text: &str) -> (usize, Defect) {
    match sparse_from(text.as_bytes()) {
        Err(Failure::Content(line, defect)) => (line, defect),
        other => panic!("{other:?}"),
    }
}

const HEAD: &str = "%%MatrixMarket matrix coordinate real general\n";

#[test]
fn layouts_fields_and_symmetries_are_read() {
    let general = format!("{HEAD}% note\n\n2 3 3\r\n1 1 1.5\r\n\n2 3 -2e1\n 1  2\t3.0D+00\n");
    assert_eq!(dense(&general), [1.5, 0.0, 3.0, 0.0, 0.0, -20.0]);
    let lower = "%%matrixmarket MATRIX Coordinate Integer Symmetric\n2 2 2\n1 1 4\n2 1 -3";
    assert_eq!(dense(lower), [4.0, -3.0, -3.0, 0.0]);
    let upper = "%%MatrixMarket matrix coordinate double symmetric\n2 2 1\n1 2 7\n";
    assert_eq!(dense(upper), [0.0, 7.0, 7.0, 0.0]);
    let skew = "%%MatrixMarket matrix coordinate real skew-symmetric\n2 2 1\n2 1 7\n";
    assert_eq!(dense(skew), [0.0, 7.0, -7.0, 0.0]);
    let array = "%%MatrixMarket matrix array real general\n2 2\n1\n2\n3\n4\n";
    assert_eq!(dense(array), [1.0, 2.0, 3.0, 4.0]);
    let array_symmetric = "%%MatrixMarket matrix array real symmetric\n2 2\n1\n2\n3\n";
    assert_eq!(dense(array_symmetric), [1.0, 2.0, 2.0, 3.0]);
    let array_skew = "%%MatrixMarket matrix array real skew-symmetric\n3 3\n1\n2\n3\n";
    assert_eq!(
        dense(array_skew),
        [0.0, 1.0, 2.0, -1.0, 0.0, 3.0, -2.0, -3.0, 0.0]
    );
    assert_eq!(dense("%%MatrixMarket matrix array real general\n0 1\n"), []);
}

#[test]
fn duplicates_are_summed_and_reported_with_their_line() {
    let file =
        sparse_from(format!("{HEAD}2 2 4\n1 1 1\n2 2 5\n% remark\n1 1 2\n1 1 4\n").as_bytes())
            .unwrap();
    assert_eq!(file.matrix.get(0, 0), Some(&7.0));
    assert_eq!(
        file.duplicates,
        Some(Duplicates {
            count: 2,
            line: 6,
            row: 1,
            column: 1
        })
    );
}

#[test]
fn repeats_of_symmetric_files_count_once_and_mirror_images_are_refused_where_the_second_stands() {
    let head = "%%MatrixMarket matrix coordinate real symmetric\n";
    let read = |body: &str| sparse_from(format!("{head}{body}").as_bytes());
    let file = read("3 3 5\n3 1 1\n2 2 8\n3 1 2\n1 1 1\n3 1 4\n").unwrap();
    assert_eq!(file.matrix.get(0, 2), Some(&7.0));
    assert_eq!(file.matrix.get(2, 0), Some(&7.0));
    let [count, line, row, column] = [2, 5, 3, 1];
    let expected = Duplicates {
        count,
        line,
        row,
        column,
    };
    assert_eq!(file.duplicates, Some(expected));
    // two pairs: the upper one is named, at the line of its later entry
    let both = refusal(&format!(
        "{head}3 3 5\n3 2 1\n2 3 1\n1 2 1\n% remark\n2 1 1\n2 1 1\n"
    ));
    let expected = Defect::BothTriangles {
        symmetry: "symmetric",
        row: 1,
        column: 2,
    };
    assert_eq!(both, (7, expected));
}

#[test]
fn the_first_defect_of_a_file_is_the_one_that_is_named() {
    // the quick passes look at all places before any value
    let early = refusal(&format!("{HEAD}2 2 3\n1 1 x\n1 9 1\n1 1 1\n"));
    assert!(matches!(early, (3, Defect::Value { .. })));
    let split = refusal(&format!("{HEAD}2 2 1\n1 1\n 2.0\n"));
    assert!(matches!(split, (3, Defect::Entry { .. })));
    let skew = "%%MatrixMarket matrix coordinate real skew-symmetric\n2 2 2\n2 2 1\n9 9 1\n";
    assert!(matches!(refusal(skew), (4, Defect::OutOfRange { .. })));
}

#[test]
fn every_defect_names_its_line() {
    let body = |lines: &str| refusal(&format!("{HEAD}{lines}"));
    assert!(matches!(refusal("1 2 3\n"), (1, Defect::Banner { .. })));
    assert!(matches!(refusal(""), (1, Defect::Banner { .. })));
    let complex = refusal("%%MatrixMarket matrix coordinate complex general\n1 1 1\n1 1 0 1\n");
    assert!(matches!(complex, (1, Defect::Field { field, .. }) if field == "complex"));
    let pattern = refusal("%%MatrixMarket matrix coordinate pattern general\n1 1 1\n1 1\n");
    assert!(matches!(pattern, (1, Defect::Field { field, .. }) if field == "pattern"));
    assert_eq!(body("% only comments\n"), (2, Defect::NoSize));
    assert!(matches!(body("2 2\n"), (2, Defect::Size { .. })));
    assert!(matches!(body("2 -2 1\n"), (2, Defect::Size { .. })));
    assert!(matches!(
        body("5000000000 1 0\n"),
        (2, Defect::TooLarge { what: "rows", .. })
    ));
    assert_eq!(
        body("2 2 3\n1 1 1\n2 2 1\n"),
        (
            4,
            Defect::Truncated {
                expected: 3,
                found: 2
            }
        )
    );
    assert_eq!(
        body("2 2 1\n1 1 1\n\n2 2 1\n"),
        (
            5,
            Defect::TooMany {
                expected: 1,
                found: 2
            }
        )
    );
    assert_eq!(
        body("2 2 1\n0 1 1\n"),
        (
            3,
            Defect::OutOfRange {
                row: 0,
                column: 1,
                rows: 2,
                columns: 2
            }
        )
    );
    assert_eq!(
        body("2 2 1\n\n1 3 1\n"),
        (
            4,
            Defect::OutOfRange {
                row: 1,
                column: 3,
                rows: 2,
                columns: 2
            }
        )
    );
    assert!(matches!(
        body("2 2 1\n1 2 nan\n"),
        (
            3,
            Defect::NotFinite {
                row: 1,
                column: 2,
                ..
            }
        )
    ));
    assert!(matches!(
        body("2 2 1\n1 2 1e999\n"),
        (3, Defect::NotFinite { .. })
    ));
    assert!(matches!(
        body("2 2 1\n1 2 1,5\n"),
        (
            3,
            Defect::Value {
                row: 1,
                column: 2,
                ..
            }
        )
    ));
    assert!(matches!(body("2 2 1\n1 2\n"), (3, Defect::Entry { .. })));
    assert!(matches!(
        body("2 2 1\n1 2 3 4\n"),
        (3, Defect::Entry { .. })
    ));
    assert!(matches!(
        body("2 2 1\n1.0 2 3\n"),
        (3, Defect::Entry { .. })
    ));
    let integer = refusal("%%MatrixMarket matrix coordinate integer general\n1 1 1\n1 1 1.5\n");
    assert!(matches!(
        integer,
        (
            3,
            Defect::Value {
                field: "integer",
                ..
            }
        )
    ));
    let both = refusal("%%MatrixMarket matrix coordinate real symmetric\n2 2 2\n2 1 1\n1 2 1\n");
    assert!(matches!(
        both,
        (
            4,
            Defect::BothTriangles {
                row: 1,
                column: 2,
                ..
            }
        )
    ));
    let skew = refusal("%%MatrixMarket matrix coordinate real skew-symmetric\n2 2 1\n2 2 1\n");
    assert_eq!(skew, (3, Defect::SkewDiagonal { row: 2, value: 1.0 }));
    let oblong = refusal("%%MatrixMarket matrix coordinate real symmetric\n2 3 0\n");
    assert!(matches!(
        oblong,
        (
            2,
            Defect::NotSquare {
                rows: 2,
                columns: 3,
                ..
            }
        )
    ));
    let short = refusal("%%MatrixMarket matrix array real general\n2 2\n1\n2\n3\n");
    assert_eq!(
        short,
        (
            5,
            Defect::Truncated {
                expected: 4,
                found: 3
            }
        )
    );
    let long = refusal("%%MatrixMarket matrix array real general\n1 1\n1\n2\n3\n");
    assert_eq!(
        long,
        (
            4,
            Defect::TooMany {
                expected: 1,
                found: 3
            }
        )
    );
}

#[test]
fn messages_are_sentences_with_file_and_line() {
    let path = scratch("message.mtx");
    std::fs::write(&path, format!("{HEAD}2 2 1\n1 2 inf\n")).unwrap();
    let message = read_sparse(&path).unwrap_err().to_string();
    let expected = "message.mtx, line 3: the value `inf` in row 1, column 2 is not a finite number";
    assert!(message.ends_with(expected), "{message}");
    let missing = read_vector(&scratch("absent.mtx")).unwrap_err();
    assert!(missing.defect().is_none() && missing.to_string().contains("absent.mtx"));
    std::fs::write(
        &path,
        "%%MatrixMarket matrix array real general\n2 2\n1\n1\n1\n1\n",
    )
    .unwrap();
    let wide = read_vector(&path).unwrap_err();
    assert_eq!(
        wide.defect(),
        Some(&Defect::NotAVector {
            rows: 2,
            columns: 2
        })
    );
}

#[test]
fn a_defect_far_into_a_large_file_has_its_line() {
    let n = 600_000;
    let mut text = format!("{HEAD}{n} 1 {n}\n");
    for i in 1..=n {
        text.push_str(&format!("{i} 1 {i}.0000000000000000e+00\n"));
    }
    assert_eq!(sparse_from(text.as_bytes()).unwrap().matrix.nnz(), n);
    let bad = text.replace("599000 1 599000.", "599000 2 599000.");
    assert!(matches!(
        refusal(&bad),
        (
            599_002,
            Defect::OutOfRange {
                row: 599_000,
                column: 2,
                ..
            }
        )
    ));
}

/// Any finite value, with subnormal and extreme ones.
fn value() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<f64>().prop_filter("finite", |v| v.is_finite()),
        Just(5e-324),
        Just(-0.0),
        Just(f64::MAX)
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn sparse_files_give_back_every_bit(
        entries in prop::collection::btree_map((0_usize..40, 0_usize..30), value(), 0..200),
    ) {
        let mut triplets = Triplets::new((40, 30));
        for ((i, j), v) in &entries {
            triplets.add_triplet(*i, *j, *v);
        }
        let matrix: SparseMatrix<f64> = triplets.to_csr();
        let path = scratch("sparse.mtx");
        write_sparse(&path, &matrix, Symmetry::General).unwrap();
        let back = read_sparse(&path).unwrap();
        prop_assert_eq!(back.duplicates, None);
        let read = back.matrix;
        prop_assert_eq!(read.indices(), matrix.indices());
        prop_assert!(read.data().iter().zip(matrix.data()).all(|(a, b)| a.to_bits() == b.to_bits()));
    }

    #[test]
    fn symmetric_and_skew_files_give_back_every_bit(
        entries in prop::collection::btree_map((0_usize..30, 0_usize..30), value(), 0..100),
        skew in any::<bool>(),
    ) {
        let mut triplets = Triplets::new((30, 30));
        let sign = if skew { -1.0 } else { 1.0 };
        for ((i, j), v) in &entries {
            if j < i {
                triplets.add_triplet(*i, *j, *v);
                triplets.add_triplet(*j, *i, sign * *v);
            } else if i == j && !skew {
                triplets.add_triplet(*i, *i, *v);
            }
        }
        let matrix: SparseMatrix<f64> = triplets.to_csr();
        let path = scratch("symmetric.mtx");
        write_sparse(&path, &matrix, if skew { Symmetry::Skew } else { Symmetry::Symmetric }).unwrap();
        let read = read_sparse(&path).unwrap().matrix;
        prop_assert_eq!(read.indices(), matrix.indices());
        prop_assert!(read.data().iter().zip(matrix.data()).all(|(a, b)| a.to_bits() == b.to_bits()));
    }

    #[test]
    fn entries_in_any_order_and_repeated_are_summed_in_the_order_of_the_file(
        entries in prop::collection::vec((1_usize..9, 1_usize..9, -1e3..1e3_f64), 0..120),
        symmetric in any::<bool>(),
    ) {
        let mut sums = std::collections::BTreeMap::new();
        let kept = |(i, j, _): &&(usize, usize, f64)| !symmetric || i >= j;
        let mut body = String::new();
        for (i, j, v) in entries.iter().filter(kept) {
            body.push_str(&format!("{i} {j} {v:e}\n"));
            let add = |sum: &mut f64| *sum += v;
            sums.entry((i - 1, j - 1)).and_modify(add).or_insert(*v);
            if symmetric && i != j {
                sums.entry((j - 1, i - 1)).and_modify(add).or_insert(*v);
            }
        }
        let count = entries.iter().filter(kept).count();
        let word = if symmetric { "symmetric" } else { "general" };
        let text = format!("%%MatrixMarket matrix coordinate real {word}\n8 8 {count}\n{body}");
        let file = sparse_from(text.as_bytes()).unwrap();
        let read = file.matrix.iter().map(|(v, (i, j))| ((i as usize, j as usize), v.to_bits()));
        prop_assert!(read.eq(sums.iter().map(|(place, v)| (*place, v.to_bits()))));
        let stored = sums.keys().filter(|(i, j)| !symmetric || i >= j).count();
        prop_assert_eq!(file.duplicates.map_or(0, |d| d.count), count - stored);
    }

    #[test]
    fn arrays_give_back_every_bit(values in prop::collection::vec(value(), 0..60)) {
        let path = scratch("array.mtx");
        write_vector(&path, &values).unwrap();
        let read = read_vector(&path).unwrap();
        prop_assert!(read.iter().zip(&values).all(|(a, b)| a.to_bits() == b.to_bits()));
        let rows = values.len() / 3;
        let matrix = Dense::from_fn(Shape::new(rows, 3), |i, j| values[3 * i + j]);
        write_dense(&path, &matrix).unwrap();
        prop_assert_eq!(read_dense(&path).unwrap(), matrix);
    }

    #[test]
    fn no_bytes_make_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..80), banner in any::<bool>()) {
        let mut text = if banner { HEAD.as_bytes().to_vec() } else { Vec::new() };
        text.extend(bytes);
        let _ = sparse_from(&text);
    }
}

/// 16 million entries, the size of A with 200k unknowns.
#[test]
#[ignore = "writes half a gigabyte"]
fn large_files_take_seconds() {
    let n = 200_000_usize;
    let (offsets, mut columns) = ((0..=n).map(|i| i * 80).collect(), Vec::new());
    for i in 0..n {
        let first = i.saturating_sub(40).min(n - 80);
        columns.extend((first..first + 80).map(|j| j as u32));
    }
    let values = (0..80 * n).map(|k| (k as f64).sin() * 1e9).collect();
    let matrix = SparseMatrix::new((n, n), offsets, columns, values);
    let path = scratch("large.mtx");
    let start = std::time::Instant::now();
    write_sparse(&path, &matrix, Symmetry::General).unwrap();
    let written = start.elapsed();
    let read = read_sparse(&path).unwrap().matrix;
    println!("write {written:?}, read {:?}", start.elapsed() - written);
    std::fs::remove_file(&path).unwrap();
    assert_eq!(read, matrix);
}
