//! A chapter becomes files; a failed check, a failed method and a broken experiment all stay visible.

use super::*;
use fracas_figures::{Axis, Figure, Mark, Series};
use fracas_solvers::{Observer, Silent};

struct Sums;

impl Experiment for Sums {
    fn id(&self) -> &'static str {
        "x01"
    }
    fn title(&self) -> &'static str {
        "Sums & <signs>"
    }
    fn question(&self) -> &'static str {
        "Is 1 + 1 = 2?"
    }
    fn setup(&self) -> &'static str {
        "two ones"
    }
    fn expect(&self) -> &'static str {
        "2"
    }
    fn run(&self, level: Level, _observer: &mut dyn Observer) -> anyhow::Result<Findings> {
        if level == Level::Paper {
            anyhow::bail!("too large");
        }
        let mut findings = Findings::default();
        findings.set("tolerance", 1e-8);
        let mut table = Table::new("cost", "Cost.", &["method", "n_it", "time [s]"]);
        table.push(["racp, local".into(), 17_usize.into(), 0.125.into()]);
        table.push(["mcp".into(), Cell::Failed, Cell::Missing]);
        findings.tables.push(table);
        let series = Series::new("a", Mark::Line, vec![[0.0, 0.0], [1.0, 2.0]]);
        findings.figures.push(
            Figure::new("line", "", "A line.", Axis::linear("x"), Axis::linear("y")).with(series),
        );
        findings
            .checks
            .push(Check::close("sum", 2.0, 2.0, 1e-12).closed_form());
        let cost = Check::at_most("cost of S_u in `a`", 1.0, 1.5);
        findings
            .checks
            .push(cost.by(Basis::Published("a lecture".into())));
        Ok(findings)
    }
}

static SUMS: Sums = Sums;

fn folder(name: &str) -> std::path::PathBuf {
    std::env::temp_dir().join(format!("fracas-report-{}-{name}", std::process::id()))
}

#[test]
fn a_chapter_is_written_as_csv_svg_manifest_and_page() {
    let out = folder("chapter");
    let chapter = run_chapter(
        &SUMS,
        Level::Smoke,
        (&out, Formats { pdf: true }),
        &mut Silent,
    )
    .unwrap();
    assert!(!chapter.passed(), "one check fails");
    write_report(&[chapter], Level::Smoke, &out).unwrap();
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    assert_eq!(
        read("x01/cost.csv"),
        "method,n_it,time [s]\n\"racp, local\",17,0.125\nmcp,X,\n"
    );
    assert!(read("x01/line.csv").starts_with("layer,kind,x,y\na,line,0,0\n"));
    let pdf = std::fs::read(out.join("x01/line.pdf")).unwrap();
    assert!(pdf.starts_with(b"%PDF-"));
    let manifest: serde_json::Value = serde_json::from_str(&read("x01/manifest.json")).unwrap();
    assert_eq!(manifest["level"], "smoke");
    assert_eq!(manifest["settings"]["tolerance"], 1e-8);
    assert_eq!(manifest["checks"][1]["pass"], false);
    let html = read("report.html");
    for text in [
        "Sums &amp; &lt;signs&gt;",
        "1 of 2 checks hold",
        "<td class=\"number\">✗</td>",
        "<svg",
        "fails",
        "≤ 1<br><span class=\"unit\">a lecture</span>",
        "<th>published</th><th>closed form</th><th>own threshold</th>",
        "cost of <math><msub><mi>S</mi><mrow><mi>u</mi></mrow></msub></math> in <code>a</code>",
        "instruction set",
        "<title>y over x</title><desc>A line.</desc>",
        "From the lecture to this page",
    ] {
        assert!(html.contains(text), "{text}");
    }
    assert!(!html.contains("<script") && !html.contains("src=") && !html.contains("url("));
    assert_eq!(
        read("x01/line.svg").trim(),
        html[html.find("<svg").unwrap()..html.find("</svg>").unwrap() + 6].trim()
    );
}

#[test]
fn a_broken_experiment_is_a_chapter_without_answer() {
    let out = folder("broken");
    let chapter =
        run_chapter(&SUMS, Level::Paper, (&out, Formats::default()), &mut Silent).unwrap();
    assert!(!chapter.passed());
    write_report(&[chapter], Level::Paper, &out).unwrap();
    assert!(
        std::fs::read_to_string(out.join("report.html"))
            .unwrap()
            .contains("No answer: too large")
    );
    assert!(!out.join("x01/line.pdf").exists());
}

#[test]
fn checks_fail_when_they_should() {
    assert!(!Check::close("", 1.0, f64::NAN, 0.1).pass && !Check::at_most("", 1.0, f64::NAN).pass);
    assert!(!Check::at_least("", 1.0, f64::NAN).pass && !Check::equal("", 1, 2).pass);
    assert!(Check::close("", -2.0, -2.1, 0.06).pass && !Check::close("", -2.0, -2.2, 0.06).pass);
}
