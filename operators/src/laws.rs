//! The laws that every operator and every preconditioner obeys, as functions that tests call with one list of both.
//!
//! Checked: shape, linearity, accumulation onto a non-zero `y` with `α ∉ {0, 1}`, `⟨Ax, y⟩ = ⟨x, Aᵀy⟩`, indifference
//! to what `work` contains (it is poisoned with NaN), that exactly `work_len()` entries suffice, `flops()` against a scalar that
//! counts, and that what is made of parts is no more linear than they are.

use crate::tally::Tally;
use crate::vector::{dot, norm2};
use crate::{AdjointOperator, Dense, LinearOperator, Preconditioner, Properties, Real};
use num_traits::Float;
use std::panic::{AssertUnwindSafe, catch_unwind};

#[cfg(test)]
mod broken;

/// A broken law: which, for what, and by how much.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{subject}: law \"{law}\" broken: relative deviation {deviation:.3e} > {tolerance:.1e}")]
pub struct Violation {
    /// Name of the operator under test.
    pub subject: String,
    /// The law.
    pub law: &'static str,
    /// Relative deviation found.
    pub deviation: f64,
    /// What rounding allows.
    pub tolerance: f64,
}

/// Deviation that rounding explains in a product, relative to the size of the result: 500 units in the last place, so that in f32, too,
/// a digit that is wrong by 1e-4 shows.
fn tolerance<R: Real>() -> f64 {
    500.0 * R::epsilon().to_f64_exact()
}

/// The same for a solve, which amplifies rounding by the condition of what it solves: 2e5 units in the last place of f64, 2e4 of f32.
fn tolerance_of_solves(digits: f64) -> f64 {
    digits * if digits > 1e-10 { 2e4 } else { 2e5 }
}

/// A reproducible vector with entries of both signs and no pattern.
pub fn probe<R: Real>(n: usize, seed: u64) -> Vec<R> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    (0..n)
        .map(|_| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            R::of((state >> 11) as f64 / (1u64 << 53) as f64 - 0.5)
        })
        .collect()
}

struct Judge<'a> {
    subject: &'a str,
}

impl Judge<'_> {
    fn same<R: Real>(&self, law: &'static str, a: &[R], b: &[R]) -> Result<(), Violation> {
        self.same_to(tolerance::<R>(), law, a, b)
    }

    fn same_to<R: Real>(
        &self,
        tolerance: f64,
        law: &'static str,
        a: &[R],
        b: &[R],
    ) -> Result<(), Violation> {
        let difference: Vec<R> = a.iter().zip(b).map(|(a, b)| *a - *b).collect();
        let scale = norm2(a).max(norm2(b)).to_f64_exact();
        self.small(law, norm2(&difference).to_f64_exact(), scale, tolerance)
    }

    fn small(
        &self,
        law: &'static str,
        difference: f64,
        scale: f64,
        tolerance: f64,
    ) -> Result<(), Violation> {
        let deviation = if difference == 0.0 {
            0.0
        } else {
            difference / scale
        };
        if deviation <= tolerance {
            Ok(())
        } else {
            Err(Violation {
                subject: self.subject.to_owned(),
                law,
                deviation,
                tolerance,
            })
        }
    }
}

/// Checks every law of a product; `oracle` is the dense reference where one is affordable.
pub fn check_operator<R: Real>(
    subject: &str,
    a: &dyn LinearOperator<R>,
    oracle: Option<&Dense<R>>,
) -> Result<(), Violation> {
    let judge = Judge { subject };
    let (rows, cols) = (a.shape().rows, a.shape().cols);
    let (x, z, y0) = (
        probe::<R>(cols, 1),
        probe::<R>(cols, 2),
        probe::<R>(rows, 3),
    );
    let (alpha, beta) = (R::of(-1.75), R::of(0.375));
    let product = |v: &[R]| {
        let mut y = vec![R::nan(); rows];
        a.apply(v, &mut y, &mut vec![R::nan(); a.work_len()]);
        y
    };
    let (ax, az) = (product(&x), product(&z));

    let combined: Vec<R> = x
        .iter()
        .zip(&z)
        .map(|(x, z)| alpha * *x + beta * *z)
        .collect();
    let sum: Vec<R> = ax
        .iter()
        .zip(&az)
        .map(|(x, z)| alpha * *x + beta * *z)
        .collect();
    judge.same("A(αx + βz) = αAx + βAz", &product(&combined), &sum)?;

    let mut y = y0.clone();
    a.apply_add(alpha, &x, &mut y, &mut vec![R::nan(); a.work_len()]);
    let accumulated: Vec<R> = y0.iter().zip(&ax).map(|(y, ax)| *y + alpha * *ax).collect();
    judge.same("apply_add accumulates y + αAx", &y, &accumulated)?;

    let refuses = |x: usize, y: usize| {
        let (x, mut y) = (vec![R::zero(); x], vec![R::zero(); y]);
        let mut work = vec![R::zero(); a.work_len()];
        let product = AssertUnwindSafe(|| a.apply_add(R::one(), &x, &mut y, &mut work));
        catch_unwind(product).is_err()
    };
    for (x, y) in [(cols + 1, rows), (cols, rows + 1)] {
        let taken = f64::from(u8::from(!refuses(x, y)));
        judge.small("vectors that do not fit are refused", taken, 1.0, 0.0)?;
    }

    if let Some(oracle) = oracle {
        let fits = f64::from(u8::from(oracle.shape() != a.shape()));
        judge.small("has the shape of the dense oracle", fits, 1.0, 0.0)?;
        let mut exact = vec![R::zero(); rows];
        oracle.apply(&x, &mut exact, &mut []);
        judge.same("agrees with the dense oracle", &ax, &exact)?;
    }
    Ok(())
}

/// Checks `⟨Ax, y⟩ = ⟨x, Aᵀy⟩` and the accumulation of the adjoint, after the laws of the product.
pub fn check_adjoint<R: Real>(
    subject: &str,
    a: &dyn AdjointOperator<R>,
    oracle: Option<&Dense<R>>,
) -> Result<(), Violation> {
    check_operator(subject, &a, oracle)?;
    let judge = Judge { subject };
    let (rows, cols) = (a.shape().rows, a.shape().cols);
    let (x, y) = (probe::<R>(cols, 4), probe::<R>(rows, 5));
    let mut ax = vec![R::zero(); rows];
    a.apply(&x, &mut ax, &mut vec![R::nan(); a.work_len()]);
    let mut aty = vec![R::zero(); cols];
    a.apply_adjoint_add(R::one(), &y, &mut aty, &mut vec![R::nan(); a.work_len()]);
    let difference = (dot(&ax, &y) - dot(&x, &aty)).abs().to_f64_exact();
    let scale = (norm2(&ax) * norm2(&y))
        .max(norm2(&x) * norm2(&aty))
        .to_f64_exact();
    judge.small("⟨Ax, y⟩ = ⟨x, Aᵀy⟩", difference, scale, tolerance::<R>())?;

    let start = probe::<R>(cols, 6);
    let mut accumulated = start.clone();
    a.apply_adjoint_add(
        R::of(-0.5),
        &y,
        &mut accumulated,
        &mut vec![R::nan(); a.work_len()],
    );
    let expected: Vec<R> = start
        .iter()
        .zip(&aty)
        .map(|(s, v)| *s - R::of(0.5) * *v)
        .collect();
    judge.same(
        "apply_adjoint_add accumulates y + αAᵀx",
        &accumulated,
        &expected,
    )
}

/// Checks that a preconditioner ignores what `z` and `work` contain, repeats itself bit for bit, and is linear if it
/// says so, to 32 bits where it says that; `matrix` is the matrix that it inverts exactly, where it claims to.
pub fn check_preconditioner<R: Real>(
    subject: &str,
    m: &dyn Preconditioner<R>,
    matrix: Option<&dyn LinearOperator<R>>,
    accuracy: f64,
) -> Result<(), Violation> {
    let judge = Judge { subject };
    let n = m.size();
    let solve = |r: &[R], dirt: R| {
        let mut z = vec![dirt; n];
        m.solve(r, &mut z, &mut vec![dirt; m.work_len()]);
        z
    };
    let (r, s) = (probe::<R>(n, 7), probe::<R>(n, 8));
    let (zr, zs) = (solve(&r, R::nan()), solve(&s, R::nan()));
    let again = solve(&r, R::of(3.0));
    let properties = m.properties();
    let same_bits = zr.iter().zip(&again).all(|(a, b)| a == b);
    judge.small(
        "same bits whatever z and work contain",
        if same_bits { 0.0 } else { 1.0 },
        1.0,
        0.0,
    )?;
    if properties.linear {
        let (alpha, beta) = (R::of(0.75), R::of(-2.0));
        let combined: Vec<R> = r
            .iter()
            .zip(&s)
            .map(|(r, s)| alpha * *r + beta * *s)
            .collect();
        let sum: Vec<R> = zr
            .iter()
            .zip(&zs)
            .map(|(a, b)| alpha * *a + beta * *b)
            .collect();
        let own = R::epsilon().to_f64_exact();
        let rounding = tolerance_of_solves(match properties.single {
            true => own.max(f64::from(f32::EPSILON)),
            false => own,
        });
        judge.same_to(
            rounding,
            "M⁻¹(αr + βs) = αM⁻¹r + βM⁻¹s",
            &solve(&combined, R::zero()),
            &sum,
        )?;
    }
    if let Some(matrix) = matrix {
        let mut back = vec![R::zero(); n];
        matrix.apply(&zr, &mut back, &mut vec![R::nan(); matrix.work_len()]);
        let difference: Vec<R> = back.iter().zip(&r).map(|(a, b)| *a - *b).collect();
        judge.small(
            "A M⁻¹ r = r",
            norm2(&difference).to_f64_exact(),
            norm2(&r).to_f64_exact(),
            accuracy,
        )?;
    }
    Ok(())
}

/// Checks `flops()` of a product against the operations of `y ← y + αAx`, to the share `slack` of them; run it on one thread.
pub fn check_flops(
    subject: &str,
    a: &dyn LinearOperator<Tally>,
    slack: f64,
) -> Result<(), Violation> {
    let (x, mut y) = (probe(a.shape().cols, 9), probe(a.shape().rows, 10));
    let mut work = vec![Tally::nan(); a.work_len()];
    let counted = Tally::count(|| a.apply_add(Tally::of(-1.75), &x, &mut y, &mut work));
    flops_are(subject, a.flops(), counted, slack)
}

/// Checks `flops()` of a solve against the operations of `z ← M⁻¹r`, to the share `slack` of them; run it on one thread.
pub fn check_flops_of_solve(
    subject: &str,
    m: &dyn Preconditioner<Tally>,
    slack: f64,
) -> Result<(), Violation> {
    let (r, mut z) = (probe(m.size(), 11), probe(m.size(), 12));
    let mut work = vec![Tally::nan(); m.work_len()];
    let counted = Tally::count(|| m.solve(&r, &mut z, &mut work));
    flops_are(subject, m.flops(), counted, slack)
}

fn flops_are(subject: &str, said: u64, counted: u64, slack: f64) -> Result<(), Violation> {
    let difference = said.abs_diff(counted) as f64;
    let law = "flops() is what a scalar counts";
    Judge { subject }.small(law, difference, counted as f64, slack)
}

/// A part that says what it is told to say of itself, and is the identity.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Length of the vectors.
    pub n: usize,
    /// What it says.
    pub properties: Properties,
}

impl<R: Real> Preconditioner<R> for Part {
    fn size(&self) -> usize {
        self.n
    }

    fn solve(&self, r: &[R], z: &mut [R], _work: &mut [R]) {
        z.copy_from_slice(r);
    }

    fn flops(&self) -> u64 {
        0
    }

    fn properties(&self) -> Properties {
        self.properties
    }
}

/// Checks that the preconditioner made of parts of these `sizes` is no linear map, or rounded to 32 bits, or local, where any one
/// part says so, and linear where all are; it may be blind by itself, and is where a part is.
pub fn check_parts<const N: usize, R: Real, M: Preconditioner<R>>(
    subject: &str,
    sizes: [usize; N],
    whole: impl Fn([Part; N]) -> M,
) -> Result<(), Violation> {
    let judge = Judge { subject };
    let both = Properties::SINGLE.and(Properties::NONLINEAR);
    let own = whole(sizes.map(|n| Part {
        n,
        properties: Properties::LINEAR,
    }));
    let own = own.properties();
    let strange = f64::from(u8::from(
        ![Properties::LINEAR, Properties::BLIND].contains(&own),
    ));
    judge.small("a whole of linear parts is linear", strange, 1.0, 0.0)?;
    for said in [
        Properties::LINEAR,
        Properties::LOCAL,
        Properties::BLIND,
        Properties::SINGLE,
        Properties::NONLINEAR,
        both,
    ] {
        for place in 0..N {
            let parts = std::array::from_fn(|k| Part {
                n: sizes[k],
                properties: if k == place { said } else { Properties::LINEAR },
            });
            let wrong = f64::from(u8::from(whole(parts).properties() != said.and(own)));
            judge.small("a whole says what its parts say", wrong, 1.0, 0.0)?;
        }
    }
    Ok(())
}
