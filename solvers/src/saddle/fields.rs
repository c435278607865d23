//! The fields of a saddle point.

use super::SaddleBlocks;
use fracas_operators::{Field, Layout};

/// Displacements [m].
pub const U: Field = Field {
    letter: "u",
    name: "displacements",
};

/// Tractions [Pa].
pub const T: Field = Field {
    letter: "t",
    name: "tractions",
};

/// Pressures [Pa].
pub const P: Field = Field {
    letter: "p",
    name: "pressures",
};

impl SaddleBlocks {
    /// The fields of a vector of unknowns.
    pub fn layout(&self) -> Layout {
        let layout = Layout::new([(U, self.n_u()), (T, self.n_t())]);
        match &self.flow {
            Some(flow) => layout.with(P, flow.t.rows()),
            None => layout,
        }
    }
}
