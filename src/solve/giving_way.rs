//! An iteration that gets nowhere around an inner solver that the program chose: it goes on around the next one.

use super::assembled::Set;
use super::set_up::SetUp;
use super::solver::{Equations, Names, Solver};
use super::{End, Finding, RightHandSide, Solve, SolveError, Solved, precision};
use crate::inner::without_stagnation;
use crate::memory::{self, NoRoomToFactorize};
use fracas_solvers::Observer;
use fracas_solvers::saddle::{InnerChoice, SaddleMethod, T, U};
use std::time::Instant;

/// What a solve has done so far around inner solvers that gave way.
#[derive(Default)]
pub(super) struct Before {
    iterations: usize,
    /// Products, where they are known.
    products: Option<u64>,
    /// `Σ n_it (1 + c_app)`.
    c_s: f64,
    /// Beside set-ups of whole inner solvers [s].
    setup_s: f64,
    solve_s: f64,
    /// Iterations around the one at hand, of which it has no more than the limit, and the relative residual that they left.
    here: usize,
    residual: f64,
    /// Where they ended, in the units of the system; empty for 0.
    pub(super) x: Vec<f64>,
    /// What was found on the way, and what was found before, where anything was done.
    findings: Option<Vec<Finding>>,
}

impl Before {
    /// Adds what was done up to here.
    fn add(&mut self, solved: Solved, setup_s: f64) {
        let products = solved.iterations * solved.krylov.products_per_iteration();
        self.products = match self.findings {
            None => solved.products,
            Some(_) => self.products.zip(solved.products).map(|(a, b)| a + b),
        };
        self.iterations += solved.iterations;
        self.here += solved.iterations;
        self.c_s += products as f64 * (1.0 + solved.c_app);
        self.setup_s += solved.setup_s - setup_s;
        self.solve_s += solved.solve_s;
        self.residual = solved.relative_residual.unwrap_or(f64::INFINITY);
        self.x = solved.x;
        self.findings = Some(solved.findings);
    }

    /// The whole of which `solved` is the last part.
    fn and(self, mut solved: Solved) -> Solved {
        if self.findings.is_some() {
            solved.iterations += self.iterations;
            solved.products = self.products.zip(solved.products).map(|(a, b)| a + b);
            solved.c_s = solved.c_s.map(|c_s| self.c_s + c_s);
            solved.setup_s += self.setup_s;
            solved.solve_s += self.solve_s;
        }
        solved
    }

    /// What has been found when the next part begins.
    pub(super) fn findings(&self, solver: &Solver) -> Vec<Finding> {
        self.findings.as_ref().unwrap_or(&solver.findings).clone()
    }

    /// Iterations that are left around the inner solver at hand.
    pub(super) fn left(&self, settings: &Solve) -> usize {
        settings.max_iterations.saturating_sub(self.here)
    }
}

impl Solver {
    /// Iterates from 0, judges, records; what took the place of f32, or of an inner solver that got nowhere, stays for the next solve.
    ///
    /// # Errors
    /// [`SolveError`]; not converging is a value.
    pub fn solve(&mut self, observer: &mut dyn Observer) -> Result<Solved, SolveError> {
        let mut before = Before::default();
        loop {
            let next = self.next();
            let may_give_way = matches!(next, Ok(Some(_)));
            let (mut solved, double) = self
                .equations
                .with(|equations| self.iterate(equations, (&before, may_give_way), observer))?;
            if let Some(double) = double {
                self.ready = double.ready;
                self.names.inner = Some(double.inner);
                self.fallbacks += 1;
            }
            let is_over = solved.has_converged() || solved.outcome == End::Stopped;
            let at = match next {
                Ok(Some(at)) if !is_over => at,
                next => {
                    if !is_over {
                        self.advise(&mut solved, next.err());
                    }
                    return Ok(before.and(solved));
                }
            };
            before.add(solved, self.setup_s);
            self.give_way(at, &mut before, observer);
        }
    }

    /// Which of the others takes the place of an inner solver that the program chose, where the iteration gets nowhere.
    fn next(&self) -> Result<Option<usize>, NoRoomToFactorize> {
        let inner = self.method.inner();
        if !self.gives_way || matches!(inner, None | Some(InnerChoice::Exact { .. })) {
            return Ok(None);
        }
        let left = self.otherwise.iter().filter_map(|method| method.inner());
        let left: Vec<InnerChoice> = left.collect();
        let n_u = self.equations.with(|system| system.layout().length(U));
        without_stagnation(&left, n_u, memory::available_bytes())
    }

    /// Takes number `at` of the others, or what takes its place; where none can be set up the one at hand goes on.
    fn give_way(&mut self, at: usize, before: &mut Before, observer: &mut dyn Observer) {
        let start = Instant::now();
        let next = self.otherwise.remove(at);
        let (settings, problem) = (self.settings.clone(), self.problem.clone());
        let mut set_up = SetUp {
            settings: &settings,
            problem: &problem,
            otherwise: std::mem::take(&mut self.otherwise).into_iter(),
            findings: Vec::new(),
            replaced: self.replaced + 1,
            observer,
        };
        let name = |method: &SaddleMethod| method.inner().map(|inner| inner.to_string());
        set_up.found(Finding::GaveWay {
            inner: name(&next).unwrap_or_default(),
            first: self.names.inner.clone().unwrap_or_default(),
            residual: before.residual,
            iterations: before.here,
        });
        set_up.observer.say(&"setting up");
        let done = match &mut self.equations {
            Equations::MatrixFree { .. } => set_up.by(next).map(|new| self.become_another(new)),
            equations => match set_up.until_ready(next, (equations, self.unit), None) {
                Ok((method, Some(ready))) => Ok(self.go_on_with(method, ready, set_up)),
                Ok((method, None)) => set_up.by(method).map(|new| self.become_another(new)),
                Err(failure) => Err(failure),
            },
        };
        match done {
            Ok(mut found) => {
                before.here = 0;
                self.findings.extend_from_slice(&found);
                before.findings.get_or_insert_default().append(&mut found);
            }
            Err(failure) => {
                let failure = failure.in_full();
                let finding = Finding::NoOther { failure };
                observer.say(&finding);
                before.findings.get_or_insert_default().push(finding);
            }
        }
        self.setup_s += start.elapsed().as_secs_f64();
    }

    /// The same equations with what was set up for them; what was found on the way.
    fn go_on_with(
        &mut self,
        method: SaddleMethod,
        (ready, lost): Set,
        mut set_up: SetUp<'_>,
    ) -> Vec<Finding> {
        self.names = Names::of_ready(&method, lost.is_some());
        self.double = precision::in_double(&method);
        self.fallbacks += usize::from(lost.is_some());
        if let Some(lost) = lost {
            set_up.found(Finding::Precision(lost));
        }
        (self.method, self.ready) = (method, ready);
        self.replaced = set_up.replaced;
        self.otherwise = set_up.otherwise.collect();
        set_up.findings
    }

    /// The same system in another form, for the same right-hand side; what was found on the way.
    fn become_another(&mut self, mut new: Self) -> Vec<Finding> {
        if self.rhs == RightHandSide::Given {
            let mut b = std::mem::take(&mut self.b);
            let layout = new.equations.with(|system| system.layout());
            let [b_t] = layout.split_mut([T], &mut b);
            b_t.iter_mut().for_each(|b| *b *= new.unit / self.unit);
            (new.rhs, new.b) = (RightHandSide::Given, b);
        }
        let found = std::mem::replace(&mut new.findings, std::mem::take(&mut self.findings));
        new.fallbacks += self.fallbacks;
        // counted by the caller as a whole
        new.setup_s = self.setup_s;
        *self = new;
        found
    }

    /// What to do where an inner solver that was asked for, or the last one that fits, gets nowhere.
    fn advise(&self, solved: &mut Solved, no_room: Option<NoRoomToFactorize>) {
        let Some(inner) = self.method.inner() else {
            return;
        };
        let is_weak = solved.outcome == End::IterationLimit && self.equations.is_here();
        let is_exact = matches!(inner, InnerChoice::Exact { .. });
        let mut findings = solved.findings.iter();
        let is_last = findings.any(|found| matches!(found, Finding::NoOther { .. }));
        solved.reason = match no_room {
            Some(no_room) => Some(format!(
                "inner = \"{inner}\" gets nowhere, and inner = \"exact\" does not fit: {no_room}; take fewer cells, or more iterations"
            )),
            None if is_weak && is_last => Some(format!(
                "inner = \"{inner}\" gets nowhere, and no other can be set up, as the note above says: take bodies that are less slender, cells less flat or contrasts smaller"
            )),
            None if is_weak && !is_exact => Some(format!(
                "inner = \"{inner}\" may be too weak for this system: take inner = \"exact\", or more iterations"
            )),
            None => return,
        };
    }
}
