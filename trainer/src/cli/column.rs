//! Columns of text, as a terminal shows them.

use super::printable;
use unicode_width::UnicodeWidthStr;

/// Measures a name in columns of a terminal, of which some characters take two and some none.
pub(super) fn width(name: &str) -> usize {
    printable(name).width()
}

/// Fills a name up to so many columns.
pub(super) fn padded(name: &str, columns: usize) -> String {
    let name = printable(name);
    let missing = columns.saturating_sub(name.width());
    name + &" ".repeat(missing)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_all_scripts_fill_one_column() {
        // Two columns a character; a letter and its accent, one; a control character that is escaped.
        for (name, columns) in [("arm", 3), ("左腕", 4), ("e\u{301}", 1), ("\u{1b}", 6)] {
            assert_eq!(width(name), columns, "{name}");
            assert_eq!(width(&padded(name, 8)), 8, "{name}");
            assert_eq!(padded(name, 0), printable(name), "never cut");
        }
    }
}
