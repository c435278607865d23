//! Claim: pressures from tables and files settle a column by α Δp/M_c, and what a table cannot say is refused with its row.

use fracas::nonlinear::Simulation;
use fracas::scene::Scene;
use fracas_operators::random::Random;
use fracas_solvers::Silent;

/// Moduli and Biot's coefficients of the two layers, 4 m above 6 m.
const LAYERS: [(&str, f64, f64, f64); 2] = [("clay", 2e8, 0.35, 0.9), ("sand", 1e9, 0.2, 0.7)];

fn column(clay: &str, sand: &str) -> String {
    let mut toml = String::from(
        "title = 'Column'\n[mesh]\nx = { from = '0 m', to = '1 m', cells = 1 }\ny = { from = '0 m', to = '2 m', cells = 1 }\n\
         z = { from = '0 m', to = '10 m', cells = 5 }\n[time]\nend = '10 day'\nsteps = 5\n[solver]\ntolerance = 1e-13\n",
    );
    for ((name, young, poisson, biot), (table, layers)) in LAYERS
        .iter()
        .zip([(clay, "['6 m', '10 m']"), (sand, "['0 m', '6 m']")])
    {
        toml += &format!(
            "[[material]]\nname = '{name}'\nyoung = '{young} Pa'\npoisson = {poisson}\nbiot = {biot}\nlayers = [{layers}]\npore_pressure = {table}\n"
        );
    }
    for side in ["x-", "x+", "y-", "y+", "z-"] {
        toml += &format!("[[boundary]]\nside = '{side}'\nhold = 'roller'\n");
    }
    toml
}

/// Constrained modulus.
pub(crate) fn modulus(young: f64, poisson: f64) -> f64 {
    young * (1.0 - poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
}

const CSV: &str = "time [day],clay [bar],sand [bar]\n0,2.5,3\n\n2.5,1.5,2\n6,1,0.5\n20,1,0.5\n";

/// A folder that goes away.
pub(crate) struct Folder(std::path::PathBuf);

impl Folder {
    pub(crate) fn empty(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("fracas-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    pub(crate) fn write(&self, file: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.0.join(file), bytes).unwrap();
    }

    /// A scene in the folder, read and not built.
    pub(crate) fn read(&self, toml: &str) -> Result<Scene, String> {
        let name = self.0.join("scene.toml").display().to_string();
        Scene::from_toml(toml, &name).map_err(|e| e.to_string())
    }

    fn new(name: &str, csv: &str) -> Self {
        let folder = Self::empty(name);
        folder.write("blocks.csv", csv);
        folder
    }

    fn scene(&self, clay: &str, sand: &str) -> Result<Scene, String> {
        self.read(&column(clay, sand))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn a_column_settles_by_the_pressures_of_its_layers() {
    let folder = Folder::new("column", CSV);
    let scene = folder
        .scene(
            "{ file = 'blocks.csv' }",
            "{ file = 'blocks.csv', column = 'sand', between = 'steps' }",
        )
        .unwrap();
    // the scene as it is written down needs no file
    let written = scene.to_toml().unwrap();
    assert!(!written.contains("blocks.csv"), "{written}");
    let again = Scene::from_toml(&written, "elsewhere.toml").unwrap();
    assert_eq!(again.sections(), scene.sections());
    let body = again.build().unwrap();
    let mut simulation = Simulation::new(&body).unwrap();
    let mut state = simulation.initial_state();
    let mut times = Vec::new();
    while state.step == 0 || !simulation.is_finished(&state) {
        state = simulation.advance(&state, &mut Silent).unwrap().state;
        let day = state.time / 86400.0;
        times.push(day);
        // linear between 2.5, 1.5 and 1 bar; 3, 2 and 0.5 bar from their days on
        let clay = match day {
            d if d <= 2.5 => -d / 2.5,
            d if d <= 6.0 => -1.0 - 0.5 * (d - 2.5) / 3.5,
            _ => -1.5,
        };
        let sand = match day {
            d if d < 2.5 - 1e-9 => 0.0,
            d if d < 6.0 - 1e-9 => -1.0,
            _ => -2.5,
        };
        let settled = |layer: usize, bar: f64| {
            let (_, young, poisson, biot) = LAYERS[layer];
            biot * bar * 1e5 / modulus(young, poisson)
        };
        let top = 4.0 * settled(0, clay) + 6.0 * settled(1, sand);
        let u = simulation.displacement(&state);
        let nodes = body.mesh.nodes.iter().zip(u.chunks_exact(3));
        for (_, u) in nodes.filter(|(x, _)| x[2] == 10.0) {
            assert!(
                (u[2] - top).abs() <= 1e-9 * 1e-3,
                "day {day}: {} {top}",
                u[2]
            );
        }
    }
    // steps land where tables bend or jump
    let expected = [0.0, 2.0, 2.5, 4.0, 6.0, 8.0, 10.0];
    assert_eq!(times.len(), expected.len(), "{times:?}");
    for (a, b) in times.iter().zip(expected) {
        assert!((a - b).abs() < 1e-9, "{times:?}");
    }
}

/// A random table: points, and how a program might write them.
fn written(r: &mut Random) -> (Vec<[f64; 2]>, Vec<String>, String) {
    let mut time = 0.0;
    let points: Vec<[f64; 2]> = (0..2 + r.below(8))
        .map(|_| {
            time += r.between(0.1, 3.0);
            [time, r.between(0.0, 300.0)]
        })
        .collect();
    let is_quoted = r.chance(0.5);
    let cell = |text: String| match is_quoted {
        true => format!("\"{text}\""),
        false => format!(" {text} "),
    };
    let place = r.below(3);
    let row = |own: String, other: &str| {
        let mut cells = vec![cell(other.to_owned()); 2];
        cells.insert(place, cell(own));
        cells.join(",")
    };
    let heads = row("clay [bar]".into(), "other [bar]");
    let mut lines = vec![format!("{},{heads}", cell("time [day]".into()))];
    for [t, p] in &points {
        lines.push(format!(
            "{},{}",
            cell(t.to_string()),
            row(p.to_string(), "1")
        ));
    }
    let end = r.one_of(&["\n", "\r\n", "\n\n"]);
    let mark = if r.chance(0.5) { "\u{feff}" } else { "" };
    (points, lines, format!("{mark}|{end}"))
}

#[test]
fn tables_are_read_however_they_are_written() {
    for seed in 0..60 {
        let r = &mut Random::new(seed);
        let (points, mut lines, style) = written(r);
        let (mark, end) = style.split_once('|').unwrap();
        let file = |lines: &[String]| format!("{mark}{}{end}", lines.join(end));
        let own = "{ points = [['0 s', '1 bar']] }";
        let folder = Folder::new(&format!("styles-{seed}"), &file(&lines));
        let scene = folder.scene("{ file = 'blocks.csv' }", own);
        let list: Vec<String> = (points.iter())
            .map(|[t, p]| format!("['{t} day', '{p} bar']"))
            .collect();
        let list = format!("{{ points = [{}] }}", list.join(", "));
        let expected = folder.scene(&list, own).unwrap();
        assert_eq!(scene.unwrap().sections(), expected.sections(), "{seed}");
        // one cell too many somewhere
        let k = 1 + r.below(points.len());
        lines[k] += ",5";
        let row = 1 + k * end.matches('\n').count();
        let folder = Folder::new(&format!("surplus-{seed}"), &file(&lines));
        let text = folder.scene("{ file = 'blocks.csv' }", own).unwrap_err();
        let expected =
            format!("blocks.csv, row {row} has 5 cells and the heading 4: cell 5 is `5`");
        assert!(text.contains(&expected), "{seed}: {text}");
    }
}

#[test]
fn tables_are_refused_with_their_row() {
    let own = "{ points = [['0 s', '1 bar']] }";
    let file = "{ file = 'blocks.csv' }";
    for (csv, expected) in [
        (
            "time [day],clay [bar]\n0,1\n2,\n",
            "blocks.csv, row 3: column `clay` is ``, which is no number",
        ),
        (
            "time [day],clay [bar]\n0,1\n2\n",
            "blocks.csv, row 3: column `clay` is ``",
        ),
        (
            "time [day],clay [bar]\n0,1\n2,n/a\n",
            "row 3: column `clay` is `n/a`",
        ),
        (
            "time [day],clay [bar]\n0,1\n2,-1\n",
            "blocks.csv, row 3, column `clay`: a pore pressure is \"-1 bar\", but it must be zero or positive",
        ),
        (
            "time [day],clay [bar]\n0,1\n2,nan\n",
            "row 3: column `clay` is `nan`",
        ),
        (
            "time,clay [bar]\n0,1\n",
            "blocks.csv, row 1: the heading must be",
        ),
        ("time [day],clay [kg]\n0,1\n", "row 1: the heading must be"),
        (
            "time [day],mud [bar]\n0,1\n",
            "blocks.csv has no column `clay`; it has: mud",
        ),
        ("", "blocks.csv has no row"),
        (
            "time [day],clay [bar]\n0,1\n\n-2,1\n",
            "blocks.csv, row 4, column `time`: ",
        ),
        (
            "time [day],clay [bar]\n0,1\n\n3,1\n2,1\n",
            "blocks.csv, row 5: time 172800 s does not come after 259200 s",
        ),
        (
            "time [day],clay [bar],clay [bar]\n0,1,2\n",
            "blocks.csv, row 1: columns 2 and 3 are both named `clay`",
        ),
        (
            "time [day],clay [bar]\n0,1\n2,1,5\n",
            "blocks.csv, row 3 has 3 cells and the heading 2: cell 3 is `5`",
        ),
        (
            "time [day],clay [bar]\n0,\"1,5\"\n",
            "blocks.csv, row 2: column `clay` is `1,5`, which is no number",
        ),
    ] {
        let folder = Folder::new("bad-table", csv);
        let text = folder.scene(file, own).unwrap_err();
        assert!(
            text.contains(expected) && text.contains("scene.toml:"),
            "{csv}: {text}"
        );
    }
    let folder = Folder::new("bad-points", CSV);
    let built = |clay: &str| match folder.scene(clay, own).map(|scene| scene.build()) {
        Ok(Ok(_)) => panic!("accepted {clay}"),
        Ok(Err(error)) => error.to_string(),
        Err(text) => text,
    };
    for (clay, expected) in [
        (
            "{ points = [['1 day', '1 bar'], ['0 day', '2 bar']] }",
            "`pore_pressure` of material \"clay\", row 2: time 0 s does not come after 86400 s",
        ),
        (
            "{ points = [['0 day', '-1 bar']] }",
            "a pore pressure is \"-1 bar\", but it must be zero or positive",
        ),
        ("{ points = [] }", "has no row"),
        (
            "{ }",
            "needs exactly one of `points`, `file`, `fields`, `grid`, `drawdown`; it has 0",
        ),
        ("{ file = 'none.csv' }", "cannot read none.csv"),
        (
            "{ points = [['0 s', '1 bar']] }\npressure_change = '1 bar'",
            "both say how its pressure changes",
        ),
        (
            "{ points = [['0 s', '1 bar']] }\nviscosity = '0 Pa*s'",
            "must be positive",
        ),
        (
            "{ points = [['0 s', '1 bar']] }\nviscosity = '-1 Pa*s'",
            "must be positive",
        ),
        (
            "{ points = [['0 s', '1 bar']] }\nviscosity = '1 Pa*s'",
            "that is a fluid",
        ),
    ] {
        let text = built(clay);
        assert!(
            text.contains(expected) && text.contains("scene.toml:"),
            "{clay}: {text}"
        );
    }
    let toml = column(own, own).replace("biot = 0.9", "biot = 1.1");
    let text = Scene::from_toml(&toml, "s.toml").unwrap_err().to_string();
    assert!(text.contains("Biot's coefficient is \"1.1\""), "{text}");
    let toml = column(own, "{ points = [['0 s', '1 bar'], ['1 s', '2 bar']] }");
    let toml = toml.replace("[time]\nend = '10 day'\nsteps = 5\n", "");
    let text = Scene::from_toml(&toml, "s.toml")
        .unwrap()
        .build()
        .unwrap_err()
        .to_string();
    assert!(text.contains("without [time]"), "{text}");
    let toml = toml.replace("['1 s', '2 bar']", "['1 s', '1 bar']") + "";
    let toml = toml.replacen("biot = 0.9", "biot = 0.9\nviscosity = '1e17 Pa*s'", 1);
    let text = Scene::from_toml(&toml, "s.toml")
        .unwrap()
        .build()
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("`viscosity` of material \"clay\" has no effect without `[time]`"),
        "{text}"
    );
}

#[test]
fn a_jump_at_a_time_of_the_table_belongs_to_its_step_whatever_rounding_says() {
    for steps in [3, 7, 11, 13] {
        // k/10 year and end · k/steps differ in the last digit for some k
        let jumps: Vec<String> = (0..=steps)
            .map(|k| format!("['{} year', '{k} bar']", f64::from(k) / 10.0))
            .collect();
        let table = format!("{{ between = 'steps', points = [{}] }}", jumps.join(", "));
        let end = format!("end = '{} year'\nsteps = {steps}", f64::from(steps) / 10.0);
        let toml = column(&table, "{ points = [['0 s', '1 bar']] }");
        let toml = toml.replace("end = '10 day'\nsteps = 5", &end);
        let body = Scene::from_toml(&toml, "s.toml").unwrap().build().unwrap();
        let mut simulation = Simulation::new(&body).unwrap();
        let mut state = simulation.initial_state();
        for k in 0..=steps {
            state = simulation.advance(&state, &mut Silent).unwrap().state;
            let (_, young, poisson, biot) = LAYERS[0];
            let top = 4.0 * biot * f64::from(k) * 1e5 / modulus(young, poisson);
            let u = simulation.displacement(&state);
            let nodes = body.mesh.nodes.iter().zip(u.chunks_exact(3));
            for (_, u) in nodes.filter(|(x, _)| x[2] == 10.0) {
                assert!(
                    (u[2] - top).abs() <= 1e-12,
                    "step {k} of {steps}: {} {top}",
                    u[2]
                );
            }
        }
        assert!(simulation.is_finished(&state));
    }
}
