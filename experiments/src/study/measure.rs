//! What a row can measure, by name.

use super::measured::Measured;
use fracas::io::Hash;
use fracas_solvers::saddle::AugmentationChoice;
use fracas_solvers::spectrum::{Bounds, Method, NonNormal, SpectrumReport};
use serde::{Deserialize, Serialize};

/// What a measure takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    /// The matrices.
    System,
    /// Its settings alone.
    Settings,
    /// A contact state.
    State,
    /// A solve.
    Solve,
    /// The clock or the memory of the machine; no second run repeats it.
    Clock,
    /// Whether and at which cost a solve succeeded.
    Count,
    /// Ends of the spectra of A and S_u.
    Condition,
    /// Eigenvalues of M⁻¹𝒜.
    Spectrum,
    /// How far M⁻¹𝒜 is from normal, in the inner product of energy.
    NonNormal,
    /// Errors against solutions of their own.
    Nested,
    /// The scene, through its load steps.
    Run,
}

macro_rules! measures {
    ($($variant:ident $name:literal $group:ident $label:literal $field:expr;)*) => {
        /// A measure; the name is that in study files and in `rows.csv`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        #[allow(missing_docs, reason = "the label says it")]
        pub enum Name {
            $(#[serde(rename = $name)] $variant,)*
        }

        impl Name {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$variant),*];

            /// As it is written.
            pub const fn text(self) -> &'static str {
                match self { $(Self::$variant => $name),* }
            }

            /// For axes of figures, with its unit.
            pub const fn label(self) -> &'static str {
                match self { $(Self::$variant => $label),* }
            }

            pub(super) const fn group(self) -> Group {
                match self { $(Self::$variant => Group::$group),* }
            }

            /// The value of a row as a field of `rows.csv`; empty where there is none.
            pub(super) fn field(self, measured: &Measured) -> String {
                let of: fn(&Measured) -> Option<String> = match self {
                    $(Self::$variant => $field),*
                };
                of(measured).unwrap_or_default()
            }
        }
    };
}

/// The field of a number; none where it is not finite.
fn real(value: Option<f64>) -> Option<String> {
    value.filter(|v| v.is_finite()).map(number)
}

fn count(n: Option<usize>) -> Option<String> {
    n.map(|n| n.to_string())
}

fn word(holds: Option<bool>) -> Option<String> {
    holds.map(|holds| if holds { "yes" } else { "no" }.into())
}

fn spectrum(m: &Measured, of: fn(&SpectrumReport) -> Option<f64>) -> Option<String> {
    real(m.spectrum.as_ref().and_then(of))
}

/// A count of all eigenvalues; none where outer ones alone were found.
fn of_all(m: &Measured, of: fn(&SpectrumReport) -> usize) -> Option<String> {
    let all = m.spectrum.as_ref().filter(|s| s.method == Method::Dense);
    count(all.map(of))
}

fn outside(m: &Measured, of: fn(&SpectrumReport) -> Option<usize>) -> Option<String> {
    count(m.spectrum.as_ref().and_then(of))
}

fn non_normal(m: &Measured, of: fn(&NonNormal) -> Option<f64>) -> Option<String> {
    let found = m.spectrum.as_ref().and_then(|s| s.non_normal.as_ref());
    real(found.and_then(of))
}

fn steps(m: &Measured, which: usize) -> Option<String> {
    let found = m.spectrum.as_ref().and_then(|s| s.non_normal.as_ref());
    count(found.and_then(|found| found.gmres.steps[which]))
}

fn bound(m: &Measured, of: fn(&Bounds) -> Option<f64>) -> Option<String> {
    real(m.spectrum.as_ref().and_then(|s| of(&s.bounds)))
}

/// The interval that is proved for all eigenvalues where S_u is exact, else for the real ones.
pub(super) fn interval(s: &SpectrumReport) -> Option<(f64, f64)> {
    s.exact_S_u_interval.or(s.bounds.region().real)
}

/// Every bit of a solution in a number.
fn digest(x: &[f64]) -> String {
    let mut hash = Hash::default();
    x.iter().for_each(|v| hash.bytes(&v.to_le_bytes()));
    hash.to_string()
}

measures! {
    N "n" System "unknowns n" |m| count(m.sizes.map(|sizes| sizes.iter().sum()));
    DisplacementUnknowns "n_u" System "displacement unknowns n_u" |m| count(m.sizes.map(|n| n[0]));
    TractionUnknowns "n_t" System "traction unknowns n_t" |m| count(m.sizes.map(|n| n[1]));
    Augmentation "C" Settings "C" |m| m.c.map(|c| c.name().into());
    Factor "factor" Settings "s" |m| match m.c {
        Some(AugmentationChoice::GlobalTimes(factor)) => real(Some(factor)),
        _ => None,
    };
    Slip "slip" State "slipping faces [%]" |m| real(m.contact.map(|c| c.slip));
    Open "open" State "open faces [%]" |m| real(m.contact.map(|c| c.open));
    OwnRows "own_rows" State "rows with a law of their own" |m| count(m.contact.map(|c| c.own_rows));
    Symmetric "symmetric" State "symmetric without its own rows" |m| word(m.contact.map(|c| c.is_symmetric));
    Newton "newton" State "Newton steps" |m| count(m.contact.map(|c| c.newton));
    NewtonConverged "newton_converged" State "Newton's method converged" |m| word(m.contact.map(|c| c.has_converged));
    Tension "tension" State "closed faces in tension" |m| count(m.contact.map(|c| c.tension));
    Overlap "overlap" State "open faces that overlap" |m| count(m.contact.map(|c| c.overlap));
    Iterations "n_it" Count "iterations n_it" |m| count(m.run.as_ref().and_then(|r| r.iterations));
    Application "c_app" Solve "cost of M⁻¹ over that of 𝒜, c_app" |m| real(m.run.as_ref().and_then(|r| r.c_app));
    Cost "C_s" Count "cost C_s [products with 𝒜]" |m| real(m.run.as_ref().and_then(|r| r.cost));
    MeshTime "mesh_s" Clock "mesh [s]" |m| real(m.mesh_s);
    AssemblyTime "assembly_s" Clock "assembly [s]" |m| real(m.assembly_s);
    SetUp "setup_s" Clock "set-up [s]" |m| real(m.run.as_ref().map(|r| r.setup_s));
    Solve "solve_s" Clock "iteration [s]" |m| real(m.run.as_ref().map(|r| r.solve_s));
    Memory "memory" Clock "peak memory [MiB]" |m| {
        let bytes = m.run.as_ref().and_then(|r| r.memory);
        real(bytes.map(|bytes| bytes as f64 / f64::from(1 << 20)))
    };
    ErrorU "error_u" Solve "error of u, relative" |m| {
        let estimates = m.run.as_ref().map(|r| r.estimates);
        real(m.errors.map(|e| e[0]).or(estimates.and_then(|e| e[0])))
    };
    ErrorT "error_t" Solve "error of t, relative" |m| {
        let estimates = m.run.as_ref().map(|r| r.estimates);
        real(m.errors.map(|e| e[1]).or(estimates.and_then(|e| e[1])))
    };
    Referenced "referenced" Solve "errors against a direct solver" |m| word(m.run.as_ref().map(|_| m.errors.is_some()));
    AlgebraicU "algebraic_u" Nested "error of u against the same mesh" |m| real(m.nested.map(|e| e.same[0]));
    AlgebraicT "algebraic_t" Nested "error of t against the same mesh" |m| real(m.nested.map(|e| e.same[1]));
    MeshError "mesh_error" Nested "error of u against the finest mesh" |m| real(m.nested.and_then(|e| e.mesh));
    Levels "levels" Solve "levels of multigrid" |m| {
        let run = m.run.as_ref();
        count(run.and_then(|r| Some(r.hierarchy.as_ref()?.levels.len())))
    };
    Complexity "complexity" Solve "operator complexity" |m| {
        let run = m.run.as_ref();
        real(run.and_then(|r| Some(r.hierarchy.as_ref()?.operator_complexity)))
    };
    Relaxation "relaxation" Solve "γ" |m| real(m.run.as_ref().map(|r| r.relaxation.gamma));
    Degree "degree" Solve "degree of W" |m| count(m.run.as_ref().map(|r| r.relaxation.degree));
    Iteration "iteration" Solve "iteration that ran" |m| {
        Some(m.run.as_ref().map_or(m.asked.clone(), |r| r.krylov.clone()))
    };
    Digest "digest" Solve "bits of the solution" |m| m.run.as_ref().map(|r| digest(&r.x));
    RunSteps "run_steps" Run "load steps" |m| count(m.steps.map(|s| s.steps));
    RunRounds "run_rounds" Run "rounds of the active set" |m| count(m.steps.map(|s| s.rounds));
    RunNewton "run_newton" Run "Newton steps of the run" |m| count(m.steps.map(|s| s.newton));
    RunKrylov "run_krylov" Run "Krylov iterations of the run" |m| count(m.steps.map(|s| s.krylov));
    RunRounds95 "run_rounds_95" Run "rounds of a step, 95 % of them" |m| count(m.steps.and_then(|s| s.rounds_95));
    RunNewtonMedian "run_newton_median" Run "Newton steps of a step, median" |m| count(m.steps.and_then(|s| s.newton_median));
    RunKrylovMedian "run_krylov_median" Run "Krylov iterations to 1e-8, median" |m| count(m.steps.and_then(|s| s.krylov_median));
    RunLost "run_lost" Run "fluid lost over fluid injected" |m| real(m.steps.and_then(|s| s.lost));
    RunCuts "run_cuts" Run "halvings of load steps" |m| count(m.steps.map(|s| s.cuts));
    RunTime "run_s" Run "run [s]" |m| real(m.steps.map(|s| s.wall_s));
    RunOnset "run_onset" Run "first slip [s]" |m| real(m.faults.and_then(|f| f.onset));
    RunOpening "run_opening" Run "first opening [s]" |m| real(m.faults.and_then(|f| f.opening));
    RunSlip "run_slip" Run "largest slip [m]" |m| real(m.faults.map(|f| f.slip));
    RunSlipping "run_slipping" Run "largest slipping area [m²]" |m| real(m.faults.map(|f| f.slipping));
    RunOpen "run_open" Run "largest open area [m²]" |m| real(m.faults.map(|f| f.open));
    RunAperture "run_aperture" Run "largest aperture [m]" |m| real(m.faults.map(|f| f.aperture));
    RunMoment "run_moment" Run "seismic moment [N m]" |m| real(m.faults.map(|f| f.moment));
    RunCriticality "run_chi" Run "largest criticality χ" |m| real(m.faults.map(|f| f.criticality));
    RunDissipated "run_dissipated" Run "dissipated by friction [J]" |m| real(m.faults.map(|f| f.dissipated));
    Kernel "kernel_A" Condition "dim ker A" |m| count(m.stiffness.map(|s| s.kernel));
    ConditionA "cond_A" Condition "κ(A), off its kernel" |m| real(m.stiffness.and_then(|s| s.ends).map(|e| e.condition()));
    ConditionSu "cond_S_u" Condition "κ(S_u)" |m| real(m.schur[0].map(|e| e.condition()));
    ConditionScaled "cond_S_u_scaled" Condition "κ(S_u), unit diagonal" |m| real(m.schur[1].map(|e| e.condition()));
    ConditionError "cond_error" Condition "error bars of κ(A) and κ(S_u), relative" |m| {
        let ends = [m.stiffness.and_then(|s| s.ends), m.schur[0]];
        real(Some(ends.iter().flatten().map(|e| e.error()).sum()))
    };
    LargestC "c_max" Spectrum "λ_max(C) [m³/Pa]" |m| spectrum(m, |s| Some(s.c_max));
    RealMin "real_min" Spectrum "smallest real eigenvalue" |m| spectrum(m, |s| s.real_min);
    RealMax "real_max" Spectrum "largest real eigenvalue" |m| spectrum(m, |s| s.real_max);
    ReMin "re_min" Spectrum "smallest Re λ" |m| spectrum(m, |s| s.re_min);
    ReMax "re_max" Spectrum "largest Re λ" |m| spectrum(m, |s| s.re_max);
    ImMax "im_max" Spectrum "largest |Im λ|" |m| spectrum(m, |s| s.im_max);
    NonReal "n_nonreal" Spectrum "non-real eigenvalues" |m| of_all(m, |s| s.n_complex);
    AtOne "n_at_one" Spectrum "eigenvalues at 1" |m| of_all(m, |s| s.n_at_one);
    AtHalf "n_at_half" Spectrum "eigenvalues at ½" |m| of_all(m, |s| s.n_at_half);
    AlphaU "alpha_u" Spectrum "α_u" |m| bound(m, |b| b.alpha_u);
    BetaU "beta_u" Spectrum "β_u" |m| bound(m, |b| b.beta_u);
    AlphaT "alpha_t" Spectrum "α_t" |m| bound(m, |b| b.alpha_t);
    BetaT "beta_t" Spectrum "β_t" |m| bound(m, |b| b.beta_t);
    DeltaMin "delta_min" Spectrum "δ = λ_min(S̃_u⁻¹S_u)" |m| spectrum(m, |s| s.delta);
    DeltaMax "delta_max" Spectrum "Δ = λ_max(S̃_u⁻¹S_u)" |m| spectrum(m, |s| s.Delta);
    Eta "eta" Spectrum "η = λ_max(C⁻¹H)" |m| spectrum(m, |s| s.eta);
    ErrorBar "error_bar" Spectrum "error bar of α and β, relative" |m| spectrum(m, |s| s.error_bar);
    ProvedLow "proved_low" Spectrum "proved lower end" |m| spectrum(m, |s| interval(s).map(|i| i.0));
    ProvedHigh "proved_high" Spectrum "proved upper end" |m| spectrum(m, |s| interval(s).map(|i| i.1));
    ProvedIm "proved_im" Spectrum "proved |Im λ|" |m| bound(m, |b| b.im_max);
    Outside "outside" Spectrum "eigenvalues outside the proved regions" |m| {
        // where nothing is proved, nothing is inside either
        outside(m, |s| s.contained.map(|_| s.outside.len()))
    };
    OutsidePrinted "outside_printed" Spectrum "eigenvalues outside the region as printed" |m| {
        outside(m, |s| s.printed.as_ref().map(|p| p.outside.len()))
    };
    Departure "departure" NonNormal "departure from normality" |m| non_normal(m, |n| Some(n.departure));
    FieldLow "field_low" NonNormal "least Re of the field of values" |m| non_normal(m, |n| Some(n.gmres.coercivity));
    FieldHigh "field_high" NonNormal "largest Re of the field of values" |m| non_normal(m, |n| Some(n.field_of_values.support[0]));
    FieldIm "field_im" NonNormal "largest |Im| of the field of values" |m| non_normal(m, |n| {
        n.field_of_values.im.iter().copied().reduce(f64::max)
    });
    StepsGmres "steps_gmres" NonNormal "steps of GMRES" |m| steps(m, 0);
    StepsResolvent "steps_resolvent" NonNormal "bound by the resolvent" |m| steps(m, 1);
    StepsField "steps_field" NonNormal "bound by the field of values" |m| steps(m, 2);
    Contained "contained" Spectrum "inside the proved regions" |m| {
        word(m.spectrum.as_ref().and_then(|s| s.contained))
    };
}

impl Name {
    /// By its text.
    pub(super) fn find(text: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|name| name.text() == text)
    }

    /// True for what the clock or the system tells, and no second run repeats.
    pub fn is_measured(self) -> bool {
        self.group() == Group::Clock || self == Self::RunTime
    }
}

/// The shortest digits that read back as the same number.
pub(super) fn number(value: f64) -> String {
    match value.fract() == 0.0 && value.abs() < 1e15 {
        true => format!("{value}"),
        false => format!("{value:?}"),
    }
}
