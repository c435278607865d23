//! Numbers without a pattern that are the same on every machine and for any number of threads.

/// Scrambled bits of a number: SplitMix64 as a hash of its argument.
///
/// # Source
/// Steele, Lea, Flood, OOPSLA 2014.
pub fn splitmix64(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Uniform in [−1, 1), from the upper 53 bits of [`splitmix64`].
pub fn signed(value: u64) -> f64 {
    (splitmix64(value) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// The generator SplitMix64: a case is its seed, on every machine.
///
/// # Source
/// Steele, Lea, Flood, OOPSLA 2014.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Random(u64);

impl Random {
    /// From a seed; near seeds give unlike numbers.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// 64 bits.
    pub fn bits(&mut self) -> u64 {
        let bits = splitmix64(self.0);
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        bits
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// In [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// In [low, high), both positive, the logarithm spread evenly.
    pub fn scale(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    /// From low to high, both included.
    pub fn whole(&mut self, low: u32, high: u32) -> u32 {
        low + (f64::from(high - low + 1) * self.unit()) as u32
    }

    /// Below n, which is not 0.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// True with this probability.
    pub fn chance(&mut self, share: f64) -> bool {
        self.unit() < share
    }

    /// True once in n times.
    pub fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// One of a few.
    pub fn one_of<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stay_where_they_are_asked_for() {
        let r = &mut Random::new(0);
        assert_eq!(r.bits(), 0xe220_a839_7b1d_cdaf);
        assert_eq!(r.bits(), 0x6e78_9e6a_a1b9_65f4);
        let mut seen = [0; 3];
        for _ in 0..3000 {
            assert!((2.0..3.0).contains(&r.between(2.0, 3.0)));
            assert!((0.01..100.0).contains(&r.scale(0.01, 100.0)));
            seen[r.whole(4, 6) as usize - 4] += 1;
            assert!(r.below(7) < 7 && [1, 5].contains(&r.one_of(&[1, 5])));
        }
        assert!(seen.iter().all(|n| *n > 800), "{seen:?}");
    }

    #[test]
    fn the_first_numbers_of_the_published_generator() {
        // its state starts at 0 and grows by the constant that the hash adds
        assert_eq!(splitmix64(0), 0xe220_a839_7b1d_cdaf);
        assert_eq!(splitmix64(0x9e37_79b9_7f4a_7c15), 0x6e78_9e6a_a1b9_65f4);
    }

    /// White: no wave of the sum of n numbers stands out, as it would for values along a grid line that repeat a pattern.
    #[test]
    fn no_wave_stands_out() {
        let n = 4096;
        let values: Vec<f64> = (0..n).map(signed).collect();
        assert!(values.iter().all(|v| (-1.0..1.0).contains(v)));
        let power = |k: u64| {
            let turn = |i: usize| std::f64::consts::TAU * (k * i as u64 % n) as f64 / n as f64;
            let (re, im) = values.iter().enumerate().fold((0.0, 0.0), |s, (i, v)| {
                (s.0 + v * turn(i).cos(), s.1 + v * turn(i).sin())
            });
            (re * re + im * im) / n as f64
        };
        // 1/3 in the mean, exponentially distributed
        assert!((0..n).all(|k| power(k) < 5.0));
    }
}
