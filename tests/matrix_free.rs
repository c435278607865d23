//! Claim: the saddle point without assembled matrices is the assembled one, on every scene of the gallery.
#![allow(clippy::unwrap_used)]

use fracas::contact::JumpStabilization;
use fracas::matrix_free::MatrixFreeSaddle;
use fracas::scene::gallery;
use fracas_operators::{LinearOperator, laws};
use fracas_solvers::saddle::SaddleOperator;

#[test]
fn matrix_free_and_assembled_saddle_points_agree_on_every_scene() {
    for entry in gallery() {
        let body = entry.small_scene().unwrap().build().unwrap();
        for stabilization in [None, Some(JumpStabilization::default())] {
            let blocks = body.saddle_blocks(stabilization).unwrap();
            let assembled = SaddleOperator::new(&blocks);
            let free = MatrixFreeSaddle::<f64>::new(&body.stick_system(stabilization)).unwrap();
            let free = free.operator();
            laws::check_operator(entry.name, &free, None).unwrap();
            let [n_u, n_t] = free.layout().lengths;
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
        laws::check_operator(entry.name, &single.operator(), None).unwrap();
    }
}
