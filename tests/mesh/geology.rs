//! Claim: layers and faults become the grid that one would have written by hand: cells have the material of the layer list, faults lie in
//! their planes, the box stays whole, and what the grid cannot follow is refused in a sentence.
//!
//! `FRACAS_RUNS=2000 FRACAS_SEED=1000 cargo test --release --test mesh geology:: -- --nocapture` tries more geologies.

use fracas::mesh::{audit, min_jacobian};
use fracas::nonlinear::Simulation;
use fracas::scene::{Body, Scene, named};
use fracas_operators::random::Random;
use fracas_solvers::Silent;

/// Geologies where nobody asks for more.
const RUNS: u64 = 150;

pub(crate) const HELD: &str = "[[boundary]]\nside = 'z-'\nhold = 'fixed'\n[[boundary]]\nside = 'x-'\nhold = 'fixed'\n[[boundary]]\nside = 'x+'\nhold = 'fixed'\n\
    [[boundary]]\nside = 'y-'\nhold = 'fixed'\n[[boundary]]\nside = 'y+'\nhold = 'fixed'\n[[boundary]]\nside = 'z+'\nhold = 'fixed'\n";

/// A fault across x (0) or y (1).
#[derive(Debug)]
struct Fault {
    axis: usize,
    at: f64,
    z: [f64; 2],
    throw: f64,
    /// From the horizontal, and the level where the plane lies at its position.
    dip: Option<(f64, f64)>,
}

/// What a seed decides.
#[derive(Debug)]
struct Case {
    /// Tops and the base [m].
    levels: Vec<f64>,
    faults: Vec<Fault>,
    /// Number of its layer, intervals of x and y.
    compartment: Option<(usize, [[f64; 2]; 2])>,
}

const BOX: [[f64; 2]; 2] = [[-2000.0, 2000.0], [0.0, 3000.0]];

impl Case {
    fn new(seed: u64) -> Self {
        let r = &mut Random::new(seed.wrapping_mul(0x9E37_79B9) + 5);
        // multiples of 30 m in cells of 100 m: nothing is closer than a quarter of a cell
        let mut levels = vec![30.0 * f64::from(r.whole(0, 20))];
        for _ in 0..r.whole(1, 5) {
            let last = levels[levels.len() - 1];
            levels.push(last - 30.0 * f64::from(r.whole(1, 25)));
        }
        let (top, bottom) = (levels[0], levels[levels.len() - 1]);
        let height = ((top - bottom) / 30.0) as u32;
        let mut faults = Vec::new();
        for axis in [0, 1] {
            let mut at = BOX[axis][0];
            for _ in 0..r.whole(0, 3 - axis as u32) {
                at += 200.0 * f64::from(r.whole(2, 7));
                if at >= BOX[axis][1] || height < 2 {
                    break;
                }
                let whole = r.chance(0.3);
                let low = if whole { 0 } else { r.whole(0, height - 1) };
                let high = if whole {
                    height
                } else {
                    r.whole(low + 1, height)
                };
                let z = [low, high].map(|k| bottom + 30.0 * f64::from(k));
                let level = (z[0] + z[1]) / 2.0;
                faults.push(Fault {
                    axis,
                    at,
                    z,
                    throw: if r.chance(0.6) {
                        30.0 * (f64::from(r.whole(0, 8)) - 4.0)
                    } else {
                        0.0
                    },
                    dip: r.chance(0.5).then(|| (r.between(60.0, 120.0), level)),
                });
            }
        }
        let compartment = r.chance(0.5).then(|| {
            let layer = r.below(levels.len() - 1);
            let ends = BOX.map(|[from, to]| {
                let cells = ((to - from) / 200.0) as u32;
                let low = r.whole(1, cells - 1);
                let high = r.whole(low + 1, cells);
                [low, high].map(|k| from + 200.0 * f64::from(k))
            });
            (layer, ends)
        });
        Self {
            levels,
            faults,
            compartment,
        }
    }

    fn toml(&self) -> String {
        let last = self.levels.len() - 1;
        let mut text = "title = 'geology'\n[mesh]\nx = { from = '-2 km', to = '2 km', size = '200 m' }\n\
            y = { from = '0 m', to = '3 km', size = '200 m', growth = 1.5, largest = '500 m' }\nz = { size = '100 m', largest = '400 m' }\n"
            .to_string();
        text += &format!("[geology]\nbottom = '{} m'\nlayers = [", self.levels[last]);
        for (k, top) in self.levels[..last].iter().enumerate() {
            text += &format!("{{ top = '{top} m', material = 'layer {k}' }}, ");
        }
        text += "]\n";
        if let Some((layer, [x, y])) = &self.compartment {
            text += &format!(
                "compartments = [{{ material = 'part', layer = 'layer {layer}', x = ['{} m', '{} m'], y = ['{} m', '{} m'] }}]\n",
                x[0], x[1], y[0], y[1]
            );
        }
        // the order of materials says nothing
        if self.compartment.is_some() {
            text += "[[material]]\nname = 'part'\nyoung = '10 GPa'\npoisson = 0.2\n";
        }
        for k in 0..last {
            text += &format!("[[material]]\nname = 'layer {k}'\nyoung = '10 GPa'\npoisson = 0.2\n");
        }
        for (k, f) in self.faults.iter().enumerate() {
            let axis = ["x", "y"][f.axis];
            text += &format!(
                "[[fracture]]\nname = 'f{k}'\nplane = '{axis}'\nat = '{} m'\nz = ['{} m', '{} m']\nthrow = '{} m'\n",
                f.at, f.z[0], f.z[1], f.throw
            );
            if let Some((dip, level)) = f.dip {
                text += &format!("dip = '{dip} deg'\nlevel = '{level} m'\n");
            }
        }
        text + HELD
    }

    /// Tops and base at a point, from the list and the throws alone.
    fn levels_at(&self, point: [f64; 2]) -> Vec<f64> {
        let last = self.levels.len() - 1;
        let mut levels = self.levels.clone();
        for level in &mut levels[1..last] {
            let written = *level;
            for f in &self.faults {
                if f.z[0] <= written && written <= f.z[1] && point[f.axis] > f.at {
                    *level -= f.throw;
                }
            }
        }
        levels
    }

    /// Name of the material at a point, before any map.
    fn material(&self, [x, y, z]: [f64; 3]) -> String {
        let levels = self.levels_at([x, y]);
        let layer = levels[1..].iter().take_while(|base| **base > z).count();
        if let Some((of, ends)) = &self.compartment
            && *of == layer
            && (0..2).all(|d| ends[d][0] < [x, y][d] && [x, y][d] < ends[d][1])
        {
            return "part".into();
        }
        format!("layer {layer}")
    }

    /// A fault whose throw moves no top: those between the top and the bottom of the box.
    fn idle(&mut self) -> Option<&mut Fault> {
        let inner = &self.levels[1..self.levels.len() - 1];
        self.faults.iter_mut().find(|f| {
            let cuts = |top: &f64| (f.z[0]..=f.z[1]).contains(top);
            f.throw != 0.0 && !inner.iter().any(cuts)
        })
    }

    /// True where some block has a layer of no height.
    fn is_eaten(&self) -> bool {
        let points = |axis: usize| {
            let own = self.faults.iter().filter(move |f| f.axis == axis);
            own.map(|f| f.at + 1.0).chain([BOX[axis][0] + 1.0])
        };
        points(0).any(|x| {
            points(1).any(|y| {
                self.levels_at([x, y])
                    .windows(2)
                    .any(|pair| pair[0] <= pair[1])
            })
        })
    }

    fn judge(&self, body: &Body, seed: u64) {
        let grid = body.mesh.grid.as_ref().unwrap();
        let mut volume = 0.0;
        for (e, region) in body.mesh.regions.iter().enumerate() {
            let [nx, ny, _] = grid.cells;
            let index = [e % nx, e / nx % ny, e / (nx * ny)];
            let center: [f64; 3] = std::array::from_fn(|d| {
                0.5 * (grid.lines[d][index[d]] + grid.lines[d][index[d] + 1])
            });
            let name = &body.material_names[usize::from(*region)];
            assert_eq!(*name, self.material(center), "seed {seed}, {center:?}");
            let corners = body.mesh.elements[e].map(|a| body.mesh.nodes[a as usize]);
            assert!(min_jacobian(&corners) > 0.0, "seed {seed}, element {e}");
            volume += body.mesh.element_volume(e);
        }
        let height = self.levels[0] - self.levels[self.levels.len() - 1];
        let whole = 4000.0 * 3000.0 * height;
        assert!(
            (volume / whole - 1.0).abs() < 1e-10,
            "seed {seed}: {volume} {whole}"
        );
        // no fault has lost a face, and each lies in its plane
        let mut seen = vec![[f64::INFINITY, f64::NEG_INFINITY]; self.faults.len()];
        for face in &body.fractures.faces {
            let number = usize::from(face.fracture);
            let fault = &self.faults[number];
            for a in face.plus.nodes.iter().chain(&face.minus.nodes) {
                let x = body.mesh.nodes[*a as usize];
                let lean = |(dip, level): (f64, f64)| (x[2] - level) / dip.to_radians().tan();
                let plane = fault.at + fault.dip.map_or(0.0, lean);
                assert!(
                    (x[fault.axis] - plane).abs() < 1e-6,
                    "seed {seed}: {x:?}, {fault:?}"
                );
                seen[number] = [seen[number][0].min(x[2]), seen[number][1].max(x[2])];
            }
        }
        for (fault, seen) in self.faults.iter().zip(seen) {
            assert_eq!(fault.z, seen, "seed {seed}");
        }
    }
}

#[test]
fn random_geologies_are_those_of_their_lists() {
    let number = |name: &str, default: u64| {
        std::env::var(name).map_or(default, |value| value.parse().unwrap())
    };
    let (first, runs) = (number("FRACAS_SEED", 0), number("FRACAS_RUNS", RUNS));
    let (mut built, mut eaten, mut crossing, mut leaning, mut idle) = (0, 0, 0, 0, 0);
    for seed in first..first + runs {
        let mut case = Case::new(seed);
        let mut text = case.toml();
        while let Some(fault) = case.idle() {
            fault.throw = 0.0;
            idle += 1;
            let error = Scene::from_toml(&text, "g.toml").unwrap_err().to_string();
            assert!(error.contains("moves no top"), "seed {seed}: {error}");
            text = case.toml();
        }
        match Scene::from_toml(&text, "g.toml").and_then(|scene| scene.build()) {
            Ok(body) => {
                assert!(!case.is_eaten(), "seed {seed}");
                case.judge(&body, seed);
                built += 1;
                leaning += usize::from(case.faults.iter().any(|f| f.dip.is_some()));
            }
            Err(error) => {
                let error = error.to_string();
                let crosses = error.contains("the grid is sheared between them");
                match error.contains("the throws of faults leave nothing of it") {
                    true => assert!(case.is_eaten(), "seed {seed}: {error}"),
                    false => assert!(crosses, "seed {seed}: {error}\n{text}"),
                }
                eaten += u64::from(!crosses);
                crossing += u64::from(crosses);
            }
        }
    }
    println!(
        "{built} built, {leaning} of them with dips, {eaten} with a layer eaten, {crossing} with faults that cross; {idle} throws moved no top"
    );
    assert!(4 * built >= runs && 10 * leaning as u64 >= runs);
    assert!(eaten > 0 && idle > 0);
}

/// The scene `storage` in layers and faults.
fn storage() -> String {
    let written = named("storage").unwrap().toml;
    let layers = "[geology]\nbottom = '-5000 m'\nlayers = [\n  { top = '0 m', material = 'overburden' },\n  { top = '-1500 m', material = 'salt' },\n  \
        { top = '-2000 m', material = 'reservoir' },\n  { top = '-2200 m', material = 'underburden' },\n]\ncompartments = [\n  \
        { material = 'west', layer = 'reservoir', between = ['western', 'central'], y = ['0 m', '1500 m'] },\n  \
        { material = 'east', layer = 'reservoir', between = ['central', 'eastern'], y = ['0 m', '1500 m'] },\n]\n\n[[material]]";
    let mut text = String::new();
    let mut skips = false;
    for line in written.lines() {
        // boxes, layers and places of fine cells are what a geology says
        if line.starts_with("boxes = [") || line.starts_with("layers = [") {
            skips = !line.ends_with(']');
            continue;
        }
        if skips {
            skips = line != "]";
            continue;
        }
        let line = line.replace(", near = [\"-1000 m\", \"0 m\", \"1000 m\"]", "");
        text += &line.replace(", near = \"1500 m\"", "");
        text += "\n";
    }
    let text = text.replacen("[[material]]", layers, 1);
    text.replacen(
        "name = \"central\"",
        "name = \"central\"\nthrow = '100 m'",
        1,
    )
}

#[test]
fn the_gas_store_by_layers_is_the_same_body() {
    let text = storage();
    for word in ["boxes", "near"] {
        assert!(!text.contains(word), "{word} in\n{text}");
    }
    let by_layers = Scene::from_toml(&text, "storage.toml").unwrap();
    let by_hand = named("storage").unwrap().scene().unwrap();
    let (a, b) = (by_layers.build().unwrap(), by_hand.build().unwrap());
    assert_eq!(a.mesh, b.mesh);
    assert_eq!(a.fractures, b.fractures);
    assert_eq!(a.material_names, b.material_names);
    assert_eq!(a.weight_stress, b.weight_stress);
    assert_eq!(by_layers.geology().unwrap().moved, []);
    // lines in z that follow from the layers: those of before within the faults, and one more, on the top of the salt
    let z = "mesh.z={ size = \"50 m\", growth = 1.35 }";
    let follows = by_layers.with_overrides(&[z]).unwrap().build().unwrap();
    let lines = |body: &Body| body.mesh.grid.as_ref().unwrap().lines[2].clone();
    let inside = |z: &f64| (-2500.0..=-1900.0).contains(z);
    let pick = |body: &Body| lines(body).into_iter().filter(inside).collect::<Vec<f64>>();
    assert_eq!(pick(&follows), pick(&b));
    assert!(lines(&follows).contains(&-1500.0) && !lines(&b).contains(&-1500.0));
    // what it has become reads back as the same scene
    let again = Scene::from_toml(&by_layers.to_toml().unwrap(), "again.toml").unwrap();
    assert_eq!(again.sections(), by_layers.sections());
    assert!(again.geology().is_none());
}

/// One plane that leans from the bottom to the top is a shear that fades, to the last bit.
#[test]
fn one_plane_is_an_incline_that_fades() {
    let scene = |map: &str| {
        let text = format!(
            "title = 'one'\n[mesh]\nx = {{ from = '0 m', to = '8 m', cells = 8 }}\ny = {{ from = '0 m', to = '2 m', cells = 2 }}\n\
             z = {{ from = '0 m', to = '4 m', cells = 4 }}\nmap = {map}\n[[material]]\nname = 'rock'\nyoung = '1 GPa'\npoisson = 0.2\n{HELD}"
        );
        Scene::from_toml(&text, "one.toml")
            .unwrap()
            .build()
            .unwrap()
            .mesh
    };
    let fading = scene(
        "{ incline = { plane = 'x', dip = '70 deg', pivot = ['3 m', '0 m', '1 m'], fade = true } }",
    );
    let sheared = scene(
        "{ shear = [{ plane = 'x', at = '3 m', level = '1 m', dip = '70 deg', z = ['0 m', '4 m'] }] }",
    );
    assert_eq!(fading, sheared);
}

const SMALL: &str = r#"title = "two blocks"
[mesh]
x = { from = "-2 km", to = "2 km", size = "200 m" }
y = { from = "0 m", to = "200 m", cells = 1 }
z = { size = "100 m" }

[geology]
bottom = "-2 km"
layers = [
  { top = "0 m", material = "sand" },
  { top = "-500 m", material = "clay" },
  { top = "-800 m", material = "rock" },
]
compartments = [{ material = "gas", layer = "clay", between = ["west", "east"] }]

[[material]]
name = "sand"
young = "1 GPa"
poisson = 0.2

[[material]]
name = "clay"
young = "1 GPa"
poisson = 0.2

[[material]]
name = "rock"
young = "1 GPa"
poisson = 0.2

[[material]]
name = "gas"
young = "1 GPa"
poisson = 0.2

[[fracture]]
name = "west"
plane = "x"
at = "-500 m"
z = ["-1000 m", "-300 m"]
dip = "70 deg"
throw = "100 m"

[[fracture]]
name = "east"
plane = "x"
at = "600 m"
cuts = ["clay"]
throw = "-50 m"
"#;

fn small(from: &str, to: &str) -> Result<(Scene, Body), String> {
    assert!(SMALL.contains(from), "{from}");
    let text = SMALL.replacen(from, to, 1) + HELD;
    let scene = Scene::from_toml(&text, "s.toml").map_err(|e| e.to_string())?;
    let body = scene.build().map_err(|e| e.to_string())?;
    Ok((scene, body))
}

#[test]
fn what_the_grid_cannot_follow_is_refused_with_its_line() {
    small("", "").unwrap();
    let mut wrong = Vec::new();
    for (from, to, start) in [
        (
            "top = \"-800 m\"",
            "top = \"-400 m\"",
            "s.toml:12:11: the top of \"rock\" at -400 m does not lie below the top of \"clay\" at -500 m; list layers from the top down\n",
        ),
        (
            "bottom = \"-2 km\"",
            "bottom = \"-700 m\"",
            "s.toml:8:10: `bottom` at -700 m does not lie below the top of the last layer at -800 m\n",
        ),
        (
            "material = \"clay\"",
            "material = \"klay\"",
            "s.toml:11:32: no material is named \"klay\", did you mean \"clay\"?; there are: sand, clay, rock, gas\n",
        ),
        (
            "layer = \"clay\"",
            "layer = \"gas\"",
            "s.toml:14:45: no layer is named \"gas\"",
        ),
        (
            "\"west\", \"east\"",
            "\"west\", \"easy\"",
            "s.toml:14:63: no fault is named \"easy\", did you mean \"east\"?; there are: west, east\n",
        ),
        (
            "\"west\", \"east\"",
            "\"west\", \"west\"",
            "s.toml:14:63: `between` needs two fractures across one axis",
        ),
        (
            "between = [\"west\", \"east\"]",
            "between = [\"west\", \"east\"], x = [\"0 m\", \"1 m\"]",
            "s.toml:14:63: the compartment of \"gas\" needs exactly one of `between`, `x`; it has 2\n",
        ),
        (
            "throw = \"100 m\"",
            "throw = \"-600 m\"",
            "s.toml:10:3: around x = 50 m, y = 100 m the top of \"sand\" lies at 0 m and its base at 100 m: the throws of faults leave nothing of it;",
        ),
        (
            "dip = \"70 deg\"",
            "dip = \"20 deg\"",
            "s.toml:41:7: fracture \"west\" dips by 20.0000 deg; the grid follows dips of 30 to 150 deg (90 is upright)\n",
        ),
        (
            "dip = \"70 deg\"",
            "dip = \"32 deg\"\nlevel = \"400 m\"",
            "s.toml:41:7: the side of the box at x = -2000 m and fracture \"west\", 1500 m apart",
        ),
        (
            "z = [\"-1000 m\", \"-300 m\"]",
            "z = [\"-300 m\", \"-1000 m\"]",
            "s.toml:40:5: fracture \"west\" has no height: its depth range from -300 m to -1000 m is empty; write the lower end first\n",
        ),
        (
            "z = [\"-1000 m\", \"-300 m\"]",
            "z = [\"-510 m\", \"-490 m\"]",
            "s.toml:40:5: fracture \"west\" from -510 m to -490 m is thinner than a quarter of the cells",
        ),
        (
            "z = [\"-1000 m\", \"-300 m\"]",
            "z = [\"-1000 m\", \"300 m\"]",
            "s.toml:40:5: fracture \"west\" leaves the box: z = 300 m is outside [-2000 m, 0 m]\n",
        ),
        (
            "at = \"-500 m\"",
            "at = \"-2500 m\"",
            "s.toml:39:6: fracture \"west\" leaves the box: x = -2500 m is outside [-2000 m, 2000 m]\n",
        ),
        (
            "at = \"-500 m\"",
            "at = \"-2000 m\"",
            "s.toml:39:6: fracture \"west\" lies on the boundary x = -2000 m",
        ),
        (
            "at = \"-500 m\"",
            "at = \"600 m\"",
            "s.toml:14:63: `between` needs",
        ),
        (
            "at = \"-500 m\"",
            "every = 2",
            "s.toml:41:7: fracture \"west\" has `dip`, which is for fractures across x or y with `at`; leave it out\n",
        ),
        (
            "cuts = [\"clay\"]",
            "cuts = []",
            "s.toml:48:8: `cuts` of fracture \"east\" is an empty list; name the layers that it cuts, e.g. cuts = [\"clay\"], or leave `cuts` out",
        ),
        (
            "cuts = [\"clay\"]",
            "cuts = [\"gas\"]",
            "s.toml:48:8: no layer is named \"gas\"",
        ),
        (
            "cuts = [\"clay\"]",
            "cuts = [\"clay\"]\nz = [\"-1 km\", \"0 m\"]",
            "s.toml:48:8: fracture \"east\" needs exactly one of `z`, `cuts`; it has 2\n",
        ),
        (
            "cuts = [\"clay\"]",
            "cuts = [\"clay\"]\nlevel = \"-1 km\"",
            "s.toml:49:9: `level` of fracture \"east\" has no effect without `dip`; give both or neither\n",
        ),
        (
            "z = { size = \"100 m\" }",
            "z = { to = \"10 m\", size = \"100 m\" }",
            "s.toml:5:12: [mesh.z] has `to` at 10 m and [geology] at 0 m; leave it out",
        ),
        (
            "z = { size = \"100 m\" }",
            "z = {}",
            "s.toml:5:1: [mesh.z] needs",
        ),
        (
            "x = { from = \"-2 km\", ",
            "x = { ",
            "s.toml:3:1: [mesh.x] needs",
        ),
        (
            "compartments = [{ material = \"gas\", layer = \"clay\", between = [\"west\", \"east\"] }]",
            "",
            "s.toml:31:1: material \"gas\" fills no layer and no compartment of [geology] and has no `boxes`;",
        ),
    ] {
        let error = small(from, to).err().unwrap_or_default();
        if !error.starts_with(start) {
            wrong.push(format!("{to}: {error}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    // the ends of the range that the sentence names
    for dip in ["30 deg", "150 deg", "29.9999 deg"] {
        let dip_of = format!("dip = \"{dip}\"\nlevel = \"-600 m\"");
        let error = small("dip = \"70 deg\"", &dip_of).err();
        assert_eq!(error.is_some(), dip == "29.9999 deg", "{dip}: {error:?}");
    }
    let text = SMALL.replacen("[geology]", "[geologi]", 1) + HELD;
    let error = Scene::from_toml(&text, "s.toml").unwrap_err().to_string();
    assert!(
        error.contains("unknown key `geologi`, did you mean `geology`?"),
        "{error}"
    );
    // keys of faults where there are no layers
    let text = "title = 'a'\n[mesh]\nx = { from = '0 m', to = '2 m', cells = 2 }\ny = { from = '0 m', to = '2 m', cells = 2 }\n\
        z = { from = '0 m', to = '2 m', cells = 2 }\n[[material]]\nname = 'rock'\nyoung = '1 GPa'\npoisson = 0.2\n\
        [[fracture]]\nname = 'F'\nplane = 'x'\nat = '1 m'\nthrow = '1 m'\n";
    let scene = Scene::from_toml(&(text.to_owned() + HELD), "s.toml").unwrap();
    let error = scene.build().unwrap_err().to_string();
    assert!(
        error.contains("`throw` of fracture \"F\" has no effect without `[geology]`"),
        "{error}"
    );
}

/// A fault that is written by the layers that it cuts reaches from the highest to the lowest of them on both sides, whatever other faults do.
#[test]
fn layers_say_how_far_a_fault_reaches() {
    let (scene, _) = small("", "").unwrap();
    let z = scene.sections().fracture[1].z.as_ref().unwrap();
    // clay from -500 to -800 m, 100 m lower before the fault and 50 m lower behind it
    assert_eq!([z[0].si(), z[1].si()], [-900.0, -550.0]);
}

/// Two faults across x and y with throws [m], listed as they come or the other way round, with x and y as they are or exchanged.
fn two_throws(throws: [f64; 2], turned: bool, exchanged: bool, z: &str) -> Result<Scene, String> {
    let fault = |k: usize| {
        let axis = ["x", "y"][k ^ usize::from(exchanged)];
        format!(
            "[[fracture]]\nname = '{}'\nplane = '{axis}'\nat = '{} m'\nthrow = '{} m'\n",
            ["A", "B"][k],
            [-300.0, 200.0][k],
            throws[k]
        )
    };
    let faults = match turned {
        false => fault(0) + &fault(1),
        true => fault(1) + &fault(0),
    };
    let text = format!(
        "title = 'two'\n[mesh]\nx = {{ from = '-2 km', to = '2 km', size = '100 m' }}\ny = {{ from = '-2 km', to = '2 km', size = '100 m' }}\n\
         z = {{ {z} }}\n[geology]\nbottom = '-2 km'\nlayers = [{{ top = '0 m', material = 'sand' }}, {{ top = '-500 m', material = 'clay' }}, \
         {{ top = '-1200 m', material = 'rock' }}]\n\
         [[material]]\nname = 'sand'\nyoung = '1 GPa'\npoisson = 0.2\n[[material]]\nname = 'clay'\nyoung = '1 GPa'\npoisson = 0.2\n\
         [[material]]\nname = 'rock'\nyoung = '1 GPa'\npoisson = 0.2\n{faults}{HELD}"
    );
    Scene::from_toml(&text, "s.toml").map_err(|error| error.to_string())
}

/// Where lines are close, neither the order of lists nor the names of axes decide which of them stays.
#[test]
fn lines_that_become_one_do_not_depend_on_lists_and_axes() {
    let r = &mut Random::new(77);
    let mut merged = 0;
    for _ in 0..60 {
        // in cells of 100 m lines within 25 m are one
        let throws = [0, 1].map(|_| f64::from(r.whole(26, 70)));
        let levels = |turned, exchanged| {
            let scene = two_throws(throws, turned, exchanged, "size = '100 m'").unwrap();
            let geology = scene.geology().unwrap();
            let mut all: Vec<([[f64; 2]; 3], usize)> = (geology.pieces.iter())
                .map(|piece| {
                    let [x, y, z] = piece.ends;
                    (
                        if exchanged { [y, x, z] } else { [x, y, z] },
                        piece.material,
                    )
                })
                .collect();
            all.sort_by(|a, b| a.partial_cmp(b).unwrap());
            (all, geology.moved.len())
        };
        let first = levels(false, false);
        merged += usize::from(first.1 > 0);
        for (turned, exchanged) in [(true, false), (false, true), (true, true)] {
            assert_eq!(first, levels(turned, exchanged), "{throws:?}");
        }
    }
    assert!(merged > 10, "{merged}");
}

/// A throw of which the grid takes nothing is refused, with the cells that would take it.
#[test]
fn a_throw_that_no_cell_takes_is_refused() {
    for (throw, z, size) in [
        (20.0, "size = '100 m'", 40.0),
        (-20.0, "size = '100 m'", 40.0),
        (20.0, "from = '-2 km', to = '0 m', cells = 20", 20.0),
    ] {
        let error = two_throws([throw, 60.0], false, false, z).unwrap_err();
        let sentence = format!(
            "the throw of {throw} m of fracture \"A\" is lost: the tops that it offsets lie on the same grid lines on both of its sides; take cells of less than {size} m in [mesh.z]"
        );
        assert!(
            error.starts_with("s.toml:") && error.contains(&sentence),
            "{error}"
        );
        let finer = match z.contains("cells") {
            true => "from = '-2 km', to = '0 m', cells = 101".to_owned(),
            false => format!("size = '{} m'", size - 1.0),
        };
        assert!(
            two_throws([throw, 60.0], false, false, &finer).is_ok(),
            "{finer}"
        );
    }
}

/// Lines closer than a quarter of a cell become one, and that is said.
#[test]
fn what_moves_to_a_line_is_said() {
    let (scene, body) = small(
        "z = [\"-1000 m\", \"-300 m\"]",
        "z = [\"-1000 m\", \"-480 m\"]",
    )
    .unwrap();
    let text = scene.geology().unwrap().to_string();
    let line = "an end of fracture \"west\" lies on the grid line z = -500 m, and not at -480 m\n";
    assert!(text.contains(line), "{text}");
    let audit = audit(&body.mesh, &body.fractures, &body.prescribed());
    assert!(audit.min_jacobian > 0.0);
    let (scene, _) = small("", "").unwrap();
    assert_eq!(scene.geology().unwrap().moved, []);
}

/// The scene on the page about gas stores is short, and is what the page says; it runs.
#[test]
fn the_store_of_the_page_is_short_and_runs() {
    let page = include_str!("../../docs/gas_storage.md");
    let toml = page
        .split("```toml\n")
        .nth(1)
        .and_then(|rest| rest.split("```").next())
        .unwrap();
    assert!(toml.lines().count() <= 60, "{}", toml.lines().count());
    let scene = Scene::from_toml(toml, "store.toml").unwrap();
    let scene = scene
        .with_overrides(&["mesh.x.size=150 m", "mesh.z.size=75 m"])
        .unwrap();
    let body = scene.build().unwrap();
    assert_eq!(body.fractures.names, ["central", "western"]);
    let mut slipped = 0.0f64;
    let mut simulation = Simulation::new(&body).unwrap();
    let end = simulation.run(&mut Silent, |_, _, done| {
        let slip = done.state.slip.iter().map(|v| v.abs());
        slipped = slip.fold(slipped, f64::max);
    });
    assert!(end.is_ok());
    assert!(slipped > 1e-3, "{slipped}");
}
