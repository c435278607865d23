//! Which method: `--method`, `--augmentation`, `--inner`.

use clap::Args;
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
    /// or :k for another cycle, :f64 for f64 inside); auto takes geometric for such a scene, and amg for a mesh from a file or
    /// a system folder.
    #[arg(long, value_name = "M")]
    inner: Option<Inner>,
}

/// `--inner`.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Inner {
    /// What fits the system.
    Auto,
    /// This one.
    Named(InnerChoice),
}

impl FromStr for Inner {
    type Err = UnknownInnerName;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        if name == "auto" {
            return Ok(Self::Auto);
        }
        name.parse().map(Self::Named).map_err(UnknownInnerName)
    }
}

/// A name that no inner solver has.
#[derive(Debug, thiserror::Error)]
#[error("{0}; or auto")]
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

/// A method and, where `auto` chose, why and what else there is.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Chosen {
    pub(super) method: SaddleMethod,
    pub(super) reason: Option<String>,
    /// What takes its place, in turn, where it cannot be set up.
    pub(super) otherwise: Vec<SaddleMethod>,
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

impl Method {
    /// The settings, from assembled blocks whatever the system is; `default` where no method is named.
    pub(super) fn chosen(
        &self,
        asker: &'static str,
        default: SaddleMethod,
    ) -> anyhow::Result<SaddleMethod> {
        let asked = Asked::SceneWithEntries(asker);
        Ok(self.of(default).route(asked)?.method)
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
            Some(Inner::Named(inner)) => {
                if matches!(inner, InnerChoice::Geometric(_)) {
                    self.require_grid(asked)?;
                }
                self.with(Some(inner))
            }
            Some(Inner::Auto) => self.auto(asked),
        }
    }

    /// Refuses geometric multigrid where there is no grid, or where entries of A are read.
    fn require_grid(&self, asked: Asked) -> anyhow::Result<()> {
        let Some(racp) = self.racp() else {
            // a method without an inner solver refuses this one as any other
            self.method.with_parts(None, Some(InnerChoice::default()))?;
            return Err(NotGeometric::Method(self.method.name()).into());
        };
        match asked {
            Asked::Folder => Err(NotGeometric::Folder.into()),
            Asked::SceneOfFile => Err(NotGeometric::NoGrid.into()),
            Asked::SceneWithEntries(who) => Err(NotGeometric::Entries(who).into()),
            Asked::Scene => Ok(racp.augmentation.require_local()?),
        }
    }

    /// The inner solver of the method; where f64 or memory do not do for that one what `auto` takes for a scene, whose bodies are held.
    fn default(&self, asked: Asked) -> anyhow::Result<Chosen> {
        let chosen = self.with(None)?;
        if matches!(asked, Asked::Folder) || self.method.inner().is_none() {
            return Ok(chosen);
        }
        let local = self.racp().is_some_and(|racp| racp.augmentation.is_local());
        let geometric = (local && asked == Asked::Scene).then(geometric);
        let inner = geometric.into_iter().chain([amg()]);
        let otherwise = inner.map(|inner| Ok(self.with(Some(inner))?.method));
        Ok(Chosen {
            otherwise: otherwise.collect::<anyhow::Result<_>>()?,
            ..chosen
        })
    }

    /// Geometric where everything it needs is there, else amg where the method has an inner solver; then amg, then a factorization.
    fn auto(&self, asked: Asked) -> anyhow::Result<Chosen> {
        if self.method.inner().is_none() {
            return self.with(None);
        }
        let exact = self.with(Some(InnerChoice::default()))?.method;
        let amg = self.with(Some(amg()))?.method;
        let reason = match (asked, self.racp()) {
            (_, None) => format!("{} is made from assembled blocks", self.method.name()),
            (Asked::Folder, _) => "a system folder has no grid".to_owned(),
            (Asked::SceneOfFile, _) => "the mesh of the scene comes from a file".to_owned(),
            (Asked::SceneWithEntries(who), _) => format!("{who} reads the entries of A"),
            (Asked::Scene, Some(racp)) if !racp.augmentation.is_local() => {
                format!("C = {} needs all of A", racp.augmentation)
            }
            (Asked::Scene, Some(_)) => {
                return Ok(Chosen {
                    reason: Some("geometric, because the mesh of the scene is a grid".into()),
                    otherwise: vec![amg, exact],
                    ..self.with(Some(geometric()))?
                });
            }
        };
        Ok(Chosen {
            method: amg,
            reason: Some(format!("amg, because {reason}")),
            otherwise: vec![exact],
        })
    }

    /// The method with this inner solver, or its own.
    fn with(&self, inner: Option<InnerChoice>) -> anyhow::Result<Chosen> {
        Ok(Chosen {
            method: self.method.with_parts(self.augmentation, inner)?,
            reason: None,
            otherwise: Vec::new(),
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

fn amg() -> InnerChoice {
    InnerChoice::Amg(Amg::default())
}

fn geometric() -> InnerChoice {
    InnerChoice::Geometric(Geometric::default())
}
