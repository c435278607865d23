//! A law suite that passes whatever it is given proves nothing: every law fails for an operator that breaks it alone.

use super::*;
use crate::operator::assert_product;
use crate::sparse::Diagonal;
use crate::{Identity, Shape};

const N: usize = 24;

/// How `diag(1, 2, …)` is broken.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    None,
    /// Adds a tenth of its input squared.
    Nonlinear,
    /// Overwrites y.
    Overwrites,
    /// Takes α for 1.
    IgnoresAlpha,
    /// Adds what work contains.
    ReadsWork,
    /// One entry is wrong by a hundredth.
    WrongEntry,
    /// The adjoint is that of another operator.
    WrongAdjoint,
    /// The adjoint overwrites y.
    AdjointOverwrites,
    /// Vectors of any length are taken.
    TakesAnything,
    /// One operation too few is said.
    WrongFlops,
}

struct Broken(Fault);

impl Broken {
    fn entry<R: Real>(&self, i: usize) -> R {
        let wrong = self.0 == Fault::WrongEntry && i == N / 2;
        R::of((i + 1) as f64 * if wrong { 1.01 } else { 1.0 })
    }
}

impl<R: Real> LinearOperator<R> for Broken {
    fn shape(&self) -> Shape {
        Shape::square(N)
    }

    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        if self.0 != Fault::TakesAnything {
            assert_product(LinearOperator::<R>::shape(self), x, y);
        }
        let alpha = match self.0 {
            Fault::IgnoresAlpha => R::one(),
            _ => alpha,
        };
        for (i, (x, y)) in x.iter().zip(y).enumerate() {
            let mut product = self.entry::<R>(i) * *x;
            if self.0 == Fault::Nonlinear {
                product += R::of(0.1) * *x * *x;
            }
            if self.0 == Fault::ReadsWork {
                product += work[0];
            }
            *y = match self.0 {
                Fault::Overwrites => alpha * product,
                _ => *y + alpha * product,
            };
        }
    }

    fn work_len(&self) -> usize {
        usize::from(self.0 == Fault::ReadsWork)
    }

    fn flops(&self) -> u64 {
        3 * N as u64 - u64::from(self.0 == Fault::WrongFlops)
    }
}

impl<R: Real> AdjointOperator<R> for Broken {
    fn apply_adjoint_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        match self.0 {
            Fault::WrongAdjoint => {
                let mut reversed = x.to_vec();
                reversed.reverse();
                self.apply_add(alpha, &reversed, y, work);
            }
            Fault::AdjointOverwrites => {
                y.fill(R::zero());
                self.apply_add(alpha, x, y, work);
            }
            _ => self.apply_add(alpha, x, y, work),
        }
    }

    fn adjoint_flops(&self) -> u64 {
        LinearOperator::<R>::flops(self)
    }
}

fn verdict<R: Real>(fault: Fault) -> Result<(), Violation> {
    let sound = Diagonal::new((1..=N).map(|i| R::of(i as f64)).collect());
    check_adjoint(
        "diagonal",
        &Broken(fault),
        Some(&Dense::of_operator(&sound)),
    )
}

#[test]
fn every_law_of_a_product_can_fail_in_both_precisions() {
    let expected = [
        (Fault::Nonlinear, "A(αx + βz) = αAx + βAz"),
        (Fault::Overwrites, "apply_add accumulates y + αAx"),
        (Fault::IgnoresAlpha, "apply_add accumulates y + αAx"),
        (Fault::ReadsWork, "A(αx + βz) = αAx + βAz"),
        (Fault::WrongEntry, "agrees with the dense oracle"),
        (Fault::WrongAdjoint, "⟨Ax, y⟩ = ⟨x, Aᵀy⟩"),
        (
            Fault::AdjointOverwrites,
            "apply_adjoint_add accumulates y + αAᵀx",
        ),
        (Fault::TakesAnything, "vectors that do not fit are refused"),
    ];
    for (fault, law) in expected {
        for broken in [verdict::<f64>(fault), verdict::<f32>(fault)] {
            assert_eq!(broken.map_err(|v| v.law), Err(law), "{fault:?}");
        }
    }
    for fault in [Fault::None, Fault::WrongFlops] {
        verdict::<f64>(fault).unwrap();
        verdict::<f32>(fault).unwrap();
    }
    check_flops("diagonal", &Broken(Fault::None), 0.0).unwrap();
    assert!(check_flops("diagonal", &Broken(Fault::WrongFlops), 0.0).is_err());
}

/// How `M = I` is broken.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Flaw {
    /// Adds what z contained.
    ReadsZ,
    /// Depends on r as no linear map does, by 1e-3.
    Nonlinear,
    /// The inverse of another matrix.
    Wrong,
}

struct Flawed(Flaw);

impl<R: Real> Preconditioner<R> for Flawed {
    fn size(&self) -> usize {
        N
    }

    fn solve(&self, r: &[R], z: &mut [R], _work: &mut [R]) {
        for (r, z) in r.iter().zip(z) {
            *z = match self.0 {
                Flaw::ReadsZ => *r + *z,
                Flaw::Nonlinear => *r + R::of(1e-2) * *r * *r,
                Flaw::Wrong => R::of(1.001) * *r,
            };
        }
    }

    fn flops(&self) -> u64 {
        0
    }

    fn properties(&self) -> Properties {
        Properties::LINEAR
    }
}

#[test]
fn every_law_of_a_solve_can_fail_in_both_precisions() {
    fn verdict<R: Real>(m: &dyn Preconditioner<R>) -> Result<(), &'static str> {
        let identity = Diagonal::new(vec![R::one(); N]);
        check_preconditioner("identity", m, Some(&identity), 1e-4).map_err(|v| v.law)
    }
    let expected = [
        (Flaw::ReadsZ, "same bits whatever z and work contain"),
        (Flaw::Nonlinear, "M⁻¹(αr + βs) = αM⁻¹r + βM⁻¹s"),
        (Flaw::Wrong, "A M⁻¹ r = r"),
    ];
    for (flaw, law) in expected {
        assert_eq!(verdict::<f64>(&Flawed(flaw)), Err(law), "{flaw:?}");
        assert_eq!(verdict::<f32>(&Flawed(flaw)), Err(law), "{flaw:?}");
    }
    assert_eq!(verdict::<f64>(&Identity { n: N }), Ok(()));
    assert_eq!(verdict::<f32>(&Identity { n: N }), Ok(()));
}

#[test]
fn a_whole_that_forgets_a_part_is_found() {
    struct Forgetful(Part);
    impl<R: Real> Preconditioner<R> for Forgetful {
        fn size(&self) -> usize {
            self.0.n
        }
        fn solve(&self, r: &[R], z: &mut [R], _work: &mut [R]) {
            z.copy_from_slice(r);
        }
        fn flops(&self) -> u64 {
            0
        }
        fn properties(&self) -> Properties {
            Properties {
                single: false,
                ..self.0.properties
            }
        }
    }
    let forgetful = check_parts::<1, f64, _>("forgetful", [N], |[part]| Forgetful(part));
    assert!(forgetful.is_err());
    check_parts::<1, f64, _>("itself", [N], |[part]| part).unwrap();
}
