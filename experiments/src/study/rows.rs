//! The folder of a study: `study.toml` says what is asked, `rows.csv` what is known.

use super::csv::records;
use super::findings::{Fields, Findings, Kept};
use super::measured::Measured;
use super::product::Case;
use super::{Kind, Name, Study};
use crate::report::write_whole;
use anyhow::{Context, bail, ensure};
use fracas_figures::{Spectrum, quote};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use toml::{Table, Value};

const STUDY: &str = "study.toml";
const ROWS: &str = "rows.csv";
const KEPT: &str = "kept";

/// Rows on the disk, and the file that takes further ones; no second process takes it.
pub(super) struct Rows {
    path: PathBuf,
    file: File,
    header: Vec<String>,
    /// Fields by number of the row.
    known: BTreeMap<usize, Vec<String>>,
}

impl Rows {
    /// Takes a folder that is new, or that holds this study.
    ///
    /// # Errors
    /// A folder with something else, another study, or another process at work.
    pub(super) fn open(study: &Study, out: &Path) -> anyhow::Result<Self> {
        let cannot = || format!("cannot write into {}", out.display());
        std::fs::create_dir_all(out).with_context(cannot)?;
        let said = toml::to_string(study)?;
        let place = out.join(STUDY);
        if place.exists() {
            let there = std::fs::read_to_string(&place).with_context(cannot)?;
            if there != said {
                let name = place.display().to_string();
                if let Some(difference) = changed(&there, study, &said, &name)? {
                    bail!(
                        "{} holds another study: {difference}; choose another --out",
                        out.display()
                    );
                }
                write_whole(&place, &said)?;
            }
        } else {
            let mut entries = std::fs::read_dir(out).with_context(cannot)?;
            ensure!(
                entries.next().is_none(),
                "{} is not empty and holds no study; choose another --out",
                out.display()
            );
            write_whole(&place, &said)?;
        }
        let path = out.join(ROWS);
        let file = (OpenOptions::new().read(true).write(true).create(true))
            .truncate(false)
            .open(&path)
            .with_context(cannot)?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => {
                bail!("another process is at work in {}", out.display())
            }
            // a filesystem without locks
            Ok(()) | Err(TryLockError::Error(_)) => {}
        }
        let mut rows = Self {
            path,
            file,
            header: header(study),
            known: BTreeMap::new(),
        };
        rows.read()?;
        Ok(rows)
    }

    /// Reads what is there, and cuts a row off that was not written to its end.
    fn read(&mut self) -> anyhow::Result<()> {
        let mut text = String::new();
        self.file.read_to_string(&mut text)?;
        let records = records(&text);
        let name = self.path.display();
        let mut lines = records.iter();
        match lines.next() {
            Some(first) => ensure!(first.fields == self.header, "{name} has other columns"),
            None => {
                self.file.set_len(0)?;
                self.file.seek(SeekFrom::Start(0))?;
                return self.append(&self.header.clone());
            }
        }
        for record in lines {
            let number = record.fields[0].parse().ok();
            let number = number.filter(|_| record.fields.len() == self.header.len());
            let number = number.with_context(|| {
                format!("{name} has a row that is none: {}", record.fields.join(","))
            })?;
            self.known.insert(number, record.fields.clone());
        }
        let end = records.last().map_or(0, |last| last.end) as u64;
        self.file.set_len(end)?;
        self.file.seek(SeekFrom::Start(end))?;
        Ok(())
    }

    fn append(&mut self, fields: &[String]) -> anyhow::Result<()> {
        let write = |file: &mut File| {
            file.write_all(line(fields).as_bytes())?;
            file.sync_data()
        };
        write(&mut self.file).with_context(|| format!("cannot write {}", self.path.display()))
    }

    /// True where it holds none yet.
    pub(super) fn is_empty(&self) -> bool {
        self.known.is_empty()
    }

    /// True where a row need not be solved again.
    pub(super) fn knows(&self, case: &Case) -> bool {
        self.known.contains_key(&case.number)
    }

    /// Puts a row on the disk; gives its outcome.
    pub(super) fn push(
        &mut self,
        study: &Study,
        case: &Case,
        measured: &Measured,
    ) -> anyhow::Result<String> {
        let (fields, kept) = fields(study, case, measured);
        if kept != Kept::default() {
            let folder = self.path.with_file_name(KEPT);
            std::fs::create_dir_all(&folder)?;
            let text = toml::to_string(&kept)?;
            write_whole(&folder.join(format!("{}.toml", case.number)), &text)?;
        }
        self.append(&fields)?;
        self.known.insert(case.number, fields);
        let outcome = measured.outcome.map_or(String::new(), |o| o.to_string());
        Ok(outcome)
    }

    /// Brings the file into the order of the product, where several rows at once have left another one.
    pub(super) fn close(self, study: &Study) -> anyhow::Result<Findings> {
        let mut text = line(&self.header);
        self.known.values().for_each(|fields| text += &line(fields));
        if std::fs::read_to_string(&self.path)? != text {
            write_whole(&self.path, &text)?;
        }
        let findings = Findings::new(self.header, &study.published);
        let mut all_kept = BTreeMap::new();
        for number in self.known.keys() {
            let file = self
                .path
                .with_file_name(KEPT)
                .join(format!("{number}.toml"));
            if let Ok(text) = std::fs::read_to_string(file) {
                all_kept.insert(*number, toml::from_str(&text)?);
            }
        }
        Ok(findings.with_rows(self.known.into_values().collect(), all_kept))
    }
}

/// A row as fields, and its eigenvalues and residuals where they are needed later.
pub(super) fn fields(study: &Study, case: &Case, measured: &Measured) -> (Fields, Kept) {
    let mut fields = vec![case.number.to_string()];
    fields.extend(case.fields.iter().cloned());
    fields.push(
        measured
            .run
            .as_ref()
            .map_or(String::new(), |r| r.ran.clone()),
    );
    let measures = study.measured().into_iter().map(|name| {
        let is_told = study.clock || !name.is_measured();
        if is_told {
            name.field(measured)
        } else {
            String::new()
        }
    });
    fields.extend(measures);
    fields.push(measured.outcome.map_or(String::new(), |o| o.to_string()));
    // a row is a line
    let reason = measured.reasons.join("; ");
    fields.push(reason.split_whitespace().collect::<Vec<_>>().join(" "));
    let [spectra, residuals] = study.keeps();
    let spectrum = measured.spectrum.as_ref().filter(|_| spectra);
    let kept = Kept {
        residuals: if residuals {
            measured.residuals.clone()
        } else {
            Vec::new()
        },
        spectrum: spectrum.map(Spectrum::from),
    };
    (fields, kept)
}

/// Names of the columns.
pub(super) fn header(study: &Study) -> Vec<String> {
    let measures = study
        .measured()
        .into_iter()
        .map(|name| name.text().to_owned());
    (["row".to_owned()].into_iter())
        .chain(study.axis_names())
        .chain(["ran".to_owned()])
        .chain(measures)
        .chain(["outcome", "reason"].map(String::from))
        .collect()
}

fn line(fields: &[String]) -> String {
    let fields: Vec<String> = fields.iter().map(|field| quote(field)).collect();
    format!("{}\n", fields.join(","))
}

/// What is shown of rows, and changes none of them.
const SHOWN: &[&str] = &[
    "title",
    "question",
    "setup",
    "expect",
    "note",
    "figure",
    "table",
    "check",
    "published",
];

/// What keeps a study from the rows of the one that is there; figures, tables and checks may be others where they ask for the same
/// measures, and for nothing that was not kept.
fn changed(there: &str, study: &Study, said: &str, name: &str) -> anyhow::Result<Option<String>> {
    let [mut old, mut new]: [Table; 2] = [there.parse()?, said.parse()?];
    for key in SHOWN {
        old.remove(*key);
        new.remove(*key);
    }
    // what figures and checks name is measured, too
    old.remove("measures");
    new.remove("measures");
    if let Some(difference) = difference(&old, &new, "") {
        return Ok(Some(difference));
    }
    let there = Study::from_toml(there, name, Path::new(""), None)?;
    let [old, new] = [there.measured(), study.measured()];
    let lacks = |names: &[Name], others: &[Name]| {
        let lacking = names.iter().find(|name| !others.contains(name));
        lacking.map(|name| name.text())
    };
    if let Some(measure) = lacks(&new, &old) {
        return Ok(Some(format!("its rows have no `{measure}`")));
    }
    if let Some(measure) = lacks(&old, &new) {
        return Ok(Some(format!(
            "its rows have `{measure}`, too, which `measures` may name"
        )));
    }
    let [[spectra, residuals], asked] = [there.keeps(), study.keeps()];
    let draws = |study: &Study, kind| study.figure.iter().any(|figure| figure.kind == kind);
    let mut of_one = [Kind::Pseudospectra, Kind::GmresBounds].into_iter();
    let more = of_one.any(|kind| draws(study, kind) && !draws(&there, kind));
    Ok(match () {
        () if (asked[0] && !spectra) || more => {
            Some("the spectra that a figure or a check needs were not kept".into())
        }
        () if asked[1] && !residuals => {
            Some("the residuals that a figure needs were not kept".into())
        }
        () => None,
    })
}

/// The first key whose value is another one, in words.
fn difference(there: &Table, asked: &Table, path: &str) -> Option<String> {
    let keys = there.keys().chain(asked.keys());
    keys.into_iter().find_map(|key| {
        let (old, new) = (there.get(key), asked.get(key));
        let path = format!("{path}{key}");
        if let (Some(Value::Table(old)), Some(Value::Table(new))) = (old, new) {
            return difference(old, new, &format!("{path}."));
        }
        let said = |value: Option<&Value>| value.map_or("nothing".into(), ToString::to_string);
        (old != new).then(|| format!("its `{path}` is {}, not {}", said(old), said(new)))
    })
}
