//! Claim: the saddle point without assembled matrices is the assembled one, on every scene of the gallery.

use fracas::contact::JumpStabilization;
use fracas::matrix_free::{MatrixFreeSaddle, PiecesError};
use fracas::scene::gallery;
use fracas_operators::{LinearOperator, laws};
use fracas_solvers::SetupError;
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::saddle::{AugmentationChoice, SaddleOperator, T, U};

#[test]
fn matrix_free_and_assembled_saddle_points_agree_on_every_scene() {
    for entry in gallery() {
        let body = entry.small_scene().unwrap().build().unwrap();
        for stabilization in [None, Some(JumpStabilization::default())] {
            let blocks = body.saddle_blocks(stabilization).unwrap();
            let assembled = SaddleOperator::new(&blocks);
            let free = MatrixFreeSaddle::<f64>::new(&body.stick_system(stabilization)).unwrap();
            laws::check_operator(entry.name, &free, None).unwrap();
            let [n_u, n_t] = [U, T].map(|field| free.layout().length(field));
            // displacements of 1 m beside tractions of the size of the stiffness: both rows matter
            let mut x = laws::probe::<f64>(n_u + n_t, 9);
            x[n_u..].iter_mut().for_each(|t| *t *= 1e10);
            let product = |operator: &dyn LinearOperator<f64>| {
                let mut y = vec![0.0; x.len()];
                operator.apply(&x, &mut y, &mut vec![0.0; operator.work_len()]);
                y
            };
            let (y, z) = (product(&assembled), product(&free));
            for part in [0..n_u, n_u..n_u + n_t] {
                let size = y[part.clone()].iter().fold(0.0, |m: f64, v| m.max(v.abs()));
                for i in part {
                    assert!(
                        (y[i] - z[i]).abs() <= 1e-13 * size,
                        "{} row {i}: {} and {}",
                        entry.name,
                        y[i],
                        z[i]
                    );
                }
            }
        }
        let single = MatrixFreeSaddle::<f32>::new(&body.stick_system(None)).unwrap();
        laws::check_operator(entry.name, &single, None).unwrap();
    }
}

#[test]
fn c_from_the_elements_around_fractures_is_c_of_the_assembled_matrix() {
    let direct = DirectChoice::Faer.solver().unwrap();
    for entry in gallery() {
        let body = entry.small_scene().unwrap().build().unwrap();
        for stabilization in [None, Some(JumpStabilization::default())] {
            let system = body.stick_system(stabilization);
            let blocks = body.saddle_blocks(stabilization).unwrap();
            let size = system.magnitude().unwrap();
            assert_eq!(size.unit, blocks.traction_unit(), "{}", entry.name);
            let blocks = blocks.into_traction_unit(size.unit);
            let free = MatrixFreeSaddle::in_traction_unit(&system, size.unit).unwrap();
            for choice in AugmentationChoice::ALL {
                let pieces = free.augmentation(&system, choice);
                if !choice.is_local() {
                    let refused = matches!(
                        pieces,
                        Err(PiecesError::Setup(SetupError::NotApplicable { .. }))
                    );
                    assert!(refused, "{choice}");
                    continue;
                }
                let (pieces, whole) = (
                    pieces.unwrap(),
                    choice.compute(&blocks, direct.as_ref()).unwrap(),
                );
                assert_eq!(pieces.empty_columns, whole.empty_columns);
                let n = blocks.n_t();
                let product = |c: &dyn LinearOperator<f64>| {
                    let (x, mut y) = (laws::probe::<f64>(n, 4), vec![0.0; n]);
                    c.apply(&x, &mut y, &mut []);
                    y
                };
                for (i, (c, d)) in product(&pieces.matrix)
                    .into_iter()
                    .zip(product(&whole.matrix))
                    .enumerate()
                {
                    assert!(
                        (c - d).abs() <= 1e-14 * d.abs(),
                        "{} {choice} row {i}: {c} and {d}",
                        entry.name
                    );
                }
            }
        }
    }
}

#[test]
fn loads_and_scales_without_a_matrix_are_those_of_the_blocks() {
    for entry in gallery() {
        let body = entry.small_scene().unwrap().build().unwrap();
        let system = body.stick_system(Some(JumpStabilization::default()));
        let blocks = body.saddle_blocks(system.stabilization).unwrap();
        let size = system.magnitude().unwrap();
        let blocks = blocks.into_traction_unit(size.unit);
        let free = MatrixFreeSaddle::in_traction_unit(&system, size.unit).unwrap();
        let (b, expected) = (free.rhs(&system, &body.forces().unwrap()), blocks.rhs());
        let largest = expected.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        assert_eq!(b.len(), expected.len());
        for (b, e) in b.iter().zip(&expected) {
            assert!((b - e).abs() <= 1e-14 * largest, "{}", entry.name);
        }
        let row = free.norm_inf_from_below(size.stiffest);
        let norm = blocks.norm_inf();
        assert!(
            row <= norm * (1.0 + 1e-12) && row > 0.3 * norm,
            "{}: {row} of {norm}",
            entry.name
        );
        let x: Vec<f64> = laws::probe(b.len(), 5);
        let n_u = blocks.n_u();
        let mut jumps: Vec<f64> = blocks.rhs_t.iter().map(|b| b.abs()).collect();
        for (row, u) in blocks.b1.outer_iterator().zip(&x[..n_u]) {
            row.iter().for_each(|(j, b)| jumps[j] += (b * u).abs());
        }
        for (scale, e) in free.contact_scale(&x, &b).into_iter().zip(jumps) {
            assert!((scale - e).abs() <= 1e-13 * e, "{}", entry.name);
        }
    }
}
