//! Small bodies for tests, from code alone: a box, planes in it, what holds its sides.

use super::build::constraints;
use super::history::Histories;
use super::{Body, History, PoreChange, Profile, Pull, SolverSection, SurfaceTraction, TimeTable};
use crate::contact::{Friction, Rocks};
use crate::elasticity::Elastic;
use crate::flow::{Channel, Fluid};
use crate::mesh::{BoxGrid, BoxRegion, Incline, PlaneFracture};

/// What a side of the box is given.
#[derive(Clone, Debug)]
pub(crate) enum Side {
    /// No displacement.
    Fixed,
    /// None along the normal.
    Roller,
    /// A pressure [Pa].
    Pressure(f64),
    /// Displacements [m] with a history.
    Moved([Option<f64>; 3], History),
}

/// A box with planes of a friction angle of 30 deg.
#[derive(Debug)]
pub(crate) struct Sample {
    pub(crate) grid: BoxGrid,
    /// One per region of the grid.
    pub(crate) rocks: Vec<Elastic>,
    /// Numbers of sides, x−, x+, y−, …, and what they are given; a later one counts.
    pub(crate) sides: Vec<(usize, Side)>,
    /// Friction angle [deg].
    pub(crate) angle: f64,
}

/// A rock of this Young's modulus [Pa].
pub(crate) const fn rock(young: f64) -> Elastic {
    Elastic {
        young,
        poisson: 0.25,
    }
}

/// The plane `axis = at` between bounds on the other axes.
pub(crate) fn plane(axis: usize, at: f64, spans: [Option<[f64; 2]>; 3]) -> PlaneFracture {
    PlaneFracture {
        spans,
        ..PlaneFracture::through("cut", axis, at)
    }
}

/// The interval of ±half [m].
const fn around(half: f64) -> Option<[f64; 2]> {
    Some([-half, half])
}

impl Sample {
    fn new(box_of: [[f64; 2]; 3], cells: [usize; 3], planes: Vec<PlaneFracture>) -> Self {
        let corner = |end: usize| box_of.map(|interval| interval[end]);
        let mut grid = BoxGrid::uniform(corner(0), corner(1), cells);
        grid.fractures = planes;
        // names differ
        for (k, plane) in grid.fractures.iter_mut().enumerate() {
            if k > 0 {
                plane.name += &k.to_string();
            }
        }
        Self {
            grid,
            rocks: vec![rock(25e9)],
            sides: vec![(4, Side::Fixed), (5, Side::Pressure(10e6))],
            angle: 30.0,
        }
    }

    fn held(mut self, sides: &[(usize, Side)]) -> Self {
        self.sides = sides.to_vec();
        self
    }

    /// Two planes that cross, at x and at z.
    pub(crate) fn crossing(cells: [usize; 3], [x, z]: [f64; 2], to: f64) -> Self {
        let planes = vec![
            plane(0, x, [None, None, around(2.0)]),
            plane(2, z, [around(2.0), None, None]),
        ];
        let mut sample = Self::new([[-4.0, to], [0.0, 4.0], [-4.0, 4.0]], cells, planes);
        sample.sides.push((1, Side::Pressure(5e6)));
        sample
    }

    /// A plane that ends on another one.
    pub(crate) fn tee(cells: [usize; 3]) -> Self {
        let planes = vec![
            plane(0, 0.0, [None, None, around(3.0)]),
            plane(2, 0.0, [Some([0.0, 3.0]), None, None]),
        ];
        Self::new([[-4.0, 4.0], [0.0, 4.0], [-4.0, 4.0]], cells, planes)
    }

    /// A plane of 60 deg dip through the box.
    pub(crate) fn inclined(cells: [usize; 3]) -> Self {
        let planes = vec![plane(0, 0.0, [None; 3])];
        let mut sample = Self::new([[-4.0, 4.0], [0.0, 4.0], [0.0, 8.0]], cells, planes);
        sample.grid.warps = vec![Box::new(Incline {
            plane: 0,
            along: 2,
            tilt: 30f64.to_radians(),
            pivot: [0.0, 2.0, 4.0],
            fade: true,
        })];
        sample.held(&[
            (0, Side::Fixed),
            (1, Side::Pressure(10e6)),
            (5, Side::Pressure(5e6)),
        ])
    }

    /// Cells of 1:50.
    pub(crate) fn stretched(cells: [usize; 3]) -> Self {
        let planes = vec![plane(0, 0.0, [None, around(200.0), around(4.0)])];
        Self::new(
            [[-300.0, 300.0], [-300.0, 300.0], [-6.0, 6.0]],
            cells,
            planes,
        )
    }

    /// A square in a cube.
    fn square(cells: [usize; 3]) -> Self {
        let planes = vec![plane(0, 0.0, [None, around(4.0), around(4.0)])];
        Self::new([[-6.0, 6.0]; 3], cells, planes)
    }

    /// The square in layers of contrast 1000, between z = -4, -2, 0 and 2 m.
    pub(crate) fn layered(cells: [usize; 3]) -> Self {
        let mut sample = Self::square(cells);
        let whole = [f64::NEG_INFINITY, f64::INFINITY];
        let layers = [[-4.0, -2.0], [0.0, 2.0]];
        sample.grid.regions.push(BoxRegion {
            name: "soft".into(),
            boxes: layers.map(|z| [whole, whole, z]).into(),
        });
        sample.rocks = vec![rock(40e9), rock(40e6)];
        sample
    }

    /// The square, closed by a pressure along x.
    pub(crate) fn checkerboard(cells: [usize; 3]) -> Self {
        Self::square(cells).held(&[(0, Side::Fixed), (1, Side::Pressure(10e6))])
    }

    /// Three blocks in a row, of which the first is held.
    pub(crate) fn floating(cells: [usize; 3]) -> Self {
        let planes = [3.0, 6.0].map(|x| plane(0, x, [None; 3])).into();
        let sample = Self::new([[0.0, 9.0], [0.0, 4.0], [0.0, 4.0]], cells, planes);
        sample.held(&[(0, Side::Fixed), (1, Side::Pressure(10e6))])
    }

    /// Four planes inside one body.
    pub(crate) fn few(cells: [usize; 3]) -> Self {
        let spans = [None, Some([6.0, 18.0]), Some([6.0, 18.0])];
        let planes = [5.0, 10.0, 15.0, 20.0].map(|x| plane(0, x, spans)).into();
        let mut sample = Self::new([[0.0, 25.0], [0.0, 24.0], [0.0, 24.0]], cells, planes);
        sample.sides.push((1, Side::Pressure(5e6)));
        sample
    }

    /// Planes between all cells along x and y, above an intact base.
    pub(crate) fn dense(cells: [usize; 3]) -> Self {
        let spans = [None, None, Some([8.0, 16.0])];
        let lines = |axis: usize| {
            let line = move |i: usize| 16.0 * i as f64 / cells[axis] as f64;
            (1..cells[axis]).map(move |i| plane(axis, line(i), spans))
        };
        let planes = lines(0).chain(lines(1)).collect();
        Self::new([[0.0, 16.0]; 3], cells, planes)
    }

    /// Two blocks of 1 m on rollers, pressed together along x.
    pub(crate) fn patch() -> Self {
        let planes = vec![plane(0, 1.0, [None; 3])];
        let sample = Self::new([[0.0, 2.0], [0.0, 1.0], [0.0, 1.0]], [4, 3, 3], planes);
        let rollers = [0, 2, 4].map(|side| (side, Side::Roller));
        let mut sample = sample.held(&rollers);
        sample.sides.push((1, Side::Pressure(10e6)));
        sample
    }

    /// A plane between a held side and one that moves: closed, sheared, opened, closed and sheared back.
    pub(crate) fn cycle() -> Self {
        let planes = vec![plane(0, 0.0, [None; 3])];
        let sample = Self::new([[-4.0, 4.0], [0.0, 20.0], [0.0, 20.0]], [4, 5, 5], planes);
        let history = |points: &[(f64, f64)]| History::through(points.to_vec());
        let across = history(&[(0.0, 1.0), (5.0, -0.9), (10.0, 1.0)]);
        let along = history(&[(0.0, 0.0), (2.0, 1.0), (8.0, 1.0), (10.0, -1.0)]);
        let (Some(across), Some(along)) = (across, along) else {
            unreachable!("times increase");
        };
        Self {
            rocks: vec![rock(5e9)],
            ..sample.held(&[
                (0, Side::Fixed),
                (1, Side::Moved([Some(-1e-3), None, None], across)),
                (1, Side::Moved([None, Some(0.0), Some(1e-3)], along)),
            ])
        }
    }

    /// Table of [`cycle`](Self::cycle).
    pub(crate) const CYCLE: TimeTable = TimeTable {
        end: 10.0,
        steps: 40,
    };

    /// The body, with the solver's settings at their defaults.
    pub(crate) fn body(self) -> Body {
        let built = self.grid.build().expect("a mesh");
        let (mut prescribed, mut tractions) = (Vec::new(), Vec::new());
        let mut histories = Histories::new();
        for (number, side) in self.sides {
            let faces: Vec<[u32; 4]> = built.sides[number].iter().map(|f| f.nodes).collect();
            let mut prescribe = |given: [Option<f64>; 3], history: usize| {
                for node in faces.iter().flatten() {
                    let dofs = given.iter().zip(3 * node..);
                    prescribed.extend(dofs.filter_map(|(u, dof)| Some((dof, (*u)?, history))));
                }
            };
            match side {
                Side::Fixed => prescribe([Some(0.0); 3], Body::ALWAYS),
                Side::Roller => {
                    let mut given = [None; 3];
                    given[number / 2] = Some(0.0);
                    prescribe(given, Body::ALWAYS);
                }
                Side::Moved(given, history) => prescribe(given, histories.number_of(history)),
                Side::Pressure(p) => tractions.push(SurfaceTraction {
                    faces,
                    pull: Pull::Pressure(p),
                    history: Body::ALWAYS,
                }),
            }
        }
        let (constraints, prescribed_histories) =
            constraints(3 * built.mesh.nodes.len(), prescribed);
        let (fractures, rocks) = (built.fractures.names.len(), self.rocks.len());
        let friction = Friction {
            angle: self.angle.to_radians(),
            ..Friction::NONE
        };
        let unchanged = PoreChange {
            change: 0.0,
            biot: 1.0,
            history: Body::ALWAYS,
        };
        Body {
            first_alike: Rocks::first_alike(rocks, |i, j| self.rocks[i] == self.rocks[j]),
            friction: vec![Some(Profile::constant(friction)); fractures],
            material_names: (0..rocks).map(|k| format!("rock {k}")).collect(),
            materials: self.rocks,
            densities: vec![0.0; rocks],
            body_force: vec![[0.0; 3]; rocks],
            weight_stress: None,
            constraints,
            prescribed_histories,
            tractions,
            viscosities: vec![None; rocks],
            isotropic: vec![false; rocks],
            initial_stress: None,
            pressures: vec![(Profile::constant(0.0), Body::ALWAYS); fractures],
            pressures_from: vec![None; fractures],
            pore_changes: vec![unchanged; rocks],
            pore_fields: Vec::new(),
            fluid: None,
            gaps: vec![0.0; fractures],
            histories: histories.0,
            time: None,
            onset: None,
            solver: SolverSection::default(),
            mesh: built.mesh,
            fractures: built.fractures,
        }
    }
}

/// A fluid of this viscosity [Pa s] in every fracture of a body, without sources.
pub(crate) fn fluid(body: &Body, viscosity: f64, channel: Channel) -> Fluid {
    Fluid {
        viscosity,
        compressibility: 0.0,
        density: 0.0,
        gravity: [0.0; 3],
        reference: 0.0,
        channels: vec![channel; body.fractures.names.len()],
        sources: Vec::new(),
        wells: Vec::new(),
    }
}
