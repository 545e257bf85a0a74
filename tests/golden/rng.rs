//! Seeded numbers and poses, computed with integers and the runtime's arithmetic: equal on all
//! CPUs.

use sinew_runtime::LocalTransform;

/// SplitMix64 (Steele, Lea, Flood 2014).
pub struct Rng(pub u64);

impl Rng {
    /// Returns the next 64 bits.
    pub fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Returns a uniform number in [-1, 1), a multiple of 2^-23.
    pub fn unit(&mut self) -> f32 {
        (self.next_u64() >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    /// Returns a local transform with a rotation of roughly up to `turn` times π.
    pub fn local(&mut self, turn: f32) -> LocalTransform {
        let mut unit = || self.unit() * turn;
        let rotation = [unit(), unit(), unit(), 0.5];
        LocalTransform { rotation, translation: [1.0, unit() * 0.125, unit() * 0.125] }
    }
}
