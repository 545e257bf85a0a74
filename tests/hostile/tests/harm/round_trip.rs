//! What the trainer bakes of random descriptions comes back.

use hostile::round_trip::round_trip;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

#[test]
fn descriptions_come_back() {
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let baked = |random: &mut ChaCha8Rng| {
        let mut data = vec![0; random.random_range(0..8192)];
        random.fill_bytes(&mut data);
        round_trip(&data)
    };
    let refused: Vec<_> = (0..500).filter_map(|_| baked(&mut random).err()).collect();
    assert!(refused.is_empty(), "{} of 500 refused, first {}", refused.len(), refused[0]);
}
