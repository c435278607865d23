//! `fracas check`: reads, meshes and audits without solving.

use super::Status;
use super::scene::{self, Overrides};
use clap::Args;
use fracas::memory;
use fracas::nonlinear::friction_remarks;
use fracas::undetermined;
use fracas_solvers::saddle::folder::read_folder;
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
                let audit = body.audit();
                write!(out, "{audit}{}", body.inventory())?;
                for remark in friction_remarks(&body) {
                    writeln!(out, "warning     {remark}")?;
                }
                undetermined::judge(name, &body, &audit.kernel)?;
            }
            (None, Some(folder)) => folder_audit(folder, out)?,
            (None, None) => anyhow::bail!("give a scene, or --system DIR"),
        }
        Ok(Status::Done)
    }
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
    for finding in &imported.findings {
        writeln!(out, "finding     {finding}")?;
    }
    Ok(())
}
