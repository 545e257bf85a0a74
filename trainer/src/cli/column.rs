//! Columns of text, as a terminal shows them.

use super::printable;
use unicode_width::{UnicodeWidthChar, UnicodeWidthStr};

/// Columns that text is wrapped to on a wider terminal, or where there is none: longer lines are hard to read.
pub(super) const COLUMNS: usize = 100;

/// Measures a name in columns of a terminal, of which some characters take two and some none.
pub(super) fn width(name: &str) -> usize {
    printable(name).width()
}

/// Returns the columns of the longest name, from `least` to `most`; [`padded`] shortens longer names.
pub(super) fn longest<'a>(
    names: impl IntoIterator<Item = &'a str>,
    least: usize,
    most: usize,
) -> usize {
    names.into_iter().map(width).fold(least, usize::max).min(most)
}

/// Fills a name up to `columns`, or shortens it in the middle, where fewer names differ than at their ends.
pub(super) fn padded(name: &str, columns: usize) -> String {
    let name = shortened(&printable(name), columns);
    let missing = columns.saturating_sub(name.width());
    name + &" ".repeat(missing)
}

/// Leaves a mark in the middle of a name that takes more than `columns`.
fn shortened(name: &str, columns: usize) -> String {
    if name.width() <= columns {
        return name.to_owned();
    }
    let room = columns.saturating_sub(1);
    let first: String = fitting(name.chars(), room / 3).collect();
    let last: Vec<char> = fitting(name.chars().rev(), room - first.width()).collect();
    first + "…" + &last.into_iter().rev().collect::<String>()
}

/// Takes characters as long as they fit.
fn fitting(characters: impl Iterator<Item = char>, columns: usize) -> impl Iterator<Item = char> {
    let mut taken = 0;
    characters.take_while(move |character| {
        taken += character.width().unwrap_or(0);
        taken <= columns
    })
}

/// Wraps lines of prose at the terminal's width, at most at [`COLUMNS`].
pub(super) fn wrapped(text: &str) -> String {
    let terminal = terminal_size::terminal_size_of(std::io::stdout());
    let columns = terminal.map_or(COLUMNS, |(width, _)| COLUMNS.min(width.0.into()));
    text.lines().map(|line| wrapped_at(line, columns)).collect()
}

/// Wraps a line between its words. What follows the first line stands two columns further in.
fn wrapped_at(line: &str, columns: usize) -> String {
    let words = line.trim_start();
    let indent = line.len() - words.len();
    let (mut out, mut taken) = (" ".repeat(indent), indent);
    for (number, word) in words.split(' ').enumerate() {
        if number > 0 && taken + 1 + word.width() > columns {
            out += "\n";
            out += &" ".repeat(indent + 2);
            taken = indent + 2;
        } else if number > 0 {
            out += " ";
            taken += 1;
        }
        out += word;
        taken += word.width();
    }
    out + "\n"
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
        }
    }

    #[test]
    fn prose_is_wrapped_between_words() {
        let line = "  note: three triangles fold";
        assert_eq!(wrapped_at(line, 28), format!("{line}\n"));
        assert_eq!(wrapped_at(line, 27), "  note: three triangles\n    fold\n");
        assert_eq!(wrapped_at(line, 12), "  note:\n    three\n    triangles\n    fold\n");
        assert_eq!(wrapped_at("左腕 左腕", 8), "左腕\n  左腕\n");
        assert_eq!(wrapped("advice\n  none\n"), "advice\n  none\n");
    }

    #[test]
    fn long_names_are_shortened_in_the_middle() {
        assert_eq!(padded("character:rig:left_forearm_01", 16), "chara…forearm_01");
        assert_eq!(padded("左腕".repeat(9).as_str(), 8), "左…左腕 ");
        assert_eq!(longest(["arm", "character:rig:left_forearm_01"], 5, 16), 16);
        assert_eq!(longest(["arm"], 5, 16), 5);
    }
}
