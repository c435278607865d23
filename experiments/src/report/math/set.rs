//! From the characters of a formula to MathML.

use super::{FUNCTIONS, LOWERED, OPERATORS, RAISED, TILDE, found, is_greek};
use crate::report::html::escape;
use std::iter::Peekable;
use std::str::Chars;

/// MathML of a formula; none where something in it is not known.
pub(super) fn set(text: &str) -> Option<String> {
    let mut reader = Reader {
        chars: text.chars().peekable(),
        out: Vec::new(),
    };
    reader.row(None)?;
    Some(format!("<math>{}</math>", reader.out.concat()))
}

/// What has been set, an entry per atom, so that an index finds what it belongs to.
struct Reader<'a> {
    chars: Peekable<Chars<'a>>,
    out: Vec<String>,
}

impl Reader<'_> {
    /// Everything up to a closing bracket, which is taken.
    fn row(&mut self, until: Option<char>) -> Option<()> {
        while let Some(c) = self.chars.next() {
            if Some(c) == until {
                return Some(());
            }
            self.atom(c)?;
        }
        until.is_none().then_some(())
    }

    fn atom(&mut self, c: char) -> Option<()> {
        match c {
            ' ' => self.space(),
            '_' => {
                let index = match self.chars.next_if_eq(&'{') {
                    Some(_) => self.within('}')?,
                    None => self.word(),
                };
                self.attach(Script::Lower, &upright(&index))?;
            }
            '^' => {
                let inner = match self.chars.next_if_eq(&'{') {
                    Some(_) => self.within('}')?,
                    None => self.word(),
                };
                let inner = set_row(&inner)?;
                self.attach(Script::Upper, &inner)?;
            }
            '√' => {
                let next = self.chars.next()?;
                let inner = match next {
                    '(' => set_row(&self.within(')')?)?,
                    c => set_row(&c.to_string())?,
                };
                self.out.push(format!("<msqrt>{inner}</msqrt>"));
            }
            '(' | '[' => {
                let close = if c == '(' { ')' } else { ']' };
                let inner = set_row(&self.within(close)?)?;
                self.out.push(format!(
                    "<mrow><mo stretchy=\"false\">{c}</mo>{inner}<mo stretchy=\"false\">{close}</mo></mrow>"
                ));
            }
            TILDE => {
                let base = self.out.pop()?;
                self.out.push(format!(
                    "<mover>{base}<mo stretchy=\"false\">~</mo></mover>"
                ));
            }
            c if found(RAISED, c).is_some() => {
                let inner = self.run_of(RAISED, c);
                let inner = set_row(&inner)?;
                self.attach(Script::Upper, &inner)?;
            }
            c if found(LOWERED, c).is_some() => {
                let inner = self.run_of(LOWERED, c);
                self.attach(Script::Lower, &upright(&inner))?;
            }
            c if c.is_ascii_digit() => self.number(c),
            c if c.is_ascii_alphabetic() => self.letters(c),
            '½' => self.out.push("<mn>½</mn>".into()),
            '∞' => self.out.push("<mi>∞</mi>".into()),
            '\'' | '′' => self.attach(Script::Upper, "<mo>′</mo>")?,
            '|' | '‖' => self.out.push(format!(
                "<mo stretchy=\"false\" lspace=\"0\" rspace=\"0\">{c}</mo>"
            )),
            c if is_greek(c) || "𝒜ℓ".contains(c) => self.out.push(format!("<mi>{c}</mi>")),
            '-' => self.out.push("<mo>−</mo>".into()),
            c if OPERATORS.contains(c) || ",.!∫∮⟨⟩∑∅⊥{}".contains(c) => {
                self.out
                    .push(format!("<mo>{}</mo>", escape(&c.to_string())));
            }
            _ => return None,
        }
        Some(())
    }

    /// A thin space between two factors; operators have their own.
    fn space(&mut self) {
        let is_operator = |c: &char| OPERATORS.contains(*c) || c.is_whitespace();
        let before = self
            .out
            .last()
            .is_some_and(|last| !last.starts_with("<mo>"));
        if before && self.chars.peek().is_some_and(|c| !is_operator(c)) {
            self.out.push("<mspace width=\"0.17em\"/>".into());
        }
    }

    /// Text up to the bracket that closes, which is taken.
    fn within(&mut self, close: char) -> Option<String> {
        let open = match close {
            ')' => '(',
            ']' => '[',
            _ => '{',
        };
        let (mut text, mut depth) = (String::new(), 1);
        for c in self.chars.by_ref() {
            depth += i32::from(c == open) - i32::from(c == close);
            if depth == 0 {
                return Some(text);
            }
            text.push(c);
        }
        None
    }

    fn word(&mut self) -> String {
        let mut word = String::new();
        while let Some(c) = self
            .chars
            .next_if(|c| c.is_alphanumeric() && found(RAISED, *c).is_none())
        {
            word.push(c);
        }
        word
    }

    fn run_of(&mut self, table: &[(char, char)], first: char) -> String {
        let mut run: String = found(table, first).into_iter().collect();
        while let Some(c) = self.chars.next_if(|c| found(table, *c).is_some()) {
            run.extend(found(table, c));
        }
        run
    }

    /// `17`, `0.5`, `1e-8` as a power of ten.
    fn number(&mut self, first: char) {
        let mut text = first.to_string();
        let mut rest = self.chars.clone();
        while let Some(c) = rest.next_if(|c| c.is_ascii_digit() || *c == '.') {
            text.push(c);
        }
        // a point that ends the number belongs to the sentence
        let length = text.trim_end_matches('.').len();
        let text = &text[..length];
        for _ in 1..length {
            self.chars.next();
        }
        let mut ahead = self.chars.clone();
        let mut power = String::new();
        if ahead.next() == Some('e') {
            while let Some(c) =
                ahead.next_if(|c| c.is_ascii_digit() || *c == '-' && power.is_empty())
            {
                power.push(c);
            }
        }
        if power.ends_with(|c: char| c.is_ascii_digit()) {
            self.chars = ahead;
            if text != "1" {
                self.out.push(format!("<mn>{text}</mn><mo>×</mo>"));
            }
            let power = power.replace('-', "−");
            self.out
                .push(format!("<msup><mn>10</mn><mn>{power}</mn></msup>"));
        } else {
            self.out.push(format!("<mn>{text}</mn>"));
        }
    }

    /// A function, or letters one by one.
    fn letters(&mut self, first: char) {
        let mut run = first.to_string();
        while let Some(c) = self.chars.next_if(char::is_ascii_alphabetic) {
            run.push(c);
        }
        match FUNCTIONS.contains(&run.as_str()) {
            true => self.out.push(format!("<mi>{run}</mi>")),
            false => (run.chars()).for_each(|c| self.out.push(format!("<mi>{c}</mi>"))),
        }
    }

    /// An index or a power of the atom before.
    fn attach(&mut self, script: Script, inner: &str) -> Option<()> {
        let base = self.out.pop()?;
        let both = base
            .strip_prefix("<msub>")
            .and_then(|rest| rest.strip_suffix("</msub>"))
            .filter(|_| script == Script::Upper)
            .map(|inside| format!("<msubsup>{inside}<mrow>{inner}</mrow></msubsup>"));
        self.out.push(both.unwrap_or_else(|| {
            let tag = match script {
                Script::Lower => "msub",
                Script::Upper => "msup",
            };
            format!("<{tag}>{base}<mrow>{inner}</mrow></{tag}>")
        }));
        Some(())
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Script {
    Lower,
    Upper,
}

/// An index: a number, or a word that is upright.
fn upright(index: &str) -> String {
    let tag = match index.chars().all(|c| c.is_ascii_digit()) {
        true => "mn",
        false => "mi",
    };
    format!("<{tag}>{}</{tag}>", escape(index))
}

fn set_row(text: &str) -> Option<String> {
    let mut reader = Reader {
        chars: text.chars().peekable(),
        out: Vec::new(),
    };
    reader.row(None)?;
    Some(reader.out.concat())
}
