//! Compares figures with their budgets.

use std::fmt::Write;

/// A budget this many percent above its figure should be tightened.
const LOOSE: u64 = 10;

/// Result of a comparison.
pub(super) struct Judged {
    /// Table of figures and budgets, to print.
    pub(super) table: String,
    /// Failures, one line each.
    pub(super) failures: Vec<String>,
}

/// Compares figures with a budget: lines of a name, a budget and, if an issue sets one, the bar
/// that no budget may exceed; `#` starts a comment.
///
/// # Errors
/// If the budget cannot be read.
pub(super) fn judge(figures: &[(String, u64)], budget: &str) -> Result<Judged, String> {
    let mut judged = Judged { table: String::new(), failures: Vec::new() };
    let mut budgeted = Vec::new();
    for line in budget.lines().map(|line| line.split('#').next().unwrap_or_default().trim()) {
        if line.is_empty() {
            continue;
        }
        let row = Row::parse(line).ok_or_else(|| format!("budget: `{line}` has no number"))?;
        match figures.iter().find(|(name, _)| *name == row.name) {
            Some((_, figure)) => row.judge(*figure, &mut judged),
            None => judged.failures.push(format!("{} has a budget but was not measured", row.name)),
        }
        budgeted.push(row.name);
    }
    for (name, figure) in figures {
        if !budgeted.contains(name) {
            judged.failures.push(format!("{name} is {figure} but has no budget"));
        }
    }
    Ok(judged)
}

struct Row {
    name: String,
    budget: u64,
    bar: Option<u64>,
}

impl Row {
    /// Parses a line: the words of the name, then one or two numbers.
    fn parse(line: &str) -> Option<Self> {
        let words: Vec<_> = line.split_whitespace().collect();
        let is_number = |word: &&&str| word.parse::<u64>().is_ok();
        let names = words.len() - words.iter().rev().take_while(is_number).count();
        let numbers: Vec<u64> =
            words[names..].iter().filter_map(|word| word.parse().ok()).collect();
        let (budget, bar) = match numbers[..] {
            [budget] => (budget, None),
            [budget, bar] => (budget, Some(bar)),
            _ => return None,
        };
        Some(Self { name: words[..names].join(" "), budget, bar })
    }

    fn judge(&self, figure: u64, judged: &mut Judged) {
        let Self { name, budget, bar } = self;
        let mut note = String::new();
        if figure > *budget {
            let over = figure - budget;
            note = format!("{over} over its budget");
            judged
                .failures
                .push(format!("{name} is {figure}: {over} more than its budget of {budget}"));
        } else if (budget - figure) * 100 > figure * LOOSE {
            note = "loose: tighten the budget".to_owned();
        }
        if let Some(bar) = bar.filter(|bar| budget > bar) {
            judged.failures.push(format!("{name}: the budget of {budget} is above {bar}"));
        }
        let bar = bar.map_or_else(String::new, |bar| format!("of {bar}"));
        // Writing to a string cannot fail.
        let _ = writeln!(judged.table, "{name:<40} {figure:>9} {budget:>9} {bar:<12} {note}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BUDGET: &str = "# budgets\nsmall code 1000 1400\nstack 500 # words\n";

    fn failures(figures: &[(&str, u64)], budget: &str) -> Vec<String> {
        let figures: Vec<_> = figures.iter().map(|(name, x)| ((*name).to_owned(), *x)).collect();
        judge(&figures, budget).map_or_else(|error| vec![error], |judged| judged.failures)
    }

    #[test]
    fn figures_within_the_budget_pass() {
        assert_eq!(failures(&[("small code", 1000), ("stack", 460)], BUDGET), [""; 0]);
    }

    #[test]
    fn one_more_fails_and_says_by_how_much() {
        let found = failures(&[("small code", 1003), ("stack", 460)], BUDGET);
        assert_eq!(found, ["small code is 1003: 3 more than its budget of 1000"]);
    }

    #[test]
    fn a_budget_above_its_bar_fails() {
        let found = failures(&[("small code", 1300)], "small code 1401 1400");
        assert_eq!(found, ["small code: the budget of 1401 is above 1400"]);
    }

    #[test]
    fn every_figure_has_a_budget_and_every_budget_a_figure() {
        let found = failures(&[("small code", 990), ("heap", 1)], BUDGET);
        assert_eq!(
            found,
            ["stack has a budget but was not measured", "heap is 1 but has no budget"]
        );
        assert_eq!(failures(&[], "stack"), ["budget: `stack` has no number"]);
    }

    #[test]
    fn a_loose_budget_is_reported() {
        let table = |figure| judge(&[("stack".to_owned(), figure)], "stack 500");
        let is_loose = |figure| table(figure).is_ok_and(|judged| judged.table.contains("loose"));
        assert!(is_loose(454) && !is_loose(455));
    }
}
