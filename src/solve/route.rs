//! Which method solves a system, and what takes its place.

use super::InnerRule;
use crate::inner::{amg, geometric, others};
use crate::scene::FACTORIZED;
use fracas_solvers::SetupError;
use fracas_solvers::saddle::{InnerChoice, Racp, SaddleMethod};

/// What a system is, as far as it decides on the inner solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SystemKind {
    /// A body whose mesh is a grid.
    Grid,
    /// The same, where its cells are far larger than it is [thick](crate::mesh::is_thin).
    Thin,
    /// A body whose mesh comes from a file.
    Mesh,
    /// A body, and work that reads the entries of A: which.
    Entries(&'static str),
    /// Matrices alone.
    Matrices,
}

/// A method, why it was chosen, and what else there is.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    /// The method.
    pub method: SaddleMethod,
    /// Its inner solver and why, where that was left to be chosen.
    pub reason: Option<String>,
    /// What takes its place, in turn, where it cannot be set up, and where an iteration gets nowhere with one that the program chose.
    pub otherwise: Vec<SaddleMethod>,
}

/// Geometric multigrid where it cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotGeometric {
    /// In another method.
    #[error(
        "inner = \"geometric\" belongs to method = \"racp\"; {0} takes exact, amg (also amg:gauss_seidel, amg:fsai, amg:chebyshev), fsai, fsai:static, jacobi, ssor, gamg, boomeramg or mumps"
    )]
    Method(&'static str),
    /// For matrices alone.
    #[error(
        "inner = \"geometric\" needs a scene, whose mesh is a grid; a system folder has matrices alone, take inner = \"amg\""
    )]
    Folder,
    /// For a mesh from a file.
    #[error(
        "inner = \"geometric\" needs a mesh that is a grid, and the mesh of this scene comes from a file; take inner = \"amg\""
    )]
    NoGrid,
    /// For work that reads entries.
    #[error(
        "inner = \"geometric\" has no assembled A, and {0} reads its entries; take inner = \"amg\""
    )]
    Entries(&'static str),
    /// With a C that needs more of A than the elements around a face.
    #[error(transparent)]
    Augmentation(SetupError),
}

fn is_geometric(inner: InnerChoice) -> bool {
    matches!(inner, InnerChoice::Geometric(_))
}

impl Route {
    /// The method with the inner solver that the rule leaves it, for about so many displacements, where they are known.
    ///
    /// # Errors
    /// [`NotGeometric`] where its own is geometric multigrid and cannot be.
    pub fn new(
        method: &SaddleMethod,
        rule: InnerRule,
        kind: SystemKind,
        displacements: Option<u128>,
    ) -> Result<Self, NotGeometric> {
        let chosen = Self {
            method: *method,
            reason: None,
            otherwise: Vec::new(),
        };
        let Some(own) = method.inner() else {
            return Ok(chosen);
        };
        if rule == InnerRule::Auto {
            let few = displacements.filter(|n| *n <= FACTORIZED as u128);
            return Ok(Self::automatic(method, kind, few));
        }
        if is_geometric(own) {
            require_grid(method, kind)?;
        }
        if rule == InnerRule::Fixed || kind == SystemKind::Matrices {
            return Ok(chosen);
        }
        Ok(Self {
            otherwise: in_place_of(own, method, kind),
            ..chosen
        })
    }

    /// A factorization of few displacements; else geometric where everything it needs is there, else amg. What comes behind
    /// takes its place.
    fn automatic(method: &SaddleMethod, kind: SystemKind, few: Option<u128>) -> Self {
        let because = match (kind, racp(method)) {
            (_, None) => format!("{} is made from assembled blocks", method.name()),
            (SystemKind::Matrices, _) => "a system folder has no grid".to_owned(),
            (SystemKind::Mesh, _) => "the mesh of the scene comes from a file".to_owned(),
            (SystemKind::Entries(who), _) => format!("{who} reads the entries of A"),
            (SystemKind::Grid, Some(racp)) if !racp.augmentation.is_local() => {
                format!("C = {} needs all of A", racp.augmentation)
            }
            (SystemKind::Thin, Some(_)) => "cells are far larger than the body is thick".to_owned(),
            (SystemKind::Grid, Some(_)) => String::new(),
        };
        let (reason, first) = match because.as_str() {
            "" => (
                "geometric, because the mesh of the scene is a grid".to_owned(),
                geometric(),
            ),
            because => (format!("amg, because {because}"), amg()),
        };
        // with the entries at hand a factorization is what serves every C
        let factorized = match (few, kind) {
            (Some(n), _) => Some(format!(
                "about {n} displacements are no more than {FACTORIZED}"
            )),
            (None, SystemKind::Entries(_)) => Some(because),
            (None, _) => None,
        };
        let (reason, first) = match factorized {
            Some(because) => (format!("exact, because {because}"), InnerChoice::default()),
            None => (reason, first),
        };
        Self {
            method: with(method, first).unwrap_or(*method),
            reason: Some(reason),
            otherwise: in_place_of(first, method, kind),
        }
    }
}

/// Refuses geometric multigrid where there is no grid, or where entries of A are read.
fn require_grid(method: &SaddleMethod, kind: SystemKind) -> Result<(), NotGeometric> {
    let racp = racp(method).ok_or(NotGeometric::Method(method.name()))?;
    match kind {
        SystemKind::Matrices => Err(NotGeometric::Folder),
        SystemKind::Mesh => Err(NotGeometric::NoGrid),
        SystemKind::Entries(who) => Err(NotGeometric::Entries(who)),
        SystemKind::Grid | SystemKind::Thin => {
            (racp.augmentation.require_local()).map_err(NotGeometric::Augmentation)
        }
    }
}

fn racp(method: &SaddleMethod) -> Option<&Racp> {
    match method {
        SaddleMethod::Racp(racp) => Some(racp),
        _ => None,
    }
}

/// The method with what takes the place of this inner solver.
fn in_place_of(first: InnerChoice, method: &SaddleMethod, kind: SystemKind) -> Vec<SaddleMethod> {
    let is_local = racp(method).is_some_and(|racp| racp.augmentation.is_local());
    let is_grid = matches!(kind, SystemKind::Grid | SystemKind::Thin);
    let inners = others(first, is_local && is_grid).into_iter();
    inners.filter_map(|inner| with(method, inner)).collect()
}

/// The method with this inner solver, where it has one.
fn with(method: &SaddleMethod, inner: InnerChoice) -> Option<SaddleMethod> {
    method.with_parts(None, Some(inner)).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inners(route: &Route) -> Vec<&'static str> {
        let methods = [&route.method].into_iter().chain(&route.otherwise);
        methods
            .filter_map(|m| m.inner().map(InnerChoice::name))
            .collect()
    }

    #[test]
    fn what_takes_the_place_of_an_inner_solver_depends_on_the_rule_and_on_the_system() {
        let racp = SaddleMethod::default();
        let mcp: SaddleMethod = "mcp".parse().unwrap();
        let (grid, matrices) = (SystemKind::Grid, SystemKind::Matrices);
        let (fixed, or_else, auto) = (InnerRule::Fixed, InnerRule::OrElse, InnerRule::Auto);
        let (few, many) = (Some(5_000), Some(5_001));
        for (method, rule, kind, displacements, expected) in [
            (&racp, fixed, grid, many, &["exact"][..]),
            (&racp, or_else, grid, many, &["exact", "geometric", "amg"]),
            (&racp, or_else, SystemKind::Mesh, many, &["exact", "amg"]),
            (&racp, or_else, matrices, many, &["exact"]),
            (&racp, auto, grid, many, &["geometric", "amg", "exact"]),
            (&racp, auto, grid, few, &["exact", "geometric", "amg"]),
            (&racp, auto, SystemKind::Thin, many, &["amg", "exact"]),
            (
                &racp,
                or_else,
                SystemKind::Thin,
                many,
                &["exact", "geometric", "amg"],
            ),
            (&racp, auto, matrices, many, &["amg", "exact"]),
            (&racp, auto, matrices, None, &["amg", "exact"]),
            (&racp, auto, matrices, few, &["exact", "amg"]),
            (
                &racp,
                auto,
                SystemKind::Entries("work"),
                many,
                &["exact", "amg"],
            ),
            (&mcp, or_else, grid, many, &["exact", "amg"]),
            (&mcp, auto, grid, many, &["amg", "exact"]),
            (&"direct".parse().unwrap(), auto, grid, many, &[]),
        ] {
            let route = Route::new(method, rule, kind, displacements).unwrap();
            assert_eq!(inners(&route), expected, "{method}, {rule:?}, {kind:?}");
            assert_eq!(route.reason.is_some(), rule == auto && !expected.is_empty());
        }
    }

    #[test]
    fn geometric_multigrid_is_refused_where_it_cannot_be() {
        let method = SaddleMethod::Racp(Racp::geometric());
        for kind in [
            SystemKind::Mesh,
            SystemKind::Matrices,
            SystemKind::Entries("spectrum"),
        ] {
            assert!(Route::new(&method, InnerRule::Fixed, kind, None).is_err());
        }
        assert!(Route::new(&method, InnerRule::Fixed, SystemKind::Grid, None).is_ok());
    }
}
