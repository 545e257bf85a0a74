//! Names of joints, matched between files.

use std::collections::{BTreeMap, HashSet};

/// Maps the joint names of a file to the names of a character.
#[derive(Clone, Copy, Debug, Default)]
pub struct JointNames<'a> {
    /// Prefixes and their replacements; the first prefix that a name has is replaced.
    pub prefixes: &'a [(String, String)],
    /// Whether upper and lower case match.
    pub ignore_case: bool,
    /// Names of the model's joints; empty if unknown.
    pub known: &'a [String],
}

impl JointNames<'_> {
    /// Renames a joint; `known` are the character's names.
    pub(crate) fn renamed(&self, name: &str, known: &[String]) -> String {
        let replaced = self
            .prefixes
            .iter()
            .find_map(|(from, to)| Some(format!("{to}{}", name.strip_prefix(from.as_str())?)));
        let name = replaced.unwrap_or_else(|| name.to_owned());
        if !self.ignore_case || known.contains(&name) {
            return name;
        }
        let same = |other: &&String| other.to_lowercase() == name.to_lowercase();
        known.iter().find(same).cloned().unwrap_or(name)
    }

    /// Explains how renamed names still differ from the model's, and names the option that matches them. Returns `None`
    /// if no option would match more.
    pub(crate) fn mismatch(&self, found: &[String]) -> Option<String> {
        mismatch(self.known, found)
    }

    /// Renames all joints of a file.
    pub(crate) fn rename(&self, names: &mut [String]) {
        names.iter_mut().for_each(|name| *name = self.renamed(name, self.known));
    }
}

/// Explains how the names of a file differ from a character's, and names the options that match them. Returns `None` if
/// no option would match more.
///
/// - `known`: the character's joints.
/// - `found`: the file's nodes.
pub(crate) fn mismatch(known: &[String], found: &[String]) -> Option<String> {
    let lower = |names: &[String]| -> Vec<String> {
        names.iter().map(|name| name.to_lowercase()).collect()
    };
    let exact = matches(known, found);
    let (known_lower, found_lower) = (lower(known), lower(found));
    let by_case = matches(&known_lower, &found_lower);
    let (prefix, by_prefix) = prefixes(known, found).unwrap_or_default();
    let (prefix_lower, by_both) = prefixes(&known_lower, &found_lower).unwrap_or_default();
    let most = by_case.max(by_prefix).max(by_both);
    if most <= exact {
        return None;
    }
    if by_case == most {
        return Some("its names differ in case: give --ignore-case".to_owned());
    }
    let advice = |(from, to): &(String, String), more: &str| {
        let begin = |prefix: &str| match prefix {
            "" => "without a prefix".to_owned(),
            prefix => format!("with {prefix}"),
        };
        let option = format!("{from}={to}");
        let is_plain = |c: char| c.is_alphanumeric() || "_:.=/-".contains(c);
        let option = if option.chars().all(is_plain) { option } else { format!("'{option}'") };
        format!(
            "its names begin {}, the character's {}: give --rename-joints {option}{more}",
            begin(from),
            begin(to)
        )
    };
    if by_prefix == most {
        return Some(advice(&prefix, ""));
    }
    // The prefix, in the case that the file uses.
    let from = &prefix_lower.0;
    let own = found
        .iter()
        .find_map(|name| name.get(..from.len()).filter(|begin| begin.to_lowercase() == *from));
    Some(advice(&(own.unwrap_or(from).to_owned(), prefix_lower.1), " --ignore-case"))
}

/// Counts the known names that are found.
fn matches(known: &[String], found: &[String]) -> usize {
    let found: HashSet<&String> = found.iter().collect();
    known.iter().filter(|name| found.contains(name)).count()
}

/// Finds the pair of prefixes, in a file and in a character, whose exchange matches most names; returns it and their
/// count.
fn prefixes(known: &[String], found: &[String]) -> Option<((String, String), usize)> {
    let mut votes: BTreeMap<(&str, &str), HashSet<usize>> = BTreeMap::new();
    for (number, known) in known.iter().enumerate() {
        let ends: HashSet<&str> = ends(known).collect();
        for found in found {
            // The longest ending that both names have.
            let end = self::ends(found).find(|end| ends.contains(end)).or_else(|| {
                let is_end = found.ends_with(known.as_str()) || known.ends_with(found.as_str());
                is_end.then_some(if found.len() < known.len() { found.as_str() } else { known })
            });
            let Some(end) = end.filter(|end| !end.is_empty()) else { continue };
            let begin = |name: &'_ str| name.len() - end.len();
            let pair = (&found[..begin(found)], &known[..begin(known)]);
            votes.entry(pair).or_default().insert(number);
        }
    }
    let least = known.len().min(2);
    let best = votes.into_iter().filter(|(pair, own)| pair.0 != pair.1 && own.len() >= least);
    let ((from, to), own) =
        best.max_by_key(|((from, to), own)| (own.len(), std::cmp::Reverse(from.len() + to.len())))?;
    Some(((from.to_owned(), to.to_owned()), own.len()))
}

/// Lists a name, and the rest of the name behind each punctuation mark.
fn ends(name: &str) -> impl Iterator<Item = &str> {
    let marks = name.char_indices().filter(|(_, c)| !c.is_alphanumeric());
    std::iter::once(name).chain(marks.map(|(place, mark)| &name[place + mark.len_utf8()..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strings(names: &[&str]) -> Vec<String> {
        names.iter().map(|&name| name.to_owned()).collect()
    }

    #[track_caller]
    fn offers(known: &[&str], found: &[&str], words: Option<&str>) {
        let said = mismatch(&strings(known), &strings(found));
        match words {
            Some(words) => assert!(said.as_ref().is_some_and(|s| s.ends_with(words)), "{said:?}"),
            None => assert_eq!(said, None),
        }
    }

    #[test]
    fn a_mismatch_names_the_option_that_helps() {
        let own = ["root", "mid", "tip"];
        let with = |prefix: &str| own.map(|name| format!("{prefix}{name}"));
        for (prefix, option) in [
            ("mixamorig:", "give --rename-joints mixamorig:="),
            ("mixamorig_", "give --rename-joints mixamorig_="),
            ("Armature|", "give --rename-joints 'Armature|='"),
            ("rig", "give --rename-joints rig="),
            ("a.b.", "give --rename-joints a.b.="),
        ] {
            let found = with(prefix);
            let found: Vec<&str> =
                found.iter().map(String::as_str).chain(["tip_end", "armature"]).collect();
            offers(&own, &found, Some(option));
        }
        let (one, other) = (with("mixamorig:"), with("mixamorig1:"));
        let [one, other] = [&one, &other].map(|all| all.each_ref().map(String::as_str));
        offers(&one, &own, Some("give --rename-joints =mixamorig:"));
        offers(&one, &other, Some("give --rename-joints mixamorig1:=mixamorig:"));
        offers(&own, &["Root", "MID", "tip"], Some("its names differ in case: give --ignore-case"));
        offers(&own, &["M:Root", "M:Mid", "M:Tip"], Some("give --rename-joints M:= --ignore-case"));
        offers(&own, &own, None);
        offers(&own, &["spine", "head"], None);
        offers(&["hip"], &["x:hip"], Some("give --rename-joints x:="));
    }

    #[test]
    fn names_are_renamed_as_asked() {
        let prefixes = [("m:".to_owned(), String::new()), (String::new(), "x_".to_owned())];
        let known = strings(&["Root", "x_tip"]);
        let names = JointNames { prefixes: &prefixes, ignore_case: true, known: &known };
        let mut all = strings(&["m:root", "TIP", "other"]);
        names.rename(&mut all);
        assert_eq!(all, ["Root", "x_tip", "x_other"]);
    }
}
