//! `fracas scene`: a scene of the gallery as the file that it is.

use super::Status;
use crate::scenes;
use clap::Args;
use std::io::Write;

/// Prints a scene of the gallery, as a beginning of one's own.
#[derive(Args, Debug)]
pub(super) struct Show {
    /// Name of the scene; `list` prints all.
    #[arg(value_name = "NAME")]
    name: String,
}

impl Show {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        out.write_all(scenes::of_gallery(&self.name)?.toml.as_bytes())?;
        Ok(Status::Done)
    }
}
