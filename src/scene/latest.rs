//! Numbers of one time that are asked for more than once.

use std::sync::{Arc, Mutex, PoisonError};

/// What was found for the last time that was asked for; a copy begins empty.
#[derive(Debug, Default)]
pub(crate) struct Latest(Mutex<Option<(f64, Arc<[f64]>)>>);

impl Latest {
    /// The numbers at a time [s], made where they are not those at hand.
    pub(crate) fn at(&self, time: f64, make: impl FnOnce() -> Vec<f64>) -> Arc<[f64]> {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match &*known {
            Some((of, numbers)) if *of == time => numbers.clone(),
            _ => {
                // the old ones go before the new ones come
                *known = None;
                let numbers: Arc<[f64]> = make().into();
                *known = Some((time, numbers.clone()));
                numbers
            }
        }
    }
}

impl Clone for Latest {
    fn clone(&self) -> Self {
        Self::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_made_once_per_time() {
        let latest = Latest::default();
        let mut made = Vec::new();
        for time in [0.0, 0.0, 2.0, 2.0, 0.0] {
            let found = latest.at(time, || {
                made.push(time);
                vec![time + 1.0]
            });
            assert_eq!(*found, [time + 1.0]);
        }
        assert_eq!(made, [0.0, 2.0, 0.0]);
    }
}
