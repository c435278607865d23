//! Which method: `--method`, `--augmentation`, `--inner`.

use crate::study::Inner;
use clap::Args;
use fracas::solve::InnerRule;
use fracas_solvers::saddle::{AugmentationChoice, Form, NoSuchPart, PressureSchur, SaddleMethod};

/// A method with the parts that the command line chooses.
#[derive(Args, Debug)]
pub(super) struct Method {
    /// What preconditions the whole system.
    #[arg(long, value_name = "METHOD", help = help())]
    method: Option<SaddleMethod>,
    /// C, in methods that have one: local, global, global_times=FACTOR, exact, local_h, half_h, fitted_h, exact_h, face_block.
    #[arg(long, value_name = "C")]
    augmentation: Option<AugmentationChoice>,
    /// Solver of the displacement block, in methods that have one: exact, amg, amg:gauss_seidel, amg:fsai, amg:chebyshev,
    /// fsai, fsai:static, jacobi, ssor; gamg, boomeramg or mumps of PETSc in a build with the feature petsc; for a scene on a grid also geometric, which assembles no A (behind it :v, :w
    /// or :k for another cycle; :f64 behind either for f64 inside, where `spectrum` works anyway); auto takes exact up to 5,000
    /// displacements, beyond geometric for such a scene, and amg for a mesh from a file, a system folder, or cells far larger than the body is thick [default: auto;
    /// spectrum: exact].
    #[arg(long, value_name = "M")]
    inner: Option<Inner>,
    /// With flow, S_p of --method racp: fixed_stress, scaled_fixed_stress, patch_fixed_stress, half_order, transmissibility, diagonal, exact
    /// [default: half_order].
    #[arg(long, value_name = "S_P")]
    schur_p: Option<PressureSchur>,
    /// With flow, the factors that --method racp applies: full, upper (pressures first, mechanics once) or lower [default: full].
    #[arg(long, value_name = "FORM")]
    form: Option<Form>,
}

/// All names.
fn help() -> String {
    let names: Vec<&str> = SaddleMethod::all().iter().map(SaddleMethod::name).collect();
    format!(
        "What preconditions the whole system: {}; also racp:published (H not relaxed, C = local_h), racp:RELAXATION (of H), mcp:FACTOR (of the published γ; 0 takes A itself), direct:faer, direct:umfpack, direct:mumps [default: racp]",
        names.join(", ")
    )
}

impl Method {
    /// The method that is named, or this one, with the inner solver that fits where none is named, and what may take its place.
    pub(super) fn fitted(
        &self,
        default: SaddleMethod,
    ) -> Result<(SaddleMethod, InnerRule), NoSuchPart> {
        self.with(default, self.inner.or(Some(Inner::Auto)))
    }

    /// The same with the inner solver of the method where none is named.
    pub(super) fn of(
        &self,
        default: SaddleMethod,
    ) -> Result<(SaddleMethod, InnerRule), NoSuchPart> {
        self.with(default, self.inner)
    }

    fn with(
        &self,
        default: SaddleMethod,
        inner: Option<Inner>,
    ) -> Result<(SaddleMethod, InnerRule), NoSuchPart> {
        let (inner, rule) = Inner::choose(inner);
        let method = self.method.unwrap_or(default);
        let method = method.with_parts(self.augmentation, inner)?;
        Ok((method.with_flow(self.schur_p, self.form)?, rule))
    }
}
