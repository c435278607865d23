//! Eigenvectors as files: fields on the mesh of a scene, tables of a system folder.

use super::output;
use anyhow::Context;
use clap::Args;
use fracas::io::Snapshot;
use fracas::scene::Body;
use fracas::solve::Loaded;
use fracas_solvers::saddle::DofCoordinate;
use fracas_solvers::spectrum::{Mode, ModeTarget, SpectrumReport};
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Which eigenvectors, and where to put them.
#[derive(Args, Debug)]
pub(super) struct Modes {
    /// Eigenvectors wanted: smallest, largest, or the one closest to a number.
    #[arg(
        long,
        value_name = "M,…",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    pub(super) modes: Vec<ModeTarget>,
    /// Writes them: mode_000_body.vtu and mode_000_fracture.vtu, or CSV for a system folder, and modes.csv.
    #[arg(long, value_name = "DIR", requires = "modes")]
    vtu: Option<PathBuf>,
}

impl Modes {
    /// Writes the modes of a report, where that is asked for.
    pub(super) fn write(&self, system: &Loaded, report: &SpectrumReport) -> anyhow::Result<()> {
        let wanted = self.modes.len();
        if wanted > 0 && report.modes.is_empty() {
            anyhow::bail!(
                "no eigenvector was computed for n_u + n_t = {}; raise --dense-limit, or take another --inner",
                report.n_u + report.n_t
            );
        }
        let Some(folder) = &self.vtu else {
            return Ok(());
        };
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot create {}", folder.display()))?;
        let mut table = String::from(TABLE_HEAD);
        for (k, mode) in report.modes.iter().enumerate() {
            let peaks = Peaks::of(mode, system);
            let (re, im) = mode.eigenvalue;
            write!(
                table,
                "{k},{re:e},{im:e},{:e},{:e}",
                mode.residual, mode.traction_share
            )?;
            for place in [peaks.traction, peaks.displacement] {
                match place {
                    Some([x, y, z]) => write!(table, ",{x},{y},{z}")?,
                    None => table.push_str(",,,"),
                }
            }
            table.push('\n');
            let at = |end: &str| folder.join(format!("mode_{k:03}_{end}"));
            match &system.body {
                Some(body) => {
                    let state = Snapshot::homogeneous(body, &mode.u, &mode.t);
                    file(&at("body.vtu"), |out| state.write_body(out))?;
                    file(&at("fracture.vtu"), |out| state.write_fracture(out))?;
                }
                None => {
                    let places = system.blocks.coordinates.as_deref();
                    output::file(&at("u.csv"), &displacements(&mode.u, places)?)?;
                    output::file(&at("t.csv"), &by_unknown(&mode.t)?)?;
                    if !mode.p.is_empty() {
                        output::file(&at("p.csv"), &by_unknown(&mode.p)?)?;
                    }
                }
            }
        }
        output::file(&folder.join("modes.csv"), &table)
    }
}

const TABLE_HEAD: &str = "mode,re,im,residual,traction_share,\
    traction_x,traction_y,traction_z,displacement_x,displacement_y,displacement_z\n";

/// Where a mode is largest [m], as far as that is known.
struct Peaks {
    /// Centre of the face with the largest ‖t‖₂.
    traction: Option<[f64; 3]>,
    /// Place of the largest |u_i|.
    displacement: Option<[f64; 3]>,
}

impl Peaks {
    fn of(mode: &Mode, system: &Loaded) -> Self {
        let center = |body: &Arc<Body>| {
            let norms = mode.t.chunks_exact(3);
            let face = largest(norms.map(|t| t.iter().map(|v| v * v).sum()))?;
            Some(body.fractures.faces[face].center)
        };
        let place = |places: &Vec<DofCoordinate>| {
            let dof = largest(mode.u.iter().map(|v| v.abs()))?;
            Some(places[dof].position)
        };
        Self {
            traction: system.body.as_ref().and_then(center),
            displacement: system.blocks.coordinates.as_ref().and_then(place),
        }
    }
}

/// Index of the largest value, the first of equal ones.
fn largest(values: impl Iterator<Item = f64>) -> Option<usize> {
    values
        .enumerate()
        .reduce(|a, b| if b.1 > a.1 { b } else { a })
        .map(|(index, _)| index)
}

/// `x,y,z,component,value` per unknown, or `unknown,value` where no coordinates are known.
fn displacements(u: &[f64], places: Option<&[DofCoordinate]>) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    match places {
        Some(places) => {
            text.push_str("x,y,z,component,value\n");
            for (place, value) in places.iter().zip(u) {
                let [x, y, z] = place.position;
                writeln!(text, "{x},{y},{z},{},{value:e}", place.component)?;
            }
        }
        None => {
            text.push_str("unknown,value\n");
            for (i, value) in u.iter().enumerate() {
                writeln!(text, "{i},{value:e}")?;
            }
        }
    }
    Ok(text)
}

/// `unknown,value` per traction or pressure.
fn by_unknown(t: &[f64]) -> Result<String, std::fmt::Error> {
    let mut text = String::from("unknown,value\n");
    for (i, value) in t.iter().enumerate() {
        writeln!(text, "{i},{value:e}")?;
    }
    Ok(text)
}

/// Writes a file through a buffer.
fn file(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> anyhow::Result<()> {
    File::create(path)
        .and_then(|file| {
            let mut out = BufWriter::new(file);
            write(&mut out)?;
            out.flush()
        })
        .with_context(|| format!("cannot write {}", path.display()))
}
