//! Records of a CSV file (RFC 4180) as fields.

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::quote;

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
