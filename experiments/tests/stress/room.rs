//! The room: so many cases of a kind, each from its seed and its number, none of which may panic, hang or lie.

use crate::generator::generator;
use fracas_operators::random::Random;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Once};
use std::time::{Duration, Instant};

/// A case that takes longer hangs.
const PATIENCE: Duration = Duration::from_secs(20);

/// Findings that are shown.
const SHOWN: usize = 8;

/// How a case ended.
pub(crate) enum Verdict {
    /// With an error in one sentence.
    Refused,
    /// It was taken for what it says.
    Taken,
    /// Something that must not be.
    Finding(String),
}

/// A number from the environment.
fn asked(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.replace('_', "").parse().ok()
}

/// Seed of all cases: `FRACAS_STRESS_SEED`, else 1.
pub(crate) fn seed() -> u64 {
    asked("FRACAS_STRESS_SEED").unwrap_or(1)
}

/// Cases of a kind: `share` of `FRACAS_STRESS`, else `usual`.
pub(crate) fn count(share: f64, usual: u64) -> u64 {
    asked("FRACAS_STRESS").map_or(usual, |all| (share * all as f64).ceil() as u64)
}

/// A folder in memory where there is one.
pub(crate) fn scratch(name: &str) -> PathBuf {
    let shared = PathBuf::from("/dev/shm");
    let base = if shared.is_dir() {
        shared
    } else {
        std::env::temp_dir()
    };
    let folder = base.join(format!("fracas-stress-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Runs `cases` cases, or the one that `FRACAS_STRESS_CASE` names, and fails where one of them is a finding.
pub(crate) fn trial(kind: &'static str, cases: u64, mut one: impl FnMut(&mut Random) -> Verdict) {
    silence();
    let seed = seed();
    let (first, last) = match asked("FRACAS_STRESS_CASE") {
        Some(case) => (case, case + 1),
        None => (0, cases),
    };
    let watch = Watch::over(kind, seed);
    let clock = Instant::now();
    let (mut refused, mut taken, mut findings) = (0u64, 0u64, Vec::new());
    for case in first..last {
        watch.next(case);
        let mut g = generator(seed, kind, case);
        match catch_unwind(AssertUnwindSafe(|| one(&mut g))) {
            Ok(Verdict::Refused) => refused += 1,
            Ok(Verdict::Taken) => taken += 1,
            Ok(Verdict::Finding(what)) => findings.push(format!("case {case}: {what}")),
            Err(panic) => {
                let what = panic.downcast_ref::<String>().cloned();
                let what = what.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
                findings.push(format!("case {case}: panic: {}", what.unwrap_or_default()));
            }
        }
    }
    eprintln!(
        "| {kind} | {seed} | {} | {taken} | {refused} | {} | {:.0} |",
        last - first,
        findings.len(),
        clock.elapsed().as_secs_f64()
    );
    let shown: Vec<&String> = findings.iter().take(SHOWN).collect();
    assert!(
        findings.is_empty(),
        "{kind}, seed {seed}: {} findings\n{shown:#?}",
        findings.len()
    );
}

/// Panics inside a case are counted, not printed.
fn silence() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let usual = std::panic::take_hook();
        set_hook(Box::new(move |info| {
            if std::env::var_os("FRACAS_STRESS_CASE").is_some() || is_verdict(info) {
                usual(info);
            }
        }));
    });
}

/// True for the panic that fails the test itself.
fn is_verdict(info: &std::panic::PanicHookInfo<'_>) -> bool {
    info.location()
        .is_some_and(|l| l.file().contains("tests/stress"))
}

/// Ends the process where a case hangs.
struct Watch {
    case: Arc<AtomicU64>,
    done: Arc<AtomicBool>,
}

impl Watch {
    fn over(kind: &'static str, seed: u64) -> Self {
        let (case, done) = (
            Arc::new(AtomicU64::new(u64::MAX)),
            Arc::new(AtomicBool::new(false)),
        );
        let watch = Self {
            case: case.clone(),
            done: done.clone(),
        };
        std::thread::spawn(move || {
            let (mut last, mut since) = (u64::MAX, Instant::now());
            while !done.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(500));
                let now = case.load(Ordering::Relaxed);
                if now != last {
                    (last, since) = (now, Instant::now());
                } else if since.elapsed() > PATIENCE {
                    eprintln!("{kind}, seed {seed}, case {now} hangs");
                    std::process::abort();
                }
            }
        });
        watch
    }

    fn next(&self, case: u64) {
        self.case.store(case, Ordering::Relaxed);
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.done.store(true, Ordering::Relaxed);
    }
}
