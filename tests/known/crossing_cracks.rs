//! Claim: two cracks that cross slide and open as the boundary elements of a full space say, better on a finer mesh, and as their
//! symmetry demands.

use crate::plane_strain::{Piece, pieces, solved, surroundings};
use fracas::analytic::{CrackNetwork, NetworkCrack, Rock, StraightCrack};
use fracas::contact::ContactState;
use fracas::scene::{Body, Scene};

/// Two cracks of 2 m through the origin.
#[derive(Clone, Copy, Debug)]
struct Cross {
    /// Their angles to z [deg].
    angles: [f64; 2],
    /// Stress far away (xx, zz) [Pa].
    stress: [f64; 2],
    /// Pressure in each of them [Pa].
    pressures: [f64; 2],
    /// Friction angle [deg].
    friction: f64,
}

/// Unit vector at an angle to z.
fn direction(angle_deg: f64) -> [f64; 2] {
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    [sin, cos]
}

impl Cross {
    /// The same in boundary elements.
    fn reference(&self) -> Vec<NetworkCrack> {
        let crack = |k: usize| {
            let [x, z] = direction(self.angles[k]);
            StraightCrack {
                ends: [[-x, -z], [x, z]],
                friction: self.friction.to_radians().tan(),
                pressure: self.pressures[k],
            }
        };
        let network = CrackNetwork {
            rock: Rock {
                young: 25e9,
                poisson: 0.25,
            },
            stress: [self.stress[0], self.stress[1], 0.0],
            cracks: [0, 1].map(crack).to_vec(),
            elements: 80,
        };
        network.solve()
    }

    /// The grid planes x = 0 and z = 0, the first tilted against z, then all turned; cells of s²/2 at tips and crossing that grow
    /// by e^s towards sides that do not move.
    fn body(&self, s: f64) -> Body {
        let turn = self.angles[1] - 90.0;
        let tilt = self.angles[0] - turn;
        let spans = [tilt.to_radians().cos(), 1.0];
        let axis = |a: f64| {
            format!(
                "{{ from = '-60 m', to = '60 m', near = ['-{a} m', '0 m', '{a} m'], size = '{} m', growth = {} }}",
                0.5 * s * s,
                s.exp()
            )
        };
        let mut toml = format!(
            "title = 'Crossing cracks'\n[mesh]\nx = {}\ny = {{ from = '0 m', to = '0.2 m', cells = 2 }}\nz = {}\n",
            axis(spans[1]),
            axis(spans[0])
        );
        let origin = "['0 m', '0 m', '0 m']";
        if tilt != 0.0 {
            toml += &format!(
                "[mesh.map.incline]\nplane = 'x'\ntilt = '{tilt} deg'\npivot = {origin}\nfade = true\n"
            );
        }
        toml += &format!(
            "[mesh.map.rotate]\naxis = 'y'\nangle = '{turn} deg'\ncenter = {origin}\n[[material]]\nname = 'rock'\nyoung = '25 GPa'\npoisson = 0.25\n"
        );
        for (k, (plane, along)) in [("x", "z"), ("z", "x")].into_iter().enumerate() {
            let (a, p, friction) = (spans[k], self.pressures[k], self.friction);
            toml += &format!(
                "[[fracture]]\nname = 'crack {k}'\nplane = '{plane}'\nat = '0 m'\n{along} = ['-{a} m', '{a} m']\nfriction_angle = '{friction} deg'\npressure = '{p} Pa'\n"
            );
        }
        toml += &surroundings(self.stress, "");
        let scene = Scene::from_toml(&toml, "crossing.toml").unwrap();
        scene.build().unwrap()
    }

    fn found(&self, s: f64) -> Found {
        let body = self.body(s);
        let solution = solved(&body);
        Found([0, 1].map(|c: usize| pieces(&body, &solution, c, direction(self.angles[c]))))
    }
}

/// Faces of both cracks.
struct Found([Vec<Piece>; 2]);

impl Found {
    fn all(&self) -> impl Iterator<Item = &Piece> {
        self.0.iter().flatten()
    }

    fn all_are(&self, state: ContactState) -> bool {
        self.all().all(|p| p.state == state)
    }

    /// Error in L2 of opening (0) or slip (1) over both cracks, relative to all jumps.
    fn jump_error(&self, exact: &[NetworkCrack], k: usize) -> f64 {
        let (mut error, mut size) = (0.0, 0.0);
        for (faces, crack) in self.0.iter().zip(exact) {
            for piece in faces {
                let truth = crack.mean_jump(piece.span[0], piece.span[1]);
                error += piece.area * (piece.jump[k] - truth[k]).powi(2);
                size += piece.area * (truth[0] * truth[0] + truth[1] * truth[1]);
            }
        }
        (error / size).sqrt()
    }

    /// Error in L2 of the normal traction where |s| ≤ 0.8, relative to it.
    fn normal_error(&self, exact: &[NetworkCrack]) -> f64 {
        let (mut error, mut size) = (0.0, 0.0);
        for (faces, crack) in self.0.iter().zip(exact) {
            for piece in faces.iter().filter(|p| p.middle().abs() <= 0.8) {
                let element = crack.ends.partition_point(|end| *end <= piece.middle()) - 1;
                let truth = crack.traction[element][0];
                error += piece.area * (piece.traction[0] - truth).powi(2);
                size += piece.area * truth * truth;
            }
        }
        (error / size).sqrt()
    }

    /// Largest difference of a traction in size from a value where |s| ≤ 0.8, relative to it.
    fn traction_error(&self, k: usize, exact: f64) -> f64 {
        let inner = self.all().filter(|p| p.middle().abs() <= 0.8);
        inner.fold(0.0, |m: f64, p| {
            m.max((p.traction[k].abs() / exact - 1.0).abs())
        })
    }

    /// Largest difference of the jumps of faces that are images of each other, relative to the largest jump; an image has the
    /// opening and `sign` times the slip.
    fn asymmetry(&self, image: impl Fn(usize, f64) -> (usize, f64), sign: f64) -> f64 {
        let (mut worst, mut largest) = (0.0f64, 0.0f64);
        for (c, faces) in self.0.iter().enumerate() {
            for piece in faces {
                let (other, at) = image(c, piece.middle());
                let distance = |p: &Piece| (p.middle() - at).abs();
                let twin = self.0[other].iter();
                let twin = twin.min_by(|a, b| distance(a).total_cmp(&distance(b)));
                let twin = twin.unwrap();
                assert!(distance(twin) < 1e-9);
                let [opening, slip] = piece.jump;
                worst = worst.max((opening - twin.jump[0]).abs());
                worst = worst.max((slip - sign * twin.jump[1]).abs());
                largest = largest.max(opening.abs()).max(slip.abs());
            }
        }
        worst / largest
    }
}

/// Steps of a coarse mesh and of a fine one: second order makes (0.42/0.3)² = 1.96 between their errors.
const STEPS: [f64; 2] = [0.42, 0.3];

#[test]
fn a_cross_under_pressure_opens_as_its_reference() {
    let cross = Cross {
        angles: [0.0, 90.0],
        stress: [0.0; 2],
        pressures: [2e6; 2],
        friction: 30.0,
    };
    let exact = cross.reference();
    let errors = STEPS.map(|s| {
        let found = cross.found(s);
        assert!(found.all_are(ContactState::Open));
        let turned = found.asymmetry(|c, s| (1 - c, s), 1.0);
        let mirrored = found.asymmetry(|c, s| (c, -s), -1.0);
        assert!(turned < 1e-9 && mirrored < 1e-9, "{turned:e} {mirrored:e}");
        found.jump_error(&exact, 0)
    });
    println!("cross under pressure: opening {errors:.4?}");
    assert!(
        errors[1] < 0.048 && errors[0] / errors[1] > 1.5,
        "{errors:?}"
    );
}

#[test]
fn a_cross_at_45_degrees_keeps_its_normal_traction_and_slides_in_mirror_images() {
    let cross = Cross {
        angles: [-45.0, 45.0],
        stress: [0.0, -100e6],
        pressures: [0.0; 2],
        friction: 20.0,
    };
    let exact = cross.reference();
    let errors = STEPS.map(|s| {
        let found = cross.found(s);
        assert!(found.all_are(ContactState::Slip));
        let mirrored = found.asymmetry(|c, s| (1 - c, s), -1.0);
        let turned = found.asymmetry(|c, s| (c, -s), 1.0);
        assert!(turned < 1e-9 && mirrored < 1e-9, "{turned:e} {mirrored:e}");
        // slip of one crack, even in s, leaves the normal traction of one at right angles to it alone
        let normal = found.traction_error(0, 50e6);
        let shear = found.traction_error(1, 50e6 * 20f64.to_radians().tan());
        assert!(normal < 1e-9 && shear < 1e-9, "{normal:e} {shear:e}");
        found.jump_error(&exact, 1)
    });
    println!("cross at 45 deg: slip {errors:.4?}");
    assert!(
        errors[1] < 0.066 && errors[0] / errors[1] > 1.5,
        "{errors:?}"
    );
}

#[test]
fn an_oblique_cross_slides_as_its_reference() {
    for (angle, bounds) in [(30.0, [0.081, 0.011]), (55.0, [0.063, 0.0024])] {
        let cross = Cross {
            angles: [-angle, angle],
            stress: [-20e6, -100e6],
            pressures: [0.0; 2],
            friction: 20.0,
        };
        let exact = cross.reference();
        let errors = STEPS.map(|s| {
            let found = cross.found(s);
            assert!(found.all_are(ContactState::Slip));
            [found.jump_error(&exact, 1), found.normal_error(&exact)]
        });
        println!("oblique cross, {angle} deg: slip and normal traction {errors:.4?}");
        for k in 0..2 {
            assert!(errors[1][k] < bounds[k], "{angle}: {errors:?}");
            assert!(errors[0][k] / errors[1][k] > 1.5, "{angle}: {errors:?}");
        }
    }
}

#[test]
fn a_crack_under_pressure_opens_and_slides_the_one_that_it_crosses() {
    let cross = Cross {
        angles: [-30.0, 30.0],
        stress: [-4e6, -4e6],
        pressures: [9e6, 0.0],
        friction: 10.0,
    };
    let exact = cross.reference();
    let errors = STEPS.map(|s| {
        let found = cross.found(s);
        assert!(found.0[0].iter().all(|p| p.state == ContactState::Open));
        assert!(found.0[1].iter().all(|p| p.state != ContactState::Open));
        [0, 1].map(|k: usize| found.jump_error(&exact, k))
    });
    println!("one crack opens another: opening and slip {errors:.4?}");
    assert!(errors[1][0] < 0.072 && errors[1][1] < 0.018, "{errors:?}");
    assert!(
        (0..2).all(|k| errors[0][k] / errors[1][k] > 1.5),
        "{errors:?}"
    );
}
