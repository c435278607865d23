//! Fields of unknowns by name: a value for each, and vectors split by them.

use std::fmt;
use std::ops::{Index, Range};

/// Fields that a system may have: u, t, p and one more. Unit: 1.
const MOST: usize = 4;

/// A field of unknowns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Field {
    /// Letter, as in `n_u`, `r_t`.
    pub letter: &'static str,
    /// What its values are, in the plural.
    pub name: &'static str,
}

/// A value for every field of a system.
#[derive(Clone, Copy, PartialEq)]
pub struct Fields<V> {
    values: [Option<(Field, V)>; MOST],
}

/// No field.
impl<V> Default for Fields<V> {
    fn default() -> Self {
        Self {
            values: [const { None }; MOST],
        }
    }
}

impl<V: Copy> Fields<V> {
    /// In this order; stops where a field comes twice.
    pub fn new(given: impl IntoIterator<Item = (Field, V)>) -> Self {
        let given = given.into_iter();
        given.fold(Self::default(), |fields, (field, value)| {
            fields.with(field, value)
        })
    }

    /// The same with a further field behind the others.
    #[must_use]
    pub fn with(mut self, field: Field, value: V) -> Self {
        assert!(self.get(field).is_none(), "two fields {}", field.letter);
        let free = self.values.iter_mut().find(|place| place.is_none());
        let Some(place) = free else {
            panic!("more than {MOST} fields");
        };
        *place = Some((field, value));
        self
    }

    /// The fields, with their values.
    pub fn iter(&self) -> impl Iterator<Item = (Field, V)> + use<V> {
        self.values.into_iter().flatten()
    }

    /// The value of a field, where there is one.
    pub fn get(&self, field: Field) -> Option<V> {
        let found = self.iter().find(|(own, _)| *own == field);
        found.map(|(_, value)| value)
    }

    /// Of every value another one.
    #[must_use]
    pub fn map<W: Copy>(&self, mut of: impl FnMut(Field, V) -> W) -> Fields<W> {
        Fields {
            values: self
                .values
                .map(|place| place.map(|(field, value)| (field, of(field, value)))),
        }
    }
}

impl Fields<f64> {
    /// The field of the largest value, with it.
    pub fn largest(&self) -> Option<(Field, f64)> {
        self.iter()
            .reduce(|most, next| if next.1 > most.1 { next } else { most })
    }
}

impl<V> Index<Field> for Fields<V> {
    type Output = V;

    fn index(&self, field: Field) -> &V {
        let mut values = self.values.iter().flatten();
        match values.find(|(own, _)| *own == field) {
            Some((_, value)) => value,
            None => panic!("no field {}", field.letter),
        }
    }
}

impl<V: fmt::Debug> fmt::Debug for Fields<V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let values = self.values.iter().flatten();
        f.debug_map()
            .entries(values.map(|(field, value)| (field.letter, value)))
            .finish()
    }
}

/// Where a field stands in a vector.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Part {
    length: usize,
    unit: f64,
}

/// The fields of a vector: lengths, one field behind the other, and what their entries are counted in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    parts: Fields<Part>,
}

impl Layout {
    /// Fields with these lengths, in units of 1.
    pub fn new(lengths: impl IntoIterator<Item = (Field, usize)>) -> Self {
        let part = |(field, length)| (field, Part { length, unit: 1.0 });
        Self {
            parts: Fields::new(lengths.into_iter().map(part)),
        }
    }

    /// The same with the entries of a field counted in `unit`.
    #[must_use]
    pub fn counted_in(self, field: Field, unit: f64) -> Self {
        assert!(self.parts.get(field).is_some(), "no field {}", field.letter);
        let counted = |own, part| match own == field {
            true => Part { unit, ..part },
            false => part,
        };
        Self {
            parts: self.parts.map(counted),
        }
    }

    /// The same with a further field behind the others.
    #[must_use]
    pub fn with(self, field: Field, length: usize) -> Self {
        Self {
            parts: self.parts.with(field, Part { length, unit: 1.0 }),
        }
    }

    /// Entries in all.
    pub fn len(&self) -> usize {
        self.parts.iter().map(|(_, part)| part.length).sum()
    }

    /// True when every field is empty.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Length of a field; 0 for one that the vector does not have.
    pub fn length(&self, field: Field) -> usize {
        self.parts.get(field).map_or(0, |part| part.length)
    }

    /// What the entries of a field are counted in.
    pub fn unit(&self, field: Field) -> f64 {
        self.parts[field].unit
    }

    /// The same value for every field.
    pub fn values<V: Copy>(&self, value: V) -> Fields<V> {
        self.parts.map(|_, _| value)
    }

    /// Where the entries of a field stand.
    pub fn range(&self, field: Field) -> Range<usize> {
        let mut start = 0;
        for (own, part) in self.parts.iter() {
            if own == field {
                return start..start + part.length;
            }
            start += part.length;
        }
        panic!("no field {}", field.letter);
    }

    /// Destructures a vector by physics: `let [r_u, r_t] = layout.split([U, T], r);`, whatever other fields there are.
    pub fn split<'v, R, const N: usize>(
        &self,
        fields: [Field; N],
        vector: &'v [R],
    ) -> [&'v [R]; N] {
        assert_eq!(vector.len(), self.len(), "vector does not fit {self:?}");
        fields.map(|field| &vector[self.range(field)])
    }

    /// The same for a writable vector; stops where a field is asked for twice.
    pub fn split_mut<'v, R, const N: usize>(
        &self,
        fields: [Field; N],
        vector: &'v mut [R],
    ) -> [&'v mut [R]; N] {
        assert_eq!(vector.len(), self.len(), "vector does not fit {self:?}");
        match vector.get_disjoint_mut(fields.map(|field| self.range(field))) {
            Ok(parts) => parts,
            Err(_) => panic!("a field twice among {fields:?}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const U: Field = Field {
        letter: "u",
        name: "displacements",
    };
    const T: Field = Field {
        letter: "t",
        name: "tractions",
    };
    const P: Field = Field {
        letter: "p",
        name: "pressures",
    };

    #[test]
    fn a_third_field_leaves_the_others_where_they_are() {
        let two = Layout::new([(U, 3), (T, 2)]).counted_in(T, 1e6);
        let three = two.with(P, 4);
        let x: Vec<usize> = (0..9).collect();
        assert_eq!(two.split([U, T], &x[..5]), [&[0, 1, 2][..], &[3, 4]]);
        assert_eq!(three.split([T, U], &x), [&[3, 4][..], &[0, 1, 2]]);
        assert_eq!(three.split([P], &x), [&[5, 6, 7, 8]]);
        assert_eq!((three.len(), three.length(T), two.length(P)), (9, 2, 0));
        assert_eq!(
            (three.unit(T), three.unit(U), three.range(P)),
            (1e6, 1.0, 5..9)
        );
        let mut y = x.clone();
        let [y_p, y_u] = three.split_mut([P, U], &mut y);
        y_u.copy_from_slice(&y_p[1..]);
        assert_eq!(y, [6, 7, 8, 3, 4, 5, 6, 7, 8]);
    }

    #[test]
    fn values_are_had_by_name() {
        let errors = Layout::new([(U, 0), (T, 0)]).values(1.0).with(P, 0.5);
        assert_eq!(errors[P], 0.5);
        assert_eq!(
            errors.map(|field, value| (field == T, value))[T],
            (true, 1.0)
        );
        assert_eq!(format!("{errors:?}"), r#"{"u": 1.0, "t": 1.0, "p": 0.5}"#);
        let empty = Layout::new([(T, 2), (U, 0), (P, 0)]);
        let mut y = [1, 2];
        let [y_u, y_p, y_t] = empty.split_mut([U, P, T], &mut y);
        assert!(y_u.is_empty() && y_p.is_empty() && y_t.len() == 2);
    }
}
