//! Fingerprints of frames (METHOD §1.12) and of files.

use super::Examples;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Distances between paired vertices in vertex order, as fractions of V; one per number of a mark.
const APART: [f64; 4] = [1.0 / 2.0, 1.0 / 3.0, 1.0 / 7.0, 1.0 / 17.0];
/// Tolerance of equal marks, relative to the diagonal: covers rounding to f32 and to text with six digits.
const SAME: f64 = 1e-6;

/// A fingerprint of a posed mesh that does not depend on axes and unit.
pub type Mark = [f32; APART.len()];

impl Examples {
    /// Computes the mark of a frame. Each number is the RMS distance between vertices and their partners at a fixed
    /// distance in vertex order, relative to the rest diagonal.
    ///
    /// # Panics
    /// If `frame` is not a frame.
    pub fn mark(&self, frame: usize) -> Mark {
        let (posed, diagonal) = (self.frame(frame), self.diagonal());
        APART.map(|share| {
            let apart = ((share * posed.len() as f64) as usize).max(1);
            let pairs = posed.iter().zip(posed.iter().cycle().skip(apart));
            let squared = |(a, b): (&[f64; 3], &[f64; 3])| -> f64 {
                a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum()
            };
            let mean = pairs.map(squared).sum::<f64>() / posed.len().max(1) as f64;
            (mean.sqrt() / diagonal.max(f64::MIN_POSITIVE)) as f32
        })
    }
}

/// Returns whether two marks agree within the tolerance.
pub fn is_same(a: &Mark, b: &Mark) -> bool {
    a.iter().zip(b).all(|(a, b)| f64::from(a - b).abs() <= SAME)
}

/// Hashes the bytes of a file with SHA-256, as 64 lower-case hexadecimal digits.
///
/// # Errors
/// Errors of opening or reading the file.
pub fn hash_file(path: &Path) -> io::Result<String> {
    let mut file = File::open(path)?;
    let mut hasher = Sha256::new();
    let mut block = vec![0; 1 << 16];
    while let read @ 1.. = file.read(&mut block)? {
        hasher.update(&block[..read]);
    }
    Ok(hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::super::testing::triangle;
    use super::*;

    #[test]
    fn marks_do_not_depend_on_axes_and_unit() {
        let mut examples = triangle(2);
        examples.vertices[3][0] += 0.01;
        let [first, second] = [0, 1].map(|frame| examples.mark(frame));
        assert!(!is_same(&first, &second));
        let turned = |[x, y, z]: [f64; 3]| [100.0 * z, -100.0 * x, 100.0 * y];
        examples.rest = examples.rest.iter().copied().map(turned).collect();
        examples.vertices = examples.vertices.iter().copied().map(turned).collect();
        assert!(is_same(&first, &examples.mark(0)) && is_same(&second, &examples.mark(1)));
    }

    #[test]
    fn hashes_agree_with_the_published_vector() {
        let path = std::env::temp_dir().join(format!("sinew-hash-{}", std::process::id()));
        std::fs::write(&path, "abc").unwrap();
        let hash = hash_file(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(hash, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }

    #[test]
    fn hashing_a_missing_file_is_an_error() {
        assert!(hash_file(Path::new("no such file")).is_err());
    }
}
