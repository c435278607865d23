//! `fracas schema --page`: the keys of a scene file as Markdown, a section per table and per list of values.
//!
//! Everything comes from the JSON Schema but the units: there the sentence of a key takes the place of that of its quantity, so
//! the reader itself is asked what it expects.

use fracas::scene::SceneSections;
use serde_json::{Value, json};

/// The page.
pub(super) fn page() -> String {
    let schema = fracas::scene::schema().to_value();
    let mut page = Page {
        schema: &schema,
        sections: Vec::new(),
    };
    page.visit(&schema, Vec::new());
    let texts: Vec<String> = page.sections.iter().map(|s| page.section(s)).collect();
    texts.join("\n")
}

struct Page<'a> {
    schema: &'a Value,
    sections: Vec<Section<'a>>,
}

/// A table, or the values that a key may take, with all places where it stands.
struct Section<'a> {
    node: &'a Value,
    places: Vec<Vec<Step>>,
}

/// A key on the way from the top of the file.
#[derive(Clone)]
struct Step {
    key: String,
    is_list: bool,
}

impl<'a> Page<'a> {
    /// Collects the sections below a node; what stands at several places gets one section.
    fn visit(&mut self, node: &'a Value, place: Vec<Step>) {
        let known = |s: &&mut Section| std::ptr::eq(s.node, node);
        if let Some(section) = self.sections.iter_mut().find(known) {
            return section.places.push(place);
        }
        self.sections.push(Section {
            node,
            places: vec![place.clone()],
        });
        let tables = match is_table(node) {
            true => vec![node],
            false => self.variants(node),
        };
        for (key, child) in tables.into_iter().flat_map(properties) {
            if let Some((target, is_list)) = self.target(child) {
                let key = key.clone();
                let step = Step { key, is_list };
                self.visit(target, [place.as_slice(), &[step]].concat());
            }
        }
    }

    /// Follows a reference.
    fn resolved(&self, node: &'a Value) -> &'a Value {
        let pointer = node["$ref"].as_str().and_then(|r| r.strip_prefix('#'));
        pointer
            .and_then(|pointer| self.schema.pointer(pointer))
            .unwrap_or(node)
    }

    /// The table or the choice that a key holds, and whether it holds a list of them.
    fn target(&self, node: &'a Value) -> Option<(&'a Value, bool)> {
        let is_list = node["items"]["$ref"].is_string();
        let one = match is_list {
            true => &node["items"],
            false => given(node),
        };
        let target = self.resolved(one);
        (is_table(target) || !alternatives(target).is_empty()).then_some((target, is_list))
    }

    /// The values of a choice, those of a choice inside it included.
    fn variants(&self, node: &'a Value) -> Vec<&'a Value> {
        let all = alternatives(node).iter().flat_map(|variant| {
            let resolved = self.resolved(variant);
            match alternatives(resolved).is_empty() {
                true => vec![resolved],
                false => self.variants(resolved),
            }
        });
        all.collect()
    }

    fn section(&self, section: &Section) -> String {
        let rows = match is_table(section.node) {
            true => self.keys(section),
            false => self.values(section.node),
        };
        let about = sentence(section.node);
        let about = match about.is_empty() {
            true => about,
            false => about + "\n\n",
        };
        format!("### {}\n\n{about}{rows}", heading(section))
    }

    /// A row per key, those that have to be given first.
    fn keys(&self, section: &Section) -> String {
        let mut keys: Vec<_> = properties(section.node).collect();
        keys.sort_by_key(|(key, _)| !is_required(section.node, key));
        let rows = keys.into_iter().map(|(key, node)| {
            let default = match (&node["default"], is_required(section.node, key)) {
                (_, true) => "required".to_owned(),
                (Value::Null, false) => "–".to_owned(),
                (value, false) => format!("`{}`", toml_of(value)),
            };
            let kind = self.kind(&section.places[0], key, node);
            format!("| `{key}` | {kind} | {default} | {} |\n", sentence(node))
        });
        "| key | value | default | meaning |\n|---|---|---|---|\n".to_owned()
            + &rows.collect::<String>()
    }

    /// A row per value of a choice.
    fn values(&self, node: &'a Value) -> String {
        let rows = self
            .variants(node)
            .into_iter()
            .map(|variant| format!("| {} | {} |\n", written(variant), sentence(variant)));
        "| value | meaning |\n|---|---|\n".to_owned() + &rows.collect::<String>()
    }

    /// What is written behind a key.
    fn kind(&self, place: &[Step], key: &str, node: &'a Value) -> String {
        match self.target(node) {
            Some((target, is_list)) if is_table(target) => match is_list {
                true => "tables".to_owned(),
                false => "a table".to_owned(),
            },
            Some((target, _)) => {
                let values = self.variants(target).into_iter().map(written);
                values.collect::<Vec<_>>().join(", ")
            }
            None => leaf(place, key, node),
        }
    }
}

/// What a plain value is: a quantity in the reader's words, else its type.
fn leaf(place: &[Step], key: &str, node: &Value) -> String {
    let is_quantity = has_type(node, "string") && has_type(node, "number");
    let one_or_many = has_type(node, "string") && has_type(node, "array");
    let expected = is_quantity.then(|| expected(place, key, one_or_many));
    match (expected.flatten(), one_or_many) {
        (Some(quantity), false) => quantity,
        (Some(quantity), true) => format!("{quantity}; or a list of them"),
        (None, true) => "text or a whole number, or a list of them".to_owned(),
        (None, false) => plain(node),
    }
}

/// A value that says itself what it is.
fn plain(node: &Value) -> String {
    if let Some(pair) = node["prefixItems"].as_array() {
        let parts: Vec<String> = pair.iter().map(plain).collect();
        return format!("a pair of {}", parts.join(", and "));
    }
    let quantity = node["description"].as_str();
    let name = match (quantity, type_name(node)) {
        (Some(text), Some("string")) if has_type(node, "number") => {
            text.split(';').next().unwrap_or(text)
        }
        (_, Some("array")) => return list(node),
        (_, Some("integer")) => "a whole number",
        (_, Some("number")) => "a number",
        (_, Some("boolean")) => "`true` or `false`",
        _ => "text",
    };
    match node["minimum"].as_u64() {
        Some(least @ 1..) => format!("{name}, at least {least}"),
        _ => name.to_owned(),
    }
}

fn list(node: &Value) -> String {
    let of = plain(&node["items"]);
    match node["maxItems"].as_u64() {
        Some(length) => format!("a list of {length}, each {of}"),
        None => format!("a list, each {of}"),
    }
}

/// What the reader expects behind a key, from its refusal of `true`.
fn expected(place: &[Step], key: &str, is_list: bool) -> Option<String> {
    let in_list = |is_list: bool, value: Value| match is_list {
        true => json!([value]),
        false => value,
    };
    let leaf = json!({ key: in_list(is_list, json!(true)) });
    let scene = place.iter().rev().fold(
        leaf,
        |value, step| json!({ step.key.as_str(): in_list(step.is_list, value) }),
    );
    let refusal = serde_json::from_value::<SceneSections>(scene).err()?;
    let text = refusal.to_string();
    let (_, expected) = text.split_once("expected ")?;
    let units = expected.replace("e.g. in no unit", "without unit");
    Some(units.replace("e.g. in", "in"))
}

fn heading(section: &Section) -> String {
    let places = section.places.iter().map(|place| {
        let keys: Vec<&str> = place.iter().map(|step| step.key.as_str()).collect();
        let name = keys.join(".");
        match (place.last(), is_table(section.node)) {
            (None, _) => "Top of the file".to_owned(),
            (Some(step), true) if step.is_list => format!("`[[{name}]]`"),
            (Some(_), true) => format!("`[{name}]`"),
            (Some(_), false) => format!("`{name}`"),
        }
    });
    let names = places.collect::<Vec<_>>().join(", ");
    match is_table(section.node) {
        true => names,
        false => format!("Values of {names}"),
    }
}

/// A value of a choice, as it stands in the file.
fn written(variant: &Value) -> String {
    match (variant["const"].as_str(), properties(variant).next()) {
        (Some(name), _) => format!("`\"{name}\"`"),
        (None, Some((key, _))) => format!("`{{ {key} = … }}`"),
        (None, None) => "a name".to_owned(),
    }
}

/// The first paragraph of a description without links; a last sentence that announces what follows it is left out.
fn sentence(node: &Value) -> String {
    let text = node["description"].as_str().unwrap_or_default();
    let first = text.split("\n\n").next().unwrap_or_default();
    let mut line = first.replace('\n', " ");
    if line.ends_with(':') {
        line.truncate(line.rfind(". ").map_or(0, |end| end + 1));
    }
    let replaced = [("[`", "`"), ("`]", "`"), ("super::", ""), ("|", "\\|")];
    replaced
        .iter()
        .fold(line, |line, (old, new)| line.replace(old, new))
}

/// A default as TOML; a number as JSON has it, which writes small ones with an exponent.
fn toml_of(value: &Value) -> String {
    match (value.is_number(), toml::Value::try_from(value)) {
        (false, Ok(value)) => value.to_string(),
        _ => value.to_string(),
    }
}

/// Without the null of a key that may be left out.
fn given(node: &Value) -> &Value {
    let is_null = |variant: &&Value| variant["type"] == "null";
    match alternatives(node) {
        [one, null] if is_null(&null) => one,
        _ => node,
    }
}

fn alternatives(node: &Value) -> &[Value] {
    let lists = ["oneOf", "anyOf"].into_iter();
    lists
        .filter_map(|name| node[name].as_array())
        .next()
        .map_or(&[], Vec::as_slice)
}

fn properties(node: &Value) -> impl Iterator<Item = (&String, &Value)> {
    node["properties"].as_object().into_iter().flatten()
}

fn is_table(node: &Value) -> bool {
    node["properties"].is_object()
}

fn is_required(node: &Value, key: &str) -> bool {
    let required = node["required"].as_array();
    required.is_some_and(|keys| keys.iter().any(|k| k == key))
}

fn types(node: &Value) -> Vec<&str> {
    match &node["type"] {
        Value::Array(all) => all.iter().filter_map(Value::as_str).collect(),
        one => one.as_str().into_iter().collect(),
    }
}

fn type_name(node: &Value) -> Option<&str> {
    types(node).first().copied()
}

fn has_type(node: &Value, name: &str) -> bool {
    types(node).contains(&name)
}
