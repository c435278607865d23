//! What a study mentions: refused where it is unknown, measured where it is known.

use super::measure::{Group, Name};
use super::page::OWN_TABLES;
use super::product::Wanted;
use super::tornado::SETS;
use super::{Column, FigureSection, Kind, Study, TableSection, formula};
use std::cell::RefCell;
use std::cmp::Ordering;
use toml::Table;

/// What is wrong with the k-th section of a kind.
#[derive(Debug, thiserror::Error)]
#[error("[[{section}]] {}: {why}", place + 1)]
pub(super) struct SectionError {
    pub(super) section: &'static str,
    /// From 0.
    pub(super) place: usize,
    why: String,
}

/// Names in a formula.
fn names(text: &str) -> Result<Vec<String>, String> {
    let names = RefCell::new(Vec::new());
    formula::value(text, &mut |name| {
        names.borrow_mut().push(name.to_owned());
        1.0
    })?;
    Ok(names.into_inner())
}

/// What is known here, and which section is looked at.
struct Judge {
    known: Vec<String>,
    section: &'static str,
    place: usize,
}

impl Judge {
    fn fail(&self, why: String) -> SectionError {
        SectionError {
            section: self.section,
            place: self.place,
            why,
        }
    }

    fn name(&self, key: &str, name: &str) -> Result<(), SectionError> {
        let plain = name.strip_prefix("published.").unwrap_or(name);
        if self.known.iter().any(|known| known == plain) {
            return Ok(());
        }
        // a key of a scene is an axis by its own name
        let plain = plain.strip_prefix("set.").unwrap_or(plain);
        let nearest = (self.known.iter())
            .min_by_key(|known| strsim::damerau_levenshtein(known, plain))
            .filter(|known| strsim::damerau_levenshtein(known, plain) <= 2);
        let nearest = nearest.map_or(String::new(), |n| format!(" (did you mean `{n}`?)"));
        let known = self.known.join(", ");
        Err(self.fail(format!("`{key}` is `{name}`{nearest}; there are: {known}")))
    }

    /// A name as it is, or a formula of names.
    fn formula(&self, key: &str, text: &str) -> Result<(), SectionError> {
        if self.name(key, text).is_ok() {
            return Ok(());
        }
        let names = names(text).map_err(|why| self.fail(format!("`{key}` is `{text}`: {why}")))?;
        names.iter().try_for_each(|name| self.name(key, name))
    }

    fn rows(&self, of: &Table) -> Result<(), SectionError> {
        let wanted = Wanted::new(of).0;
        wanted
            .iter()
            .try_for_each(|(name, _)| self.name("where", name))
    }
}

impl FigureSection {
    fn formulas(&self) -> impl Iterator<Item = &String> {
        let own = [&self.x, &self.color]
            .into_iter()
            .filter(|text| !text.is_empty());
        own.chain(&self.y)
    }
}

impl TableSection {
    fn formulas(&self) -> impl Iterator<Item = String> {
        self.columns
            .iter()
            .map(Column::full)
            .map(|column| column.of)
    }
}

impl Study {
    /// True unless the level of this study is one of these; the file as it stands is `paper`.
    pub(super) fn is_at_level(&self, not_at: &[String]) -> bool {
        let at = match self.at.as_str() {
            "" => "paper",
            at => at,
        };
        not_at.iter().all(|level| level != at)
    }

    /// True where the axis has variants that change a setting, and one that does not.
    fn changes_one_at_a_time(&self, y: &[String]) -> bool {
        let all = self.axes.0.iter().flat_map(|axes| &axes.together);
        let axes = all.filter(|axis| y.first() == Some(&axis.name));
        let named = axes.flat_map(|axis| &axis.values);
        let (changed, base): (Vec<_>, Vec<_>) = named.partition(|value| value.name.contains(SETS));
        y.len() == 1 && !changed.is_empty() && !base.is_empty()
    }

    /// Refuses what nobody measures or varies.
    pub(super) fn check_names(&self) -> Result<(), SectionError> {
        let measures = Name::ALL.iter().map(|name| name.text().to_owned());
        let known = measures
            .chain(self.axis_names())
            .chain(["outcome", "reason", "row", "ran"].map(String::from));
        let mut judge = Judge {
            known: known.collect(),
            section: "figure",
            place: 0,
        };
        for (place, figure) in self.figure.iter().enumerate() {
            judge.place = place;
            if figure.kind.has_axes() && (figure.x.is_empty() || figure.y.is_empty()) {
                return Err(judge.fail("it needs x and y".into()));
            }
            if !figure.x.is_empty() {
                judge.formula("x", &figure.x)?;
            }
            figure.y.iter().try_for_each(|y| judge.formula("y", y))?;
            if figure.kind == Kind::Tornado && !self.changes_one_at_a_time(&figure.y) {
                let why = "`y` of a tornado is an axis of variants named `setting = value`, and one without `=` that changes nothing";
                return Err(judge.fail(why.into()));
            }
            match (figure.kind, figure.color.as_str()) {
                (Kind::Map, "") => return Err(judge.fail("a map needs a color".into())),
                (_, "") => {}
                (_, color) => judge.formula("color", color)?,
            }
            let within = &figure.within;
            if within.len() > 2 || (!within.is_empty() && figure.kind != Kind::Map) {
                return Err(judge.fail("`within` is for maps, one axis for x and one for y".into()));
            }
            if figure
                .colors
                .is_some_and(|[low, high]| low.partial_cmp(&high) != Some(Ordering::Less))
            {
                return Err(judge.fail("`colors` are two numbers, the lower one first".into()));
            }
            within
                .iter()
                .try_for_each(|axis| judge.name("within", axis))?;
            let series = figure.series.iter().flatten();
            series
                .into_iter()
                .try_for_each(|s| judge.name("series", s))?;
            figure
                .facet
                .iter()
                .try_for_each(|f| judge.name("facet", f))?;
            let endless = |y: &f64| !y.is_finite();
            if let Some(line) = figure
                .line
                .iter()
                .find(|line| line.y.as_ref().is_some_and(endless))
            {
                let why = format!("`y` of the line \"{}\" is a finite number", line.label);
                return Err(judge.fail(why));
            }
            judge.rows(&figure.of_rows)?;
            figure
                .line
                .iter()
                .try_for_each(|line| judge.rows(&line.of_rows))?;
        }
        judge.section = "table";
        for (place, table) in self.table.iter().enumerate() {
            judge.place = place;
            let taken = (self.table[..place].iter()).any(|other| other.id == table.id);
            if taken || OWN_TABLES.contains(&table.id.as_str()) {
                let why = format!(
                    "another table is named {}; give it an `id` of its own",
                    table.id
                );
                return Err(judge.fail(why));
            }
            judge.rows(&table.of_rows)?;
            table
                .rows
                .iter()
                .try_for_each(|name| judge.name("rows", name))?;
            table
                .least
                .iter()
                .try_for_each(|of| judge.formula("least", of))?;
            for column in table.columns.iter().map(Column::full) {
                judge.formula("columns", &column.of)?;
                judge.rows(&column.of_rows)?;
            }
        }
        judge.section = "published";
        for (place, published) in self.published.iter().enumerate() {
            judge.place = place;
            judge.rows(&published.rows)?;
            published
                .values
                .keys()
                .try_for_each(|name| judge.name("of", name))?;
        }
        judge.section = "check";
        for (place, check) in self.check.iter().enumerate() {
            judge.place = place;
            if let Some(why) = check.objection() {
                return Err(judge.fail(why.into()));
            }
            check
                .mentions()
                .iter()
                .try_for_each(|text| judge.formula("of", text))?;
            let others = [&check.over, &check.minus].into_iter().flatten();
            let rows = others.map(|other| &other.of_rows);
            rows.chain([&check.of_rows])
                .try_for_each(|rows| judge.rows(rows))?;
            check
                .pair
                .iter()
                .try_for_each(|axis| judge.name("pair", axis))?;
            check
                .each
                .iter()
                .try_for_each(|axis| judge.name("for", axis))?;
        }
        Ok(())
    }

    /// Measures of a row, in the order of `rows.csv`: those of the groups that are mentioned.
    pub(super) fn measured(&self) -> Vec<Name> {
        let mut mentioned: Vec<String> = Vec::new();
        let mut add = |text: &str| {
            mentioned.push(text.to_owned());
            mentioned.extend(names(text).unwrap_or_default());
        };
        let parts = self.axes.0.iter().flat_map(|axes| &axes.measures);
        parts
            .chain(&self.measures)
            .for_each(|name| add(name.text()));
        for figure in &self.figure {
            figure.formulas().for_each(|text| add(text));
            figure.kind.needs().iter().for_each(|name| add(name.text()));
            match figure.kind {
                Kind::Residuals => add(Name::Iterations.text()),
                kind if kind.is_of_spectra() => add(Name::ReMin.text()),
                _ => {}
            }
        }
        self.table
            .iter()
            .flat_map(TableSection::formulas)
            .for_each(|text| add(&text));
        let checks = self.check.iter();
        checks.flat_map(|check| check.mentions()).for_each(&mut add);
        let rows = self.check.iter().map(|check| &check.of_rows);
        rows.flat_map(|rows| Wanted::new(rows).0)
            .for_each(|(name, _)| add(&name));
        let is_mentioned = |name: &Name| mentioned.iter().any(|text| text == name.text());
        let all = || Name::ALL.iter().copied();
        let groups: Vec<Group> = all().filter(is_mentioned).map(Name::group).collect();
        let has_states = self.axis_names().iter().any(|name| name == "state");
        let solves = [Group::Solve, Group::Count, Group::Clock, Group::Nested];
        let is_taken = |name: &Name| match name.group() {
            Group::System | Group::Settings => true,
            Group::State => has_states,
            Group::Condition | Group::Nested => is_mentioned(name),
            group if solves.contains(&group) => solves.iter().any(|g| groups.contains(g)),
            group => groups.contains(&group),
        };
        all().filter(is_taken).collect()
    }

    /// Whether figures or checks need the eigenvalues of rows, and their residuals.
    pub(super) fn keeps(&self) -> [bool; 2] {
        let any = |of: fn(Kind) -> bool| self.figure.iter().any(|figure| of(figure.kind));
        let compared = self.check.iter().any(|check| check.of == "eigenvalues");
        let residuals = any(|kind| kind == Kind::Residuals);
        [any(Kind::is_of_spectra) || compared, residuals]
    }
}
