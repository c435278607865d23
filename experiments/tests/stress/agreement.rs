//! `check` and `run` agree about what is refused before a step.

use crate::mutation::mutate;
use crate::random::fracas;
use crate::room::{Verdict, count, scratch, trial};
use crate::scenes;
use fracas_operators::random::Random;

/// Sections that some scenes cannot be run with.
const SOLVERS: &[&str] = &[
    "[solver]\ninner = \"geometric\"\n",
    "[solver]\nmethod = { penalty = { factor = 1e3 } }\n",
    "[solver]\nracp = { augmentation = \"exact\", inner = \"geometric\" }\n",
    "[solver]\nracp = { augmentation = \"local_h\", inner = \"amg\" }\n",
    "[solver]\nrounds = { rounds = 0 }\n",
    "[fluid]\nviscosity = \"1 mPa s\"\n",
    "[fluid]\nviscosity = \"1 mPa s\"\n[solver]\nmethod = { penalty = { factor = 1e3 } }\n",
    "[solver]\ntolerance = 2.0\n",
    "[solver]\nstabilization = \"box\"\njunctions = \"apart\"\n",
];

/// A scene that is wrong in one of many ways, or right.
fn scene(g: &mut Random) -> String {
    let mut text = scenes::random(g);
    if g.once_in(3) {
        // fractures without friction, all or one of them
        let line = "friction_angle";
        text = match g.once_in(2) {
            true => text.replace(line, "# friction_angle"),
            false => text.replacen(line, "# friction_angle", 1),
        };
    }
    if g.once_in(2) {
        text += g.one_of(SOLVERS);
    }
    if g.once_in(3) {
        let (bytes, _) = mutate(text.as_bytes(), g);
        text = String::from_utf8_lossy(&bytes).into_owned();
    }
    text
}

#[test]
fn check_refuses_what_run_refuses() {
    let folder = scratch("agreement");
    let (file, out) = (folder.join("scene.toml"), folder.join("out"));
    let [file_name, out_name] = [&file, &out].map(|p| p.display().to_string());
    trial("check and run", count(2e-4, 60), |g| {
        let text = scene(g);
        std::fs::write(&file, &text).unwrap();
        let _ = std::fs::remove_dir_all(&out);
        let check = fracas(&["check", &file_name]);
        let run = fracas(&[
            "run",
            &file_name,
            "--out",
            &out_name,
            "--steps",
            "1",
            "--threads",
            "1",
        ]);
        let said = [&check, &run].map(|o| String::from_utf8_lossy(&o.stderr).into_owned());
        // the sentence itself
        let error = |text: &str| {
            let line = text.lines().find_map(|l| l.strip_prefix("error: "));
            line.map(str::to_owned)
        };
        let [of_check, of_run] = said.each_ref().map(|text| error(text));
        match [&check, &run].map(|o| o.status.code()) {
            [Some(2), Some(2)] if of_check == of_run && of_run.is_some() => Verdict::Refused,
            // without any friction: a scene for `solve`, and a warning
            [Some(0), Some(2)]
                if of_run.as_ref().is_some_and(|error| {
                    let told = String::from_utf8_lossy(&check.stdout).into_owned();
                    told.contains(&format!("a run is refused: {error}"))
                }) =>
            {
                Verdict::Refused
            }
            [Some(0), Some(0 | 3)] => Verdict::Taken,
            status => Verdict::Finding(format!("{status:?}: {said:?}\n{text}")),
        }
    });
    std::fs::remove_dir_all(&folder).unwrap();
}
