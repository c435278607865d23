//! Numbers that depend on a seed alone.

/// SplitMix64 (Steele, Lea & Flood, OOPSLA 2014): a case is its seed, its kind and its number, on every machine.
pub(crate) struct Generator(u64);

impl Generator {
    /// Of one case.
    pub(crate) fn new(seed: u64, kind: &str, case: u64) -> Self {
        let mut generator = Self(seed);
        for part in kind.bytes().map(u64::from).chain([case]) {
            generator.0 = generator.next() ^ part;
        }
        generator
    }

    /// 64 random bits.
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Below `n`, which is not 0.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    /// One of a few.
    pub(crate) fn one_of<'a, T: ?Sized>(&mut self, of: &[&'a T]) -> &'a T {
        of[self.below(of.len())]
    }

    /// In [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// True once in `n` times.
    pub(crate) fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }
}
