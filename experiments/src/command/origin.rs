//! What a report says of where it came from: system, version, machine code.

use super::scene::Overrides;
use fracas_operators::simd::Level;
use serde::Serialize;
use std::path::Path;
use std::sync::LazyLock;

/// Where a system came from, and what worked on it.
#[derive(Serialize)]
pub(super) struct Origin<'a> {
    scene: Option<&'a str>,
    system: Option<&'a Path>,
    overrides: &'a [String],
    version: &'static str,
    features: &'static [&'static str],
    /// Registers in use.
    instructions: &'static str,
}

/// A report with its origin before it.
#[derive(Serialize)]
pub(super) struct Of<'a, R> {
    #[serde(flatten)]
    origin: Origin<'a>,
    #[serde(flatten)]
    report: &'a R,
}

/// Features of this build that change what it can do.
const FEATURES: &[&str] = match (cfg!(feature = "suitesparse"), cfg!(feature = "petsc")) {
    (true, true) => &["suitesparse", "petsc"],
    (true, false) => &["suitesparse"],
    (false, true) => &["petsc"],
    (false, false) => &[],
};

impl<'a> Origin<'a> {
    pub(super) fn new(
        scene: Option<&'a str>,
        system: Option<&'a Path>,
        overrides: &'a Overrides,
    ) -> Self {
        Self {
            scene,
            system,
            overrides: overrides.texts(),
            version: env!("CARGO_PKG_VERSION"),
            features: FEATURES,
            instructions: Level::best().name(),
        }
    }

    /// A report of that system.
    pub(super) fn of<R: Serialize>(self, report: &'a R) -> Of<'a, R> {
        Of {
            origin: self,
            report,
        }
    }
}

/// Version, features and instruction set, a line each.
pub(super) fn long_version() -> &'static str {
    static LINES: LazyLock<String> = LazyLock::new(|| {
        let features = match FEATURES {
            [] => "none (direct solvers: faer)".to_owned(),
            some => some.join(", "),
        };
        // those in use are chosen after the arguments are read
        let instructions = Level::supported().next().map_or("", Level::name);
        let version = env!("CARGO_PKG_VERSION");
        format!("{version}\nfeatures      {features}\ninstructions  {instructions}")
    });
    &LINES
}
