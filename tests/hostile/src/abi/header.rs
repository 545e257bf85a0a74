//! What `sinew.h` promises.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

const HEADER: &str = include_str!("../../../../runtime/capi/include/sinew.h");

/// The first status that tells of a file.
const FIRST_OF_FILES: i32 = 100;

/// The numbers of the statuses that each function may return besides 0, by its name, as the sentence
/// "Returns ..." of its comment lists them.
pub(super) fn promises() -> &'static BTreeMap<&'static str, BTreeSet<i32>> {
    static PROMISES: LazyLock<BTreeMap<&str, BTreeSet<i32>>> = LazyLock::new(|| {
        let numbers = numbers();
        let (functions, _) = HEADER.split_once("}  // extern").unwrap_or_default();
        let declarations = functions.split(";\n").filter_map(|text| {
            let (comment, declaration) = text.split_once("\nsinew_status ")?;
            let (name, _) = declaration.split_once('(')?;
            let (_, listed) = comment.rsplit_once("Returns ")?;
            let named = listed.split('`').skip(1).step_by(2).map(|status| numbers[status]);
            let of_files = numbers.values().copied().filter(|number| {
                *number >= FIRST_OF_FILES && listed.contains("every status from 100 on")
            });
            Some((name, named.chain(of_files).collect()))
        });
        declarations.collect()
    });
    &PROMISES
}

/// Reads the enumeration: numbers by the names that comments use.
fn numbers() -> BTreeMap<&'static str, i32> {
    let lines = HEADER.lines().filter_map(|line| line.trim().strip_prefix("SINEW_STATUS_"));
    lines
        .filter_map(|line| line.strip_suffix(',')?.split_once(" = "))
        .filter_map(|(name, number)| Some((name, number.parse().ok()?)))
        .collect()
}
