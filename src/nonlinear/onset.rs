//! When slip begins: a step in which it does is halved until the time is known as closely as the scene asks.

mod known;

use super::active_set::Settled;
use super::fields::given_pressures;
use super::times::{Target, length};
use super::{Accepted, Event, Simulation, State};
use crate::contact::ContactState;
use crate::scene::{Body, Onset};

pub use known::{Begins, Onsets, SlipOnset};

/// Share of the interval that is asked for within which its end is taken to be reached. Unit: 1.
const REACHED: f64 = 1e-3;

/// A body at a time, as it may be accepted.
struct Moment<'m> {
    states: &'m [ContactState],
    /// Fluid pressure per face [Pa], where a fluid flows.
    p: &'m [f64],
    time: f64,
    loaded: f64,
}

/// The search for onsets within a step.
pub(super) struct Search {
    asked: Onset,
    known: Onsets,
    /// Those that a run without the search had passed.
    passed: Vec<SlipOnset>,
    /// What begins in the last attempt that settled.
    begins: Vec<SlipOnset>,
    /// No shorter step settles: the time stays as it is known.
    is_over: bool,
}

impl Search {
    /// From a state on; none where the scene looks for no onset.
    pub(super) fn new(simulation: &Simulation<'_>, state: &State) -> Option<Self> {
        let asked = simulation.problem().body().onset?;
        let mut known = state.onsets.as_deref().cloned().unwrap_or_default();
        let is_new = state.onsets.is_none();
        if known.patch != asked.patch {
            known.found.retain(|onset| onset.begins == Begins::Face);
            known.until = None;
        }
        let is_other = is_new || known.patch != asked.patch;
        known.patch = asked.patch;
        let mut search = Self {
            asked,
            known,
            passed: Vec::new(),
            begins: Vec::new(),
            is_over: false,
        };
        if is_other && state.step > 0 {
            let at = Moment {
                states: &state.states,
                p: &state.p,
                time: state.time,
                loaded: state.loaded,
            };
            let slip = || {
                state
                    .slip
                    .chunks_exact(2)
                    .map(|s| s[0].hypot(s[1]))
                    .collect()
            };
            search.passed = search.begin(simulation, &at, None, slip);
            let passed = search.passed.iter().cloned();
            search.known.found.extend(passed);
        }
        Some(search)
    }

    /// The increment of the first attempt, where `planned` would be taken otherwise [s].
    pub(super) fn increment(&self, state: &State, planned: f64) -> f64 {
        match self.known.until {
            Some([until, _]) => planned.min(self.part(until - state.time)),
            None => planned,
        }
    }

    /// True where something is known to begin and its time is looked for.
    pub(super) fn narrows(&self) -> bool {
        self.known.until.is_some() && !self.is_over
    }

    /// Half of an interval that is longer than asked for [s].
    fn part(&self, interval: f64) -> f64 {
        match interval > self.asked.within {
            true => 0.5 * interval,
            false => interval,
        }
    }

    /// Half the step, where something begins in it and it is longer than asked for; `increment` is what was planned for it [s].
    pub(super) fn halved(
        &mut self,
        simulation: &Simulation<'_>,
        (state, target): (&State, Target),
        settled: &Settled,
        increment: f64,
    ) -> Option<f64> {
        let is_loading = state.loaded < 1.0;
        let before = [state.time, target.time][usize::from(is_loading)];
        let at = Moment {
            states: &settled.states,
            p: &settled.x.p,
            time: target.time,
            loaded: target.loaded,
        };
        let moved = || {
            let problem = simulation.problem();
            let load = problem.loads().at(state.time, state.loaded);
            let from = problem.jumps(&state.u, &load);
            let pairs = settled.effective.iter().zip(&from);
            let change: Vec<f64> = pairs.map(|(to, from)| to - from).collect();
            let faces = change.chunks_exact(3);
            faces.map(|g| g[0].hypot(g[1]).hypot(g[2])).collect()
        };
        self.begins = self.begin(simulation, &at, Some(before), moved);
        let length = length(state, target);
        let is_long = !is_loading && length > self.asked.within;
        if self.begins.is_empty() || self.is_over || !is_long {
            return None;
        }
        let planned = self.known.until.map_or(increment, |[_, planned]| planned);
        self.known.until = Some([target.time, planned]);
        Some(0.5 * length)
    }

    /// No shorter step settles; the increment up to the time by which something begins, from where none was tried from this state [s].
    pub(super) fn gives_up(&mut self, state: &State) -> f64 {
        self.is_over = true;
        (self.known.until).map_or(state.next, |[until, _]| until - state.time)
    }

    /// Why a step is halved.
    pub(super) fn reason(&self, simulation: &Simulation<'_>) -> String {
        let names = &simulation.problem().body().fractures.names;
        let each = self.begins.iter().map(|onset| {
            let what = match onset.begins {
                Begins::Face => "a first face",
                Begins::Patch => "a patch",
            };
            format!("{what} on fracture \"{}\"", names[onset.fracture])
        });
        let each: Vec<String> = each.collect();
        format!("slip begins, and when is looked for: {}", each.join(", "))
    }

    /// What begins in the last attempt that settled, and what had begun before anything was looked for.
    pub(super) fn events(&self, simulation: &Simulation<'_>) -> Vec<Event> {
        let names = &simulation.problem().body().fractures.names;
        let told = self.passed.iter().chain(&self.begins);
        let event = |onset: &SlipOnset| Event::Onset {
            fracture: names[onset.fracture].clone(),
            onset: Box::new(onset.clone()),
        };
        told.map(event).collect()
    }

    /// A step is accepted: what begins in it is known, and the one after it goes on as before the search, or with its next half.
    pub(super) fn accepts(self, simulation: &Simulation<'_>, accepted: &mut Accepted) {
        accepted.events.extend(self.events(simulation));
        let Self {
            asked,
            mut known,
            begins,
            ..
        } = self;
        let state = &mut accepted.state;
        if let Some([until, planned]) = known.until
            && (!begins.is_empty() || state.time >= until - REACHED * asked.within)
        {
            known.until = None;
            state.next = state.next.max(planned);
        }
        known.found.extend(begins);
        state.onsets = Some(Box::new(known));
    }

    /// What has begun at a moment and is not known; `moved` is how far every face has moved.
    fn begin(
        &self,
        simulation: &Simulation<'_>,
        at: &Moment<'_>,
        before: Option<f64>,
        moved: impl Fn() -> Vec<f64>,
    ) -> Vec<SlipOnset> {
        let body = simulation.problem().body();
        let fractures = &body.fractures;
        let wanted = |fracture: usize| {
            let all = [Begins::Face, Begins::Patch];
            let of_patch = self.asked.patch.is_some();
            let asked = all.into_iter().take(1 + usize::from(of_patch));
            asked.filter(move |begins| !self.known.has(fracture, *begins))
        };
        let moves = |f: usize| {
            let fracture = usize::from(fractures.faces[f].fracture);
            at.states[f] != ContactState::Stick && wanted(fracture).next().is_some()
        };
        let patches = fractures.patches(moves);
        if patches.is_empty() {
            return Vec::new();
        }
        let moved = moved();
        let pressures = match at.p.is_empty() {
            true => given_pressures(body, at.time, at.loaded),
            false => at.p.to_vec(),
        };
        let changes = body.pore_changes_at(at.time);
        let most = |faces: &[usize]| {
            let farther = |a: usize, b: &usize| if moved[*b] > moved[a] { *b } else { a };
            faces.iter().fold(faces[0], farther)
        };
        let mut found = Vec::new();
        for fracture in 0..fractures.names.len() {
            let is_own =
                |patch: &&Vec<usize>| fractures.faces[patch[0]].fracture as usize == fracture;
            let own: Vec<&Vec<usize>> = patches.iter().filter(is_own).collect();
            let area = |patch: &[usize]| fractures.area_of(patch.iter().copied());
            let larger = |a: &&&Vec<usize>, b: &&&Vec<usize>| area(a).total_cmp(&area(b));
            let Some(largest) = own.iter().max_by(larger) else {
                continue;
            };
            let (largest, all) = (&largest[..], own.iter().copied().flatten().copied());
            let all: Vec<usize> = all.collect();
            for begins in wanted(fracture) {
                let (face, center) = match begins {
                    Begins::Face => {
                        let face = most(&all);
                        (face, fractures.faces[face].center)
                    }
                    Begins::Patch if self.asked.has_patch(area(largest)) => {
                        (most(largest), middle(body, largest))
                    }
                    Begins::Patch => continue,
                };
                let sides = [&fractures.faces[face].minus, &fractures.faces[face].plus];
                let drained = |e: u32| at.loaded * changes.drained(e);
                found.push(SlipOnset {
                    fracture,
                    begins,
                    before,
                    after: at.time,
                    face,
                    center,
                    area: area(largest),
                    drained: sides.map(|side| drained(side.element)),
                    pressure: pressures[face],
                });
            }
        }
        found
    }
}

/// Centre of faces [m].
fn middle(body: &Body, faces: &[usize]) -> [f64; 3] {
    let fractures = &body.fractures;
    let area = fractures.area_of(faces.iter().copied());
    [0, 1, 2].map(|k: usize| {
        let each = faces.iter().map(|f| &fractures.faces[*f]);
        each.map(|face| face.area * face.center[k]).sum::<f64>() / area
    })
}

impl Simulation<'_> {
    /// When slip began, as far as a state knows, with the names of the fractures; nothing where the scene does not ask.
    pub fn onsets<'s>(
        &'s self,
        state: &'s State,
    ) -> impl Iterator<Item = (&'s str, &'s SlipOnset)> {
        let names = &self.problem().body().fractures.names;
        let found = state.onsets.iter().flat_map(|known| &known.found);
        found.map(|onset| (&names[onset.fracture][..], onset))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Onset;
    use crate::scene::sample::Sample;

    fn body(patch: Option<f64>) -> Body {
        let mut body = Sample::cycle().body();
        body.time = Some(Sample::CYCLE);
        body.onset = Some(Onset { within: 0.1, patch });
        body
    }

    fn known(begins: Begins) -> SlipOnset {
        SlipOnset::sample(begins, Some(0.25))
    }

    #[test]
    fn an_interval_is_halved_until_it_is_short_and_taken_whole_where_no_shorter_step_settles() {
        let body = body(None);
        let simulation = Simulation::new(&body).unwrap();
        let mut state = simulation.initial_state();
        (state.step, state.time, state.loaded, state.next) = (3, 1.0, 1.0, 0.8);
        for (until, increment) in [(1.5, 0.25), (1.2, 0.1), (1.0625, 0.0625), (9.0, 0.8)] {
            state.onsets = Some(Box::new(Onsets {
                until: Some([until, 0.8]),
                ..Onsets::default()
            }));
            let mut search = Search::new(&simulation, &state).unwrap();
            assert!(search.narrows());
            let found = search.increment(&state, state.next);
            assert!((found - increment).abs() < 1e-15, "{until}: {found}");
            assert_eq!(search.gives_up(&state), until - 1.0);
            assert!(!search.narrows());
        }
    }

    #[test]
    fn another_patch_is_looked_for_anew_and_what_had_begun_is_told_without_a_time_before() {
        let body = body(Some(16.0));
        let simulation = Simulation::new(&body).unwrap();
        let mut state = simulation.initial_state();
        (state.step, state.time, state.loaded) = (3, 1.0, 1.0);
        state.onsets = Some(Box::new(Onsets {
            found: vec![known(Begins::Face), known(Begins::Patch)],
            patch: Some(8.0),
            until: Some([1.5, 0.8]),
        }));
        let all_stick = Search::new(&simulation, &state).unwrap();
        assert_eq!(all_stick.known.found, [known(Begins::Face)]);
        assert!(!all_stick.narrows());
        state.states.fill(ContactState::Slip);
        let last = state.slip.len() - 1;
        state.slip[last] = 1e-3;
        let search = Search::new(&simulation, &state).unwrap();
        let found = &search.known.found[1];
        let is_it = (found.begins, found.before, found.after);
        assert_eq!(is_it, (Begins::Patch, None, 1.0));
        assert_eq!(found.face, state.states.len() - 1);
        assert_eq!(search.events(&simulation).len(), 1);
        // the same patch is known already
        state.onsets = Some(Box::new(Onsets {
            found: vec![known(Begins::Patch)],
            patch: Some(16.0),
            until: None,
        }));
        let search = Search::new(&simulation, &state).unwrap();
        assert_eq!(search.known.found, [known(Begins::Patch)]);
        assert!(search.events(&simulation).is_empty());
    }
}
