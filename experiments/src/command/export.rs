//! `fracas export`: a system folder.

use super::progress::Progress;
use super::source::Assembly;
use super::{Status, output};
use clap::Args;
use fracas::io::face_table;
use fracas_operators::matrix_market::write_dense;
use fracas_solvers::saddle::folder::write_folder;
use std::io::Write;
use std::path::PathBuf;

#[derive(Args, Debug)]
pub(super) struct Export {
    /// Scene file, or the name of a scene of the gallery.
    #[arg(value_name = "SCENE")]
    scene: String,
    #[command(flatten)]
    assembly: Assembly,
    /// Folder to write.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

impl Export {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        output::folder(&self.out)?;
        let mut progress = Progress::new();
        let system = self.assembly.assemble(&self.scene, &mut progress)?;
        write_folder(&self.out, &system.blocks, &system.manifest)?;
        if let Some(body) = &system.body {
            write_dense(&self.out.join("faces.mtx"), &face_table(&body.fractures))?;
        }
        writeln!(out, "{}", self.out.display())?;
        Ok(Status::Done)
    }
}
