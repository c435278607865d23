//! Where a system comes from: a scene, a scene of the gallery by name, or a system folder.

use super::progress::Progress;
use anyhow::Context;
use clap::Args;
use fracas_solvers::saddle::SaddleBlocks;
use fracas_solvers::saddle::folder::{Manifest, read_folder};
use std::path::PathBuf;

/// A scene or a folder.
#[derive(Args, Debug)]
#[group(required = true, multiple = false)]
pub(super) struct Source {
    /// System folder (A.mtx, B1.mtx, …).
    #[arg(long, value_name = "DIR")]
    system: Option<PathBuf>,
}

/// A system with what is known about its origin.
pub(super) struct System {
    pub(super) blocks: SaddleBlocks,
    #[expect(dead_code)]
    pub(super) manifest: Manifest,
    /// Remarks of the import.
    pub(super) findings: Vec<String>,
    /// False when the folder holds no right-hand side at all.
    pub(super) has_rhs: bool,
}

impl Source {
    /// Reads or assembles the system; remarks go to the progress stream.
    pub(super) fn load(&self, progress: &mut Progress) -> anyhow::Result<System> {
        let folder = self
            .system
            .as_deref()
            .context("give a scene, or --system DIR")?;
        let imported = read_folder(folder)?;
        let findings: Vec<String> = imported.findings.iter().map(ToString::to_string).collect();
        for finding in &findings {
            progress.say(&format!("note: {finding}"));
        }
        let (blocks, manifest, has_rhs) = (imported.blocks, imported.manifest, imported.has_rhs);
        progress.say(&format!(
            "n_u = {}, n_t = {}, n_p = {}",
            blocks.n_u(),
            blocks.n_t(),
            blocks.n_p()
        ));
        Ok(System {
            blocks,
            manifest,
            findings,
            has_rhs,
        })
    }
}
