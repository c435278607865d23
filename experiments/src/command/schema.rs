//! `fracas schema`: JSON Schema of the scene file, or its keys as a page.

use super::{Status, schema_page};
use clap::Args;
use std::io::Write;

/// JSON Schema of the scene file.
#[derive(Debug, Args)]
pub(super) struct Schema {
    /// Writes the tables of keys of docs/scenes.md instead, as Markdown
    #[arg(long)]
    page: bool,
}

impl Schema {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        match self.page {
            true => write!(out, "{}", schema_page::page())?,
            false => {
                let schema = serde_json::to_string_pretty(&fracas::scene::schema())?;
                writeln!(out, "{schema}")?;
            }
        }
        Ok(Status::Done)
    }
}
