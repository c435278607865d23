//! Claim: an element takes the pressure of the cell that holds it, exact where cells are those of the mesh, however they grow and whichever are left
//! out; linear values between their centres are there for the asking.

use crate::pore_pressure::Folder;
use fracas::io::vtu::{Cells, Field, Grid};
use fracas::scene::Body;
use fracas_operators::random::Random;

/// Lines that grow by random factors.
fn graded(r: &mut Random) -> Vec<f64> {
    let mut lines = vec![r.between(-2.0, 2.0)];
    for k in 0..2 + r.below(4) {
        // millimetres that text keeps
        lines.push(((lines[k] + r.scale(0.05, 5.0)) * 1e3).round() / 1e3);
    }
    lines
}

/// The same with more lines between them.
fn finer(r: &mut Random, lines: &[f64]) -> Vec<f64> {
    let mut all = lines.to_vec();
    for pair in lines.windows(2) {
        for share in [r.between(0.05, 0.45), r.between(0.55, 0.95)] {
            if r.chance(0.6) {
                all.push(pair[0] + share * (pair[1] - pair[0]));
            }
        }
    }
    all.sort_by(f64::total_cmp);
    all
}

/// Cells between lines, those that `is_there` admits, with a pressure each.
fn cells(
    lines: &[Vec<f64>; 3],
    is_there: impl Fn(usize) -> bool,
    pressure: impl Fn(usize) -> f64,
) -> Vec<u8> {
    let n = [0, 1, 2].map(|d: usize| lines[d].len());
    let mut points = Vec::new();
    for z in &lines[2] {
        for y in &lines[1] {
            points.extend(lines[0].iter().map(|x| [*x, *y, *z]));
        }
    }
    let at = |i: usize, j: usize, k: usize| (i + n[0] * (j + n[1] * k)) as u32;
    let (mut hexahedra, mut values) = (Vec::new(), Vec::new());
    let all = (n[0] - 1) * (n[1] - 1) * (n[2] - 1);
    for cell in (0..all).filter(|cell| is_there(*cell)) {
        let (i, j, k) = (
            cell % (n[0] - 1),
            cell / (n[0] - 1) % (n[1] - 1),
            cell / (n[0] - 1) / (n[1] - 1),
        );
        let ring = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
        let level = |k: usize| ring.map(|(i, j)| at(i, j, k));
        let [[a, b, c, d], [e, f, g, h]] = [level(k), level(k + 1)];
        hexahedra.push([a, b, c, d, e, f, g, h]);
        values.push(pressure(cell));
    }
    let grid = Grid {
        points: &points,
        cells: Cells::Hexahedra(&hexahedra),
        point_fields: Vec::new(),
        cell_fields: vec![Field {
            name: "pressure",
            components: 1,
            values: &values,
        }],
    };
    let mut bytes = Vec::new();
    grid.write(&mut bytes).unwrap();
    bytes
}

fn scene(lines: &[Vec<f64>; 3], more: &str) -> String {
    let axis = |d: usize| {
        let all: Vec<String> = lines[d].iter().map(|x| format!("'{x} m'")).collect();
        format!(
            "{} = {{ lines = [{}] }}\n",
            ["x", "y", "z"][d],
            all.join(", ")
        )
    };
    format!(
        "title = 'Cells'\n[mesh]\n{}{}{}[time]\nend = '10 day'\nsteps = 2\n[[material]]\nname = 'rock'\nyoung = '1 GPa'\npoisson = 0.25\n\
         pore_pressure = {{ fields = [['0 day', 'a.vtu'], ['10 day', 'b.vtu']], unit = 'bar'{more} }}\n\
         [[boundary]]\nside = 'z-'\nhold = 'fixed'\n",
        axis(0),
        axis(1),
        axis(2)
    )
}

fn changes(body: &Body) -> Vec<([f64; 3], f64)> {
    let field = &body.pore_fields[0];
    let found = field.at(864_000.0);
    let elements = field.elements.iter().zip(found.iter());
    let of = |(e, p): (&u32, &f64)| {
        let nodes = body.mesh.elements[*e as usize].map(|a| body.mesh.nodes[a as usize]);
        let center = [0, 1, 2].map(|d| nodes.iter().map(|x| x[d]).sum::<f64>() / 8.0);
        (center, *p)
    };
    elements.map(of).collect()
}

#[test]
fn constant_pressures_of_cells_are_exact_on_a_mesh_of_their_lines() {
    let (mut misled, mut left_out) = (0, 0);
    for seed in 0..40 {
        let r = &mut Random::new(seed);
        let lines = [0; 3].map(|_| graded(r));
        let all = lines.iter().map(|own| own.len() - 1).product();
        let bars: Vec<f64> = (0..all).map(|_| r.between(0.0, 300.0)).collect();
        let inactive: Vec<bool> = (0..all).map(|_| seed % 2 == 0 && r.chance(0.15)).collect();
        let folder = Folder::empty(&format!("cells-{seed}"));
        let is_there = |cell: usize| !inactive[cell];
        folder.write("a.vtu", cells(&lines, is_there, |_| 310.0));
        folder.write("b.vtu", cells(&lines, is_there, |cell| bars[cell]));
        let mesh = [0, 1, 2].map(|d: usize| finer(r, &lines[d]));
        let asked = ["", ", interpolation = 'nearest'"][seed as usize % 3 % 2];
        let toml = scene(&mesh, &format!("{asked}, within = '9 m'"));
        let body = folder.read(&toml).unwrap().build().unwrap();
        for (x, p) in changes(&body) {
            let of = |d: usize| lines[d].partition_point(|line| *line < x[d]) - 1;
            let n = [0, 1].map(|d: usize| lines[d].len() - 1);
            let cell = of(0) + n[0] * (of(1) + n[1] * of(2));
            if inactive[cell] {
                left_out += 1;
                continue;
            }
            let expected = 1e5 * (bars[cell] - 310.0);
            assert!(
                (p - expected).abs() < 1e-6,
                "seed {seed} {x:?}: {p} {expected}"
            );
            // a neighbour along an axis has the nearer centre
            misled += usize::from((0..3).any(|d| {
                let (k, lines) = (of(d), &lines[d]);
                let middle = |k: usize| 0.5 * (lines[k] + lines[k + 1]);
                let beside = [
                    k.checked_sub(1),
                    Some(k + 1).filter(|k| k + 1 < lines.len()),
                ];
                let mut beside = beside.into_iter().flatten();
                beside.any(|other| (middle(other) - x[d]).abs() < (middle(k) - x[d]).abs())
            }));
        }
    }
    assert!(misled > 300 && left_out > 100, "{misled} {left_out}");
}

#[test]
fn linear_values_between_centres_are_there_for_the_asking() {
    let folder = Folder::empty("cells-linear");
    let r = &mut Random::new(3);
    let lines = [0; 3].map(|_| graded(r));
    let middles = [0, 1, 2].map(|d: usize| -> Vec<f64> {
        let pairs = lines[d].windows(2);
        pairs.map(|pair| 0.5 * (pair[0] + pair[1])).collect()
    });
    let n = [0, 1].map(|d: usize| middles[d].len());
    let bar = |x: [f64; 3]| 100.0 + 2.0 * x[0] - 3.0 * x[1] + 4.0 * x[2];
    let center = |cell: usize| {
        let [i, j, k] = [cell % n[0], cell / n[0] % n[1], cell / n[0] / n[1]];
        [middles[0][i], middles[1][j], middles[2][k]]
    };
    folder.write("a.vtu", cells(&lines, |_| true, |_| 100.0));
    folder.write("b.vtu", cells(&lines, |_| true, |cell| bar(center(cell))));
    let toml = scene(&lines, ", interpolation = 'linear'");
    let mesh = [0, 1, 2].map(|d: usize| finer(r, &lines[d]));
    let [own, fine] = [&toml, &scene(&mesh, ", interpolation = 'linear'")].map(|toml| {
        let body = folder.read(toml).unwrap().build().unwrap();
        let text = body.pore_fields[0].to_string();
        assert!(
            text.contains("the linear value between points of a lattice"),
            "{text}"
        );
        changes(&body)
    });
    let inside = |x: &[f64; 3]| {
        (0..3).all(|d| middles[d][0] <= x[d] && x[d] <= middles[d][middles[d].len() - 1])
    };
    let mut between = 0;
    for (x, p) in own.iter().chain(&fine).filter(|(x, _)| inside(x)) {
        between += 1;
        assert!((p - 1e5 * (bar(*x) - 100.0)).abs() < 1e-5, "{x:?} {p}");
    }
    assert!(between > own.len());
    // a cell less is no lattice
    folder.write(
        "b.vtu",
        cells(&lines, |cell| cell != 1, |cell| bar(center(cell))),
    );
    let text = folder.read(&toml).unwrap().build().unwrap_err().to_string();
    assert!(
        text.contains("b.vtu: `interpolation = \"linear\"` needs a full lattice, and the centres of its cells ("),
        "{text}"
    );
    let text = folder
        .read(&toml.replace("'linear'", "'cubic'"))
        .unwrap_err();
    assert!(text.contains("unknown value `cubic`"), "{text}");
    let text = folder.read(&toml.replace(
        "fields = [['0 day', 'a.vtu'], ['10 day', 'b.vtu']], unit = 'bar'",
        "points = [['0 day', '1 bar']]",
    ));
    assert!(
        text.unwrap_err()
            .contains("has no effect without `fields` or `grid`")
    );
}
