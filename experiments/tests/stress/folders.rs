//! Mutated system folders: what is taken is what a slow and strict reader finds.

use crate::mutation::mutate;
use crate::room::{Verdict, count, scratch, trial};
use fracas_operators::random::Random;
use fracas_operators::sparse::SparseMatrix;
use fracas_solvers::saddle::folder::read_folder;
use std::collections::BTreeMap;
use std::path::Path;

/// Entries of a matrix, duplicates summed.
type Entries = BTreeMap<(usize, usize), f64>;

/// Rows, columns and entries.
type Plain = (usize, usize, Entries);

/// The files of a small system: n_u = 6, n_t = 2.
pub(crate) const FILES: [(&str, &str); 8] = [
    (
        "A.mtx",
        "%%MatrixMarket matrix coordinate real symmetric\n% stiffness\n6 6 11\n1 1 4\n2 2 4\n3 3 4\n4 4 4.5\n5 5 4\n6 6 4\n2 1 -1\n3 2 -1e0\n4 3 -1.0\n5 4 -1\n6 5 -1\n",
    ),
    (
        "B1.mtx",
        "%%MatrixMarket matrix coordinate real general\n6 2 4\n1 1 -1\n2 1 1\n5 2 -0.5\n6 2 0.5\n",
    ),
    (
        "B2.mtx",
        "%%MatrixMarket matrix coordinate real general\n2 6 4\n1 1 -1\n1 2 1.25\n2 5 -0.5\n2 6 0.5\n",
    ),
    (
        "H.mtx",
        "%%MatrixMarket matrix coordinate real general\n2 2 4\n1 1 2\n1 2 -1\n2 1 -1\n2 2 2\n",
    ),
    (
        "rhs_u.mtx",
        "%%MatrixMarket matrix array real general\n6 1\n1\n2\n-3\n4e-1\n5\n6\n",
    ),
    (
        "rhs_t.mtx",
        "%%MatrixMarket matrix coordinate integer general\n2 1 1\n2 1 7\n",
    ),
    (
        "coords.mtx",
        "%%MatrixMarket matrix array real general\n2 3\n0\n1\n0\n0.5\n0\n0.25\n",
    ),
    (
        "manifest.json",
        "{\n  \"n_t\": 2,\n  \"n_u\": 6,\n  \"scene\": \"by hand\"\n}\n",
    ),
];

#[test]
fn mutated_folders_are_refused_or_taken_for_what_they_say() {
    let folder = scratch("folders");
    for (name, text) in FILES {
        std::fs::write(folder.join(name), text).unwrap();
    }
    trial("folders", count(0.2, 3_000), |g| {
        let (name, text) = FILES[g.below(FILES.len())];
        let (bytes, _) = mutate(text.as_bytes(), g);
        std::fs::write(folder.join(name), &bytes).unwrap();
        let verdict = judge(&folder, name, &bytes);
        std::fs::write(folder.join(name), text).unwrap();
        verdict
    });
    std::fs::remove_dir_all(&folder).unwrap();
}

/// What a folder with one mutated file is taken for.
fn judge(folder: &Path, name: &str, bytes: &[u8]) -> Verdict {
    let Ok(imported) = read_folder(folder) else {
        return Verdict::Refused;
    };
    let finding = |what: &str| {
        Verdict::Finding(format!(
            "{name}: {what}\n{}",
            String::from_utf8_lossy(bytes)
        ))
    };
    if name == "manifest.json" {
        let json = serde_json::from_slice::<serde_json::Value>(bytes);
        return match json {
            Ok(_) => Verdict::Taken,
            Err(error) => finding(&format!("taken, but no JSON: {error}")),
        };
    }
    let (rows, columns, expected) = match plain(bytes) {
        Ok(plain) => plain,
        Err(why) => return finding(&format!("taken, but {why}")),
    };
    let b = &imported.blocks;
    let found = match name {
        "A.mtx" => of(&b.a),
        "B1.mtx" => of(&b.b1),
        "H.mtx" => b.h.as_ref().map_or((rows, columns, Entries::new()), of),
        // rounding of B1ᵀ counts as B1ᵀ
        "B2.mtx" => match &b.b2 {
            Some(b2) => of(b2),
            None => return Verdict::Taken,
        },
        "rhs_u.mtx" => vector(&b.rhs_u),
        "rhs_t.mtx" => vector(&b.rhs_t),
        _ => return Verdict::Taken,
    };
    let nonzero = |e: &Entries| -> Entries {
        e.iter()
            .filter(|(_, v)| **v != 0.0)
            .map(|(k, v)| (*k, *v))
            .collect()
    };
    if (found.0, found.1) != (rows, columns) || nonzero(&found.2) != nonzero(&expected) {
        return finding(&format!("taken for {found:?} in place of {expected:?}"));
    }
    Verdict::Taken
}

fn of(matrix: &SparseMatrix<f64>) -> Plain {
    let entries = matrix
        .iter()
        .map(|(v, (i, j))| ((i as usize, j as usize), *v));
    (matrix.rows(), matrix.cols(), entries.collect())
}

fn vector(values: &[f64]) -> Plain {
    let entries = values.iter().enumerate().map(|(i, v)| ((i, 0), *v));
    (values.len(), 1, entries.collect())
}

/// The format as its report has it, and nothing else: Fortran exponents, blank lines and comments, in whatever encoding, are the
/// only liberties.
pub(crate) fn plain(bytes: &[u8]) -> Result<Plain, String> {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = text.lines();
    let banner = lines.next().unwrap_or_default().to_ascii_lowercase();
    let words: Vec<&str> = banner.split_ascii_whitespace().collect();
    let ["%%matrixmarket", "matrix", layout, field, symmetry] = words[..] else {
        return Err("it has no banner".into());
    };
    let mut lines = lines.filter(|l| !l.trim().is_empty() && !l.trim_start().starts_with('%'));
    let whole = |word: &str| word.parse::<usize>().map_err(|e| format!("{word}: {e}"));
    let sizes = lines.next().ok_or("it has no sizes")?;
    let sizes = sizes
        .split_whitespace()
        .map(whole)
        .collect::<Result<Vec<_>, _>>()?;
    let number = |word: &str| -> Result<f64, String> {
        let value: f64 = match field {
            "integer" => word.parse::<i64>().map_err(|e| format!("{word}: {e}"))? as f64,
            "real" | "double" => {
                let word = word.replace(['d', 'D'], "e");
                word.parse().map_err(|e| format!("{word}: {e}"))?
            }
            other => return Err(format!("its field is {other}")),
        };
        value
            .is_finite()
            .then_some(value)
            .ok_or(format!("{word} is not finite"))
    };
    let mut listed = Vec::new();
    let (rows, columns, announced) = match (layout, &sizes[..]) {
        ("coordinate", [rows, columns, entries]) => {
            for line in lines {
                let words: Vec<&str> = line.split_whitespace().collect();
                let [i, j, v] = words[..] else {
                    return Err(format!("`{line}` is no entry"));
                };
                listed.push((whole(i)?, whole(j)?, number(v)?));
            }
            (*rows, *columns, *entries)
        }
        ("array", [rows, columns]) => {
            let symmetric = symmetry != "general";
            let places = (1..=*columns).flat_map(|j| {
                let first = if symmetric { j } else { 1 };
                (first..=*rows).map(move |i| (i, j))
            });
            let mut places = places.into_iter();
            for line in lines {
                let (i, j) = places.next().ok_or("it has too many values")?;
                listed.push((i, j, number(line.trim())?));
            }
            if places.next().is_some() {
                return Err("it has too few values".into());
            }
            (*rows, *columns, listed.len())
        }
        _ => return Err("its sizes are not those of its layout".into()),
    };
    if listed.len() != announced {
        return Err(format!(
            "it announces {announced} entries and has {}",
            listed.len()
        ));
    }
    let mut entries = Entries::new();
    for (i, j, v) in listed {
        if i == 0 || j == 0 || i > rows || j > columns {
            return Err(format!("({i}, {j}) lies outside"));
        }
        *entries.entry((i - 1, j - 1)).or_default() += v;
        match symmetry {
            "general" => {}
            "symmetric" if i == j => {}
            "symmetric" => *entries.entry((j - 1, i - 1)).or_default() += v,
            "skew-symmetric" => *entries.entry((j - 1, i - 1)).or_default() -= v,
            other => return Err(format!("its symmetry is {other}")),
        }
    }
    Ok((rows, columns, entries))
}

/// A random small system: symmetric positive definite A with a spread of scales, B of full rank, perhaps H; n_u, n_t.
pub(crate) fn random(folder: &Path, g: &mut Random) -> (usize, usize) {
    let n_t = 1 + g.below(4);
    let n_u = n_t + 1 + g.below(9);
    let scale: Vec<f64> = (0..n_u).map(|_| 10f64.powf(3.0 * g.unit())).collect();
    let mut a = String::new();
    let mut entries = 0;
    for i in 0..n_u {
        for j in 0..=i {
            let value = match i == j {
                true => n_u as f64 * scale[i] * scale[i],
                false => (2.0 * g.unit() - 1.0) * scale[i] * scale[j],
            };
            a += &format!("{} {} {value:e}\n", i + 1, j + 1);
            entries += 1;
        }
    }
    let a = format!("%%MatrixMarket matrix coordinate real symmetric\n{n_u} {n_u} {entries}\n{a}");
    let mut b = format!("%%MatrixMarket matrix array real general\n{n_u} {n_t}\n");
    for j in 0..n_t {
        for i in 0..n_u {
            let value = f64::from(u8::from(i == j)) * 2.0 + g.unit() - 0.5;
            b += &format!("{value:e}\n");
        }
    }
    let mut h = format!("%%MatrixMarket matrix array real symmetric\n{n_t} {n_t}\n");
    for j in 0..n_t {
        for i in j..n_t {
            h += if i == j { "1.5e-1\n" } else { "-1e-2\n" };
        }
    }
    let vector = |n: usize, g: &mut Random| {
        let values: String = (0..n).map(|_| format!("{:e}\n", g.unit() - 0.5)).collect();
        format!("%%MatrixMarket matrix array real general\n{n} 1\n{values}")
    };
    let mut files = vec![("A.mtx", a), ("B1.mtx", b)];
    files.push(("rhs_u.mtx", vector(n_u, g)));
    files.push(("rhs_t.mtx", vector(n_t, g)));
    if g.once_in(2) {
        files.push(("H.mtx", h));
    }
    for (name, text) in files {
        std::fs::write(folder.join(name), text).unwrap();
    }
    (n_u, n_t)
}
