//! Sections and symbols of an image: an ELF file of 32 bits, little-endian.

use std::path::Path;

/// An image.
pub(super) struct Elf {
    bytes: Vec<u8>,
    sections: Vec<Section>,
}

struct Section {
    kind: u32,
    flags: u32,
    offset: usize,
    bytes: usize,
    link: usize,
}

const PROGRAM: u32 = 1;
const SYMBOLS: u32 = 2;
const ZEROED: u32 = 8;
const WRITABLE: u32 = 1;
const LOADED: u32 = 2;

impl Elf {
    /// Reads an image.
    pub(super) fn read(path: &Path) -> Result<Self, String> {
        let bytes = std::fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
        Self::parse(bytes).ok_or_else(|| format!("{}: no ELF file of 32 bits", path.display()))
    }

    fn parse(bytes: Vec<u8>) -> Option<Self> {
        if !bytes.starts_with(b"\x7fELF\x01\x01") {
            return None;
        }
        let (table, row_bytes, rows) = (word(&bytes, 32)?, half(&bytes, 46)?, half(&bytes, 48)?);
        let section = |row: usize| {
            let at = table + row * row_bytes;
            Some(Section {
                kind: word(&bytes, at + 4)? as u32,
                flags: word(&bytes, at + 8)? as u32,
                offset: word(&bytes, at + 16)?,
                bytes: word(&bytes, at + 20)?,
                link: word(&bytes, at + 24)?,
            })
        };
        let sections = (0..rows).map(section).collect::<Option<_>>()?;
        Some(Self { bytes, sections })
    }

    /// Counts the bytes in flash: code and constants.
    pub(super) fn loaded_bytes(&self) -> u64 {
        let loaded = |s: &&Section| s.kind == PROGRAM && s.flags & LOADED != 0;
        self.sections.iter().filter(loaded).map(|s| s.bytes as u64).sum()
    }

    /// Counts the bytes in static RAM.
    pub(super) fn ram_bytes(&self) -> u64 {
        let held = |s: &&Section| {
            [PROGRAM, ZEROED].contains(&s.kind)
                && s.flags & (LOADED | WRITABLE) == LOADED | WRITABLE
        };
        self.sections.iter().filter(held).map(|s| s.bytes as u64).sum()
    }

    /// Lists symbols of an allocator, Rust's or C's.
    pub(super) fn allocator(&self) -> Vec<String> {
        let of_allocator = |name: &&str| {
            // `__rust_alloc` and related functions, whichever crate implements them, and the growth
            // code of `Vec` and `Box`.
            let rust = ["__rust_", "__rg_", "__rdl_", "GlobalAlloc", "RawVec"];
            ["malloc", "free", "realloc", "calloc"].contains(name)
                || rust.iter().any(|part| name.contains(part))
        };
        self.symbols().filter(of_allocator).map(str::to_owned).collect()
    }

    fn symbols(&self) -> impl Iterator<Item = &str> {
        let tables = self.sections.iter().filter(|s| s.kind == SYMBOLS);
        tables.flat_map(move |table| {
            let names = self.sections.get(table.link).map_or(0, |names| names.offset);
            let rows = (table.offset..table.offset + table.bytes).step_by(16);
            rows.filter_map(move |row| {
                let name = self.bytes.get(names + word(&self.bytes, row)?..)?;
                std::str::from_utf8(name.split(|&byte| byte == 0).next()?).ok()
            })
        })
    }
}

fn word(bytes: &[u8], at: usize) -> Option<usize> {
    Some(u32::from_le_bytes(bytes.get(at..)?.first_chunk().copied()?) as usize)
}

fn half(bytes: &[u8], at: usize) -> Option<usize> {
    Some(u16::from_le_bytes(bytes.get(at..)?.first_chunk().copied()?).into())
}
