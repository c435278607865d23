//! `fracas check`: reads, meshes and audits without solving.

use super::Status;
use super::scene::{self, Overrides};
use clap::Args;
use fracas::memory;
use fracas::nonlinear::{Simulation, SimulationError, friction_remarks};
use fracas::run::RunError;
use fracas::scene::{Body, Scene};
use fracas::undetermined;
use fracas_solvers::saddle::folder::read_folder;
use fracas_solvers::spectrum::{Certificate, certificate};
use std::io::Write;
use std::path::{Path, PathBuf};

#[derive(Args, Debug)]
pub(super) struct Check {
    #[command(flatten)]
    place: Place,
    #[command(flatten)]
    overrides: Overrides,
}

#[derive(Args, Debug)]
#[group(required = true, multiple = false)]
struct Place {
    /// Scene file, or the name of a scene of the gallery.
    #[arg(value_name = "SCENE")]
    scene: Option<String>,
    /// System folder: sizes, symmetry, empty rows and columns.
    #[arg(long, value_name = "DIR")]
    system: Option<PathBuf>,
}

impl Check {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        match (&self.place.scene, &self.place.system) {
            (Some(name), _) => {
                let scene = scene::load(name, &self.overrides)?;
                memory::room_for(name, &scene, memory::CHECK)?;
                let body = scene.build()?;
                writeln!(out, "scene       {}", scene.title())?;
                if let Some(geology) = scene.geology() {
                    write!(out, "{geology}")?;
                }
                let audit = body.audit();
                write!(out, "{audit}{}", body.inventory())?;
                write_friction(&body, out)?;
                for remark in friction_remarks(&body) {
                    writeln!(out, "warning     {remark}")?;
                }
                undetermined::judge(name, &body, &audit.kernel)?;
                judge_run(name, &scene, &body, out)?;
                certify(name, &scene, &body, out)?;
            }
            (None, Some(folder)) => {
                self.overrides.are_none()?;
                folder_audit(folder, out)?;
            }
            (None, None) => anyhow::bail!("give a scene, or --system DIR"),
        }
        Ok(Status::Done)
    }
}

/// What holds each fracture: values, or the least and the largest on its faces.
fn write_friction(body: &Body, out: &mut dyn Write) -> anyhow::Result<()> {
    let names = &body.fractures.names;
    // per fracture: angle [deg], cohesion [MPa], and with weakening angle [deg] and distance [m]
    let mut all = vec![[[f64::INFINITY, f64::NEG_INFINITY]; 4]; names.len()];
    for face in &body.fractures.faces {
        let Some(friction) = body.friction_of(face) else {
            continue;
        };
        let weakening = friction
            .weakening
            .map(|w| [w.angle.to_degrees(), w.distance]);
        let [dynamic, distance] = weakening.unwrap_or([f64::NAN; 2]);
        let (angle, cohesion) = (friction.angle.to_degrees(), 1e-6 * friction.cohesion);
        let values = [angle, cohesion, dynamic, distance];
        // NaN is neither the least nor the largest
        for ([low, high], value) in all[usize::from(face.fracture)].iter_mut().zip(values) {
            (*low, *high) = (low.min(value), high.max(value));
        }
    }
    let is_there = |[low, high]: [f64; 2]| low <= high;
    let told = |ends: [f64; 2], unit: &str| {
        let [low, high] = ends.map(|v| (1e6 * v).round() / 1e6);
        match low == high {
            true => format!("{low} {unit}"),
            false => format!("{low} to {high} {unit}"),
        }
    };
    for (name, [angle, cohesion, dynamic, distance]) in names.iter().zip(all) {
        if !is_there(angle) {
            continue;
        }
        write!(out, "friction    \"{name}\": {}", told(angle, "deg"))?;
        if cohesion != [0.0; 2] {
            write!(out, ", cohesion {}", told(cohesion, "MPa"))?;
        }
        if is_there(dynamic) {
            // least values: a `profile` may do both
            let way = if dynamic[0] > angle[0] { "up" } else { "down" };
            let (dynamic, distance) = (told(dynamic, "deg"), told(distance, "m"));
            write!(out, ", {way} to {dynamic} over {distance} of slip")?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// Refuses what `run` refuses before its first step.
fn judge_run(name: &str, scene: &Scene, body: &Body, out: &mut dyn Write) -> anyhow::Result<()> {
    let work = fracas::run::work_of(scene);
    if let Err(too_large) = memory::room_for(name, scene, work) {
        // another machine may have the room
        writeln!(out, "warning     a run is refused here: {too_large}")?;
        return Ok(());
    }
    let Err(source) = Simulation::new(body) else {
        return Ok(());
    };
    let name = name.to_owned();
    let refused = RunError::Simulation { name, source };
    let has_friction = body.friction.iter().any(Option::is_some);
    if has_friction
        || !matches!(
            refused,
            RunError::Simulation {
                source: SimulationError::NoFriction { .. },
                ..
            }
        )
    {
        return Err(refused.into());
    }
    // without any friction it is a scene of systems: `solve` and `spectrum` ask for none
    let why = anyhow::Error::from(refused);
    writeln!(out, "warning     a run is refused: {why:#}")?;
    Ok(())
}

/// Displacements up to which A is assembled for the bound of the inf-sup constant, too.
const ASSEMBLED: usize = 300_000;

/// Tractions up to which it is computed: some minutes.
const CERTIFIED: usize = 10_000_000;

/// Bounds the inf-sup constant, where time and memory suffice.
fn certify(name: &str, scene: &Scene, body: &Body, out: &mut dyn Write) -> anyhow::Result<()> {
    let tractions = 3 * body.fractures.faces.len();
    if tractions > CERTIFIED || memory::room_for(name, scene, memory::CERTIFICATE).is_err() {
        let why = "for want of time or memory";
        writeln!(
            out,
            "inf-sup     not computed for {tractions} tractions {why}"
        )?;
        return Ok(());
    }
    let h = Some(body.jump_stabilization());
    let system = body.stick_system(h);
    let is_small = 3 * body.mesh.nodes.len() <= ASSEMBLED;
    let found = match is_small && memory::room_for(name, scene, memory::BLOCKS).is_ok() {
        true => system.certificate_beside(&body.saddle_blocks(h)?)?,
        false => system.certificate()?,
    };
    write_certificate(found, out)
}

fn write_certificate(found: Option<Certificate>, out: &mut dyn Write) -> anyhow::Result<()> {
    match found {
        Some(Certificate { beta_squared, .. }) if beta_squared > 0.0 => writeln!(
            out,
            "inf-sup     β² ≥ {beta_squared:.3e} in the scale of Bᵀ diag(A)⁻¹B (local certificate)"
        )?,
        Some(_) => writeln!(
            out,
            "inf-sup     no positive bound: some tractions are seen neither by the displacements nor by H"
        )?,
        None => writeln!(out, "inf-sup     not stated for this system")?,
    }
    Ok(())
}

fn folder_audit(folder: &Path, out: &mut dyn Write) -> anyhow::Result<()> {
    let imported = read_folder(folder)?;
    let b = &imported.blocks;
    writeln!(
        out,
        "unknowns    n_u = {}, n_t = {}, n_p = {}",
        b.n_u(),
        b.n_t(),
        b.n_p()
    )?;
    let entries = |m: &Option<_>| {
        m.as_ref().map_or(
            "absent".to_owned(),
            |m: &fracas_operators::sparse::SparseMatrix<f64>| m.nnz().to_string(),
        )
    };
    writeln!(
        out,
        "entries     A {}, B1 {}, B2 {}, H {}",
        b.a.nnz(),
        b.b1.nnz(),
        entries(&b.b2),
        entries(&b.h)
    )?;
    if let Some(flow) = &b.flow {
        let open = (flow.q2.outer_iterator()).filter(|row| row.data().iter().any(|v| *v != 0.0));
        writeln!(
            out,
            "flow        Q1 {}, Q2 {}, T {} entries; the volume of {} of {} faces changes with the displacements",
            flow.q1.nnz(),
            flow.q2.nnz(),
            flow.t.nnz(),
            open.count(),
            b.n_p()
        )?;
    }
    for finding in &imported.findings {
        writeln!(out, "finding     {finding}")?;
    }
    write_certificate(certificate(b)?, out)?;
    Ok(())
}
