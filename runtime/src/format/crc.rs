//! CRC-32 (ISO-HDLC): polynomial 0x04C11DB7 reflected, start and final XOR all ones.

/// Computes the checksum of several slices in order, 16 bytes at a time, with tables of 16 KiB.
#[cfg(not(target_os = "none"))]
pub(crate) fn of(parts: &[&[u8]]) -> u32 {
    static CRC: ::crc::Crc<u32, ::crc::Table<16>> =
        ::crc::Crc::<u32, ::crc::Table<16>>::new(&::crc::CRC_32_ISO_HDLC);
    let mut digest = CRC.digest();
    parts.iter().for_each(|part| digest.update(part));
    digest.finalize()
}

/// Computes the checksum of several slices in order, four bits at a time, with a table of 64 bytes.
/// Bare targets have little flash, and load a file only once.
#[cfg(any(target_os = "none", test))]
pub(crate) fn by_nibbles(parts: &[&[u8]]) -> u32 {
    const TABLE: [u32; 16] = {
        let mut table = [0; 16];
        let mut nibble = 0;
        while nibble < 16 {
            let (mut rest, mut bit) = (nibble as u32, 0);
            while bit < 4 {
                rest = if rest & 1 == 1 { (rest >> 1) ^ 0xedb8_8320 } else { rest >> 1 };
                bit += 1;
            }
            table[nibble] = rest;
            nibble += 1;
        }
        table
    };
    // Not inlined: unrolling would make the loop ten times as long.
    #[inline(never)]
    fn step(sum: u32, byte: u8) -> u32 {
        let next = |sum: u32| {
            let at = sum & 15;
            (sum >> 4) ^ TABLE.get(at as usize).copied().unwrap_or_default()
        };
        next(next(sum ^ u32::from(byte)))
    }
    parts.iter().copied().flatten().fold(u32::MAX, |sum, byte| step(sum, *byte)) ^ u32::MAX
}

#[cfg(target_os = "none")]
pub(crate) use by_nibbles as of;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_give_the_check_value_of_the_catalogue() {
        for of in [of, by_nibbles] {
            assert_eq!(of(&[b"123456789"]), 0xcbf4_3926);
            assert_eq!(of(&[b"1234", b"", b"56789"]), 0xcbf4_3926);
            assert_eq!(of(&[]), 0);
        }
    }
}
