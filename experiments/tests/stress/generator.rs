//! The generator of a case.

use fracas_operators::random::Random;

/// Of one case, which is a seed, its kind and its number.
pub(crate) fn generator(seed: u64, kind: &str, case: u64) -> Random {
    let mixed = kind.bytes().map(u64::from).chain([case]);
    Random::new(mixed.fold(seed, |state, part| Random::new(state).bits() ^ part))
}
