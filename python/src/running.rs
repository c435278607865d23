//! A run on its thread: in its folder, or in memory alone.

use crate::call;
use crate::error::{Kind, Raise, of_any, raise};
use crate::run::{Asked, Ended, Fields, Message, Step, Wish};
use crate::watch::Watch;
use fracas::contact::ContactState;
use fracas::nonlinear::{Event, Failure, Simulation, State, StepRecord};
use fracas::run::{History, Outcome, Run, Taken, event};
use fracas_experiments::command::{PageSteps, write_page};
use pyo3::prelude::*;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender};

/// The thread's ends of the line to the iterator.
pub(crate) struct Line {
    /// A wish for the next step, with who observes it; gone when the iterator is.
    pub(crate) asks: Receiver<Wish>,
    /// Answers.
    pub(crate) tells: Sender<Message>,
}

impl Line {
    /// Waits for a wish; where nobody is left to have one, the run stops as if it had been interrupted. An observer is not held while it waits:
    /// it may be what holds the run.
    fn wait(&self, stop: &AtomicBool, watch: &mut Watch<'_>) {
        watch.tells(None);
        match self.asks.recv() {
            Ok(Wish {
                observer,
                mut owners,
            }) => {
                owners.push(owner(stop));
                call::works_for(owners);
                watch.tells(observer);
            }
            Err(_) => stop.store(true, Ordering::Relaxed),
        }
    }

    fn tell(&self, message: Message) {
        // nobody listens where the iterator is gone
        let _ = self.tells.send(message);
    }
}

/// What a run is known by while it is at work.
pub(crate) fn owner(stop: &AtomicBool) -> usize {
    std::ptr::from_ref(stop) as usize
}

/// Runs to the end, step by step as the iterator asks.
pub(crate) fn run(mut asked: Asked, line: &Line, stop: &AtomicBool) {
    call::works_for(vec![owner(stop)]);
    let mut watch = Watch::new(stop, asked.observer.take());
    let (ended, raised) = call::heard(|| match asked.in_memory() {
        true => in_memory(&asked, line, stop, &mut watch),
        false => in_folder(&asked, line, stop, &mut watch),
    });
    let observed = watch.end(Ok(())).err();
    line.tell(match (ended, raised, observed) {
        (Ok(ended), None, None) => Message::Ended(ended),
        (Ok(ended), None, Some(error)) => Message::Failed(error, Some(ended)),
        // what ended it so is no failure of the run
        (_, Some(error), _) | (Err(_), None, Some(error)) | (Err(error), None, None) => {
            Message::Failed(error, None)
        }
    });
}

/// As `fracas run` does, with the same files.
fn in_folder(
    asked: &Asked,
    line: &Line,
    stop: &AtomicBool,
    watch: &mut Watch<'_>,
) -> PyResult<Ended> {
    let settings = Run {
        out: asked.out.clone(),
        restart: asked.restart.clone(),
        steps: asked.steps,
        fields_every: asked.fields_every,
        clock: asked.clock,
    };
    let opened = settings.open(&asked.name, asked.scene.clone(), watch);
    let mut folder = opened.raised()?;
    let (path, scene) = (folder.path().to_path_buf(), folder.scene().clone());
    let mut run = folder.begin(watch).raised()?;
    let ended = loop {
        line.wait(stop, watch);
        match run.advance(stop, watch).raised()? {
            Taken::Step(done) => {
                let fields = (asked.fields).then(|| fields(run.simulation(), run.state()));
                line.tell(step(&done.record, &done.events, fields));
            }
            Taken::Ended(ended) => break ended,
        }
    };
    let page = write_page(
        &scene,
        &ended.to_string(),
        &run,
        &PageSteps::default(),
        &path,
    );
    page.map_err(|error| of_any(Kind::Run, &error))?;
    run.close(&ended).raised()?;
    Ok(Ended {
        outcome: word(ended.outcome),
        reason: ended.reason,
        path: Some(path),
    })
}

/// The same steps without a file.
fn in_memory(
    asked: &Asked,
    line: &Line,
    stop: &AtomicBool,
    watch: &mut Watch<'_>,
) -> PyResult<Ended> {
    let body = asked.scene.build().raised()?;
    let mut simulation = Simulation::new(&body).raised()?;
    let mut state = simulation.initial_state();
    let mut left = asked.steps;
    let ended = |outcome, reason| Ended {
        outcome: word(outcome),
        reason,
        path: None,
    };
    loop {
        line.wait(stop, watch);
        if simulation.is_finished(&state) {
            return Ok(ended(Outcome::Finished, None));
        }
        if left == Some(0) {
            return Ok(ended(Outcome::Stopped, None));
        }
        if stop.load(Ordering::Relaxed) {
            return Ok(ended(Outcome::Interrupted, None));
        }
        left = left.map(|n| n - 1);
        match simulation.advance(&state, watch) {
            Ok(accepted) => {
                state = accepted.state;
                let fields = (asked.fields).then(|| fields(&simulation, &state));
                line.tell(step(&accepted.record, &accepted.events, fields));
            }
            Err(_) if stop.load(Ordering::Relaxed) => {
                return Ok(ended(Outcome::Interrupted, None));
            }
            Err(failure) => {
                let outcome = match failure.reason {
                    Failure::Unstable(_) => Outcome::Unstable,
                    _ => Outcome::NotConverged,
                };
                return Ok(ended(outcome, Some(failure.to_string())));
            }
        }
    }
}

/// A step for the iterator.
fn step(record: &StepRecord, events: &[Event], fields: Option<Fields>) -> Message {
    let json = |told: &Event| {
        let (name, members) = event(told);
        format!("[{name:?},{members}]")
    };
    Message::Step(Box::new(Step {
        line: History::line(record),
        events: events.iter().map(json).collect(),
        fields,
    }))
}

/// What a state shows.
fn fields(simulation: &Simulation<'_>, state: &State) -> Fields {
    Fields {
        displacement: simulation.displacement(state),
        faces: simulation.face_fields(state),
        states: state
            .states
            .iter()
            .map(|s: &ContactState| s.code() as i8)
            .collect(),
    }
}

/// As in `run.json`.
fn word(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Running => "running",
        Outcome::Finished => "finished",
        Outcome::Stopped => "stopped",
        Outcome::NotConverged => "not_converged",
        Outcome::Interrupted => "interrupted",
        Outcome::Unstable => "unstable",
    }
}

/// The exception of a run that did not reach its end.
pub(crate) fn failure(ended: &Ended) -> Option<PyErr> {
    let failed = ["not_converged", "unstable"].contains(&ended.outcome);
    let place = |path: &Path| format!(" (files in {})", path.display());
    let place = ended.path.as_deref().map_or(String::new(), place);
    failed.then(|| {
        let reason = ended.reason.as_deref().unwrap_or("no reason given");
        raise(Kind::NotConverged, format!("{reason}{place}"))
    })
}
