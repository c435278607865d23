//! From a body to all levels.
#![allow(unsafe_code, reason = "promises that tasks share no entry")]

use super::bottom::bottom;
use super::coarse_lines::CoarseLines;
use super::coarsening::{Coarsening, coarsen};
use super::elements::Elements;
use super::faces::{self, FractureTerm};
use super::fixed;
use super::grid::Grid;
use super::interpolation::{Interpolation, Owners};
use super::operators::{Coarse, Finest};
use super::pattern::pattern;
use super::remainder::{Rows, Step};
use super::smoothing::polynomial;
use super::{Geometric, GeometricError};
use crate::elasticity::{Bricks, Elastic, Hexes};
use crate::system::StickSystem;
use fracas_operators::simd::Level as Instructions;
use fracas_operators::small::{Symmetric, upper};
use fracas_operators::sparse::Block3;
use fracas_operators::{AdjointOperator, LinearOperator, Make, Real};
use fracas_solvers::multigrid::{
    About, BlockChebyshev, BlockJacobi, Hierarchy, Level, NoInverse, Scaled, Smoother, Smoothing,
};
use std::borrow::Cow;

/// Levels beyond which a grid cannot have been halved.
const MOST_LEVELS: usize = 32;

/// What the operator of a level is made of.
struct Operator<'a> {
    level: &'a Current<'a>,
    system: &'a StickSystem<'a>,
    materials: &'a [Elastic],
    c_inverse: &'a [[[f64; 3]; 3]],
}

impl Make for Operator<'_> {
    type Made<R: Real> = Result<(Box<dyn LinearOperator<R>>, usize), GeometricError>;

    fn double(self) -> Self::Made<f64> {
        self.other()
    }

    fn single(self) -> Self::Made<f32> {
        self.other()
    }

    fn other<R: Real>(self) -> Self::Made<R> {
        (self.level).operator(self.system, self.materials, self.c_inverse)
    }
}

/// The level that is being worked on.
struct Current<'a> {
    grid: Grid<'a>,
    elements: Elements<'a>,
    /// Fixed components per node.
    fixed: Vec<u8>,
    /// Elements on the two sides of a fracture.
    links: Vec<[u32; 2]>,
    /// What of its matrix is not bricks; `None` on the finest level.
    remainder: Option<Block3<f64>>,
}

/// When levels that lose few nodes are coarsened no further.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stop {
    /// As soon as they can be factorized.
    Late,
    /// At once; algebraic multigrid takes over where they are large.
    Early,
}

/// Least Ritz value of `M⁻¹S_u` below which S_u of a small body is factorized. Plates of 1:50 that cuts turn into bars have 0.03 and took 249
/// iterations, S_u factorized 56; of 190 random bodies with flat, graded and unlike cells none has less than 0.18. Unit: 1.
const SEEN: f64 = 0.1;

/// Cells across a body up to which factors of S_u grow as those of plane problems do. Unit: 1.
const THIN: usize = 8;

/// Times `direct` up to which S_u of such a body is factorized. A slab of 60 × 60 × 2 cells of 1:10 that bends (34,038 unknowns) took 1,000 iterations, S_u
/// factorized 17, and a graded plate of 30 × 6 × 30 cells with ν = 0.499 (20,160) 1,000 and 45: wide cells cannot bend without shear, which on every
/// coarser grid is four times as stiff. Unit: 1.
const OF_A_PLANE: usize = 5;

/// What a hierarchy on grids says of itself.
const ABOUT: About = About {
    near_null_space: "linear fields on every side of a fracture",
    smoothing: Smoothing {
        smoother: Smoother::Chebyshev,
        chained: None,
    },
};

/// All levels of `S_u / scale`. `materials` and `c_inverse` are divided by the scale.
///
/// Grids take fewer iterations than algebraic multigrid, so that comes first only where the functions of small blocks on coarse
/// cells have become the same to rounding. Of a small body S_u itself is factorized where a cycle hardly sees something.
pub(super) fn hierarchy<R: Real>(
    settings: &Geometric,
    system: &StickSystem<'_>,
    materials: &[Elastic],
    c_inverse: &[[[f64; 3]; 3]],
) -> Result<Hierarchy<R>, GeometricError> {
    let levels = |settings, stop| levels(settings, system, materials, c_inverse, stop);
    let (unknowns, most) = (3 * system.mesh.nodes.len(), factorizable(settings, system));
    match levels(settings, Some(Stop::Late)) {
        Err(GeometricError::Bottom(_)) => levels(settings, Some(Stop::Early)),
        Ok(h) if unknowns <= most && h.least_seen() < SEEN => {
            let direct = Geometric {
                direct: most,
                ..*settings
            };
            let whole = levels(&direct, None).ok();
            // not where S_u itself is singular to rounding
            Ok(whole
                .filter(|whole| whole.left_out().is_none())
                .unwrap_or(h))
        }
        done => done,
    }
}

/// Unknowns up to which S_u of this body is factorized where a cycle hardly sees something.
fn factorizable(settings: &Geometric, system: &StickSystem<'_>) -> usize {
    let grid = system.mesh.grid.as_ref();
    let is_thin = grid.is_some_and(|grid| grid.cells.iter().any(|cells| *cells <= THIN));
    if is_thin {
        OF_A_PLANE * settings.direct
    } else {
        settings.direct
    }
}

/// The same; nothing is coarsened without a rule where to stop.
fn levels<R: Real>(
    settings: &Geometric,
    system: &StickSystem<'_>,
    materials: &[Elastic],
    c_inverse: &[[[f64; 3]; 3]],
    stop: Option<Stop>,
) -> Result<Hierarchy<R>, GeometricError> {
    // before any work
    let smooths = |ends_early| polynomial(settings, materials, &system.mesh.regions, ends_early);
    let degree = smooths(false)?.degree;
    let mut current = Current {
        grid: Grid::of_mesh(system.mesh).ok_or(GeometricError::NoGrid)?,
        elements: Elements::of_mesh(system.mesh, materials),
        fixed: fixed::prescribed(system.constraints),
        links: Vec::new(),
        remainder: None,
    };
    let lines = CoarseLines::new(settings.lines, &current.grid, system.mesh, materials);
    // the coarse grid of a small body is the grid itself
    let first = stop.and_then(|stop| match 3 * current.grid.nodes <= settings.direct {
        true => (lines.next(&current.grid)).map(|starts| coarsen(&current.grid, starts)),
        // and that of a large one whose blocks keep their nodes: functions of narrow blocks on wide cells are no basis for what solves it
        false => smaller(&current.grid, &lines, stop, settings.direct),
    });
    let itself = || coarsen(&current.grid, current.grid.all_lines());
    let mut coarsening = first.unwrap_or_else(itself);
    let mut levels = Vec::new();
    loop {
        let coarse = &coarsening.coarse;
        let owners = Owners::new(&current.grid, &coarsening);
        let fixed_coarse = fixed::coarse(&current.fixed, &current.grid, &owners, &coarsening);
        // all of it fixed where every side is held: a level without unknowns smooths nothing
        let is_small = 3 * coarse.nodes <= settings.coarsest
            || levels.len() + 1 == MOST_LEVELS
            || fixed_coarse.iter().all(|bits| *bits == 0b111);
        let stop = stop.filter(|_| !is_small);
        let next = stop.and_then(|stop| smaller(coarse, &lines, stop, settings.direct));
        let kinds = if next.is_none() {
            vec![Elements::NONE; coarse.elements.len()]
        } else {
            let bits = [&*current.fixed, &*fixed_coarse];
            fixed::whole_bricks(&current.grid, &current.elements, &coarsening, &owners, bits)
        };
        let links = match current.remainder {
            None => faces::links(system.fractures, &coarsening.parent),
            Some(_) => faces::unique(current.links.iter().copied(), &coarsening.parent),
        };
        let step = Step {
            fine: &current.grid,
            elements: &current.elements,
            coarsening: &coarsening,
            owners: &owners,
            fixed: &current.fixed,
            kinds: &kinds,
        };
        let mut rows = Rows::new(pattern(coarse, &kinds, &links));
        rows.add_elements(step)?;
        match &current.remainder {
            None => faces::add_faces(&mut rows, step, system.fractures, c_inverse),
            Some(above) => rows.add_product(step, above),
        }
        let remainder = rows.finish(&fixed_coarse);
        let transfer = Interpolation::new(&owners, coarse);
        drop(owners);
        let place = (levels.len(), degree);
        let (scaled, fixed) = current.scaled(system, materials, c_inverse, place)?;
        levels.push((scaled, transfer, fixed));
        let Some(next) = next else {
            let bottom = bottom(settings, system.mesh, coarse, &remainder, &fixed_coarse)?;
            let polynomial = smooths(!is_small)?;
            let levels = levels.into_iter().map(|(scaled, transfer, fixed)| {
                let smoother = BlockChebyshev::new(scaled, polynomial);
                Level::new(Box::new(smoother), Box::new(transfer), fixed)
            });
            return Ok(Hierarchy::new(
                levels.collect(),
                bottom,
                settings.cycle,
                ABOUT,
            ));
        };
        current = Current {
            grid: std::mem::replace(&mut coarsening, next).coarse,
            elements: Elements::Bricks {
                kinds: Cow::Owned(kinds),
                materials,
            },
            fixed: fixed_coarse,
            links,
            remainder: Some(remainder),
        };
    }
}

/// The next grid, if it has few enough nodes and not too few. Where fractures cut blocks smaller than a coarse cell, each block keeps
/// the corners of its cell: no fewer nodes, and functions that differ ever less on the block. With e the share of nodes that would be
/// left without fractures, a level of up to `direct` unknowns is coarsened if √e of them are left or fewer, a larger one, to stop late,
/// if (1 + e)/2.
///
/// Where a coarse cell reaches beyond the end of the fractures its blocks become one, and motions against each other are lost at once
/// (columns on an intact base: 12,363 unknowns above 27). A level of up to `direct` unknowns of which less than e/2 would be left is not
/// coarsened either: `analogue_c` with 24², 29², 32² columns takes 51, 77, 63 iterations in place of 65, 85, 70.
fn smaller(grid: &Grid<'_>, lines: &CoarseLines, stop: Stop, direct: usize) -> Option<Coarsening> {
    let next = coarsen(grid, lines.next(grid)?);
    let coarse = &next.coarse;
    let vertices = |grid: &Grid<'_>| grid.cells.iter().map(|n| n + 1).product::<usize>() as f64;
    let whole = vertices(coarse) / vertices(grid);
    let (least, most) = match (stop, 3 * grid.nodes <= direct) {
        (_, true) => (0.5 * whole, whole.sqrt()),
        (Stop::Early, false) => (0.0, whole.sqrt()),
        (Stop::Late, false) => (0.0, 0.5 * (1.0 + whole)),
    };
    let left = coarse.nodes as f64 / grid.nodes as f64;
    (least <= left && left <= most).then_some(next)
}

impl Current<'_> {
    /// D⁻¹A of the level at this depth, for polynomials of about this degree, and its fixed components.
    fn scaled<R: Real>(
        &mut self,
        system: &StickSystem<'_>,
        materials: &[Elastic],
        c_inverse: &[[[f64; 3]; 3]],
        (depth, degree): (usize, usize),
    ) -> Result<(Scaled<R>, Vec<u32>), GeometricError> {
        let mut diagonal: Vec<Symmetric<f64>> = vec![[0.0; 6]; self.grid.nodes];
        self.elements.add_diagonals(&self.grid, &mut diagonal)?;
        match &self.remainder {
            None => faces::add_diagonals(system.fractures, c_inverse, &mut diagonal),
            Some(remainder) => add_diagonal_blocks(remainder, &mut diagonal),
        }
        // a coarse component that no free fine one sees is no unknown
        for (bits, block) in self.fixed.iter_mut().zip(&diagonal) {
            for (i, k) in [0, 3, 5].into_iter().enumerate() {
                if depth > 0 && block[k] == 0.0 {
                    *bits |= 1 << i;
                }
            }
        }
        let (operator, bytes) = R::make(Operator {
            level: self,
            system,
            materials,
            c_inverse,
        })?;
        let fixed = fixed::list(&self.fixed);
        let jacobi = match &self.remainder {
            Some(couplings) => BlockJacobi::with_couplings(&diagonal, couplings, &fixed),
            None => BlockJacobi::new(&diagonal, &fixed),
        };
        drop(diagonal);
        let jacobi = jacobi.map_err(|error| match error {
            NoInverse::Indefinite { node } => GeometricError::Indefinite {
                level: depth,
                place: self.position(system, node),
            },
            NoInverse::Overflow { .. } => overflow::<R>(depth),
        })?;
        let scaled = Scaled::estimated(operator, bytes, jacobi, degree);
        if scaled.lambda_max().is_finite() && scaled.lambda_max() > 0.0 {
            Ok((scaled, fixed))
        } else {
            Err(overflow::<R>(depth))
        }
    }

    /// The operator and its bytes.
    fn operator<R: Real>(
        &self,
        system: &StickSystem<'_>,
        materials: &[Elastic],
        c_inverse: &[[[f64; 3]; 3]],
    ) -> Result<(Box<dyn LinearOperator<R>>, usize), GeometricError> {
        let Some(remainder) = &self.remainder else {
            let mesh = system.mesh;
            let fractures = FractureTerm::new(system.fractures, mesh.nodes.len(), c_inverse);
            let (stiffness, bytes): (Box<dyn AdjointOperator<R>>, usize) = match self.elements {
                Elements::Bricks { .. } => {
                    let bricks = Bricks::new(mesh, materials)?;
                    let bytes = bricks.bytes();
                    (Box::new(bricks), bytes)
                }
                Elements::Hexes { .. } => {
                    let hexes = Hexes::new(mesh, materials)?;
                    let bytes = hexes.bytes();
                    (Box::new(hexes), bytes)
                }
            };
            let bytes = bytes + fractures.bytes();
            return Ok((
                Box::new(Finest {
                    stiffness,
                    fractures,
                }),
                bytes,
            ));
        };
        let bricks = self.bricks(materials);
        let remainder: Block3<R> = remainder.cast();
        let bytes = remainder.bytes() + bricks.as_ref().map_or(0, Bricks::bytes);
        Ok((Box::new(Coarse { bricks, remainder }), bytes))
    }

    /// The bricks of a coarse level, if it has any.
    fn bricks<R: Real>(&self, materials: &[Elastic]) -> Option<Bricks<R>> {
        let grid = &self.grid;
        let kind = |e: usize| self.elements.brick_kind(e);
        if (0..grid.elements.len()).all(|e| kind(e) == Elements::NONE) {
            return None;
        }
        let elements = (0..grid.cells.iter().product()).flat_map(|cell| {
            let inside = grid
                .elements_in(cell)
                .filter(|e| kind(*e) != Elements::NONE);
            inside.map(move |e| (cell, grid.elements[e], materials[usize::from(kind(e))]))
        });
        let lines = [0, 1, 2].map(|d: usize| &*grid.lines[d]);
        // SAFETY: `coarsen` numbers vertices first, then copies, each a class of corners at one vertex.
        Some(unsafe {
            Bricks::of_elements(
                grid.cells,
                lines,
                grid.nodes,
                elements,
                Instructions::best(),
            )
        })
    }

    /// Where a node lies [m].
    fn position(&self, system: &StickSystem<'_>, node: usize) -> [f64; 3] {
        match self.remainder {
            None => system.mesh.nodes[node],
            Some(_) => position(system.mesh, &self.grid, node),
        }
    }
}

/// Where a node of a coarse level lies [m].
pub(super) fn position(mesh: &crate::mesh::HexMesh, grid: &Grid<'_>, node: usize) -> [f64; 3] {
    let [i, j, k] = grid.finest_place(node);
    let [nx, ny] = [0, 1].map(|d: usize| grid.origin[d].last().map_or(1, |n| *n as usize + 1));
    mesh.nodes[i + nx * (j + ny * k)]
}

fn overflow<R: Real>(level: usize) -> GeometricError {
    GeometricError::Overflow {
        level,
        precision: R::NAME,
    }
}

/// Adds the diagonal blocks of an assembled matrix.
fn add_diagonal_blocks(matrix: &Block3<f64>, diagonal: &mut [Symmetric<f64>]) {
    for (i, to) in diagonal.iter_mut().enumerate() {
        if let Some(block) = matrix.block(i, i) {
            to.iter_mut().zip(upper(block)).for_each(|(to, v)| *to += v);
        }
    }
}
