//! Which steps a page shows.

use fracas::run::History;
use std::str::FromStr;

/// Steps that are shown at most.
const MOST: usize = 8;

/// Figures that stand side by side.
const BESIDE: usize = 4;

/// Steps of a page, as `--page-steps` has them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum PageSteps {
    /// The first, that in which slip or opening begins, that of the largest slip, and the last.
    #[default]
    Telling,
    /// These.
    These(Vec<usize>),
    /// None: history and totals alone.
    None,
}

impl FromStr for PageSteps {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.is_empty() {
            return Ok(Self::Telling);
        }
        if text == "none" {
            return Ok(Self::None);
        }
        let steps: Result<Vec<usize>, _> = text.split(',').map(|s| s.trim().parse()).collect();
        let mut steps = steps.map_err(|_| "write steps, as in 0,4,12, or `none`".to_owned())?;
        steps.sort_unstable();
        steps.dedup();
        match steps.len() {
            ..=MOST => Ok(Self::These(steps)),
            n => Err(format!("{n} steps are too many: {MOST} at most")),
        }
    }
}

/// A step and why it is shown.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Chosen {
    pub(super) step: usize,
    /// `slip begins, largest slip`; empty for one that was asked for.
    pub(super) why: String,
}

impl PageSteps {
    /// Steps in order, each with fields in the folder, and what is to be said of the others.
    pub(super) fn choose(
        &self,
        history: &History,
        with_fields: &[usize],
    ) -> (Vec<Chosen>, Vec<String>) {
        let wanted = match self {
            Self::None => Vec::new(),
            Self::Telling => telling(history),
            Self::These(steps) => steps.iter().map(|s| (*s, String::new())).collect(),
        };
        let (mut chosen, mut notes): (Vec<Chosen>, Vec<String>) = (Vec::new(), Vec::new());
        for (step, why) in wanted {
            let at = with_fields.partition_point(|s| *s < step);
            let Some(found) = with_fields.get(at).or(with_fields.last()) else {
                continue;
            };
            if *found != step {
                let of = match why.is_empty() {
                    true => String::new(),
                    false => format!(" ({why})"),
                };
                notes.push(format!(
                    "No fields of step {step}{of} are in this folder: step {found} stands for it. `--fields-every 1` writes those of every step."
                ));
            }
            match chosen.last_mut() {
                Some(last) if last.step == *found => {
                    if last.why.is_empty() {
                        last.why = why;
                    } else if !why.is_empty() {
                        last.why += &format!(", {why}");
                    }
                }
                _ => chosen.push(Chosen { step: *found, why }),
            }
        }
        (chosen, notes)
    }
}

/// The steps that tell most, in order.
fn telling(history: &History) -> Vec<(usize, String)> {
    let column = |name| history.column(name).collect::<Vec<f64>>();
    let steps = column("step");
    let [new, slip, open] = ["newslip", "slip", "open"].map(column);
    let largest = column("slip_max_m");
    let mut found: Vec<(usize, &str)> = Vec::new();
    let last = steps.len().saturating_sub(1);
    if !steps.is_empty() {
        found.push((0, "first"));
    }
    let begins = |of: &dyn Fn(usize) -> f64| (0..steps.len()).find(|k| of(*k) > 0.0);
    let slips = begins(&|k| new[k] + slip[k]).map(|k| (k, "slip begins"));
    let opens = begins(&|k| open[k]).map(|k| (k, "opening begins"));
    found.extend(slips.into_iter().chain(opens));
    let most = largest.iter().fold(0.0, |m: f64, x| m.max(*x));
    // the first of those that are the same but for rounding
    let reached = (0..steps.len()).find(|k| most > 0.0 && largest[*k] >= (1.0 - 1e-6) * most);
    found.extend(reached.map(|k| (k, "largest slip")));
    if last > 0 {
        found.push((last, "last"));
    }
    let places = |found: &[(usize, &str)]| {
        let mut places: Vec<usize> = found.iter().map(|(k, _)| *k).collect();
        places.sort_unstable();
        places.dedup();
        places.len()
    };
    if places(&found) > BESIDE {
        // the later of two beginnings
        let later = slips.max(opens);
        found.retain(|one| Some(*one) != later);
    }
    // in order of time, what is said of one step in the order of above
    found.sort_by_key(|(k, _)| *k);
    let mut told: Vec<(usize, String)> = Vec::new();
    for (k, why) in found {
        let step = steps[k] as usize;
        match told.last_mut() {
            Some((last, words)) if *last == step => *words += &format!(", {why}"),
            _ => told.push((step, why.to_owned())),
        }
    }
    told
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_is_read_in_order_and_nonsense_refused() {
        assert_eq!("4, 0,4".parse(), Ok(PageSteps::These(vec![0, 4])));
        assert_eq!("none".parse(), Ok(PageSteps::None));
        for text in ["1,", "1;2", "-1", "0,1,2,3,4,5,6,7,8"] {
            assert!(text.parse::<PageSteps>().is_err(), "{text}");
        }
    }

    #[test]
    fn a_step_without_fields_is_stood_for_by_the_next_that_has_some() {
        let these = PageSteps::These(vec![0, 3, 4, 9]);
        let (chosen, notes) = these.choose(&History::default(), &[0, 4, 8]);
        let steps: Vec<usize> = chosen.iter().map(|c| c.step).collect();
        assert_eq!(steps, [0, 4, 8]);
        assert_eq!(notes.len(), 2);
        assert!(notes[1].starts_with("No fields of step 9"), "{notes:?}");
    }
}
