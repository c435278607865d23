//! `fracas run`: a scene through its load steps, in a folder that survives the process.

use super::Status;
use super::interrupt::{self, Signals};
use super::page::{self, PageSteps};
use super::progress::Progress;
use super::scene::{self, Overrides};
use clap::Args;
use fracas::nonlinear::{Event, StepRecord};
use fracas::run::{Outcome, Run as Settings, Taken};
use fracas_figures::format_real;
use fracas_solvers::Observer;
use std::io::Write;
use std::path::PathBuf;

#[derive(Args, Debug)]
pub(super) struct Run {
    /// Scene file, or the name of a scene of the gallery.
    #[arg(value_name = "SCENE")]
    scene: String,
    #[command(flatten)]
    overrides: Overrides,
    /// Folder of the results, which must be empty [default: out, or that of the checkpoint].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Goes on from a checkpoint: a file, or the folder of a run for its last one.
    #[arg(long, value_name = "CHECKPOINT")]
    restart: Option<PathBuf>,
    /// Stops after N steps, of which step 0, the equilibrium at time 0, is one; --restart goes on.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    steps: Option<u32>,
    /// Writes fields for ParaView every N steps and at the end.
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u32).range(1..))]
    fields_every: u32,
    /// Steps of the maps of report.html, as in 0,4,12, or `none` [default: the first, where slip and opening begin, the largest slip, the last].
    #[arg(
        long,
        value_name = "N,…",
        default_value = "",
        hide_default_value = true
    )]
    page_steps: PageSteps,
    /// Fills the column wall_s of history.csv, which then differs from run to run.
    #[arg(long)]
    clock: bool,
}

impl Run {
    pub(super) fn run(&self, out: &mut dyn Write) -> anyhow::Result<Status> {
        let scene = scene::load(&self.scene, &self.overrides)?;
        let settings = Settings {
            out: self.out.clone(),
            restart: self.restart.clone(),
            steps: self.steps.map(|n| n as usize),
            fields_every: self.fields_every as usize,
            clock: self.clock,
        };
        let mut progress = Progress::new();
        let mut folder = settings.open(&self.scene, scene, &mut progress)?;
        interrupt::listen();
        let path = folder.path().to_path_buf();
        let scene = folder.scene().clone();
        let mut run = folder.begin(&mut progress)?;
        progress.step(run.steps_left());
        let ended = loop {
            match run.advance(&Signals, &mut progress)? {
                Taken::Step(done) => {
                    warn(&done.events, &progress);
                    progress.tell(&line(&done.record, &done.events));
                    progress.step(run.steps_left());
                }
                Taken::Ended(ended) => break ended,
            }
        };
        warn(&ended.events, &progress);
        for remark in &ended.remarks {
            progress.tell(&format!("warning: {remark}"));
        }
        if let Some(reason) = &ended.reason {
            progress.say(reason);
        }
        let lead = ended.to_string();
        page::write(&scene, &lead, &run, &self.page_steps, &path)?;
        let onsets = run.onsets().map(|(fracture, onset)| onset.told(fracture));
        let failed = ended.events.iter().filter_map(|event| match event {
            Event::Onset { fracture, onset } => Some(onset.told(fracture)),
            _ => None,
        });
        for onset in onsets.chain(failed) {
            progress.tell(&format!("onset: {onset}"));
        }
        run.close(&ended)?;
        writeln!(out, "{}", path.join("report.html").display())?;
        Ok(match (ended.outcome, interrupt::asked()) {
            (Outcome::NotConverged | Outcome::Unstable, _) => Status::NotConverged,
            (Outcome::Interrupted, Some(signal)) => Status::Interrupted(signal),
            _ => Status::Done,
        })
    }
}

/// Says what gave way (f32 to f64, an inner solver to another, equilibrium under weakening), and what could not be computed.
fn warn(events: &[Event], progress: &Progress) {
    for event in events {
        let warning = match event {
            Event::Precision { reason } => format!("{reason}; the hierarchy is in f64"),
            Event::Inner { reason, now } => {
                format!("{reason}; the inner solver is {now} instead")
            }
            Event::Arrested { patch } => format!("unstable: {patch}; stepped over"),
            Event::Unknown { reason } => {
                format!("whether slip runs away in this step is not known: {reason}")
            }
            _ => continue,
        };
        progress.tell(&format!("warning: {warning}"));
    }
}

/// A step in a line, and when slip begins on a fracture, where H or the stabilization of pressures acts on more or less than its states constrain, faces have no cohesion, or
/// given pressures were raised in parts.
fn line(record: &StepRecord, events: &[Event]) -> String {
    let [stick, new_slip, slip, open] = record.faces;
    let cuts = match record.cuts {
        0 => String::new(),
        n => format!(", cut {n} times"),
    };
    let beyond = events.iter().filter_map(|event| match event {
        Event::Stabilized { faces } => {
            Some(format!("; stabilized on {faces} faces beyond their states"))
        }
        Event::Unstabilized { faces } => Some(format!("; {faces} faces left unstabilized")),
        Event::Raised { parts, .. } => Some(format!("; given pressures raised in {parts} parts")),
        Event::Torn { faces } => Some(format!("; {} faces without their cohesion", faces.len())),
        Event::Onset { fracture, onset } => Some(format!("; {}", onset.told(fracture))),
        _ => None,
    });
    format!(
        "step {}, t = {} s: {} rounds, {} Newton, {} Krylov{cuts}; {stick} stick, {new_slip} new-slip, {slip} slip, {open} open{}",
        record.step,
        format_real(record.time),
        record.active_it,
        record.newton_it,
        record.lin_it,
        beyond.collect::<String>(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas::nonlinear::{Begins, SlipOnset};

    #[test]
    fn a_step_says_where_more_is_held_than_its_states_constrain() {
        let record = StepRecord {
            step: 3,
            time: 0.5,
            faces: [4, 3, 2, 1],
            ..StepRecord::default()
        };
        let plain =
            "step 3, t = 0.5 s: 0 rounds, 0 Newton, 0 Krylov; 4 stick, 3 new-slip, 2 slip, 1 open";
        let torn = format!("{plain}; 1 faces without their cohesion");
        assert_eq!(line(&record, &[Event::Torn { faces: vec![1] }]), torn);
        let held = [Event::Stabilized { faces: 7 }];
        let more = format!("{plain}; stabilized on 7 faces beyond their states");
        assert_eq!(line(&record, &held), more);
        let onset = SlipOnset {
            fracture: 0,
            begins: Begins::Face,
            before: Some(0.25),
            after: 0.5,
            face: 3,
            center: [1.0, 2.0, -3.0],
            area: 4.0,
            drained: [0.0; 2],
            pressure: 0.0,
        };
        let onset = [Event::Onset {
            fracture: "F".into(),
            onset: Box::new(onset),
        }];
        let begins = "on fracture \"F\" a first face slips or opens between t = 0.25 s and t = 0.5 s, at (1.000000, 2.000000, -3.000000) m";
        assert_eq!(line(&record, &onset), format!("{plain}; {begins}"));
        let free = [Event::Unstabilized { faces: 2 }];
        let less = format!("{plain}; 2 faces left unstabilized");
        assert_eq!(line(&record, &free), less);
    }
}
