//! e22: faults around a gas store, year by year.

mod figures;
mod run;

use crate::report::{Cell, Check, Experiment, Findings, Level, Table};
use fracas::scene::named;
use fracas_solvers::Observer;
use run::{Run, Stage};

/// When do faults around gas stores slip?
#[derive(Debug)]
pub struct GasStorage;

/// The scene.
const SCENE: &str = "storage";

/// A variation of the scene: its name, its overrides, and what it changes.
const VARIATIONS: [(&str, &[&str]); 4] = [
    ("as it is", &[]),
    ("salt does not creep", NO_CREEP),
    (
        "Biot 0.6",
        &["material.west.biot=0.6", "material.east.biot=0.6"],
    ),
    (
        "M1 = M2 = 0.4",
        &["initial_stress.weight.horizontal=[0.4, 0.4]"],
    ),
];

/// Salt that flows in a hundred thousand years.
const NO_CREEP: &[&str] = &["material.salt.viscosity=1e22 Pa*s"];

impl Experiment for GasStorage {
    fn id(&self) -> &'static str {
        "e22"
    }

    fn title(&self) -> &'static str {
        "Faults around a gas store"
    }

    fn question(&self) -> &'static str {
        "When do the faults around two blocks of a gas store slip: in primary production, as cushion gas comes in, or in storage; and what \
         do creep of the salt, Biot's coefficient and the initial stress change?"
    }

    fn setup(&self) -> &'static str {
        "`storage`: two blocks of 1 km × 1.5 km (half, by symmetry) and 200 m, offset by 100 m along a central fault, with a fault along every \
         outer side, below salt that creeps. Printed: densities, moduli, Poisson's ratios and the viscosity of the four layers, M1 = 0.74, M2 = 0.83, \
         stages, steps of a year. Within printed ranges: depth, offset, Biot's coefficient, pressure change. Ours: extents, the friction \
         angle of 20°, pore fluid of 1000 kg/m³, the pressure history (350 → 150 → 300 bar, then 300 and 220 in turn; the eastern block begins \
         three years later), faults that keep their hydrostatic pressure, salt whose initial stress is isotropic. Smoke: cells of 250 m × 500 m × 100 m beside the \
         faults, paper 100 m × 200 m × 50 m."
    }

    fn expect(&self) -> &'static str {
        "As printed in words: faults slip during primary production; what then is in equilibrium is loaded the other way when the pressure \
         turns, so that slip goes back at cushion gas injection; a lower horizontal stress lets faults slip early and over a large area."
    }

    fn run(&self, level: Level, observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        let mut findings = Findings::default();
        findings.set("scene", SCENE).set("level", level.word());
        let entry = named(SCENE).ok_or_else(|| anyhow::anyhow!("no scene {SCENE}"))?;
        let scene = match level {
            Level::Smoke => entry.small_scene()?,
            Level::Paper => entry.scene()?,
        };
        // few displacements with many faces in slip take half the time of factorizations
        let inner = match level {
            Level::Smoke => "solver.inner='amg'",
            Level::Paper => "solver.inner='auto'",
        };
        let mut runs = Vec::new();
        for (name, overrides) in VARIATIONS {
            let strict = scene
                .with_overrides(overrides)?
                .with_overrides(&["solver.tolerance=1e-10", inner])?;
            runs.push(Run::of(name, &strict, observer)?);
        }
        let [own, stiff, biot, stress] = &runs[..] else {
            anyhow::bail!("four variations");
        };
        findings.tables.push(years(own));
        findings.tables.push(variations(&runs));
        findings.figures.push(figures::area(own));
        findings.figures.push(figures::dip_slip(&runs));
        findings.figures.push(figures::energy(own, stiff));
        findings.figures.extend(figures::criticality(own));
        let production = own.largest(Stage::Production, |y| y.moment_step());
        let turned = stress.largest(Stage::Cushion, |y| y.moment_step());
        let stored = stress.largest(Stage::Storage, |y| y.moment_step());
        let [before, after] = [stress.end(Stage::Production), stress.end(Stage::Cushion)];
        findings.checks = vec![
            Check::at_least(
                "the central fault slips in primary production: moment of the largest year [N m]",
                1e12,
                production,
            ),
            Check::at_least(
                "M1 = M2 = 0.4: it slips as cushion gas comes in: moment of the largest year [N m]",
                1e12,
                turned,
            ),
            Check::at_least(
                "M1 = M2 = 0.4: it slips in storage: moment of the largest year [N m]",
                1e12,
                stored,
            ),
            Check::holds(
                "M1 = M2 = 0.4: as cushion gas comes in slip goes back: mean dip slip of the central fault [mm]",
                format!("nearer to 0 than {before:.3}"),
                format!("{after:.3}"),
                after.abs() < before.abs(),
            ),
            Check::at_most(
                "with M1 = M2 = 0.4 faults slip no later: years until the first slip, over those of the scene",
                1.0,
                stress.first_slip() / own.first_slip(),
            ),
            Check::at_most(
                "Biot 0.6 slips less: moment at the end of production, over that of the scene",
                1.0,
                biot.moment(Stage::Production) / own.moment(Stage::Production),
            ),
            Check::at_most(
                "energy that the balance misses, over the work of the loads",
                1e-5,
                own.imbalance(),
            ),
            Check::at_least(
                "energy that creep dissipates in a step [J]",
                0.0,
                own.least_creep(),
            ),
            Check::at_least(
                "creep dissipates a hundred times as much as in salt that hardly flows",
                100.0,
                own.crept() / stiff.crept(),
            ),
            Check::at_most("preconditioners built per step", 1.0, own.setups()),
        ];
        findings.notes.push(
            "Criticality is shown against the total stress less the hydrostatic pressure of the initial state: faults that share the falling \
             pressure of a block would be pressed together by it."
                .into(),
        );
        findings.notes.push(
            "With M1 = 0.74 and M2 = 0.83 whether slip goes back as cushion gas comes in depends on the mesh: in cells of 250 m × 500 m × 100 m \
             the central fault gives back 1.8 of 11.1 mm of its mean, in cells of 100 m × 200 m × 50 m nothing."
                .into(),
        );
        Ok(findings)
    }
}

/// Every year of every fault.
fn years(run: &Run) -> Table {
    let mut table = Table::new(
        "e22_years",
        "Every fault at the end of every year: slipping area, slip, moment, largest criticality.",
        &[
            "time [year]",
            "stage",
            "fault",
            "slipping area [km²]",
            "largest slip [mm]",
            "moment [N m]",
            "moment of the year [N m]",
            "largest χ",
            "dissipated [J]",
        ],
    );
    for year in &run.years {
        for fault in &year.faults {
            table.push([
                Cell::from(year.time.round()),
                year.stage.word().into(),
                fault.name.clone().into(),
                (1e-6 * fault.slipping_area).into(),
                (1e3 * fault.slip_max).into(),
                fault.moment.into(),
                fault.moment_step.into(),
                fault.chi_max.into(),
                fault.dissipated.into(),
            ]);
        }
    }
    table
}

/// One line per variation.
fn variations(runs: &[Run]) -> Table {
    let mut table = Table::new(
        "e22_variations",
        "What changes what: first slip, moments of the stages (all faults), largest slip, energy that creep dissipates.",
        &[
            "variation",
            "first slip [year]",
            "moment after production [N m]",
            "largest slip [mm]",
            "moment of the cushion gas [N m]",
            "moment of storage [N m]",
            "creep [J]",
            "friction [J]",
        ],
    );
    for run in runs {
        table.push([
            Cell::from(run.name.clone()),
            run.first_slip().into(),
            run.moment(Stage::Production).into(),
            (1e3 * run.slip_max()).into(),
            run.sum(Stage::Cushion, |y| y.all_moment_step()).into(),
            run.sum(Stage::Storage, |y| y.all_moment_step()).into(),
            run.crept().into(),
            run.dissipated().into(),
        ]);
    }
    table
}
