//! A scene through its load steps, in a folder that survives the process.
//!
//! | file | what it keeps |
//! |---|---|
//! | `settings` | what is asked of a run |
//! | `folder`, `lock` | a folder of one process, a scene that fits it, where to go on from |
//! | `running` | step by step, each on the disk before the next begins |
//! | `tree`, `lines`, `collection` | what is written when, and taken back by a restart |
//! | `beyond` | what H lets through where it acts on more than the states constrain |
//! | `history`, `events`, `onsets`, `manifest` | rows, log, onsets of slip, `run.json` |
//!
//! ```
//! use fracas::prelude::*;
//! use std::sync::atomic::AtomicBool;
//!
//! let scene = named("cycle").ok_or("a scene of the gallery")?.small_scene()?;
//! let out = std::env::temp_dir().join(format!("fracas-run-{}", std::process::id()));
//! let settings = Run {
//!     out: Some(out.clone()),
//!     steps: Some(2),
//!     ..Run::default()
//! };
//! // another thread, or a signal, may set it
//! let stop = AtomicBool::new(false);
//! let mut folder = settings.open("cycle", scene, &mut Silent)?;
//! let mut run = folder.begin(&mut Silent)?;
//! let ended = loop {
//!     match run.advance(&stop, &mut Silent)? {
//!         Taken::Step(done) => assert!(done.record.lin_it > 0),
//!         Taken::Ended(ended) => break ended,
//!     }
//! };
//! assert_eq!((ended.outcome, run.history().len()), (Outcome::Stopped, 2));
//! run.close(&ended)?;
//! # drop(folder);
//! # std::fs::remove_dir_all(out)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod beyond;
mod changed;
mod collection;
mod error;
mod events;
mod folder;
mod history;
mod lines;
mod lock;
mod manifest;
mod onsets;
mod outcome;
mod running;
mod settings;
mod stored;
mod tree;

pub use error::RunError;
pub use events::event;
pub use folder::{RunFolder, work_of};
pub use history::History;
pub use lines::Unreadable;
pub use lock::Busy;
pub use outcome::{Done, Ended, Outcome, Stop, Taken};
pub use running::Running;
pub use settings::Run;
pub use stored::Stored;
pub use tree::{Refused, holds_run};
