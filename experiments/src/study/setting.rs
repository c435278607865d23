//! What a row is made of, as far as it is said.

use super::axes::flatten;
use super::{Choice, Inner, Load, State, Tolerance};
use fracas_solvers::krylov::KrylovChoice;
use fracas_solvers::saddle::{AugmentationChoice, SaddleMethod};
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;
use std::num::NonZeroU32;
use toml::{Table, Value};

macro_rules! settings {
    ($($(#[$doc:meta])* $field:ident: $kind:ty,)*) => {
        /// Keys of a row; a variant of `[[axes.together]]` says some of them.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct Setting {
            /// Of the variant.
            pub name: String,
            /// Keys of the scene.
            #[serde(skip_serializing_if = "BTreeMap::is_empty", deserialize_with = "flat")]
            pub set: BTreeMap<String, Value>,
            $($(#[$doc])* #[serde(skip_serializing_if = "Option::is_none")] pub $field: Option<$kind>,)*
        }

        impl Setting {
            /// Takes over what another one says.
            pub(super) fn take(&mut self, other: &Self) {
                self.set.extend(other.set.clone());
                $(if other.$field.is_some() { self.$field.clone_from(&other.$field); })*
            }

            /// Keys that are said.
            pub(super) fn said(&self) -> Vec<&'static str> {
                let mut said = Vec::new();
                $(if self.$field.is_some() { said.push(stringify!($field)); })*
                said
            }
        }
    };
}

settings! {
    /// A scene file, or a name of the gallery.
    scene: String,
    /// A system folder.
    system: String,
    /// Factor on every cell count of the grid.
    refine: NonZeroU32,
    /// Contact state.
    state: State,
    /// Factor of H.
    stabilization: f64,
    /// Right-hand side.
    rhs: Choice<Load>,
    /// Preconditioner of the whole system.
    method: Choice<SaddleMethod>,
    /// C.
    augmentation: Choice<AugmentationChoice>,
    /// Solver of the displacement block.
    inner: Choice<Inner>,
    /// Iteration.
    krylov: Choice<KrylovChoice>,
    /// Tolerance.
    tolerance: Tolerance,
    /// Threads of the row.
    threads: u16,
    /// Unknowns above which the row is not tried.
    largest: usize,
    /// Unknowns up to which all eigenvalues are found.
    dense: usize,
    /// `published` or `solve`, as of the study.
    counts: super::Counts,
    /// Without an assembled 𝒜, where counts are those of published tables.
    matrix_free: bool,
    /// Everything in f32: products, vectors, scalar products.
    single: bool,
    /// Repetitions of the iteration, whose least time counts.
    repetitions: usize,
    /// Whether rows of slip and opening are eliminated before RACP.
    eliminate: bool,
}

pub(super) fn flat<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<BTreeMap<String, Value>, D::Error> {
    let mut flat = BTreeMap::new();
    flatten(&Table::deserialize(deserializer)?, "", &mut |key, value| {
        flat.insert(key, value.clone());
    });
    Ok(flat)
}
