use super::*;
use crate::nonlinear::{Begins, SlipOnset};

const OWN: Fingerprint = Fingerprint { mesh: 7, scene: 8 };

fn state(step: usize) -> State {
    State {
        step,
        time: 0.1 + 0.2,
        loaded: 1.0 / 3.0,
        next: f64::MIN_POSITIVE / 4.0,
        force: 2.0 / 3.0,
        traction: 1e300,
        size: Fields::new([(U, 1e-300), (T, 0.7)]),
        krylov: 2.5,
        prepared: Some(Prepared {
            states: vec![ContactState::Open, ContactState::Stick],
            c: [1.0, -3.5]
                .map(|v| [[v, 0.1, f64::MIN_POSITIVE], [0.1, 2.0, v], [1e300, v, 3.0]])
                .to_vec(),
        }),
        u: vec![-0.0, 1.0 / 3.0, f64::NAN, f64::INFINITY, 1e-310],
        t: vec![-1e7, 2.0, 3.0, 0.0, -0.0, 1e-30],
        p: Vec::new(),
        states: vec![ContactState::Open, ContactState::NewSlip],
        slip: vec![-0.0, 1e-310, 1.0 / 3.0, 7.0],
        path: vec![1e-310; 2 * (step % 5 / 3)],
        creep: step.is_multiple_of(2).then(|| {
            Box::new(CreepState {
                step: 0.1,
                strain: vec![[1e-310, -0.0, 1.0 / 3.0, 4.0, 5.0, f64::MIN_POSITIVE]; 8],
            })
        }),
        released: vec![false, true],
        torn: vec![true, false],
        flips: vec![3, u32::MAX],
        onsets: step.is_multiple_of(4).then(|| Box::new(onsets())),
    }
}

fn onsets() -> Onsets {
    let onset = |begins, before| SlipOnset {
        fracture: 1,
        ..SlipOnset::sample(begins, before)
    };
    Onsets {
        found: vec![onset(Begins::Patch, Some(0.1)), onset(Begins::Face, None)],
        patch: Some(2.0),
        until: Some([0.7, 0.25]),
    }
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

/// A folder that goes away with the test.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let name = format!("fracas-checkpoint-{}-{name}", std::process::id());
        let path = std::env::temp_dir().join(name);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).unwrap();
        let mut names: Vec<String> = entries
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn every_bit_comes_back() {
    let folder = Folder::new("bits");
    let written = state(12);
    let path = Checkpoints::new(folder.0.clone(), OWN)
        .save(&written)
        .unwrap();
    let read = read_checkpoint(&path, OWN).unwrap();
    let scalars = |s: &State| [s.time, s.loaded, s.next, s.force, s.traction].map(f64::to_bits);
    assert_eq!((read.step, scalars(&read)), (12, scalars(&written)));
    assert_eq!((read.size, read.krylov), (written.size, written.krylov));
    assert_eq!(bits(&read.u), bits(&written.u));
    assert_eq!(bits(&read.t), bits(&written.t));
    assert_eq!(bits(&read.slip), bits(&written.slip));
    assert_eq!((read.states, read.flips), (written.states, written.flips));
    assert_eq!(
        (read.released, read.torn),
        (written.released.clone(), written.torn.clone())
    );
    let strain = |s: &Option<Box<CreepState>>| {
        let own = s.as_ref().unwrap();
        (own.step.to_bits(), bits(own.strain.as_flattened()))
    };
    assert_eq!(strain(&read.creep), strain(&written.creep));
    assert_eq!(read.onsets.as_deref(), Some(&onsets()));
}

#[test]
fn every_choice_of_fields_comes_back() {
    for step in 0..12 {
        let mut written = state(step);
        written.p = vec![4.0; 2 * (step % 3)];
        let read = decode(&encode(&written, OWN), Path::new("file"), OWN).unwrap();
        assert_eq!((read.p, read.onsets), (written.p, written.onsets));
        assert_eq!(read.path, written.path);
        assert_eq!(read.creep, written.creep);
    }
}

#[test]
fn the_last_two_stay_and_later_ones_can_be_taken_back() {
    let folder = Folder::new("last");
    let checkpoints = Checkpoints::new(folder.0.clone(), OWN);
    assert!(matches!(
        newest_checkpoint(&folder.0),
        Err(CheckpointError::None { .. })
    ));
    for step in [0, 1, 2, 10] {
        checkpoints.save(&state(step)).unwrap();
    }
    assert_eq!(
        folder.names(),
        ["step_000002.checkpoint", "step_000010.checkpoint"]
    );
    assert!(
        newest_checkpoint(&folder.0)
            .unwrap()
            .ends_with("step_000010.checkpoint")
    );
    checkpoints.forget_after(2).unwrap();
    assert_eq!(folder.names(), ["step_000002.checkpoint"]);
    assert!(matches!(
        newest_checkpoint(&folder.0.join("none")),
        Err(CheckpointError::Read { .. })
    ));
}

#[test]
fn a_checkpoint_cut_anywhere_is_refused() {
    let bytes = encode(&state(1), OWN);
    let path = Path::new("file");
    assert!(decode(&bytes, path, OWN).is_ok());
    for n in 0..bytes.len() {
        let error = decode(&bytes[..n], path, OWN).unwrap_err();
        match n {
            0..8 => assert!(matches!(error, CheckpointError::Foreign { .. }), "{error}"),
            _ => assert!(
                matches!(error, CheckpointError::Length { found, .. } if found == n as u64),
                "{error}"
            ),
        }
    }
    let longer = [&bytes[..], &[0]].concat();
    let error = decode(&longer, path, OWN).unwrap_err();
    assert_eq!(
        error.to_string(),
        format!(
            "the checkpoint file is damaged: it has {} of {} bytes; take the one before it",
            bytes.len() + 1,
            bytes.len()
        )
    );
}

#[test]
fn a_checkpoint_with_any_bit_changed_is_refused() {
    let bytes = encode(&state(1), OWN);
    for bit in 0..8 * bytes.len() {
        let mut changed = bytes.clone();
        changed[bit / 8] ^= 1 << (bit % 8);
        let error = decode(&changed, Path::new("file"), OWN).unwrap_err();
        let seen = match bit / 64 {
            0 => matches!(error, CheckpointError::Foreign { .. }),
            1 => matches!(error, CheckpointError::Version { .. }),
            2 => matches!(error, CheckpointError::Length { .. }),
            _ => matches!(error, CheckpointError::Checksum { .. }),
        };
        assert!(seen, "bit {bit}: {error}");
    }
}

#[test]
fn a_checkpoint_of_something_else_is_refused() {
    let bytes = encode(&state(1), OWN);
    let refused = |mesh, scene| {
        let other = Fingerprint { mesh, scene };
        decode(&bytes, Path::new("file"), other)
            .unwrap_err()
            .to_string()
    };
    assert!(refused(6, 8).contains("another mesh"));
    assert!(refused(7, 9).contains("same mesh but other materials"));
}

#[test]
fn a_checkpoint_with_other_fields_or_of_another_layout_is_refused_in_a_sentence() {
    let with = |at: usize, word: u64| {
        let mut bytes = encode(&state(1), OWN);
        bytes[8 * at..8 * at + 8].copy_from_slice(&word.to_le_bytes());
        let content = bytes.len() - 8;
        let sum = checksum(&bytes[..content]);
        bytes[content..].copy_from_slice(&sum.to_le_bytes());
        decode(&bytes, Path::new("file"), OWN)
            .unwrap_err()
            .to_string()
    };
    let pressures = u64::from_le_bytes(*b"p\0\0\0\0\0\0\0");
    assert_eq!(
        with(HEADER + 3, pressures),
        "the checkpoint file holds the fields u, p, this program reads u and t, with p, e_v, s and on where there are any"
    );
    assert_eq!(
        with(1, 3),
        "the checkpoint file has layout 3, this program reads layout 4"
    );
    // tables that reach beyond the file
    for (at, word) in [
        (HEADER - 1, u64::MAX),
        (HEADER - 2, u64::MAX / 2),
        (HEADER + 1, u64::MAX),
    ] {
        assert!(with(at, word).contains("is damaged"));
    }
}
