//! Rows one after the other, or several at once, each on the disk before its thread begins another one.

use super::Study;
use super::page;
use super::product::{Case, Origin};
use super::rows::Rows;
use anyhow::Context;
use fracas::run::Stop;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, mpsc};

/// A study with the folder that it fills.
pub struct Engine<'a> {
    /// What is asked.
    pub study: &'a Study,
    /// Where the answer goes.
    pub out: &'a Path,
    /// Rows at once, each on its share of the threads.
    pub jobs: usize,
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ended {
    /// Rows that are on the disk.
    pub done: usize,
    /// Rows of the study.
    pub total: usize,
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
        let findings = rows.close()?;
        let ended = Ended {
            done: findings.rows.len(),
            total,
        };
        page::write(self, &findings, &ended)?;
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
        let mut reference = None;
        while stop.asked().is_none() {
            let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) else {
                break;
            };
            let Some(measured) = pool.install(|| case.measured(self.study, &mut reference, stop))
            else {
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
    let scenes = cases
        .iter()
        .filter(|c| matches!(c.origin, Origin::Scene(_)));
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
