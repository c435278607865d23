//! More fluid is asked of fractures than they hold.

use super::Attempt;
use crate::contact::ContactState;
use crate::nonlinear::Failure;
use std::collections::BTreeSet;

impl Attempt<'_> {
    /// So much is missing in connected closed faces [m³].
    pub(super) fn drained(&self, faces: &[u32], volume: f64) -> Failure {
        Failure::Drained {
            fractures: self.fractures_of(faces),
            volume,
        }
    }

    /// Names of the fractures of faces.
    fn fractures_of(&self, faces: &[u32]) -> Vec<String> {
        let body = self.problem.body();
        let fracture = |f: &u32| body.fractures.faces[*f as usize].fracture;
        let fractures: BTreeSet<u16> = faces.iter().map(fracture).collect();
        let name = |f: &u16| body.fractures.names[usize::from(*f)].clone();
        fractures.iter().map(name).collect()
    }

    /// Fractures of which more is asked than they hold, though all of their faces are closed.
    pub(in crate::nonlinear) fn overdrawn(&self) -> Option<Failure> {
        let (step, balance) = (self.flow?, self.problem.balance()?);
        let closed = vec![ContactState::Stick; self.problem.faces().len()];
        let mut parts = balance.sealed(&closed, step).into_iter();
        let part = parts.find(|part| part.excess < 0.0)?;
        Some(self.drained(&part.faces, -part.excess))
    }

    /// Refuses pressures at which the fluid has no mass left, `1 + c_f p < 0`.
    ///
    /// # Errors
    /// [`Failure::Emptied`].
    pub(in crate::nonlinear) fn require_mass(&self, p: &[f64]) -> Result<(), Failure> {
        let (Some(_), Some(balance)) = (self.flow, self.problem.balance()) else {
            return Ok(());
        };
        let empty = -1.0 / balance.fluid().compressibility;
        let below: Vec<u32> = (0..p.len() as u32)
            .filter(|f| p[*f as usize] < empty)
            .collect();
        if below.is_empty() {
            return Ok(());
        }
        Err(Failure::Emptied {
            fractures: self.fractures_of(&below),
            pressure: p.iter().copied().fold(f64::INFINITY, f64::min),
            empty,
        })
    }
}
