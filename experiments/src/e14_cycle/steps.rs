//! The scene from its first step to its last, and what its faces show.

use crate::report::{Cell, Table};
use fracas::nonlinear::{Accepted, FaceFields, Simulation};
use fracas::scene::{Body, Scene};
use fracas_solvers::Observer;

/// An accepted step and what its faces show.
pub(super) struct Row {
    pub(super) done: Accepted,
    pub(super) fields: FaceFields,
}

impl Row {
    /// Area-weighted mean of a quantity of faces.
    fn mean(&self, body: &Body, value: impl Fn(usize) -> f64) -> f64 {
        let faces = &body.fractures.faces;
        let area: f64 = faces.iter().map(|f| f.area).sum();
        let sum: f64 = faces
            .iter()
            .enumerate()
            .map(|(i, f)| f.area * value(i))
            .sum();
        sum / area
    }

    /// Component of a vector of faces along z, the direction of the shear.
    fn along_z(body: &Body, field: &[f64], f: usize) -> f64 {
        let frame = body.fractures.faces[f].frame;
        (0..3).map(|k| field[3 * f + k] * frame[k][2]).sum()
    }

    /// Mean traction along z [Pa].
    pub(super) fn shear(&self, body: &Body) -> f64 {
        self.mean(body, |f| Self::along_z(body, &self.fields.traction, f))
    }

    /// Mean −t_N [Pa].
    pub(super) fn pressure(&self, body: &Body) -> f64 {
        self.mean(body, |f| -self.fields.traction[3 * f])
    }

    /// Mean length of the shear traction [Pa].
    pub(super) fn friction(&self, body: &Body) -> f64 {
        self.mean(body, |f| {
            self.fields.traction[3 * f + 1].hypot(self.fields.traction[3 * f + 2])
        })
    }

    /// Mean jump along z [m].
    pub(super) fn slip(&self, body: &Body) -> f64 {
        self.mean(body, |f| Self::along_z(body, &self.fields.jump, f))
    }

    /// Mean aperture [m].
    pub(super) fn aperture(&self, body: &Body) -> f64 {
        self.mean(body, |f| self.fields.aperture[f])
    }

    /// A line of [`table`].
    pub(super) fn cells(&self, body: &Body) -> Vec<Cell> {
        let record = &self.done.record;
        let [stick, new, slip, open] = record.faces;
        vec![
            record.time.into(),
            stick.into(),
            new.into(),
            slip.into(),
            open.into(),
            record.changed_area.into(),
            (1e-6 * self.pressure(body)).into(),
            (1e-6 * self.shear(body)).into(),
            (1e3 * self.slip(body)).into(),
            (1e3 * self.aperture(body)).into(),
            record.active_it.into(),
            record.newton_it.into(),
            record.lin_it.into(),
            record.cuts.into(),
        ]
    }
}

/// Of the finest mesh.
pub(super) fn table() -> Table {
    Table::new(
        "e14_cycle",
        "Every step of the finest mesh: faces per state, means over the fracture, iterations of the three cycles.",
        &[
            "time [s]",
            "stick",
            "new slip",
            "slip",
            "open",
            "changed area [m²]",
            "mean −t_N [MPa]",
            "mean t_z [MPa]",
            "mean slip z [mm]",
            "mean aperture [mm]",
            "n_it active set",
            "n_it Newton",
            "n_it Krylov",
            "cuts",
        ],
    )
}

/// A mesh and its steps.
pub(super) struct Run {
    /// Cells per axis, in words.
    pub(super) name: String,
    pub(super) body: Body,
    pub(super) rows: Vec<Row>,
}

impl Run {
    /// Runs a scene to its end.
    pub(super) fn of(scene: &Scene, observer: &mut dyn Observer) -> anyhow::Result<Self> {
        let body = scene.build()?;
        let grid = body.mesh.grid.as_ref();
        let name = grid.map_or(String::new(), |g| {
            g.cells.map(|c| c.to_string()).join(" × ")
        });
        let rows = steps(&body, observer)?;
        Ok(Self { name, body, rows })
    }
}

fn steps(body: &Body, observer: &mut dyn Observer) -> anyhow::Result<Vec<Row>> {
    let mut simulation = Simulation::new(body)?;
    let mut rows: Vec<Row> = Vec::new();
    simulation.run(observer, |simulation, _, done| {
        rows.push(Row {
            fields: simulation.face_fields(&done.state),
            done: done.clone(),
        });
    })?;
    Ok(rows)
}
