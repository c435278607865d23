//! `fracas schema`: JSON Schema of the scene file.

use super::Status;
use std::io::Write;

pub(super) fn run(out: &mut dyn Write) -> anyhow::Result<Status> {
    writeln!(
        out,
        "{}",
        serde_json::to_string_pretty(&fracas::scene::schema())?
    )?;
    Ok(Status::Done)
}
