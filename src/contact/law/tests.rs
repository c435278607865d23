use super::*;
use crate::contact::{SlipSoFar, Weakening, WeakeningBy};

const LAW: FaceLaw = FaceLaw {
    friction: Friction {
        angle: 0.5,
        cohesion: 2e5,
        weakening: None,
    },
    compliance: 3e-10,
    tiny: 1e-9,
};

/// The same, weakening over 4 mm.
const WEAKENING: FaceLaw = FaceLaw {
    friction: Friction {
        weakening: Some(Weakening {
            angle: 0.3,
            distance: 4e-3,
            by: WeakeningBy::Slip,
        }),
        ..LAW.friction
    },
    ..LAW
};

/// The residual with the direction of slip frozen at `at`, which is what new-slip and tiny slip differentiate.
fn frozen(law: &FaceLaw, state: ContactState, at: &FacePoint, point: &FacePoint) -> [f64; 3] {
    let (m, turning) = law.direction(state, at);
    if turning > 0.0 || !matches!(state, ContactState::NewSlip | ContactState::Slip) {
        return law.rows(state, point).residual;
    }
    let slip = point.start.after([point.jump[1], point.jump[2]]).slip;
    let limit = law.friction.limit(point.traction[0], slip);
    let r_t = |i: usize| law.compliance * (limit * m[i] - point.traction[i]);
    [point.jump[0], r_t(1), r_t(2)]
}

/// Largest difference between the tangent and central differences, relative to the size of each block.
fn tangent_error(law: &FaceLaw, state: ContactState, point: FacePoint) -> f64 {
    let rows = law.rows(state, &point);
    let mut worst: f64 = 0.0;
    for k in 0..3 {
        let steps = [(1e-5 * tangential_norm(point.jump).max(1e-6), 0), (1e2, 1)];
        for (h, which) in steps {
            let moved = |s: f64| {
                let mut p = point;
                let v = if which == 0 {
                    &mut p.jump
                } else {
                    &mut p.traction
                };
                v[k] += s;
                frozen(law, state, &point, &p)
            };
            let (plus, minus) = (moved(h), moved(-h));
            let (exact, scale) = if which == 0 {
                (rows.by_jump, 1.0)
            } else {
                (rows.by_traction, law.compliance)
            };
            for i in 0..3 {
                let difference = (plus[i] - minus[i]) / (2.0 * h);
                worst = worst.max((difference - exact[i][k]).abs() / scale);
            }
        }
    }
    worst
}

#[test]
fn tangents_are_derivatives_in_every_state() {
    let slipping = FacePoint {
        traction: [-4e6, 1.5e6, -0.8e6],
        jump: [1e-5, 2e-3, -1e-3],
        start: SlipSoFar::Vector([3e-4, 2e-4]),
    };
    let tiny = FacePoint {
        jump: [0.0, 3e-10, 4e-10],
        ..slipping
    };
    let no_shear = FacePoint {
        traction: [-4e6, 0.0, 0.0],
        jump: [0.0; 3],
        start: SlipSoFar::Vector([0.0; 2]),
    };
    let sideways = FacePoint {
        jump: [0.0, 1e-4, 0.0],
        traction: [-1e6, 0.0, 5e5],
        start: SlipSoFar::Vector([0.0; 2]),
    };
    let again = FacePoint {
        start: SlipSoFar::Path(1e-3),
        ..slipping
    };
    for state in ContactState::ALL {
        for point in [slipping, tiny, no_shear, sideways, again] {
            for law in [LAW, WEAKENING] {
                let error = tangent_error(&law, state, point);
                assert!(error < 1e-7, "{law:?} {state:?} at {point:?}: {error:e}");
            }
        }
    }
}

#[test]
fn slip_at_the_limit_along_the_slip_has_no_residual() {
    let t_n = -5e6;
    let limit = LAW.friction.limit(t_n, 0.0);
    let point = FacePoint {
        traction: [t_n, 0.6 * limit, -0.8 * limit],
        jump: [0.0, 3e-3, -4e-3],
        start: SlipSoFar::Vector([0.0; 2]),
    };
    for state in [ContactState::Slip, ContactState::NewSlip] {
        let r = LAW.rows(state, &point).residual;
        assert!(r.iter().all(|r| r.abs() < 1e-12 * LAW.compliance * limit));
    }
}

#[test]
fn a_face_without_shear_and_slip_gives_its_traction_back() {
    let point = FacePoint {
        traction: [-4e6, 0.0, 0.0],
        jump: [0.0; 3],
        start: SlipSoFar::Vector([0.0; 2]),
    };
    for state in [ContactState::Slip, ContactState::NewSlip] {
        let rows = LAW.rows(state, &point);
        assert_eq!(rows.residual, [0.0; 3]);
        assert_eq!(rows.by_traction[1], [0.0, -LAW.compliance, 0.0]);
        assert_eq!(rows.by_jump[1], [0.0; 3]);
    }
}

#[test]
fn the_slip_block_resists_turning_and_nothing_along_the_slip() {
    let point = FacePoint {
        traction: [-4e6, 1e6, 1e6],
        jump: [0.0, 3e-4, 4e-4],
        start: SlipSoFar::Vector([0.0; 2]),
    };
    let d = LAW.rows(ContactState::Slip, &point).by_jump;
    let times = |v: [f64; 2]| [1, 2].map(|i: usize| d[i][1] * v[0] + d[i][2] * v[1]);
    let stiffness = LAW.compliance * LAW.friction.limit(-4e6, 0.0) / 5e-4;
    let along = times([0.6, 0.8]);
    let across = times([-0.8, 0.6]);
    assert!(along.iter().all(|v| v.abs() < 1e-14 * stiffness));
    assert!((across[0] + 0.8 * stiffness).abs() < 1e-12 * stiffness);
    assert!((across[1] - 0.6 * stiffness).abs() < 1e-12 * stiffness);
}

#[test]
fn states_keep_their_numbers() {
    for (code, state) in ContactState::ALL.into_iter().enumerate() {
        assert_eq!(usize::from(state.code()), code);
        assert_eq!(ContactState::from_code(state.code()), Some(state));
    }
    assert_eq!(ContactState::from_code(4), None);
}
