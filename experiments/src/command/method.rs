//! Which method: `--method`, `--augmentation`, `--inner`.

use clap::Args;
use fracas::matrix_free::MatrixFreeRacp;
use fracas::multigrid::Geometric;
use fracas_solvers::amg::Amg;
use fracas_solvers::saddle::inner::UnknownInner;
use fracas_solvers::saddle::{AugmentationChoice, InnerChoice, Racp, SaddleMethod};
use std::str::FromStr;

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
    /// fsai, fsai:static, jacobi, ssor; for `solve` of a scene on a grid also geometric, which assembles no A (behind it :v, :w
    /// or :k for another cycle, :f64 for f64 inside); auto takes geometric for such a scene and amg for a mesh from a file or
    /// a system folder.
    #[arg(long, value_name = "M")]
    inner: Option<Inner>,
}

/// `--inner`.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Inner {
    /// What fits the system.
    Auto,
    /// Geometric multigrid, without an assembled A.
    Geometric(Geometric),
    /// Made from assembled blocks.
    Assembled(InnerChoice),
}

impl FromStr for Inner {
    type Err = UnknownInnerName;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        if name == "auto" {
            return Ok(Self::Auto);
        }
        match Geometric::of_name(name) {
            Some(geometric) => Ok(Self::Geometric(geometric)),
            None => name.parse().map(Self::Assembled).map_err(UnknownInnerName),
        }
    }
}

/// A name that no inner solver has.
#[derive(Debug, thiserror::Error)]
#[error("{0}; or geometric, behind it :v, :w or :k and :f64 (geometric:k:f64), or auto")]
struct UnknownInnerName(UnknownInner);

/// All names.
fn help() -> String {
    let names: Vec<&str> = SaddleMethod::all().iter().map(SaddleMethod::name).collect();
    format!(
        "What preconditions the whole system: {}; also racp:RELAXATION (of H; 0: as published, with C = local_h), mcp:FACTOR (of the published γ; 0 takes A itself), direct:faer, direct:umfpack [default: racp; spectrum: racp:0]",
        names.join(", ")
    )
}

/// What the system is, as far as it decides on the inner solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Asked {
    /// A scene: its mesh is a grid.
    Scene,
    /// A scene whose mesh comes from a file.
    SceneOfFile,
    /// A scene, and work that reads the entries of A: the option.
    SceneWithEntries(&'static str),
    /// A system folder.
    Folder,
}

/// How a system is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Route {
    /// From assembled blocks.
    Assembled(SaddleMethod),
    /// RACP around geometric multigrid, without an assembled A.
    MatrixFree(MatrixFreeRacp),
}

/// A route and, where `auto` chose, why and what else there is.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chosen {
    pub(super) route: Route,
    pub(super) reason: Option<String>,
    /// What takes its place, in turn, where it cannot be set up.
    pub(super) otherwise: Vec<SaddleMethod>,
    /// What comes before these where the route is an assembled one.
    pub(super) geometric: Option<MatrixFreeRacp>,
}

/// Geometric multigrid where it cannot be.
#[derive(Debug, thiserror::Error)]
enum NotGeometric {
    #[error(
        "--inner geometric belongs to --method racp; {0} takes exact, amg (also amg:gauss_seidel, amg:fsai, amg:chebyshev), fsai, fsai:static, jacobi or ssor"
    )]
    Method(&'static str),
    #[error(
        "--inner geometric needs a scene, whose mesh is a grid; a system folder has matrices alone, take --inner amg"
    )]
    Folder,
    #[error(
        "--inner geometric needs a mesh that is a grid, and the mesh of this scene comes from a file; take --inner amg"
    )]
    NoGrid,
    #[error("--inner geometric has no assembled A, and {0} reads its entries; take --inner amg")]
    Entries(&'static str),
}

/// RACP with these settings around this geometric multigrid.
fn matrix_free(racp: Racp, inner: Geometric) -> MatrixFreeRacp {
    MatrixFreeRacp {
        augmentation: racp.augmentation,
        relaxation: racp.relaxation,
        inner,
    }
}

impl Method {
    /// The settings, from assembled blocks whatever the system is; `default` where no method is named.
    pub(super) fn chosen(
        &self,
        asker: &'static str,
        default: SaddleMethod,
    ) -> anyhow::Result<SaddleMethod> {
        let asked = Asked::SceneWithEntries(asker);
        match self.of(default).route(asked)?.route {
            Route::Assembled(method) => Ok(method),
            Route::MatrixFree(_) => Err(NotGeometric::Entries(asker).into()),
        }
    }

    /// How a system is solved.
    pub(super) fn route(&self, asked: Asked) -> anyhow::Result<Chosen> {
        self.of(SaddleMethod::default()).route(asked)
    }

    /// The method that is named, or this one.
    fn of(&self, default: SaddleMethod) -> Parts {
        Parts {
            method: self.method.unwrap_or(default),
            augmentation: self.augmentation,
            inner: self.inner,
        }
    }
}

/// A method and what is put in the place of its parts.
struct Parts {
    method: SaddleMethod,
    augmentation: Option<AugmentationChoice>,
    inner: Option<Inner>,
}

impl Parts {
    fn route(&self, asked: Asked) -> anyhow::Result<Chosen> {
        match self.inner {
            None => self.default(asked),
            Some(Inner::Assembled(inner)) => self.assembled(Some(inner), None),
            Some(Inner::Geometric(geometric)) => {
                let Some(racp) = self.racp() else {
                    // a method without an inner solver refuses this one as any other
                    self.method.with_parts(None, Some(InnerChoice::default()))?;
                    return Err(NotGeometric::Method(self.method.name()).into());
                };
                match asked {
                    Asked::Folder => Err(NotGeometric::Folder.into()),
                    Asked::SceneOfFile => Err(NotGeometric::NoGrid.into()),
                    Asked::SceneWithEntries(who) => Err(NotGeometric::Entries(who).into()),
                    Asked::Scene => {
                        racp.augmentation.require_local()?;
                        Ok(Chosen {
                            route: Route::MatrixFree(matrix_free(racp, geometric)),
                            reason: None,
                            otherwise: Vec::new(),
                            geometric: None,
                        })
                    }
                }
            }
            Some(Inner::Auto) => self.auto(asked),
        }
    }

    /// The inner solver of the method; where f64 or memory do not do for that one what `auto` takes for a scene, whose bodies are held.
    fn default(&self, asked: Asked) -> anyhow::Result<Chosen> {
        let chosen = self.assembled(None, None)?;
        if matches!(asked, Asked::Folder) || self.method.inner().is_none() {
            return Ok(chosen);
        }
        let amg = InnerChoice::Amg(Amg::default());
        let amg = self.method.with_parts(self.augmentation, Some(amg))?;
        let racp = self.racp().filter(|racp| racp.augmentation.is_local());
        let racp = racp.filter(|_| matches!(asked, Asked::Scene));
        Ok(Chosen {
            geometric: racp.map(|racp| matrix_free(racp, Geometric::default())),
            otherwise: vec![amg],
            ..chosen
        })
    }

    /// Geometric where everything it needs is there, else amg where the method has an inner solver; then amg, then a factorization.
    fn auto(&self, asked: Asked) -> anyhow::Result<Chosen> {
        if self.method.inner().is_none() {
            return self.assembled(None, None);
        }
        let amg = InnerChoice::Amg(Amg::default());
        let with = |inner| self.method.with_parts(self.augmentation, Some(inner));
        let exact = with(InnerChoice::default())?;
        let reason = match (asked, self.racp()) {
            (_, None) => format!("{} is made from assembled blocks", self.method.name()),
            (Asked::Folder, _) => "a system folder has no grid".to_owned(),
            (Asked::SceneOfFile, _) => "the mesh of the scene comes from a file".to_owned(),
            (Asked::SceneWithEntries(who), _) => format!("{who} reads the entries of A"),
            (Asked::Scene, Some(racp)) => {
                let c = racp.augmentation;
                if c.is_local() {
                    return Ok(Chosen {
                        route: Route::MatrixFree(matrix_free(racp, Geometric::default())),
                        reason: Some("geometric, because the mesh of the scene is a grid".into()),
                        otherwise: vec![with(amg)?, exact],
                        geometric: None,
                    });
                }
                format!("C = {c} needs all of A")
            }
        };
        Ok(Chosen {
            otherwise: vec![exact],
            ..self.assembled(Some(amg), Some(format!("amg, because {reason}")))?
        })
    }

    fn assembled(
        &self,
        inner: Option<InnerChoice>,
        reason: Option<String>,
    ) -> anyhow::Result<Chosen> {
        let method = self.method.with_parts(self.augmentation, inner)?;
        Ok(Chosen {
            route: Route::Assembled(method),
            reason,
            otherwise: Vec::new(),
            geometric: None,
        })
    }

    /// RACP with this C, where it is the method.
    fn racp(&self) -> Option<Racp> {
        let SaddleMethod::Racp(racp) = self.method else {
            return None;
        };
        Some(Racp {
            augmentation: self.augmentation.unwrap_or(racp.augmentation),
            ..racp
        })
    }
}
