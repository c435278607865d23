//! Claim: files that VTK and meshio have written, compressed by zlib, are read as they are meant; what others compress is refused.
//!
//! `data/vtu/` holds one grid of 5 × 4 × 3 leaning hexahedra, written by VTK 9.7 (base 64 between tags, 32 bits; raw and base 64 behind them, 64 bits,
//! blocks of 4 KiB; LZ4) and by meshio 5.3 as it writes by default.

use crate::pore_pressure::Folder;
use fracas::io::vtu::{Cells, Field, Grid};
use fracas::scene::Body;

const LINES: [&[f64]; 3] = [
    &[0.0, 1.0, 3.0, 7.0, 8.0, 8.5],
    &[0.0, 0.5, 1.0, 1.5, 2.0],
    &[-4.0, -3.5, -2.0, 0.0],
];

/// A point without pressure, and a file of `data/vtu`.
fn build(file: &str, array: &str) -> Result<Body, String> {
    let folder = Folder::empty(&format!("foreign-{file}-{array}"));
    let none = Grid {
        points: &[[4.0, 1.0, -2.0]],
        cells: Cells::Hexahedra(&[]),
        point_fields: vec![Field {
            name: array,
            components: 1,
            values: &[0.0],
        }],
        cell_fields: Vec::new(),
    };
    let mut bytes = Vec::new();
    none.write(&mut bytes).unwrap();
    folder.write("none.vtu", bytes);
    let data = std::env::var("FRACAS_VTU").ok();
    let data = data.unwrap_or(format!("{}/data/vtu", env!("CARGO_MANIFEST_DIR")));
    folder.write("own.vtu", std::fs::read(format!("{data}/{file}")).unwrap());
    let toml = format!(
        "title = 'Foreign'\n[mesh]\nx = {{ from = '0 m', to = '8.5 m', cells = 30 }}\ny = {{ from = '0 m', to = '2 m', cells = 7 }}\n\
         z = {{ from = '-3 m', to = '0 m', cells = 9 }}\n[time]\nend = '10 day'\nsteps = 1\n[[material]]\nname = 'rock'\nyoung = '1 GPa'\npoisson = 0.25\n\
         pore_pressure = {{ fields = [['0 day', 'none.vtu'], ['10 day', 'own.vtu']], array = '{array}', unit = 'bar', within = '20 m' }}\n\
         [[boundary]]\nside = 'z-'\nhold = 'fixed'\n"
    );
    folder.read(&toml)?.build().map_err(|e| e.to_string())
}

/// Pressures of elements against those of the cells that hold their centres, and against those of the nearest points.
fn holds(file: &str) {
    let points: Vec<[f64; 3]> = (0..120)
        .map(|n| {
            let [x, y, z] = [LINES[0][n % 6], LINES[1][n / 6 % 5], LINES[2][n / 30]];
            [x, y, z + 0.2 * x]
        })
        .collect();
    for array in ["pressure", "p_point"] {
        let body = build(file, array).unwrap();
        let field = &body.pore_fields[0];
        let mut held = 0;
        for (e, p) in field.elements.iter().zip(field.at(864_000.0).iter()) {
            let nodes = body.mesh.elements[*e as usize].map(|a| body.mesh.nodes[a as usize]);
            let x = [0, 1, 2].map(|d| nodes.iter().map(|x| x[d]).sum::<f64>() / 8.0);
            if array == "p_point" {
                let square = |a: &[f64; 3]| (0..3).map(|d| (a[d] - x[d]).powi(2)).sum::<f64>();
                let least = points.iter().map(square).fold(f64::INFINITY, f64::min);
                let bar = p / 1e5;
                let mut nearest = points.iter().filter(|a| square(a) < least + 1e-9);
                held += 1;
                assert!(nearest.any(|a| (bar - (200.0 + a[0] - 3.0 * a[2])).abs() < 1e-9));
                continue;
            }
            let flat = [x[0], x[1], x[2] - 0.2 * x[0]];
            let on_line = (0..3).any(|d| LINES[d].iter().any(|l| (l - flat[d]).abs() < 1e-9));
            if flat[2] < -4.0 || flat[2] > 0.0 || on_line {
                continue;
            }
            let of = |d: usize| LINES[d].partition_point(|line| *line < flat[d]) - 1;
            let cell = of(0) + 5 * (of(1) + 4 * of(2));
            held += 1;
            let bar = 100.0 + 0.5 * cell as f64;
            assert!((p - 1e5 * bar).abs() < 1e-3, "{file} {x:?}: {p} {bar}");
        }
        assert!(held > 900, "{held}");
    }
}

#[test]
fn files_of_vtk_and_meshio_are_read() {
    let all = std::env::var("FRACAS_VTU").ok().map(|data| {
        let files = std::fs::read_dir(data).unwrap();
        let names = files.map(|file| file.unwrap().file_name().into_string().unwrap());
        let is_read = |name: &String| name.ends_with(".vtu") && !name.contains("lz");
        names.filter(is_read).collect()
    });
    let own = ["meshio", "vtk_binary", "vtk_raw", "vtk_base64"];
    let own = || own.map(|name| format!("{name}.vtu")).to_vec();
    let all: Vec<String> = all.unwrap_or_else(own);
    all.iter().for_each(|file| holds(file));
}

#[test]
fn what_others_compress_is_refused() {
    if std::env::var("FRACAS_VTU").is_ok() {
        return;
    }
    let said = build("vtk_lz4.vtu", "pressure").unwrap_err();
    assert!(
        said.contains("own.vtu is compressed (vtkLZ4DataCompressor), and only zlib is read; save it with zlib or as it is"),
        "{said}"
    );
}
