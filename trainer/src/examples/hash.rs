//! Fingerprints of input files.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use sha2::{Digest, Sha256};

/// Hashes the bytes of a file with SHA-256, as 64 lower-case hexadecimal digits.
///
/// # Errors
/// Whatever opening or reading the file says.
pub fn hash_file(path: &Path) -> io::Result<String> {
    let mut file = File::open(path)?;
    let mut hasher = Sha256::new();
    let mut block = vec![0; 1 << 16];
    loop {
        let read = file.read(&mut block)?;
        if read == 0 {
            break;
        }
        hasher.update(&block[..read]);
    }
    Ok(hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_published_vector() {
        let path = std::env::temp_dir().join(format!("sinew-hash-{}", std::process::id()));
        std::fs::write(&path, "abc").unwrap();
        let hash = hash_file(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(hash, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }

    #[test]
    fn says_when_there_is_no_file() {
        assert!(hash_file(Path::new("no such file")).is_err());
    }
}
