//! The report: one page, figures inline, nothing fetched, no scripts.

use super::lecture;
use super::math::prose;
use super::sheet::{FIGURES, Sheet};
use super::{Basis, Chapter, Check, Findings, Level, Outcome, Panels, Table};
use fracas_operators::simd;
use std::fmt::Write as _;

const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Columns up to which a table has letters of the usual size.
const WIDE: usize = 12;

const STYLE: &str = include_str!("report.css");

/// The whole page.
pub(super) fn page(chapters: &[Chapter], level: Level) -> anyhow::Result<String> {
    let mut html = String::new();
    let size = match level {
        Level::Paper => "the sizes in print",
        Level::Smoke => {
            "small sizes, so that everything takes minutes; <code>fracas reproduce ID</code> computes the sizes in print"
        }
    };
    let lead = format!("{}. Level {}: {size}.", origin(), level.word());
    let heading = "Figures and tables, beside the published numbers";
    head(&mut html, "fracas: figures and tables", heading, &lead)?;
    overview(&mut html, chapters)?;
    for chapter in chapters {
        section(&mut html, chapter)?;
    }
    lecture::section(&mut html, chapters)?;
    html.push_str("</body>\n</html>\n");
    Ok(html)
}

/// The page of a single answer.
pub(super) fn single(sheet: &Sheet<'_>) -> anyhow::Result<String> {
    let mut html = String::new();
    let lead = format!("{}. {}", origin(), prose(sheet.lead));
    let title = escape(sheet.title);
    head(&mut html, &format!("fracas: {title}"), &title, &lead)?;
    answer(&mut html, FIGURES, sheet.findings)?;
    html.push_str("</body>\n</html>\n");
    Ok(html)
}

/// Version, commit where the build knows it, and machine code: what a number depends on beside its settings.
fn origin() -> String {
    let commit = match env!("FRACAS_COMMIT") {
        "" => String::new(),
        commit => format!(", commit <code>{commit}</code>"),
    };
    format!(
        "fracas {VERSION}{commit}, instruction set {}",
        escape(simd::Level::best().name())
    )
}

/// Everything down to the first paragraph, from texts in HTML.
fn head(html: &mut String, title: &str, heading: &str, lead: &str) -> anyhow::Result<()> {
    write!(
        html,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<header>\n<h1>{heading}</h1>\n\
         <p>{lead}</p>\n</header>\n"
    )?;
    Ok(())
}

fn overview(html: &mut String, chapters: &[Chapter]) -> anyhow::Result<()> {
    html.push_str("<table class=\"overview\">\n<thead><tr><th>experiment</th><th>question</th><th>verdict</th></tr></thead>\n<tbody>\n");
    for chapter in chapters {
        let e = chapter.experiment;
        let (class, verdict) = verdict(chapter);
        writeln!(
            html,
            "<tr><td><a href=\"#{id}\">{id}</a></td><td>{}</td><td class=\"{class}\">{verdict}</td></tr>",
            prose(e.question()),
            id = escape(e.id())
        )?;
    }
    html.push_str("</tbody>\n</table>\n");
    Ok(())
}

/// Style class and words.
fn verdict(chapter: &Chapter) -> (&'static str, String) {
    match &chapter.outcome {
        Outcome::Broken(_) => ("fail", "no answer".into()),
        Outcome::Answered(findings) => {
            let (all, good) = (
                findings.checks.len(),
                findings.checks.iter().filter(|c| c.pass).count(),
            );
            let class = if good == all { "pass" } else { "fail" };
            (class, format!("{good} of {all} checks hold"))
        }
    }
}

fn section(html: &mut String, chapter: &Chapter) -> anyhow::Result<()> {
    let e = chapter.experiment;
    write!(
        html,
        "<section id=\"{id}\">\n<h2><span class=\"id\">{id}</span> {}</h2>\n<dl>\n<dt>Question</dt><dd>{}</dd>\n<dt>Set-up</dt><dd>{}</dd>\n<dt>Expected</dt><dd>{}</dd>\n</dl>\n",
        prose(e.title()),
        prose(e.question()),
        prose(e.setup()),
        prose(e.expect()),
        id = escape(e.id())
    )?;
    match &chapter.outcome {
        Outcome::Broken(error) => writeln!(
            html,
            "<p class=\"fail\">No answer: {}</p>",
            escape(&format!("{error:#}"))
        )?,
        Outcome::Answered(findings) => answer(html, e.id(), findings)?,
    }
    html.push_str("</section>\n");
    Ok(())
}

fn answer(html: &mut String, id: &str, findings: &Findings) -> anyhow::Result<()> {
    for figure in &findings.figures {
        writeln!(
            html,
            "<figure>\n{}\n<figcaption>{} <a href=\"{id}/{file}.csv\">data</a></figcaption>\n</figure>",
            figure.to_svg()?.trim(),
            prose(&figure.caption),
            file = escape(&figure.id)
        )?;
    }
    for panels in &findings.panels {
        side_by_side(html, id, panels)?;
    }
    for table in &findings.tables {
        table_rows(html, id, table)?;
    }
    if !findings.checks.is_empty() {
        verdicts(html, &findings.checks)?;
    }
    for note in &findings.notes {
        writeln!(html, "<p class=\"note\">{}</p>", prose(note))?;
    }
    if !findings.settings.is_empty() {
        let settings = serde_json::to_string_pretty(&findings.settings)?;
        writeln!(
            html,
            "<details><summary>Settings</summary><pre>{}</pre></details>",
            escape(&settings)
        )?;
    }
    Ok(())
}

fn side_by_side(html: &mut String, id: &str, panels: &Panels) -> anyhow::Result<()> {
    if !panels.title.is_empty() {
        writeln!(html, "<h3>{}</h3>", prose(&panels.title))?;
    }
    if !panels.caption.is_empty() {
        writeln!(html, "<p class=\"panels\">{}</p>", prose(&panels.caption))?;
    }
    html.push_str("<div class=\"panels\">\n");
    for figure in &panels.figures {
        writeln!(
            html,
            "<figure>\n{}\n<figcaption>{} <a href=\"{id}/{file}.csv\">data</a></figcaption>\n</figure>",
            figure.to_panel_svg()?.trim(),
            prose(&figure.caption),
            file = escape(&figure.id)
        )?;
    }
    html.push_str("</div>\n");
    Ok(())
}

fn table_rows(html: &mut String, id: &str, table: &Table) -> anyhow::Result<()> {
    let class = match table.columns.len() {
        ..=WIDE => "",
        _ => " class=\"wide\"",
    };
    writeln!(
        html,
        "<table{class}>\n<caption>{} <a href=\"{id}/{file}.csv\">data</a></caption>",
        prose(&table.caption),
        file = escape(&table.id)
    )?;
    html.push_str("<thead><tr>");
    for column in &table.columns {
        let unit = if column.unit.is_empty() {
            String::new()
        } else {
            format!(" <span class=\"unit\">[{}]</span>", escape(&column.unit))
        };
        write!(html, "<th>{}{unit}</th>", prose(&column.name))?;
    }
    html.push_str("</tr></thead>\n<tbody>\n");
    for row in &table.rows {
        html.push_str("<tr>");
        for cell in row {
            let class = if cell.is_number() {
                " class=\"number\""
            } else {
                ""
            };
            write!(html, "<td{class}>{}</td>", escape(&cell.display()))?;
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody>\n</table>\n");
    Ok(())
}

fn verdicts(html: &mut String, checks: &[Check]) -> anyhow::Result<()> {
    html.push_str("<table>\n<caption>Verdict</caption>\n<thead><tr><th>claim</th><th>published</th><th>closed form</th><th>own threshold</th><th>ours</th><th></th></tr></thead>\n<tbody>\n");
    for check in checks {
        let (class, word) = if check.pass {
            ("pass", "holds")
        } else {
            ("fail", "fails")
        };
        let expected = prose(&check.expected);
        let [published, closed_form, own] = match &check.basis {
            Basis::Published(source) => {
                let source = escape(source);
                let value = format!("{expected}<br><span class=\"unit\">{source}</span>");
                [value, String::new(), String::new()]
            }
            Basis::ClosedForm => [String::new(), expected, String::new()],
            Basis::Own => [String::new(), String::new(), expected],
        };
        writeln!(
            html,
            "<tr><td>{}</td><td class=\"bound\">{published}</td><td class=\"bound\">{closed_form}</td><td class=\"bound\">{own}</td>\
             <td class=\"bound\">{}</td><td class=\"{class}\">{word}</td></tr>",
            prose(&check.claim),
            escape(&check.ours)
        )?;
    }
    html.push_str("</tbody>\n</table>\n");
    Ok(())
}

/// Text in HTML.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
