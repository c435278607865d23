//! Claim: RACP in a balanced unit of tractions gives the solution of a sparse direct solver, displacements and
//! tractions alike, on every scene that carries a load.

use fracas::contact::JumpStabilization;
use fracas::scene::gallery;
use fracas_operators::Preconditioner;
use fracas_solvers::direct::{DirectChoice, Kind};
use fracas_solvers::krylov::{Criteria, Gmres, KrylovMethod, Outcome, System};
use fracas_solvers::saddle::{Racp, SaddleOperator};
use fracas_solvers::{Prepare, Silent};

/// ‖a − b‖/‖b‖; relative to the whole solution where b is a millionth of it: fluid inside a fracture that sticks moves nothing.
fn relative(a: &[f64], b: &[f64], whole: &[f64]) -> f64 {
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    let (size, whole) = (
        norm(&mut b.iter().copied()),
        norm(&mut whole.iter().copied()),
    );
    let size = if size < 1e-6 * whole { whole } else { size };
    norm(&mut a.iter().zip(b).map(|(x, y)| x - y)) / size
}

#[test]
fn racp_and_the_direct_solver_agree_in_both_fields() {
    let mut loaded = 0;
    for entry in gallery() {
        let body = entry.small_scene().unwrap().build().unwrap();
        let blocks = body
            .saddle_blocks(Some(JumpStabilization::default()))
            .unwrap();
        if blocks.rhs().iter().all(|b| *b == 0.0) {
            continue;
        }
        loaded += 1;
        let unit = blocks.traction_unit();
        assert_eq!(unit.log2().fract(), 0.0, "a power of two changes no bits");
        let scaled = blocks.in_traction_unit(unit);
        let (n_u, b) = (scaled.n_u(), scaled.rhs());

        let operator = SaddleOperator::new(&scaled);
        let preconditioner = Racp::default().prepare(&scaled).unwrap();
        let system = System {
            operator: &operator,
            preconditioner: preconditioner.as_ref(),
            rhs: &b,
        };
        let criteria = Criteria {
            relative_tolerance: 1e-9,
            max_iterations: 200,
        };
        let mut x = vec![0.0; b.len()];
        let report = Gmres::default()
            .solve(&system, &criteria, &mut x, &mut Silent)
            .unwrap();
        assert_eq!(report.outcome, Outcome::Converged, "{}", entry.name);

        let matrix = scaled.assembled();
        let solver = DirectChoice::Faer.solver().unwrap();
        let factor = solver
            .analyze(&matrix, Kind::General)
            .unwrap()
            .factor(&matrix)
            .unwrap();
        let mut exact = vec![0.0; b.len()];
        factor.solve(&b, &mut exact, &mut vec![0.0; factor.work_len()]);
        for (field, part) in [("u", 0..n_u), ("t", n_u..b.len())] {
            let error = relative(&x[part.clone()], &exact[part], &exact);
            assert!(
                error < 1e-6,
                "{}: {field} differs by {error:.1e}",
                entry.name
            );
        }
    }
    assert!(loaded >= 5, "only {loaded} scenes carry a load");
}
