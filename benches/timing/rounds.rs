//! Rounds of one thread and of two in turn: what disturbs a shared machine disturbs both.

use std::fmt;

/// Pools of one thread and of two.
pub fn pools() -> [rayon::ThreadPool; 2] {
    [1, 2].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().expect("threads")
    })
}

/// Values in ascending order.
pub struct Sorted(Vec<f64>);

impl Sorted {
    /// Of at least one value.
    pub fn new(values: impl IntoIterator<Item = f64>) -> Self {
        let mut values: Vec<f64> = values.into_iter().collect();
        values.sort_unstable_by(f64::total_cmp);
        assert!(!values.is_empty(), "no value");
        Self(values)
    }

    /// The middle one.
    pub fn median(&self) -> f64 {
        self.0[self.0.len() / 2]
    }
}

/// Median and range.
impl fmt::Display for Sorted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (least, most) = (self.0[0], self.0[self.0.len() - 1]);
        let digits = f.precision().unwrap_or(2);
        write!(
            f,
            "{:.digits$} ({least:.digits$}–{most:.digits$})",
            self.median()
        )
    }
}
