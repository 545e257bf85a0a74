//! Results of commands. A [`Report`] is printed as a table or as JSON, so both hold the same figures.

use super::files::{self, OutputFile};
use super::output::{Output, printable};
use anyhow::{Context, bail};
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::io::{ErrorKind, Write};
use unicode_width::{UnicodeWidthChar, UnicodeWidthStr};

/// Maximum width of text, in columns: longer lines are hard to read.
pub(super) const COLUMNS: usize = 100;

/// Command of the command line.
pub(super) trait Run {
    /// Runs the command and returns its result.
    ///
    /// # Errors
    /// Bad input, or a file that cannot be written.
    fn run(&self, output: Output) -> anyhow::Result<Report>;
}

/// Result of a command: rows with a key for JSON, and a label, a figure and a unit for the table.
#[derive(Default)]
pub(super) struct Report {
    /// Line above the table; not part of the JSON.
    pub(super) title: String,
    rows: Vec<Row>,
    /// Reason why the command fails after the result is printed.
    pub(super) failure: Option<String>,
}

struct Row {
    /// Key in the JSON; empty if the row is text only.
    key: String,
    /// Label in the table; empty if the row is JSON only.
    label: String,
    content: Content,
}

enum Content {
    /// A value, and the same value as text.
    Figure(Value, String),
    /// A nested object.
    Part(Report),
    /// A nested list: a table if its items have no titles.
    List(Vec<Report>),
}

impl Report {
    /// Makes a report with a line above its table.
    pub(super) fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), ..Self::default() }
    }

    /// Makes a report of a part of a file.
    pub(super) fn of_part(kind: &str, part: usize, name: &str) -> Self {
        let title = format!("{kind} \"{}\", part {part}", printable(name));
        Self::new(title).json("part", part).json("name", name)
    }

    /// Makes a report of a value whose fields are the JSON; [`Report::show`] adds fields to the table.
    pub(super) fn of(value: &impl Serialize) -> Self {
        match json!(value) {
            Value::Object(fields) => {
                fields.into_iter().fold(Self::default(), |out, (key, value)| out.json(&key, value))
            }
            other => Self::default().json("value", other),
        }
    }

    /// Adds a figure.
    pub(super) fn figure(self, key: &str, label: &str, value: impl Serialize, unit: &str) -> Self {
        let value = json!(value);
        let text = with_unit(&value, unit);
        self.shown(key, label, value, text)
    }

    /// Adds a figure that the table shows in other words.
    pub(super) fn shown(
        self,
        key: &str,
        label: &str,
        value: impl Serialize,
        text: impl Into<String>,
    ) -> Self {
        self.row(key, label, Content::Figure(json!(value), text.into()))
    }

    /// Adds a value that is too long for the table.
    pub(super) fn json(self, key: &str, value: impl Serialize) -> Self {
        self.shown(key, "", value, "")
    }

    /// Adds text to the table that repeats figures of the JSON.
    pub(super) fn text(self, text: impl Into<String>) -> Self {
        self.shown("", "", Value::Null, text)
    }

    /// Shows a value of the JSON in the table too, below the rows so far. Values that are absent or null are not shown.
    pub(super) fn show(mut self, key: &str, label: &str, unit: &str) -> Self {
        let found = self.rows.extract_if(.., |row| {
            matches!(&row.content, Content::Figure(value, _) if row.key == key && !value.is_null())
        });
        match found.last() {
            Some(Row { content: Content::Figure(value, _), .. }) => {
                self.figure(key, label, value, unit)
            }
            _ => self,
        }
    }

    /// Adds a nested object.
    pub(super) fn part(self, key: &str, part: Report) -> Self {
        self.row(key, "", Content::Part(part))
    }

    /// Adds a nested object, or null.
    pub(super) fn part_or_null(self, key: &str, part: Option<Report>) -> Self {
        match part {
            Some(part) => self.part(key, part),
            None => self.json(key, Value::Null),
        }
    }

    /// Adds a list. Items with titles are blocks of text, items without are rows of a table.
    pub(super) fn list(self, key: &str, items: impl IntoIterator<Item = Report>) -> Self {
        self.row(key, "", Content::List(items.into_iter().collect()))
    }

    fn row(mut self, key: &str, label: &str, content: Content) -> Self {
        self.rows.push(Row { key: key.to_owned(), label: label.to_owned(), content });
        self
    }

    /// Writes a file, and adds its name and number of bytes.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(super) fn write(self, file: &OutputFile, bytes: &[u8]) -> anyhow::Result<Self> {
        files::write(&[(file, bytes)])?;
        Ok(self.wrote(file, bytes))
    }

    /// Adds the name and the number of bytes of a written file.
    pub(super) fn wrote(self, file: &OutputFile, bytes: &[u8]) -> Self {
        let named = file.named.display().to_string();
        self.json("file", named).json("bytes", bytes.len()).text(files::wrote(file, bytes))
    }

    /// Sets the reason why the command fails after the result is printed, if there is a reason.
    pub(super) fn failing(self, failure: Option<String>) -> Self {
        Self { failure, ..self }
    }

    /// Returns all values by their keys.
    pub(super) fn as_json(&self) -> Value {
        let keyed = self.rows.iter().filter(|row| !row.key.is_empty());
        let value = |row: &Row| match &row.content {
            Content::Figure(value, _) => value.clone(),
            Content::Part(part) => part.as_json(),
            Content::List(items) => items.iter().map(Self::as_json).collect(),
        };
        Value::Object(keyed.map(|row| (row.key.clone(), value(row))).collect::<Map<_, _>>())
    }

    /// Returns the table, a line for each row.
    pub(super) fn as_text(&self) -> String {
        let mut out = String::new();
        let indent = if self.title.is_empty() { "" } else { "  " };
        if !self.title.is_empty() {
            out += &format!("{}\n", self.title);
        }
        let lines = self.lines();
        let labels = lines.iter().filter(|(_, text)| !text.is_empty()).map(|(label, _)| label);
        let columns = labels.map(|label| label.width()).max().unwrap_or(0);
        for (label, text) in &lines {
            if text.is_empty() {
                label.lines().for_each(|line| out += &format!("{indent}{line}\n"));
            } else {
                let text = shortened(text, COLUMNS.saturating_sub(indent.len() + columns + 2));
                out += &format!("{indent}{}  {text}\n", padded(label, columns));
            }
        }
        out
    }

    /// Returns labels and figures; text that stands by itself has no figure.
    fn lines(&self) -> Vec<(String, String)> {
        let mut out = Vec::new();
        for Row { label, content, .. } in &self.rows {
            match content {
                Content::Figure(_, text) if label.is_empty() && text.is_empty() => {}
                Content::Figure(_, text) if label.is_empty() => {
                    out.push((text.clone(), String::new()));
                }
                Content::Figure(_, text) => out.push((label.clone(), text.clone())),
                Content::Part(part) if part.title.is_empty() => out.extend(part.lines()),
                Content::Part(part) => out.push((part.as_text(), String::new())),
                Content::List(items) => out.push((list(items), String::new())),
            }
        }
        out
    }

    /// Prints a result, as JSON or as a table.
    ///
    /// # Errors
    /// The result states a failure, or standard output cannot be written.
    pub(super) fn print(&self, output: Output) -> anyhow::Result<()> {
        let text = if output.json {
            serde_json::to_string_pretty(&self.as_json())?
        } else {
            self.as_text()
        };
        let mut out = std::io::stdout().lock();
        match writeln!(out, "{}", text.trim_end()).and_then(|()| out.flush()) {
            // A reader that closed the pipe has read enough.
            Err(error) if error.kind() == ErrorKind::BrokenPipe => {}
            done => done.context("cannot write to standard output")?,
        }
        match &self.failure {
            Some(failure) => bail!("{failure}"),
            None => Ok(()),
        }
    }
}

/// Writes items as blocks, or as rows of a table if they have no titles.
fn list(items: &[Report]) -> String {
    if items.iter().any(|item| !item.title.is_empty()) {
        return items.iter().map(Report::as_text).collect();
    }
    let rows: Vec<_> = items.iter().map(Report::lines).collect();
    let Some(first) = rows.first() else { return String::new() };
    let head: Vec<&str> = first.iter().map(|(label, _)| label.as_str()).collect();
    let cells = rows.iter().map(|row| row.iter().map(|(_, text)| text.clone()).collect());
    table(&head, cells.collect())
}

/// Writes a table that fits [`COLUMNS`]: names are aligned left, figures right. Long names are shortened in the middle.
pub(super) fn table(head: &[&str], mut rows: Vec<Vec<String>>) -> String {
    let is_name = |column: usize| {
        let mut cells = rows.iter().filter_map(|row| row.get(column));
        column == 0 || cells.any(|cell| cell.starts_with(char::is_alphabetic) && cell != "inf")
    };
    let names: Vec<bool> = (0..head.len()).map(is_name).collect();
    rows.insert(0, head.iter().map(|&label| label.to_owned()).collect());
    let cells = |column: usize| rows.iter().filter_map(move |row| row.get(column));
    let mut columns: Vec<usize> = (0..head.len())
        .map(|column| cells(column).map(|cell| printable(cell).width()).max().unwrap_or(0))
        .collect();
    let mut excess = (columns.iter().sum::<usize>() + 2 * head.len()).saturating_sub(COLUMNS);
    while excess > 0 {
        let widest = (0..head.len()).filter(|&at| names[at]).max_by_key(|&at| columns[at]);
        let Some(widest) = widest.filter(|&at| columns[at] > 8) else { break };
        columns[widest] -= 1;
        excess -= 1;
    }
    let mut out = String::new();
    for row in &rows {
        let mut line = String::new();
        for (column, cell) in row.iter().enumerate() {
            let cell = padded(cell, columns[column]);
            let gap = if column > 0 { "  " } else { "" };
            let (own, blanks) = cell.split_at(cell.trim_end().len());
            line +=
                &if names[column] { format!("{gap}{cell}") } else { format!("{gap}{blanks}{own}") };
        }
        out += line.trim_end();
        out += "\n";
    }
    out
}

/// Writes a value of JSON with its unit for the table.
fn with_unit(value: &Value, unit: &str) -> String {
    let text = match value {
        Value::Null => return "-".to_owned(),
        Value::Bool(is_true) => if *is_true { "yes" } else { "no" }.to_owned(),
        Value::Number(number) if number.is_f64() => figure(number.as_f64().unwrap_or(f64::NAN)),
        Value::Number(number) => number.to_string(),
        Value::String(text) => printable(text),
        Value::Array(all) => {
            all.iter().map(|value| with_unit(value, "")).collect::<Vec<_>>().join(", ")
        }
        Value::Object(all) => {
            let named = |(key, value): (&String, &Value)| {
                format!("{} {}", printable(key), with_unit(value, ""))
            };
            all.iter().map(named).collect::<Vec<_>>().join(", ")
        }
    };
    if unit.is_empty() { text } else { format!("{text} {unit}") }
}

/// Writes a number with five significant digits; a whole number has no decimals.
pub(super) fn figure(x: f64) -> String {
    let magnitude = x.abs().log10().floor();
    match magnitude {
        _ if x.fract() == 0.0 && x.abs() < 1e9 => x.to_string(),
        -3.0..6.0 => format!("{x:.*}", (4.0 - magnitude).max(0.0) as usize),
        _ if x.is_finite() => format!("{x:.3e}"),
        _ => x.to_string(),
    }
}

/// Fills a name up to `columns`. Longer names are shortened in the middle, since names differ more at their ends.
pub(super) fn padded(name: &str, columns: usize) -> String {
    let name = shortened(&printable(name), columns);
    let missing = columns.saturating_sub(name.width());
    name + &" ".repeat(missing)
}

/// Replaces the middle of a long name by an ellipsis.
fn shortened(name: &str, columns: usize) -> String {
    if name.width() <= columns {
        return name.to_owned();
    }
    let room = columns.saturating_sub(1);
    let first: String = fitting(name.chars(), room / 3).collect();
    let last: Vec<char> = fitting(name.chars().rev(), room - first.width()).collect();
    first + "…" + &last.into_iter().rev().collect::<String>()
}

/// Takes characters while they fit into `columns`.
fn fitting(characters: impl Iterator<Item = char>, columns: usize) -> impl Iterator<Item = char> {
    let mut taken = 0;
    characters.take_while(move |character| {
        taken += character.width().unwrap_or(0);
        taken <= columns
    })
}

/// Wraps prose at the width of the terminal, at most at [`COLUMNS`].
pub(super) fn wrapped(text: &str) -> String {
    let terminal = terminal_size::terminal_size_of(std::io::stdout());
    let columns = terminal.map_or(COLUMNS, |(width, _)| COLUMNS.min(width.0.into()));
    text.lines().map(|line| wrapped_at(line, columns)).collect()
}

/// Wraps a line between words. Further lines are indented by two more columns.
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
    fn table_and_json_hold_the_same_figures() {
        let joint = |name: &str, range: f64| {
            Report::default().figure("name", "joint", name, "").figure(
                "range",
                "range, °",
                range,
                "",
            )
        };
        let report = Report::of_part("envelope", 3, "arm")
            .figure("rms", "error, RMS", 0.012_345_67, "mm")
            .part("fit", Report::default().figure("frames", "frames", 12, ""))
            .list("joints", [joint("hand", 90.0), joint("左腕", 2.5)]);
        let text = "envelope \"arm\", part 3\n  error, RMS  0.012346 mm\n  frames      12\n  \
                    joint  range, °\n  hand         90\n  左腕     2.5000\n";
        assert_eq!(report.as_text(), text);
        let expected = json!({
            "part": 3, "name": "arm", "rms": 0.012_345_67, "fit": { "frames": 12 },
            "joints": [{ "name": "hand", "range": 90.0 }, { "name": "左腕", "range": 2.5 }],
        });
        assert_eq!(report.as_json(), expected);
    }

    #[test]
    fn fields_of_a_value_are_shown_on_request() {
        let report = Report::of(&json!({ "rms": 1e-7, "none": null, "hash": 7 }));
        let report = report.show("rms", "RMS", "px").show("none", "none", "");
        assert_eq!(report.as_text(), "RMS  1.000e-7 px\n");
        assert_eq!(report.as_json(), json!({ "rms": 1e-7, "none": null, "hash": 7 }));
    }

    #[test]
    fn figures_have_five_digits() {
        for (x, text) in [(0.0, "0"), (360.0, "360"), (37.481_23, "37.481"), (-0.5, "-0.50000")] {
            assert_eq!(figure(x), text);
        }
        assert_eq!([figure(1.5e9), figure(f64::INFINITY)], ["1.500e9", "inf"]);
    }

    #[test]
    fn names_of_all_scripts_fill_one_column() {
        // Two columns a character; a letter and its accent, one; a control character that is escaped.
        for (name, columns) in [("arm", 3), ("左腕", 4), ("e\u{301}", 1), ("\u{1b}", 6)] {
            assert_eq!(printable(name).width(), columns, "{name}");
            assert_eq!(padded(name, 8).width(), 8, "{name}");
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
        let rows = vec![vec!["x".repeat(200), "1.5".to_owned()]];
        assert!(table(&["name", "figure"], rows).lines().all(|line| line.width() <= COLUMNS));
    }
}
