//! Tests golden files, and a file of several parts, that are cut short, lengthened, or flipped bit
//! by bit.

use hostile::poses::KINDS;
use hostile::recipe::mutant;
use hostile::{files, targets};
use models::seal;
use sinew_runtime::format::CHECKSUM_OFFSET;
use sinew_runtime::{FileError, FileErrorKind, Model};

fn refusal(file: &[u8]) -> Option<FileError> {
    Model::from_bytes(file).err()
}

fn kind(file: &[u8]) -> Option<FileErrorKind> {
    refusal(file).map(|error| error.kind)
}

#[test]
fn every_truncation_is_refused() {
    for golden in files() {
        assert_eq!(targets::run(golden), Ok(()));
        for len in 0..golden.len() {
            let mut short = golden[..len].to_vec();
            assert_eq!(kind(&short), Some(FileErrorKind::Truncated), "{len}");
            seal(&mut short);
            assert_eq!(kind(&short), Some(FileErrorKind::Truncated), "{len}");
        }
    }
}

#[test]
fn extra_bytes_are_refused() {
    for golden in files() {
        for extra in [&[0][..], &[0; 16], &[0xff; 300], golden] {
            let mut long = [golden.as_slice(), extra].concat();
            assert_eq!(kind(&long), Some(FileErrorKind::Checksum));
            seal(&mut long);
            assert_eq!(kind(&long), Some(FileErrorKind::Malformed));
        }
    }
}

#[test]
fn every_flipped_bit_is_refused_and_harmless_when_sealed() {
    for golden in files() {
        let mut accepted = 0;
        let mut file = golden.clone();
        // The file of several parts takes as long as all others together: flips one bit per byte,
        // in turn.
        let several = golden.len() > 20_000;
        let is_flipped = |bit: &usize| !several || (bit / 8 + bit / 32) % 8 == bit % 8;
        for bit in (0..8 * golden.len()).filter(is_flipped) {
            file.copy_from_slice(golden);
            file[bit / 8] ^= 1 << (bit % 8);
            match refusal(&file) {
                // The refusal reports the computed checksum: no need to compute it again.
                Some(FileError { kind: FileErrorKind::Checksum, found, .. }) => {
                    file[CHECKSUM_OFFSET..][..4].copy_from_slice(&found.to_le_bytes());
                }
                Some(_) => seal(&mut file),
                None => panic!("bit {bit} may be flipped"),
            }
            // One kind of pose per bit, in turn: neighbouring bits have similar effects.
            accepted +=
                usize::from(targets::run_poses(&file, bit % KINDS..bit % KINDS + 1).is_ok());
        }
        // Most bits of most floats may change, so the second half of the test has evaluated many
        // files.
        let least = if several { golden.len() / 3 } else { 3 * golden.len() };
        assert!(accepted > least, "{accepted}");
    }
}

#[test]
fn mutants_are_harmless() {
    let accepted = (0..20_000).filter(|&number| targets::run(&mutant(number)).is_ok()).count();
    // The first of the million files of `mutants`; too few accepted files would prove too little.
    assert!(accepted > 4_000, "{accepted}");
}
