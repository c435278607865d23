//! What a fracture face does.

/// State of a fracture face; its number is the one in files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum ContactState {
    /// Closed, no slip: all three jumps vanish.
    #[default]
    Stick = 0,
    /// Closed, starts to slip along its shear traction.
    NewSlip = 1,
    /// Closed, slips along its slip increment.
    Slip = 2,
    /// Open, without traction.
    Open = 3,
}

impl ContactState {
    /// Every state, in the order of their numbers.
    pub const ALL: [Self; 4] = [Self::Stick, Self::NewSlip, Self::Slip, Self::Open];

    /// The number in files: 0 stick, 1 new-slip, 2 slip, 3 open.
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The state with that number.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.get(usize::from(code)).copied()
    }

    /// True where the rows of a face are linear in its jump and traction: stick and open.
    pub const fn is_linear(self) -> bool {
        matches!(self, Self::Stick | Self::Open)
    }

    /// How many of (n, t1, t2) are multipliers of a vanishing jump: stick 3, slip the normal one, open none.
    ///
    /// These are the components that the jump stabilization acts on; the others carry a law for the traction itself.
    pub const fn constrained(self) -> usize {
        match self {
            Self::Stick => 3,
            Self::NewSlip | Self::Slip => 1,
            Self::Open => 0,
        }
    }
}
