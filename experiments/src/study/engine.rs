//! Rows one after the other, or several at once, each on the disk before its thread begins another one.

use super::findings::Findings;
use super::measured::Measured;
use super::page;
use super::product::Case;
use super::rows::{self, Rows};
use super::solving::{Row, Shared};
use super::sources;
use super::{Name, Study};
use crate::report::Formats;
use anyhow::{Context, bail};
use fracas::run::Stop;
use rayon::ThreadPool;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, mpsc};

/// A study with the folder that it fills.
pub struct Engine<'a> {
    /// What is asked.
    pub study: &'a Study,
    /// Where the answer goes.
    pub out: &'a Path,
    /// Rows at once, each on its share of the threads.
    pub jobs: usize,
    /// Formats of its figures.
    pub formats: Formats,
}

/// A row that ended.
#[derive(Clone, Debug)]
pub struct Taken {
    /// Rows done, with those of before.
    pub done: usize,
    /// Rows of the study.
    pub total: usize,
    /// Its axes, in words.
    pub name: String,
    /// Its outcome, in a word.
    pub outcome: String,
}

/// How a study ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ended {
    /// Rows that are on the disk.
    pub done: usize,
    /// Rows of the study.
    pub total: usize,
    /// Checks that fail, a sentence each.
    pub failed: Vec<String>,
}

impl Ended {
    /// True where no row is left.
    pub fn is_complete(&self) -> bool {
        self.done == self.total
    }
}

impl Engine<'_> {
    /// Solves the rows that the folder does not hold, then writes figures and page; `tell` hears of the rows of before as one number,
    /// then of every row.
    ///
    /// # Errors
    /// A study without a row that can be read, a folder of something else, files that cannot be written; a row that fails is none.
    pub fn run(
        &self,
        stop: &(dyn Stop + Sync),
        mut tell: impl FnMut(&Taken),
    ) -> anyhow::Result<Ended> {
        let cases = self.study.product()?;
        require_one_that_reads(&cases)?;
        let rows = Rows::open(self.study, self.out)?;
        sources::same(&cases, self.out, !rows.is_empty())?;
        let total = cases.len();
        let left: Vec<&Case> = cases.iter().filter(|case| !rows.knows(case)).collect();
        let before = total - left.len();
        let jobs = self.jobs.clamp(1, left.len().max(1));
        let threads = (rayon::current_num_threads() / jobs).max(1);
        let (rows, next) = (Mutex::new(rows), AtomicUsize::new(0));
        let (rows_of, left_of, next_of) = (&rows, &left, &next);
        std::thread::scope(|scope| {
            let (sender, receiver) = mpsc::channel();
            let workers: Vec<_> = (0..jobs)
                .map(|_| {
                    let sender = sender.clone();
                    scope.spawn(move || {
                        let say = |name, outcome| {
                            // nobody listens any more where another worker has failed
                            let _ = sender.send((name, outcome));
                        };
                        self.work(left_of, next_of, threads, rows_of, stop, say)
                    })
                })
                .collect();
            drop(sender);
            for (done, (name, outcome)) in receiver.into_iter().enumerate() {
                tell(&Taken {
                    done: before + done + 1,
                    total,
                    name,
                    outcome,
                });
            }
            workers
                .into_iter()
                .try_for_each(|worker| match worker.join() {
                    Ok(worked) => worked,
                    Err(panic) => std::panic::resume_unwind(panic),
                })
        })?;
        let rows = rows.into_inner().unwrap_or_else(|held| held.into_inner());
        let findings = rows.close(self.study)?;
        let mut ended = Ended {
            done: findings.rows.len(),
            total,
            failed: Vec::new(),
        };
        ended.failed = page::write(self, &findings, &ended)?;
        Ok(ended)
    }

    /// Takes the next row until none is left, or until somebody wants to stop.
    fn work(
        &self,
        cases: &[&Case],
        next: &AtomicUsize,
        threads: usize,
        rows: &Mutex<Rows>,
        stop: &(dyn Stop + Sync),
        say: impl Fn(String, String),
    ) -> anyhow::Result<()> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .context("no threads for a row")?;
        let mut shared = Shared::default();
        let names = self.study.measured();
        while stop.asked().is_none() {
            let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) else {
                break;
            };
            let row = row(self.study, case, &names, (stop, Some(self.out)));
            let Some(measured) = row.in_pool(&pool, &mut shared)? else {
                break;
            };
            let mut rows = rows.lock().unwrap_or_else(|held| held.into_inner());
            let outcome = rows.push(self.study, case, &measured)?;
            drop(rows);
            let name: Vec<&str> = (case.fields.iter())
                .map(String::as_str)
                .filter(|field| !field.is_empty() && *field != "default")
                .collect();
            say(name.join(" "), outcome);
        }
        Ok(())
    }
}

/// Refuses a study whose scenes cannot be read in a single row: then a key is wrong, and no row would say anything else.
fn require_one_that_reads(cases: &[Case]) -> anyhow::Result<()> {
    let scenes = cases.iter().filter(|c| c.setting.scene.is_some());
    let mut first = None;
    for case in scenes {
        match case.problem() {
            Ok(_) => return Ok(()),
            Err(error) => {
                first.get_or_insert(error);
            }
        }
    }
    first.map_or(Ok(()), Err)
}

fn row<'a>(
    study: &'a Study,
    case: &'a Case,
    names: &'a [Name],
    (stop, place): (&'a (dyn Stop + Sync), Option<&'a Path>),
) -> Row<'a> {
    let names = match case.only.as_slice() {
        [] => names,
        only => only,
    };
    Row {
        case,
        study,
        names,
        stop,
        place,
    }
}

impl Row<'_> {
    /// On the threads that it asks for, or on those of the pool.
    fn in_pool(&self, pool: &ThreadPool, shared: &mut Shared) -> anyhow::Result<Option<Measured>> {
        let Some(threads) = self.case.setting.threads else {
            return Ok(pool.install(|| self.measured(shared)));
        };
        let own = rayon::ThreadPoolBuilder::new()
            .num_threads(threads.into())
            .build()
            .context("no threads for a row")?;
        Ok(own.install(|| self.measured(shared)))
    }
}

/// Every row of a study, on no disk; `tell` hears of those that are done, and may stop.
///
/// # Errors
/// A study without a row that can be read; the wish to stop.
pub(super) fn in_memory(
    study: &Study,
    mut tell: impl FnMut(usize, usize) -> ControlFlow<()>,
) -> anyhow::Result<Findings> {
    let cases = study.product()?;
    require_one_that_reads(&cases)?;
    let pool = rayon::ThreadPoolBuilder::new().build()?;
    let never = AtomicBool::new(false);
    let names = study.measured();
    let (mut all, mut all_kept) = (Vec::new(), BTreeMap::new());
    let mut shared = Shared::default();
    for (done, case) in cases.iter().enumerate() {
        if tell(done, cases.len()) == ControlFlow::Break(()) {
            bail!("stopped on request");
        }
        let row = row(study, case, &names, (&never, None));
        let measured = row.in_pool(&pool, &mut shared)?.unwrap_or_default();
        let (fields, kept) = rows::fields(study, case, &measured);
        all.push(fields);
        all_kept.insert(case.number, kept);
    }
    let findings = Findings::new(rows::header(study), &study.published);
    Ok(findings.with_rows(all, all_kept))
}
