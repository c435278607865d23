//! Who looks on while a Krylov method works: an observer, and a judge of what it believes to have solved.

use crate::Observer;

/// An x whose residual meets the tolerance, as the recurrence has it.
#[derive(Clone, Copy, Debug)]
pub struct Candidate<'a, R> {
    /// The iterate.
    pub x: &'a [R],
    /// Iterations of this solve so far.
    pub iteration: usize,
    /// ‖b − A x‖₂ / ‖b‖₂ by the recurrence.
    pub estimated_residual: f64,
    /// Modulus of the Ritz value of A M⁻¹ nearest to zero so far, where the method knows one.
    pub smallest_ritz: Option<f64>,
}

/// What a judge says of a [`Candidate`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// The true ‖b − A x‖₂ / ‖b‖₂.
    pub relative_residual: f64,
    /// The relative residual to go on to with the basis, or the directions, at hand; `None` hands x back.
    pub further: Option<f64>,
}

/// Says whether an x with a small residual is what was asked for, before a method throws away what it knows.
pub trait Judge<R> {
    /// The verdict; `observer` is told of work that it takes.
    fn judge(&mut self, candidate: &Candidate<'_, R>, observer: &mut dyn Observer) -> Verdict;
}

/// Those who look on.
pub struct Watch<'a, R> {
    /// Sees every iteration, may stop it.
    pub observer: &'a mut dyn Observer,
    /// Judges what has a small residual; without one the residual decides. A method may leave it unasked.
    pub judge: Option<&'a mut dyn Judge<R>>,
}

impl<'a, R> Watch<'a, R> {
    /// Residuals alone decide.
    pub fn of(observer: &'a mut dyn Observer) -> Self {
        Self {
            observer,
            judge: None,
        }
    }
}
