//! `fracas scene`: a scene of the gallery as the file that it is, or any scene with its `[geology]` written out.

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
    /// Writes grid lines, boxes and a shear in the place of [geology], also of a scene file.
    #[arg(long)]
    expand: bool,
}

impl Show {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        let text = match self.expand {
            true => scenes::load(&self.name)?.to_toml()?,
            false => scenes::of_gallery(&self.name)?.toml.to_owned(),
        };
        out.write_all(text.as_bytes())?;
        Ok(Status::Done)
    }
}
