//! Parts that somebody else brings: each known by its name to scenes, studies and command lines.
//!
//! A family (augmentations, inner solvers, methods, Krylov methods, direct solvers) is an enum of the house's parts with one more
//! variant for a [`Registered`] one, and a [`Registry`] of those.

use serde::{Serialize, Serializer};
use std::fmt::{Debug, Formatter, Result as Formatted};
use std::hash::{Hash, Hasher};
use std::str::FromStr;
use std::sync::{PoisonError, RwLock};

/// A part with a name.
pub trait Named: Debug + Send + Sync {
    /// Plain name.
    fn name(&self) -> &'static str;
}

/// The registered parts of a family, in the order of their registration; it lasts as long as the process.
pub(crate) struct Registry<T: ?Sized + 'static> {
    what: &'static str,
    parts: RwLock<Vec<&'static T>>,
}

/// A name that two parts of a family would share, or that is read as another part's with its settings (`gmres:50`).
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the {what} {name:?} exists already, or is read as another one with its settings; give yours another name"
)]
pub struct NameTaken {
    /// The family.
    pub what: &'static str,
    /// The name.
    pub name: &'static str,
}

impl<T: ?Sized + Named> Registry<T> {
    /// An empty one of a family, named in the singular.
    pub(crate) const fn new(what: &'static str) -> Self {
        Self {
            what,
            parts: RwLock::new(Vec::new()),
        }
    }

    /// Makes a part known, from here on and in every thread; `C` is its family, whose parser must not know the name yet, and find
    /// it whole: settings stand behind `:` and `=`.
    pub(crate) fn register<C: FromStr>(
        &self,
        part: &'static T,
    ) -> Result<Registered<T>, NameTaken> {
        let name = part.name();
        let is_taken = name.contains([':', '=']) || name.parse::<C>().is_ok();
        let mut parts = self.parts.write().unwrap_or_else(PoisonError::into_inner);
        if is_taken || parts.iter().any(|known| known.name() == name) {
            return Err(self.taken(name));
        }
        parts.push(part);
        Ok(Registered(part))
    }

    /// The answer to a name that is not free.
    pub(crate) fn taken(&self, name: &'static str) -> NameTaken {
        let what = self.what;
        NameTaken { what, name }
    }

    /// All of them.
    fn all(&self) -> Vec<Registered<T>> {
        let parts = self.parts.read().unwrap_or_else(PoisonError::into_inner);
        parts.iter().map(|part| Registered(*part)).collect()
    }

    /// The one of this name.
    pub(crate) fn find(&self, name: &str) -> Option<Registered<T>> {
        self.all().into_iter().find(|part| part.0.name() == name)
    }

    /// `, a, b` for lists that name the house's parts before.
    pub(crate) fn names(&self) -> String {
        let all = self.all().into_iter();
        all.map(|part| format!(", {}", part.0.name())).collect()
    }
}

/// A part, known by its name: two are equal where they share it.
pub struct Registered<T: ?Sized + 'static>(pub &'static T);

impl<T: ?Sized> Clone for Registered<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T: ?Sized> Copy for Registered<T> {}

impl<T: ?Sized + Named> Debug for Registered<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> Formatted {
        f.write_str(self.0.name())
    }
}

impl<T: ?Sized + Named> PartialEq for Registered<T> {
    fn eq(&self, other: &Self) -> bool {
        self.0.name() == other.0.name()
    }
}

impl<T: ?Sized + Named> Eq for Registered<T> {}

impl<T: ?Sized + Named> Hash for Registered<T> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.name().hash(state);
    }
}

impl<T: ?Sized + Named> Serialize for Registered<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug)]
    struct Part(&'static str);

    impl Named for Part {
        fn name(&self) -> &'static str {
            self.0
        }
    }

    #[test]
    fn a_part_is_found_by_its_name_which_no_other_takes() {
        /// A parser that knows two names, and one of them with settings.
        struct Family;
        impl FromStr for Family {
            type Err = ();

            fn from_str(name: &str) -> Result<Self, ()> {
                let known = ["own", "own 50"].contains(&name);
                known.then_some(Self).ok_or(())
            }
        }
        static PARTS: Registry<Part> = Registry::new("part");
        static MINE: Part = Part("mine");
        let mine = PARTS.register::<Family>(&MINE).unwrap();
        assert_eq!(PARTS.find("mine"), Some(mine));
        assert_eq!(PARTS.find("own"), None);
        assert_eq!(PARTS.names(), ", mine");
        assert_eq!(serde_json::to_string(&mine).unwrap(), "\"mine\"");
        static OTHERS: [Part; 4] = [Part("own"), Part("own 50"), Part("mine:50"), Part("a=b")];
        for taken in OTHERS.iter().chain([&MINE]) {
            let error = PARTS.register::<Family>(taken).unwrap_err().to_string();
            let expected = format!(
                "the part {:?} exists already, or is read as another one with its settings; give yours another name",
                taken.0
            );
            assert_eq!(error, expected);
        }
    }
}
