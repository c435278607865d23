//! What is known of the onset of slip, and the list of numbers that a checkpoint keeps of it.

/// What begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Begins {
    /// A first face slips or opens.
    Face,
    /// A patch of the area that is looked for slips or is open.
    Patch,
}

impl Begins {
    /// In files: `face` or `patch`.
    pub fn name(self) -> &'static str {
        ["face", "patch"][self as usize]
    }
}

/// When and where slip begins on a fracture.
#[derive(Clone, Debug, PartialEq)]
pub struct SlipOnset {
    /// Number of the fracture.
    pub fracture: usize,
    /// What begins.
    pub begins: Begins,
    /// Latest time at which it had not begun [s]; that of the onset where it has begun at time 0, none where the run looked for no onset
    /// before.
    pub before: Option<f64>,
    /// Earliest time at which it has [s].
    pub after: f64,
    /// The face that has moved most by then: the first one.
    pub face: usize,
    /// Centre of that face, or of the patch [m].
    pub center: [f64; 3],
    /// Area of the largest patch of faces that slip or are open [m²].
    pub area: f64,
    /// α Δp in the elements on the minus and on the plus side of the face [Pa].
    pub drained: [f64; 2],
    /// Pressure of the fluid in the face [Pa].
    pub pressure: f64,
}

impl SlipOnset {
    /// A sentence without its point; `fracture` is the name of the fracture.
    pub fn told(&self, fracture: &str) -> String {
        let [x, y, z] = self.center;
        let (after, area) = (self.after, self.area);
        let when = match self.before {
            None => format!("by t = {after:?} s"),
            Some(before) if before == after => format!("at t = {after:?} s"),
            Some(before) => format!("between t = {before:?} s and t = {after:?} s"),
        };
        let place = format!("({x:.6}, {y:.6}, {z:.6}) m");
        match self.begins {
            Begins::Face => {
                format!("on fracture \"{fracture}\" a first face slips or opens {when}, at {place}")
            }
            Begins::Patch => format!(
                "on fracture \"{fracture}\" a patch of {area:.6} m2 slips or opens {when}, around {place}"
            ),
        }
    }
}

#[cfg(test)]
impl SlipOnset {
    /// An onset of the first fracture, with numbers that no short text holds.
    pub(crate) fn sample(begins: Begins, before: Option<f64>) -> Self {
        Self {
            fracture: 0,
            begins,
            before,
            after: 0.1 + 0.2,
            face: 7,
            center: [-0.5, 1.0 / 3.0, 2.0],
            area: 2.5,
            drained: [-1e7, 0.0],
            pressure: 3.0,
        }
    }
}

/// What a run that looks for the onset of slip knows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Onsets {
    /// What has begun, in the order in which it did.
    pub found: Vec<SlipOnset>,
    /// The patch that is looked for [m²].
    pub patch: Option<f64>,
    /// A time by which something begins that has not begun yet, and the increment of steps before it was known [s].
    pub until: Option<[f64; 2]>,
}

/// Numbers of a [`SlipOnset`] in a list.
const NUMBERS: usize = 12;

/// Numbers before those of the onsets.
const HEADER: usize = 3;

impl Onsets {
    /// All of it in a list; NaN stands for nothing.
    pub(crate) fn numbers(&self) -> Vec<f64> {
        let none = f64::NAN;
        let [until, planned] = self.until.unwrap_or([none; 2]);
        let mut list = vec![self.patch.unwrap_or(none), until, planned];
        for onset in &self.found {
            let [x, y, z] = onset.center;
            let [minus, plus] = onset.drained;
            let own: [f64; NUMBERS] = [
                onset.fracture as f64,
                f64::from(onset.begins as u8),
                onset.before.unwrap_or(none),
                onset.after,
                onset.face as f64,
                x,
                y,
                z,
                onset.area,
                minus,
                plus,
                onset.pressure,
            ];
            list.extend(own);
        }
        list
    }

    /// From [such a list](Self::numbers); none where it is of another length.
    pub(crate) fn from_numbers(list: &[f64]) -> Option<Self> {
        let given = |v: f64| (!v.is_nan()).then_some(v);
        let (header, rest) = list.split_at_checked(HEADER)?;
        let (rows, []) = rest.as_chunks::<NUMBERS>() else {
            return None;
        };
        let onset = |row: &[f64; NUMBERS]| SlipOnset {
            fracture: row[0] as usize,
            begins: [Begins::Face, Begins::Patch][usize::from(row[1] > 0.5)],
            before: given(row[2]),
            after: row[3],
            face: row[4] as usize,
            center: [row[5], row[6], row[7]],
            area: row[8],
            drained: [row[9], row[10]],
            pressure: row[11],
        };
        Some(Self {
            found: rows.iter().map(onset).collect(),
            patch: given(header[0]),
            until: given(header[1]).map(|until| [until, header[2]]),
        })
    }

    /// True where it is known when this began on a fracture.
    pub(super) fn has(&self, fracture: usize, begins: Begins) -> bool {
        let is_it = |o: &SlipOnset| o.fracture == fracture && o.begins == begins;
        self.found.iter().any(is_it)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_of_another_length_is_none() {
        let onsets = Onsets {
            found: vec![SlipOnset::sample(Begins::Patch, None)],
            patch: None,
            until: None,
        };
        let list = onsets.numbers();
        assert_eq!(Onsets::from_numbers(&list), Some(onsets));
        for n in [0, 2, list.len() - 1] {
            assert_eq!(Onsets::from_numbers(&list[..n]), None);
        }
    }
}
