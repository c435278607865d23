//! Physical groups: numbers, names, and which elements carry them.

use std::collections::{BTreeSet, HashMap};
use std::fmt;

use super::GmshDefect;
use crate::nearest::nearest;

/// How a scene calls a physical group.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum GroupName {
    /// By its name.
    Name(String),
    /// By its number.
    Number(i32),
}

impl fmt::Display for GroupName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name(name) => write!(f, "\"{name}\""),
            Self::Number(number) => write!(f, "{number}"),
        }
    }
}

/// What a physical group of each dimension is called.
pub(super) const DIMENSIONS: [&str; 4] = ["point", "curve", "surface", "volume"];

/// A line of $PhysicalNames.
#[derive(Clone, Debug)]
struct Named {
    dimension: u8,
    number: i32,
    name: String,
}

/// The physical groups of a file; elements refer to sets of them.
#[derive(Clone, Debug)]
pub(super) struct Groups {
    names: Vec<Named>,
    sets: Vec<Vec<i32>>,
    places: HashMap<Vec<i32>, u32>,
    /// (dimension, number) of groups that elements carry.
    present: BTreeSet<(u8, i32)>,
}

impl Groups {
    /// No group; set 0 is the empty one.
    pub(super) fn new() -> Self {
        Self {
            names: Vec::new(),
            sets: vec![Vec::new()],
            places: HashMap::from([(Vec::new(), 0)]),
            present: BTreeSet::new(),
        }
    }

    /// A line of $PhysicalNames.
    pub(super) fn call(&mut self, dimension: u8, number: i32, name: String) {
        self.names.push(Named {
            dimension,
            number,
            name,
        });
    }

    /// The set of these groups of elements of a dimension; a sign is an orientation, and 0 is no group.
    pub(super) fn set(&mut self, dimension: u8, numbers: impl Iterator<Item = i32>) -> u32 {
        let mut numbers: Vec<i32> = numbers.map(i32::saturating_abs).collect();
        numbers.retain(|n| *n != 0);
        numbers.sort_unstable();
        numbers.dedup();
        let groups = numbers.iter().map(|number| (dimension, *number));
        self.present.extend(groups);
        if let Some(place) = self.places.get(&numbers) {
            return *place;
        }
        let place = self.sets.len() as u32;
        self.sets.push(numbers.clone());
        self.places.insert(numbers, place);
        place
    }

    /// The groups of a set, increasing.
    pub(super) fn of(&self, set: u32) -> &[i32] {
        &self.sets[set as usize]
    }

    /// Whether a set has one of these groups.
    pub(super) fn touches(&self, set: u32, numbers: &[i32]) -> bool {
        self.of(set).iter().any(|n| numbers.contains(n))
    }

    /// The set of all groups of two.
    pub(super) fn union(&mut self, dimension: u8, a: u32, b: u32) -> u32 {
        let both = [self.of(a), self.of(b)].concat();
        self.set(dimension, both.into_iter())
    }

    /// Name of a group, or its number.
    pub(super) fn name(&self, dimension: u8, number: i32) -> GroupName {
        let mut named = self.names.iter();
        let found = named.find(|n| (n.dimension, n.number) == (dimension, number));
        found.map_or(GroupName::Number(number), |n| {
            GroupName::Name(n.name.clone())
        })
    }

    /// Numbers that a name stands for, with their dimensions.
    fn meant(&self, name: &GroupName) -> Vec<(u8, i32)> {
        let named = self.names.iter().map(|n| (n.dimension, n.number));
        match name {
            GroupName::Name(name) => named
                .zip(&self.names)
                .filter(|(_, n)| n.name == *name)
                .map(|(group, _)| group)
                .collect(),
            GroupName::Number(number) => {
                let mut groups = self.present.clone();
                groups.extend(named);
                groups.into_iter().filter(|g| g.1 == *number).collect()
            }
        }
    }

    /// Numbers of the groups of this dimension with this name: files that were joined have several.
    ///
    /// # Errors
    /// [`GmshDefect::UnknownGroup`] with the nearest name, [`GmshDefect::WrongDimension`].
    pub(super) fn find(&self, dimension: u8, name: &GroupName) -> Result<Vec<i32>, GmshDefect> {
        let meant = self.meant(name);
        let here = meant.iter().filter(|g| g.0 == dimension);
        let numbers: Vec<i32> = here.map(|(_, number)| *number).collect();
        if !numbers.is_empty() {
            return Ok(numbers);
        }
        let expected = DIMENSIONS[usize::from(dimension)];
        if let Some((other, _)) = meant.first() {
            return Err(GmshDefect::WrongDimension {
                name: name.clone(),
                found: DIMENSIONS[usize::from(*other)],
                expected,
            });
        }
        let mut all = self.present.clone();
        all.extend(self.names.iter().map(|n| (n.dimension, n.number)));
        let here = all.into_iter().filter(|g| g.0 == dimension);
        let known: Vec<GroupName> = here.map(|(d, number)| self.name(d, number)).collect();
        let text = |name: &GroupName| match name {
            GroupName::Name(name) => name.clone(),
            GroupName::Number(number) => number.to_string(),
        };
        let names: Vec<String> = known.iter().map(text).collect();
        let close = nearest(&text(name), &names);
        let place = close.and_then(|close| names.iter().position(|n| *n == close));
        Err(GmshDefect::UnknownGroup {
            dimension: expected,
            name: name.clone(),
            nearest: place.map(|place| known[place].clone()),
            known,
        })
    }
}
