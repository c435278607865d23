//! Half, default and double of settings, counted over cases.

use fracas_solvers::steering::{Setting, Steering};
use fracas_solvers::{Observer, Step};

/// What a case took.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Count {
    /// Iterations of a system, rounds of a run.
    pub(super) n_it: usize,
    /// C_s of a system, Krylov iterations of a run.
    pub(super) cost: f64,
}

/// A setting over all cases; counts are those of half, default and double, `None` where there is no solution.
#[derive(Debug)]
pub(super) struct Row {
    /// What it is a setting of.
    pub(super) of: &'static str,
    pub(super) setting: &'static str,
    pub(super) values: [f64; 3],
    pub(super) cases: Vec<(String, [Option<Count>; 3])>,
}

/// Whether half or double counts otherwise than the default.
pub(super) fn differ(counts: &[Option<Count>; 3]) -> bool {
    counts[0] != counts[1] || counts[2] != counts[1]
}

impl Row {
    /// Cases that change.
    pub(super) fn changed(&self) -> usize {
        self.cases
            .iter()
            .filter(|(_, counts)| differ(counts))
            .count()
    }

    /// n_it, cost and failures by half, default and double, over cases that have a solution by all three, and over all.
    pub(super) fn totals(&self) -> [[f64; 3]; 3] {
        let mut totals = [[0.0; 3]; 3];
        for (_, counts) in &self.cases {
            let solved = counts.iter().all(Option::is_some);
            for (total, count) in totals.iter_mut().zip(counts) {
                match count {
                    Some(count) if solved => {
                        total[0] += count.n_it as f64;
                        total[1] += count.cost;
                    }
                    Some(_) => {}
                    None => total[2] += 1.0,
                }
            }
        }
        totals
    }

    /// Cost of half (0) or double (2) over that of the default.
    pub(super) fn ratio(&self, k: usize) -> f64 {
        let totals = self.totals();
        totals[k][1] / totals[1][1]
    }

    /// Cost of the default over the least.
    pub(super) fn excess(&self) -> f64 {
        1.0 / self.ratio(0).min(self.ratio(2)).min(1.0)
    }
}

/// Every setting of `S`, one after the other, the others at `default`.
///
/// # Errors
/// Those of `count`, and an observer that stops.
pub(super) fn sweep<S: Steering>(
    of: &'static str,
    default: S,
    names: &[String],
    mut count: impl FnMut(usize, S) -> anyhow::Result<Option<Count>>,
    observer: &mut dyn Observer,
) -> anyhow::Result<Vec<Row>> {
    let mut at = |settings: S| {
        (0..names.len())
            .map(|k| count(k, settings))
            .collect::<anyhow::Result<Vec<_>>>()
    };
    let standard = at(default)?;
    let mut rows = Vec::new();
    let total = S::SETTINGS.len();
    for (done, setting) in S::SETTINGS.iter().enumerate() {
        if observer
            .observe(&Step::Progress {
                stage: of,
                done,
                total,
            })
            .is_break()
        {
            anyhow::bail!("stopped on request");
        }
        let [half, double] = [0.5, 2.0].map(|factor| changed(setting, default, factor));
        let values = [half, default, double].map(|settings| (setting.value)(&settings));
        let (half, double) = (at(half)?, at(double)?);
        let counts =
            (0..names.len()).map(|k| (names[k].clone(), [half[k], standard[k], double[k]]));
        rows.push(Row {
            of,
            setting: setting.name,
            values,
            cases: counts.collect(),
        });
    }
    Ok(rows)
}

/// The setting times this, or the end of its range.
fn changed<S: Steering>(setting: &Setting<S>, default: S, factor: f64) -> S {
    let mut settings = default;
    let [least, most] = setting.range;
    (setting.set)(
        &mut settings,
        (factor * (setting.value)(&default)).clamp(least, most),
    );
    settings
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas::scene::Rounds;
    use fracas_solvers::Silent;

    #[test]
    fn every_setting_is_halved_and_doubled_alone_and_within_its_range() {
        let names = ["one".to_owned(), "two".to_owned()];
        // only patience counts, and the second case has no solution with less of it
        let count = |k: usize, rounds: Rounds| {
            let solved = k == 0 || rounds.patience >= Rounds::default().patience;
            Ok(solved.then_some(Count {
                n_it: rounds.patience,
                cost: rounds.patience as f64,
            }))
        };
        let rows = sweep("rounds", Rounds::default(), &names, count, &mut Silent).unwrap();
        assert_eq!(rows.len(), Rounds::SETTINGS.len());
        for row in &rows {
            let patience = row.setting == "patience";
            assert_eq!(
                row.changed(),
                if patience { 2 } else { 0 },
                "{}",
                row.setting
            );
            let [half, default, double] = row.values;
            assert!(half <= default && default <= double);
        }
        let patience = rows.iter().find(|row| row.setting == "patience").unwrap();
        assert_eq!(patience.values, [10.0, 20.0, 40.0]);
        assert_eq!(patience.totals().map(|t| t[2]), [1.0, 0.0, 0.0]);
        assert_eq!((patience.ratio(0), patience.ratio(2)), (0.5, 2.0));
        assert_eq!(patience.excess(), 2.0);
        let last = rows.iter().find(|row| row.setting == "last").unwrap();
        assert_eq!(last.values, [0.15, 0.3, 0.6]);
        let slow = rows.iter().find(|row| row.setting == "slow").unwrap();
        assert_eq!(slow.values[0], 1.0);
    }
}
