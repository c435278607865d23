//! Claim: whatever the settings of a gas store, within their published ranges and a little beyond, its run finishes or ends with a loss of
//! equilibrium that is shown.
//!
//! `FRACAS_RUNS=300 FRACAS_SEED=7000 cargo test --release --test contact store:: -- --nocapture` runs more stores;
//! `FRACAS_SCENES=folder` keeps their scenes there.

use crate::robust::{asked, ends_in_a_known_way, sweep};
use fracas_operators::random::Random;

/// Stores where nobody asks for more.
const RUNS: u64 = 4;

/// A store that the seed alone decides: a slab or half of a body, one to three faults across x, one across y and one level one that cross
/// them, dips of ±25° from upright, throws to 200 m, friction of 8 to 32° that may weaken, drawdown to 250 bar, salt that may creep.
fn store(seed: u64) -> String {
    let r = &mut Random::new(seed.wrapping_mul(0x2545_F491_4F6C_DD1D) + 17);
    let is_slab = r.chance(0.5);
    let y = match is_slab {
        true => "{ from = '0 m', to = '250 m', cells = 1 }",
        false => "{ from = '0 m', to = '3 km', size = '500 m', growth = 1.8 }",
    };
    let size = if is_slab {
        r.between(40.0, 120.0)
    } else {
        r.between(90.0, 200.0)
    };
    let mut toml = format!(
        "title = 'store {seed}'\n[mesh]\nx = {{ from = '-3 km', to = '3 km', size = '{} m', growth = 1.7 }}\ny = {y}\n\
         z = {{ size = '{} m', growth = 1.8 }}\n[geology]\nbottom = '-4500 m'\nlayers = [\n\
         {{ top = '0 m', material = 'overburden' }},\n{{ top = '-1500 m', material = 'salt' }},\n\
         {{ top = '-2000 m', material = 'reservoir' }},\n{{ top = '-2200 m', material = 'underburden' }},\n]\n",
        (1.5 * size).round(),
        size.round()
    );
    let (has_west, has_east) = (r.chance(0.6), r.chance(0.6));
    let has_north = !is_slab && r.chance(0.8);
    let north = if is_slab { "250 m" } else { "1500 m" };
    // blocks end at a fault or within the layer
    let west = if has_west { "-1000 m" } else { "-2 km" };
    let east = if has_east { "1000 m" } else { "2 km" };
    toml += &format!(
        "compartments = [\n{{ material = 'west', layer = 'reservoir', x = ['{west}', '0 m'], y = ['0 m', '{north}'] }},\n\
         {{ material = 'east', layer = 'reservoir', x = ['0 m', '{east}'], y = ['0 m', '{north}'] }},\n]\n"
    );
    let reservoir = r.scale(3.0, 40.0);
    let drawdown = [r.between(0.0, 250.0), r.between(0.0, 250.0)];
    let biot = r.between(0.5, 1.0);
    for (name, young) in [
        ("overburden", r.scale(3.0, 30.0)),
        ("salt", r.scale(20.0, 50.0)),
        ("reservoir", reservoir),
        ("underburden", r.scale(10.0, 60.0)),
        ("west", reservoir),
        (
            "east",
            reservoir
                * if r.chance(0.3) {
                    r.scale(0.3, 3.0)
                } else {
                    1.0
                },
        ),
    ] {
        toml += &format!(
            "[[material]]\nname = '{name}'\nyoung = '{young} GPa'\npoisson = {}\ndensity = '{} kg/m3'\n",
            r.between(0.1, 0.35),
            r.between(2000.0, 2700.0)
        );
        if name == "salt" && r.chance(0.6) {
            toml += &format!("viscosity = '{:e} Pa*s'\n", r.scale(1e16, 1e19));
            toml += &format!("isotropic_stress = {}\n", r.chance(0.7));
        }
        if let Some(block) = ["west", "east"].iter().position(|block| *block == name) {
            let low = 350.0 - drawdown[block];
            let full = 350.0 - 0.3 * drawdown[block];
            toml += &format!(
                "biot = {biot}\npore_pressure = {{ points = [['0 year', '350 bar'], ['{} year', '350 bar'], ['10 year', '{low} bar'], \
                 ['12 year', '{full} bar'], ['13 year', '{} bar'], ['14 year', '{full} bar']] }}\n",
                [0.5, 3.0][block],
                0.5 * (low + full)
            );
        }
    }
    let weakens = r.chance(0.45);
    let friction = |r: &mut Random| {
        let angle = r.between(8.0, 32.0);
        let mut text = format!("friction_angle = '{angle} deg'\n");
        if weakens && r.chance(0.8) {
            let lost = r.between(1.0, 8.0).min(angle);
            let over = r.scale(1.0, 400.0);
            text += &format!(
                "dynamic_friction_angle = '{} deg'\nweakening_distance = '{over} mm'\n",
                angle - lost
            );
        }
        if r.chance(0.2) {
            text += &format!("cohesion = '{} MPa'\n", r.between(0.0, 2.0));
        }
        text
    };
    let leans = r.chance(0.6);
    for (name, at, there) in [
        ("central", 0, true),
        ("western", -1000, has_west),
        ("eastern", 1000, has_east),
    ] {
        if !there {
            continue;
        }
        toml += &format!("[[fracture]]\nname = '{name}'\nplane = 'x'\nat = '{at} m'\n");
        if has_north {
            toml += "y = ['0 m', '1500 m']\n";
        }
        toml += match r.whole(0, 2) {
            0 => "cuts = ['reservoir']\n",
            1 => "z = ['-2500 m', '-1900 m']\n",
            _ => "z = ['-2700 m', '-1600 m']\n",
        };
        if name == "central" || r.chance(0.4) {
            let throw = r.between(0.0, 200.0).round();
            // less is lost between the lines of the grid, and refused
            if throw > 0.25 * size.round() {
                toml += &format!("throw = '{throw} m'\n");
            }
        }
        if leans && r.chance(0.8) {
            toml += &format!("dip = '{} deg'\n", r.between(65.0, 115.0));
        }
        toml += &friction(r);
    }
    if has_north {
        toml += &format!(
            "[[fracture]]\nname = 'northern'\nplane = 'y'\nat = '1500 m'\nx = ['{west}', '{east}']\nz = ['-2500 m', '-1900 m']\n{}",
            friction(r)
        );
    }
    if r.chance(0.2) {
        // a level one through the blocks, which the central one crosses
        let z = [-2400, -2350][usize::from(r.chance(0.5))];
        toml += &format!(
            "[[fracture]]\nname = 'level'\nplane = 'z'\nat = '{z} m'\nx = ['{west}', '{east}']\n{}{}",
            if has_north {
                "y = ['0 m', '1500 m']\n"
            } else {
                ""
            },
            friction(r)
        );
    }
    toml += &format!(
        "[gravity]\nz = '-9.81 m/s2'\n[initial_stress]\nweight = {{ horizontal = [{}, {}], fluid = '1000 kg/m3' }}\n\
         [time]\nend = '14 year'\nsteps = {}\n",
        r.between(0.4, 0.95),
        r.between(0.4, 0.95),
        [7, 14][usize::from(r.chance(0.5))]
    );
    if weakens && r.chance(0.4) {
        toml += "[solver]\nunstable = 'arrest'\n";
    }
    for side in ["x-", "x+", "y-", "y+", "z-"] {
        toml += &format!("[[boundary]]\nside = '{side}'\nhold = 'roller'\n");
    }
    toml
}

#[test]
fn stores_end_well() {
    let seeds = asked(RUNS);
    let runs = seeds.end - seeds.start;
    let tally = sweep(store, seeds);
    // one of a few may end otherwise, of many one in fifty
    ends_in_a_known_way(&tally, if runs < 50 { 4 } else { 50 });
}
