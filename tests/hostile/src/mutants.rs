//! Mutated files by number, the same every time.

use crate::{files, recipe};
use models::seal;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Bytes of a random recipe; few use all.
const RECIPE_BYTES: usize = 96;

/// Makes a mutant with a checksum that holds: of four, three by a recipe and one by bits flipped
/// anywhere.
pub fn mutant(number: u64) -> Vec<u8> {
    let mut random = ChaCha8Rng::seed_from_u64(number);
    if !number.is_multiple_of(4) {
        let mut bytes = [0; RECIPE_BYTES];
        random.fill_bytes(&mut bytes);
        return recipe::file(&bytes);
    }
    let files = files();
    let mut file = files[random.random_range(0..files.len())].clone();
    for _ in 0..random.random_range(1..=8) {
        let at = random.random_range(0..file.len());
        file[at] ^= 1 << random.random_range(0..8);
    }
    seal(&mut file);
    file
}
