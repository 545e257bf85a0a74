//! Names in a file: the part's name, then the names of its components.

use crate::linear::Le;

/// The ends of all names, and the text that they index.
#[derive(Clone, Copy)]
pub(crate) struct Names<'a> {
    ends: &'a [Le],
    text: &'a [u8],
}

impl<'a> Names<'a> {
    /// Splits section `names` of a part with `len` names.
    pub(crate) fn new(bytes: &'a [u8], len: usize) -> Self {
        let (ends, text) = bytes.split_at_checked(len.saturating_mul(4)).unwrap_or_default();
        Self { ends: ends.as_chunks().0, text }
    }

    /// Returns a name.
    pub(crate) fn get(&self, index: usize) -> Option<&'a str> {
        let end = |i: usize| self.ends.get(i).map(|le| u32::from_le_bytes(*le) as usize);
        let start = match index.checked_sub(1) {
            None => 0,
            Some(before) => end(before)?,
        };
        core::str::from_utf8(self.text.get(start..end(index)?)?).ok()
    }

    /// Finds the first name that is not UTF-8 or does not follow the previous name. The last name
    /// must end with the text.
    pub(crate) fn first_invalid(&self) -> Option<usize> {
        let last = self.ends.len().saturating_sub(1);
        let mut start = 0;
        self.ends.iter().map(|le| u32::from_le_bytes(*le) as usize).enumerate().position(
            |(index, end)| {
                let whole = index != last || end == self.text.len();
                let text = self.text.get(start..end).filter(|_| whole);
                start = end;
                text.is_none_or(|text| core::str::from_utf8(text).is_err())
            },
        )
    }
}
