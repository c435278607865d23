//! A preconditioner of one's own in `solve`: the lower block triangle with a diagonal Schur complement.
//!
//! `cargo run --release --example own_method`

use fracas::prelude::*;
use fracas_operators::sparse::Csr;
use fracas_operators::{Layout, LinearOperator, Preconditioner, Properties};
use fracas_solvers::direct::{DirectChoice, Factorization, Kind};
use fracas_solvers::saddle::{CustomMethod, T, U};
use fracas_solvers::{Named, SetupError};

/// `y_u = A⁻¹ x_u, y_t = (C_0 + diag H)⁻¹ (B2 y_u − x_t)`, `C_0 = diag(BᵀD⁻¹B)`.
#[derive(Debug)]
struct LowerTriangle;

struct Inverse {
    a: Box<dyn Factorization>,
    b2: Csr<f64>,
    schur: Vec<f64>,
    layout: Layout,
}

impl Named for LowerTriangle {
    fn name(&self) -> &'static str {
        "lower_triangle"
    }
}

impl CustomMethod for LowerTriangle {
    fn prepare(&self, blocks: &SaddleBlocks) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
        let direct = DirectChoice::default().solver()?;
        let a = direct.analyze(&blocks.a, Kind::Spd)?.factor(&blocks.a)?;
        let h = |i| blocks.h.as_ref().and_then(|h| h.get(i, i)).copied();
        let c = blocks.contact_compliance().into_iter().enumerate();
        let schur = c.map(|(i, c)| c + h(i).unwrap_or(0.0)).collect();
        let b2 = Csr::new(blocks.b2_rows());
        let layout = blocks.layout();
        Ok(Box::new(Inverse {
            a,
            b2,
            schur,
            layout,
        }))
    }

    fn takes_flow(&self) -> bool {
        false
    }

    fn takes_local_rows(&self) -> bool {
        false
    }
}

impl Preconditioner<f64> for Inverse {
    fn size(&self) -> usize {
        self.layout.len()
    }

    fn solve(&self, x: &[f64], y: &mut [f64], work: &mut [f64]) {
        let [x_u, x_t] = self.layout.split([U, T], x);
        let [y_u, y_t] = self.layout.split_mut([U, T], y);
        self.a.solve(x_u, y_u, work);
        self.b2.apply(y_u, y_t, &mut []);
        for ((y, x), s) in y_t.iter_mut().zip(x_t).zip(&self.schur) {
            *y = (*y - x) / s;
        }
    }

    fn work_len(&self) -> usize {
        self.a.work_len()
    }

    fn flops(&self) -> u64 {
        self.a.flops() + self.b2.flops() + 2 * self.schur.len() as u64
    }

    fn properties(&self) -> Properties {
        self.a.properties()
    }
}

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    SaddleMethod::register(&LowerTriangle)?;
    let scene = named("clamped")
        .ok_or("a scene of the gallery")?
        .small_scene()?;
    for name in ["lower_triangle", "racp"] {
        let settings = Solve {
            method: name.parse()?,
            max_iterations: 500,
            ..Solve::default()
        };
        let solved = settings.solve(&scene.clone().into(), &mut Silent)?;
        let errors = [solved.error_u, solved.error_t];
        println!(
            "{name}: {} iterations, errors {errors:?}",
            solved.iterations
        );
        assert!(errors.iter().all(|e| e.is_some_and(|e| e < 1e-8)));
        assert!(solved.has_converged());
    }
    Ok(())
}
