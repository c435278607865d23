//! Errors of a solution against the same mesh solved to rounding, and of its mesh against a finer one.

use super::counted::equations;
use super::prepared::Prepared;
use super::product::Case;
use anyhow::{Context, ensure};
use fracas::multigrid::Geometric;
use fracas::scene::Body;
use fracas::solve::{InnerRule, Problem, Solve, Solved, StuckBody};
use fracas_operators::vector::norm2;
use fracas_solvers::Silent;
use fracas_solvers::multigrid::Precision;
use fracas_solvers::saddle::{InnerChoice, Measure, Racp, SaddleBlocks, SaddleMethod};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;
use toml::Value;

/// Relative residual of the solution on the same mesh, or rounding where that is larger.
const ROUNDING: f64 = 1e-13;

/// `[finest]`: the mesh that judges the others, which divide it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Finest {
    /// Keys of the scene.
    #[serde(deserialize_with = "super::setting::flat")]
    pub set: BTreeMap<String, Value>,
    /// Relative residual of its solution.
    pub tolerance: f64,
}

/// What rows of one study are judged by.
#[derive(Default)]
pub(super) struct Nested {
    same: Option<(Case, Vec<f64>)>,
    /// A finest mesh per scene with other keys; 8 bytes per displacement each.
    finest: Vec<(Case, Sample)>,
}

/// Relative, in ℓ²: of u and t against the same mesh, of u against the finest one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Errors {
    pub(super) same: [f64; 2],
    pub(super) mesh: Option<f64>,
}

/// `‖a − b‖ / ‖b‖`.
fn relative(a: &[f64], b: &[f64]) -> f64 {
    let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    norm2(&difference) / norm2(b)
}

/// Displacements and tractions [m, Pa] of a stuck body under its own loads to a tolerance, by geometric multigrid in f64 on a grid.
fn solution(stuck: &StuckBody, body: &Arc<Body>, tolerance: f64) -> anyhow::Result<Solved> {
    let geometric = Geometric {
        precision: Precision::F64,
        ..Geometric::default()
    };
    let on_grid = SaddleMethod::Racp(Racp {
        inner: InnerChoice::Geometric(geometric),
        ..Racp::default()
    });
    let (method, inner) = match body.mesh.grid {
        Some(_) => (on_grid, InnerRule::Fixed),
        None => (SaddleMethod::default(), InnerRule::Auto),
    };
    let mut of_body = StuckBody::of_body(stuck.name.clone(), body.clone());
    of_body.stabilization = stuck.stabilization;
    solved(&Problem::Body(of_body), (method, inner), tolerance)
}

fn solved(
    problem: &Problem,
    (method, inner): (SaddleMethod, InnerRule),
    tolerance: f64,
) -> anyhow::Result<Solved> {
    let settings = Solve {
        method,
        inner,
        measure: Measure::Residual,
        tolerance,
        ..Solve::default()
    };
    Ok(settings.solve(problem, &mut Silent)?)
}

/// The solution [m, Pa] of the equations of a row: its own matrices and right-hand side.
fn exact(case: &Case, prepared: &Prepared) -> anyhow::Result<Vec<f64>> {
    if let (Some((body, stuck)), true) = (&prepared.body, is_own_load(case)) {
        return Ok(solution(stuck, body, ROUNDING)?.x);
    }
    let (blocks, rhs, unit) = equations(case, prepared);
    let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
    let mut blocks = SaddleBlocks::clone(&blocks);
    blocks.rhs_u = rhs[..n_u].to_vec();
    blocks.rhs_t = rhs[n_u..n_u + n_t].to_vec();
    let method = (SaddleMethod::default(), InnerRule::Auto);
    let mut x = solved(&Problem::Blocks(blocks.into()), method, ROUNDING)?.x;
    x[n_u..].iter_mut().for_each(|t| *t *= unit);
    Ok(x)
}

/// True for a scene with every face in stick, under what it says itself.
fn is_own_load(case: &Case) -> bool {
    case.setting.state.is_none() && case.has_own_load()
}

impl Nested {
    /// Errors of a solution [m, Pa], that of the mesh where there is a finest one.
    ///
    /// # Errors
    /// What judges cannot be solved, or its mesh is not a grid that the mesh of the row divides; a finest mesh beside a system folder, another
    /// load than that of the scene, or a contact state.
    pub(super) fn errors(
        &mut self,
        case: &Case,
        prepared: &Prepared,
        finest: Option<&Finest>,
        x: &[f64],
    ) -> anyhow::Result<Errors> {
        let is_known = |(own, _): &(Case, Vec<f64>)| own.same_system(case);
        if !self.same.as_ref().is_some_and(is_known) {
            self.same = Some((case.clone(), exact(case, prepared)?));
        }
        let own = self.same.as_ref().map_or(&[][..], |(_, x)| x);
        let n_u = prepared.blocks.n_u();
        let (u, t) = x.split_at(n_u);
        let (own_u, own_t) = own.split_at(n_u);
        let same = [relative(u, own_u), relative(t, own_t)];
        let Some(finest) = finest else {
            return Ok(Errors { same, mesh: None });
        };
        let (body, _) = (prepared.body.as_ref())
            .context("mesh_error needs a scene, whose mesh can be made finer")?;
        ensure!(
            is_own_load(case),
            "mesh_error is that of the scene in stick under its own loads, and this row has another `rhs` or a `state`"
        );
        let judge = finest.of(case);
        let known = (self.finest.iter()).position(|(own, _)| own.same_matrices(&judge));
        let known = match known {
            Some(known) => known,
            None => {
                let sample = Sample::of(&judge, finest.tolerance)?;
                self.finest.push((judge, sample));
                self.finest.len() - 1
            }
        };
        let mesh = Some(self.finest[known].1.error(body, u)?);
        Ok(Errors { same, mesh })
    }
}

/// The displacements of the finest mesh at its grid nodes.
struct Sample {
    cells: [usize; 3],
    u: Vec<f64>,
}

/// Grid nodes that a fracture splits: both sides have their own displacement there.
fn split(body: &Body, vertices: usize) -> Vec<bool> {
    let mesh = &body.mesh;
    let mut split = vec![false; vertices];
    for copy in vertices..mesh.nodes.len() {
        let mut root = copy;
        while mesh.origin[root] as usize != root {
            root = mesh.origin[root] as usize;
        }
        split[root] = true;
    }
    split
}

impl Finest {
    /// The row on this mesh: the same scene with the same keys but for these.
    fn of(&self, case: &Case) -> Case {
        let mut case = case.clone();
        case.setting.set.extend(self.set.clone());
        case.setting.refine = None;
        case
    }
}

impl Sample {
    fn of(case: &Case, tolerance: f64) -> anyhow::Result<Self> {
        let stuck = case.stuck()?.context("a finer mesh needs a scene")?;
        let scene = case.scene()?.context("a finer mesh needs a scene")?;
        let body = Arc::new(scene.build()?);
        let solved = solution(&stuck, &body, tolerance)?;
        ensure!(
            solved.has_converged(),
            "the finest mesh was not solved to {tolerance:e}"
        );
        let mut x = solved.x;
        x.truncate(body.constraints.free_len());
        Ok(Self {
            cells: cells(&body)?,
            u: body.constraints.expand(&x),
        })
    }

    /// `‖u − u_fine‖ / ‖u_fine‖` in ℓ² of the grid nodes of `body` off its fractures; its mesh divides the finest one.
    fn error(&self, body: &Body, u: &[f64]) -> anyhow::Result<f64> {
        let own = cells(body)?;
        let divides = own.iter().zip(self.cells).all(|(n, fine)| fine % n == 0);
        ensure!(
            divides,
            "{own:?} cells do not divide the {:?} cells of [finest]",
            self.cells
        );
        let u = body.constraints.expand(u);
        let lines = own.map(|n| n + 1);
        let nodes: usize = lines.iter().product();
        let split = split(body, nodes);
        let (mut difference, mut size) = (Vec::new(), Vec::new());
        for node in (0..nodes).filter(|n| !split[*n]) {
            let [x, y, _] = lines;
            let at = [node % x, node / x % y, node / (x * y)];
            let [i, j, k]: [usize; 3] = std::array::from_fn(|d| at[d] * (self.cells[d] / own[d]));
            let there = i + (self.cells[0] + 1) * (j + (self.cells[1] + 1) * k);
            for d in 0..3 {
                difference.push(u[3 * node + d] - self.u[3 * there + d]);
                size.push(self.u[3 * there + d]);
            }
        }
        Ok(norm2(&difference) / norm2(&size))
    }
}

fn cells(body: &Body) -> anyhow::Result<[usize; 3]> {
    let grid = body.mesh.grid.as_ref();
    Ok(grid
        .context("[finest] compares grids, and a mesh is a file")?
        .cells)
}
