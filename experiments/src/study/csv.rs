//! Records of a CSV file (RFC 4180) as fields.

use anyhow::Context;
use std::str::FromStr;

/// A record, and where the next one begins.
#[derive(Debug, PartialEq)]
pub(super) struct Record {
    pub(super) fields: Vec<String>,
    pub(super) end: usize,
}

/// Every record that is complete: the last one needs its line break, too.
pub(super) fn records(text: &str) -> Vec<Record> {
    let mut records = Vec::new();
    let (mut fields, mut field, mut quoted) = (Vec::new(), String::new(), false);
    let mut characters = text.char_indices().peekable();
    while let Some((at, c)) = characters.next() {
        match c {
            '"' if quoted && characters.peek().is_some_and(|(_, next)| *next == '"') => {
                characters.next();
                field.push('"');
            }
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(std::mem::take(&mut field)),
            '\n' if !quoted => {
                fields.push(std::mem::take(&mut field));
                records.push(Record {
                    fields: std::mem::take(&mut fields),
                    end: at + 1,
                });
            }
            _ => field.push(c),
        }
    }
    records
}

/// The fields of the columns `names` of every row below the heading of `file`.
///
/// # Errors
/// Of a column that is missing.
pub(super) fn columns<const N: usize>(
    file: &str,
    text: &str,
    names: [&str; N],
) -> anyhow::Result<Vec<[String; N]>> {
    let records = records(text);
    let Some((heading, rows)) = records.split_first() else {
        return Ok(Vec::new());
    };
    let mut places = [0; N];
    for (place, name) in places.iter_mut().zip(names) {
        let found = heading.fields.iter().position(|field| field == name);
        *place = found.with_context(|| format!("{file} has no column {name}"))?;
    }
    let of = |row: &Record| places.map(|place| row.fields.get(place).cloned().unwrap_or_default());
    Ok(rows.iter().map(of).collect())
}

/// A field as a number; `row` counts from 0 below the heading.
///
/// # Errors
/// Of what is no number.
pub(super) fn number<T: FromStr>(
    file: &str,
    row: usize,
    name: &str,
    field: &str,
) -> anyhow::Result<T> {
    let line = row + 2;
    let number = field.parse().ok();
    number.with_context(|| format!("{file}, line {line}: {name} is {field:?}, not a number"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_figures::quote;

    #[test]
    fn quoted_fields_come_back_and_the_torn_end_does_not() {
        let fields = ["a", "b, c", "say \"d\"", "two\nlines", ""];
        let line = fields.map(quote).join(",");
        let text = format!("{line}\n{line}\n1,2,\"tor");
        let read = records(&text);
        assert_eq!(read.len(), 2);
        assert!(read.iter().all(|record| record.fields == fields));
        assert_eq!(&text[read[1].end..], "1,2,\"tor");
    }
}
