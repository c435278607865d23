//! From the node numbers of a file to their places in the list.

use std::collections::HashMap;

/// Places of node numbers: a table where the numbers are dense, else a map.
#[derive(Clone, Debug)]
pub(super) enum Tags {
    /// 1 + place, or 0.
    Table(Vec<u32>),
    /// Place.
    Map(HashMap<u64, u32>),
}

/// Table entries per node that are still worth their memory.
const SPREAD: u64 = 8;

impl Tags {
    /// Of `tags` in order.
    ///
    /// # Errors
    /// The first number that is there twice.
    pub(super) fn new(tags: &[u64]) -> Result<Self, u64> {
        let last = tags.iter().copied().max().unwrap_or(0);
        let places = || (0u32..).zip(tags);
        if last <= SPREAD * tags.len() as u64 {
            let mut table = vec![0u32; last as usize + 1];
            for (place, tag) in places() {
                let entry = &mut table[*tag as usize];
                if *entry != 0 {
                    return Err(*tag);
                }
                *entry = place + 1;
            }
            return Ok(Self::Table(table));
        }
        let mut map = HashMap::with_capacity(tags.len());
        for (place, tag) in places() {
            if map.insert(*tag, place).is_some() {
                return Err(*tag);
            }
        }
        Ok(Self::Map(map))
    }

    /// Place of a number.
    pub(super) fn place(&self, tag: u64) -> Option<u32> {
        match self {
            Self::Table(table) => table.get(usize::try_from(tag).ok()?)?.checked_sub(1),
            Self::Map(map) => map.get(&tag).copied(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Tags;

    #[test]
    fn dense_and_sparse_numbers_are_found_and_repeated_ones_named() {
        for factor in [1, 1_000_000_007] {
            let tags: Vec<u64> = [7, 3, 9, 1].map(|t| t * factor).into();
            let found = Tags::new(&tags).unwrap();
            for (place, tag) in tags.iter().enumerate() {
                assert_eq!(found.place(*tag), Some(place as u32));
                assert_eq!(found.place(tag + 1), None);
            }
            let twice: Vec<u64> = tags.iter().chain(&tags[1..2]).copied().collect();
            assert_eq!(Tags::new(&twice).unwrap_err(), 3 * factor);
        }
        assert!(matches!(Tags::new(&[1, 2]).unwrap(), Tags::Table(_)));
        assert!(matches!(Tags::new(&[1, 1000]).unwrap(), Tags::Map(_)));
    }
}
