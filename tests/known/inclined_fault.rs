//! Claim: depletion loads and slips a displaced fault of 60° dip as a plane of a full space whose tractions are known,
//! whichever side was thrown down.

use crate::graded::growing;
use crate::plane_strain::{Piece, pieces, solved};
use fracas::analytic::{Depletion, FaultFriction, Rock, Strength};
use fracas::contact::ContactState;
use fracas::scene::Scene;
use std::fmt::Write;

/// Half the width and height of the box [m].
const WIDTH: f64 = 5000.0;

/// Isotropic stress before depletion, compression [Pa].
const PRESSED: f64 = 60e6;

/// Reservoirs 300 m thick: [bottom, top] to the left of the fault and to the right of it [m].
type Blocks = [[f64; 2]; 2];

/// The right one 100 m higher, and 100 m lower.
const THROWS: [Blocks; 2] = [
    [[-200.0, 100.0], [-100.0, 200.0]],
    [[-100.0, 200.0], [-200.0, 100.0]],
];

/// One fault in one mesh.
#[derive(Clone, Copy, Debug)]
struct Case {
    /// Height of a cell beside the fault [m].
    cell: f64,
    blocks: Blocks,
    /// Change of the pressure in the reservoirs [Pa].
    change: f64,
    /// Friction angle [deg].
    friction: f64,
}

/// Tangent of the fault, upwards.
fn tangent() -> [f64; 2] {
    let (sin, cos) = 60f64.to_radians().sin_cos();
    [cos, sin]
}

/// Lines from −WIDTH to WIDTH, `cell` apart within ± `core`, as a list of TOML.
fn axis(core: f64, cell: f64) -> String {
    let out = growing(core, cell, WIDTH);
    let n = (2.0 * core / cell).round() as usize;
    let inner = (0..=n).map(|i| -core + cell * i as f64);
    let lower = out.iter().rev().map(|x| -x);
    let all = lower.chain(inner).chain(out.iter().copied());
    let quoted: Vec<String> = all.map(|v| format!("'{v} m'")).collect();
    quoted.join(", ")
}

fn scene(case: &Case) -> String {
    let (cell, change, friction) = (case.cell, case.change, case.friction);
    let mut toml = format!(
        "title = 'Displaced fault of 60 deg dip'\n[mesh]\nx = {{ lines = [{}] }}\ny = {{ from = '0 m', to = '{cell} m', cells = 2 }}\nz = {{ lines = [{}] }}\n",
        axis(0.0, cell),
        axis(300.0, cell)
    );
    toml += "[mesh.map.incline]\nplane = 'x'\ndip = '60 deg'\npivot = ['0 m', '0 m', '0 m']\nfade = true\n";
    let elastic = "young = '14.95 GPa'\npoisson = 0.15\n";
    let _ = writeln!(toml, "[[material]]\nname = 'rock'\n{elastic}");
    for (k, [bottom, top]) in case.blocks.into_iter().enumerate() {
        let (from, to) = [(-WIDTH, 0.0), (0.0, WIDTH)][k];
        let _ = writeln!(
            toml,
            "[[material]]\nname = 'block {k}'\n{elastic}boxes = [{{ x = ['{from} m', '{to} m'], z = ['{bottom} m', '{top} m'] }}]\npressure_change = '{change} Pa'\nbiot = 0.9",
        );
    }
    let _ = writeln!(
        toml,
        "[[fracture]]\nname = 'fault'\nplane = 'x'\nat = '0 m'\nfriction_angle = '{friction} deg'\n[initial_stress]\nconstant = {{ xx = '-{PRESSED} Pa', yy = '-{PRESSED} Pa', zz = '-{PRESSED} Pa' }}"
    );
    for side in ["x-", "x+", "y-", "y+", "z-"] {
        let _ = writeln!(toml, "[[boundary]]\nside = '{side}'\nhold = 'roller'");
    }
    let _ = writeln!(toml, "[[boundary]]\nside = 'z+'\npressure = '{PRESSED} Pa'");
    toml + "[solver]\nracp = { augmentation = 'local_h', inner = { amg = {} } }\n"
}

/// Faces of one row in y, upwards.
fn on_fault(case: &Case) -> Vec<Piece> {
    let scene = Scene::from_toml(&scene(case), "fault.toml").unwrap();
    let body = scene.build().unwrap();
    let all = pieces(&body, &solved(&body), 0, tangent());
    all.into_iter().step_by(2).collect()
}

/// Width of the reservoirs of the full space: rollers on the sides of the box make them endless, and ends 20 km away would still
/// add 0.06 MPa [m].
const FAR: f64 = 1e7;

/// (σ_N, τ) of the stuck fault at a distance from its middle, upwards [Pa].
fn stuck(case: &Case, s: f64) -> [f64; 2] {
    let t = tangent();
    let n = [-t[1], t[0]];
    let on = |z: f64| [z * t[0] / t[1], z];
    let [[a, b], [c, d]] = case.blocks;
    let polygons = [
        vec![[-FAR, a], on(a), on(b), [-FAR, b]],
        vec![on(c), [FAR, c], [FAR, d], on(d)],
    ];
    let depletion = Depletion {
        poisson: 0.15,
        biot: 0.9,
        pressure_change: case.change,
    };
    // tractions are the same on both sides of the fault, stresses are not
    let x = [s * t[0] + 1e-6 * n[0], s * t[1] + 1e-6 * n[1]];
    let [xx, zz, xz] = depletion.stress_change(&polygons, x);
    let traction = [xx * n[0] + xz * n[1], xz * n[0] + zz * n[1]];
    [
        traction[0] * n[0] + traction[1] * n[1] - PRESSED,
        traction[0] * t[0] + traction[1] * t[1],
    ]
}

/// Distance of a face from the nearest corner of a block, in height [m].
fn from_corner(piece: &Piece) -> f64 {
    let z = piece.middle() * tangent()[1];
    let corners = THROWS[0].as_flattened();
    corners
        .iter()
        .fold(f64::INFINITY, |m, c| m.min((z - c).abs()))
}

#[test]
fn a_stuck_fault_carries_the_known_tractions() {
    // bounds of the errors of normal and shear traction: those of a vertical fault in cubes are 0.006 and 0.044
    for (blocks, bounds) in THROWS.into_iter().zip([[0.01, 0.02], [0.009, 0.042]]) {
        let case = Case {
            cell: 20.0,
            blocks,
            change: -20e6,
            friction: 60.0,
        };
        let (mut errors, mut sizes, mut count) = ([0.0; 2], [0.0; 2], 0);
        for piece in &on_fault(&case) {
            // shear is log-singular at the corners
            if piece.middle().abs() > 400.0 || from_corner(piece) < 1.1 * case.cell {
                continue;
            }
            let [normal, shear] = stuck(&case, piece.middle());
            let pairs = [
                (piece.traction[0] + PRESSED, normal + PRESSED),
                (piece.traction[1], shear),
            ];
            for (k, (found, exact)) in pairs.into_iter().enumerate() {
                errors[k] += (found - exact).powi(2);
                sizes[k] += exact * exact;
            }
            count += 1;
        }
        assert!(count > 15, "{count}");
        let errors = [0, 1].map(|k: usize| (errors[k] / sizes[k]).sqrt());
        println!("tractions of the stuck fault: {errors:.4?} on {count} faces");
        assert!(
            errors[0] < bounds[0] && errors[1] < bounds[1],
            "{case:?}: {errors:?}"
        );
    }
}

/// Ends of elements of the plane of a full space, and their slip under the tractions of the stuck fault.
fn reference(case: &Case) -> (Vec<f64>, Vec<f64>) {
    let (n, half) = (400, 500.0);
    let ends: Vec<f64> = (0..=n)
        .map(|k| -half + 2.0 * half * f64::from(k) / f64::from(n))
        .collect();
    let tractions: Vec<[f64; 2]> = ends
        .windows(2)
        .map(|e| stuck(case, 0.5 * (e[0] + e[1])))
        .collect();
    let friction = case.friction.to_radians().tan();
    let rock = Rock {
        young: 14.95e9,
        poisson: 0.15,
    };
    let shear: Vec<f64> = tractions.iter().map(|t| t[1]).collect();
    let limit = |t: &[f64; 2]| Strength::constant(-t[0] * friction);
    let limits: Vec<Strength> = tractions.iter().map(limit).collect();
    let plane = FaultFriction::new(rock, tractions.len(), ends[1] - ends[0]);
    (ends, plane.slip(&shear, &limits).unwrap())
}

/// Relative errors of the slip in L2, of its integral and of its peak, and that peak [m].
fn slip_errors(case: &Case) -> ([f64; 3], f64) {
    let (ends, slip) = reference(case);
    let tip = slip[0].abs().max(slip[slip.len() - 1].abs());
    assert!(tip < 1e-9, "slip ends within the plane: {tip} m");
    let faces = on_fault(case);
    let slipping = faces.iter().filter(|p| p.state == ContactState::Slip);
    assert!(slipping.count() > 5, "friction gives way at the reservoirs");
    let (mut error, mut size, mut total, mut sum) = (0.0, 0.0, 0.0, 0.0);
    let (mut peak, mut found) = (0.0f64, 0.0f64);
    for piece in faces {
        if piece.middle().abs() > 450.0 {
            assert_eq!(piece.state, ContactState::Stick, "{piece:?}");
            continue;
        }
        let [from, to] = piece.span;
        let common = |e: &[f64]| (e[1].min(to) - e[0].max(from)).max(0.0);
        let over = ends.windows(2).zip(&slip);
        let exact: f64 = over.map(|(e, d)| common(e) * d).sum::<f64>() / (to - from);
        error += piece.area * (piece.jump[1] - exact).powi(2);
        size += piece.area * exact * exact;
        total += piece.area * (piece.jump[1] - exact);
        sum += piece.area * exact;
        peak = peak.max(exact.abs());
        found = found.max(piece.jump[1].abs());
    }
    let relative = [
        (error / size).sqrt(),
        (total / sum).abs(),
        (found / peak - 1.0).abs(),
    ];
    (relative, peak)
}

#[test]
fn friction_slips_an_inclined_fault_as_the_plane_in_a_full_space() {
    let [up, down] = THROWS;
    // cell [m], throw, change of pressure [Pa], friction angle [deg]; bound of the three errors
    for (cell, blocks, change, friction, bound) in [
        (20.0, up, -20e6, 3.0, 0.02),
        (20.0, up, -20e6, 5.0, 0.02),
        (20.0, up, 20e6, 5.0, 0.036),
        (20.0, down, -20e6, 2.0, 0.035),
        (10.0, down, -20e6, 2.0, 0.015),
    ] {
        let case = Case {
            cell,
            blocks,
            change,
            friction,
        };
        let (errors, peak) = slip_errors(&case);
        println!("{case:?}: slip {errors:.4?}, peak {peak:.5} m");
        assert!(errors.iter().all(|e| *e < bound), "{case:?}: {errors:?}");
    }
}
