use super::*;

const FAR_SIDES: [FarSide; 3] = [FarSide::Closed, FarSide::Held, FarSide::Driven];

fn layer(far: FarSide) -> Diffusion {
    Diffusion {
        thickness: 40.0,
        diffusivity: 3e-7,
        far,
    }
}

/// Time in which `κ t/L²` becomes `t`.
fn time(layer: &Diffusion, t: f64) -> f64 {
    t * layer.length() * layer.length() / layer.diffusivity
}

#[test]
fn images_and_sines_are_one_function() {
    for far in FAR_SIDES {
        let own = layer(far);
        for t in [0.02, 0.08, 0.15, 0.3, 0.6] {
            for ends in [
                [0.0, 0.1],
                [0.0, 1.0],
                [0.3, 0.35],
                [0.8, 1.0],
                [0.5, 0.5001],
            ] {
                let [a, b] = [
                    own.images(Drive::Step, ends, t) - own.sines(Drive::Step, ends, t),
                    own.images(Drive::Ramp, ends, t) - own.sines(Drive::Ramp, ends, t),
                ];
                assert!(
                    a.abs() < 1e-11 && b.abs() < 1e-11,
                    "{far:?} {t} {ends:?}: {a:e} {b:e}"
                );
            }
        }
    }
}

#[test]
fn means_of_parts_are_that_of_the_whole() {
    for far in FAR_SIDES {
        let own = layer(far);
        for t in [1e-6, 1e-3, 0.1, 0.2, 3.0] {
            let time = time(&own, t);
            let cuts = [0.0, 1.0, 7.5, 21.0, 28.0, 40.0];
            for of in [Diffusion::step, Diffusion::ramp] {
                let whole = of(&own, [0.0, 40.0], time);
                let parts = cuts
                    .windows(2)
                    .map(|c| (c[1] - c[0]) / 40.0 * of(&own, [c[0], c[1]], time));
                let sum: f64 = parts.sum();
                assert!(
                    (sum - whole).abs() < 1e-13 * time.max(1.0),
                    "{far:?} {t}: {sum} {whole}"
                );
            }
        }
    }
}

#[test]
fn a_ramp_is_the_integral_of_steps() {
    for far in FAR_SIDES {
        let own = layer(far);
        for t in [0.01, 0.5] {
            let (ends, end, n) = ([4.0, 9.0], time(&own, t), 4000);
            // the midpoint rule in s = √τ, as a step begins like √t
            let h = end.sqrt() / f64::from(n);
            let steps = (0..n).map(|k| {
                let s = h * (f64::from(k) + 0.5);
                2.0 * s * h * own.step(ends, s * s)
            });
            let (sum, ramp): (f64, f64) = (steps.sum(), own.ramp(ends, end));
            assert!(
                (sum - ramp).abs() < 1e-6 * ramp,
                "{far:?} {t}: {sum} {ramp}"
            );
        }
    }
}

#[test]
fn late_and_steady() {
    let ends = [10.0, 14.0];
    for (far, steady) in [
        (FarSide::Closed, 1.0),
        (FarSide::Held, 0.7),
        (FarSide::Driven, 1.0),
    ] {
        let own = layer(far);
        let end = time(&own, 50.0);
        assert!((own.step(ends, end) - steady).abs() < 1e-14, "{far:?}");
        // a steady ramp rises as fast as the face, or its share
        let rise = (own.ramp(ends, 2.0 * end) - own.ramp(ends, end)) / end;
        assert!((rise - steady).abs() < 1e-12, "{far:?}: {rise}");
        assert_eq!([own.step(ends, 0.0), own.ramp(ends, -1.0)], [0.0; 2]);
    }
}

/// Implicit midpoint in time, finite volumes in space: means of cells after a ramp of 1 per unit of time.
fn volumes(far: FarSide, cells: usize, steps: usize, end: f64) -> Vec<f64> {
    let (h, dt) = (1.0 / cells as f64, end / steps as f64);
    let r = dt / (h * h);
    let mut p = vec![0.0; cells];
    let ends = [true, far != FarSide::Closed];
    for n in 0..steps {
        let face = (n as f64 + 0.5) * dt;
        let faces = [face, if far == FarSide::Driven { face } else { 0.0 }];
        // (1 − dt/2 L) p' = (1 + dt/2 L) p + dt b
        let of = |p: &[f64], k: usize| {
            let low = match k {
                0 if ends[0] => 2.0 * (faces[0] - p[0]),
                0 => 0.0,
                k => p[k - 1] - p[k],
            };
            let high = match k {
                k if k + 1 < cells => p[k + 1] - p[k],
                _ if ends[1] => 2.0 * (faces[1] - p[k]),
                _ => 0.0,
            };
            low + high
        };
        let mut b: Vec<f64> = (0..cells).map(|k| p[k] + 0.5 * r * of(&p, k)).collect();
        if ends[0] {
            b[0] += r * faces[0];
        }
        if ends[1] {
            b[cells - 1] += r * faces[1];
        }
        let mut main: Vec<f64> = (0..cells)
            .map(|k| {
                let low = if k == 0 {
                    2.0 * f64::from(u8::from(ends[0]))
                } else {
                    1.0
                };
                let high = if k + 1 == cells {
                    2.0 * f64::from(u8::from(ends[1]))
                } else {
                    1.0
                };
                1.0 + 0.5 * r * (low + high)
            })
            .collect();
        for k in 1..cells {
            let w = -0.5 * r / main[k - 1];
            main[k] -= w * -0.5 * r;
            b[k] -= w * b[k - 1];
        }
        p[cells - 1] = b[cells - 1] / main[cells - 1];
        for k in (0..cells - 1).rev() {
            p[k] = (b[k] + 0.5 * r * p[k + 1]) / main[k];
        }
    }
    p
}

#[test]
fn a_ramp_is_that_of_fine_volumes() {
    for far in FAR_SIDES {
        let own = Diffusion {
            thickness: 1.0,
            diffusivity: 1.0,
            far,
        };
        for end in [0.02, 0.2, 1.0] {
            let cells = 400;
            let found = volumes(far, cells, 800, end);
            for (k, p) in found.iter().enumerate() {
                let ends = [k, k + 1].map(|k| k as f64 / cells as f64);
                let exact = own.ramp(ends, end);
                assert!(
                    (p - exact).abs() < 0.4 / (cells * cells) as f64,
                    "{far:?} {end} {k}: {p} {exact}"
                );
            }
        }
    }
}
