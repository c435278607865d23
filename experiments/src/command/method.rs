//! Which method: `--method`, `--augmentation`, `--inner`.

use clap::Args;
use fracas_solvers::saddle::{AugmentationChoice, InnerChoice, NoSuchPart, SaddleMethod};

/// A method with the parts that the command line chooses.
#[derive(Args, Debug)]
pub(super) struct Method {
    /// What preconditions the whole system.
    #[arg(long, value_name = "METHOD", default_value_t, help = help())]
    method: SaddleMethod,
    /// C, in methods that have one: local, global, global_times=FACTOR, exact, local_h, exact_h, face_block.
    #[arg(long, value_name = "C")]
    augmentation: Option<AugmentationChoice>,
    /// Solver of the displacement block, in methods that have one: exact, amg, amg:gauss_seidel, amg:fsai, amg:chebyshev, fsai, fsai:static, jacobi, ssor.
    #[arg(long, value_name = "M")]
    inner: Option<InnerChoice>,
}

/// All names.
fn help() -> String {
    let names: Vec<&str> = SaddleMethod::all().iter().map(SaddleMethod::name).collect();
    format!(
        "What preconditions the whole system: {}; also mcp:FACTOR (of the published γ; 0 takes A itself), direct:faer, direct:umfpack",
        names.join(", ")
    )
}

impl Method {
    /// The settings.
    pub(super) fn chosen(&self) -> Result<SaddleMethod, NoSuchPart> {
        self.method.with_parts(self.augmentation, self.inner)
    }
}
