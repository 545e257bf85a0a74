//! The size of the runtime's public interface, counted in its documentation.

use pages::repository;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Items and methods that an engine developer may have to know, with default features.
const MOST: usize = 170;

/// Kinds of items with a page in rustdoc.
const KINDS: [&str; 8] = ["struct", "enum", "trait", "fn", "constant", "type", "macro", "static"];

/// Documents the runtime with features and returns the folder of its pages.
fn documented(features: &str) -> PathBuf {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("../nested/doc").join(features);
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["doc", "-q", "-p", "sinew-runtime", "--no-deps", "--offline", "--locked"]);
    cargo.args(["--features", features]).current_dir(repository());
    cargo.env("CARGO_TARGET_DIR", &target).env("RUSTDOCFLAGS", "-D warnings");
    pages::build::output(&mut cargo);
    target.join("doc/sinew_runtime")
}

/// Returns the texts between `start` and a quotation mark.
fn quoted<'a>(html: &'a str, start: &str) -> Vec<&'a str> {
    html.split(start).skip(1).filter_map(|rest| rest.split('"').next()).collect()
}

/// Counts the items of the documentation, and the methods and associated constants of each.
fn count(pages: &Path) -> usize {
    let all = std::fs::read_to_string(pages.join("all.html")).unwrap();
    let is_item = |link: &&str| {
        let name = link.rsplit('/').next().unwrap_or_default();
        KINDS.iter().any(|kind| name.starts_with(&format!("{kind}.")))
    };
    let items: BTreeSet<&str> = quoted(&all, "href=\"").into_iter().filter(is_item).collect();
    let methods = items.iter().map(|item| {
        let page = std::fs::read_to_string(pages.join(item)).unwrap();
        // Own methods stand before the implementations of traits.
        let own = page.split("id=\"implementations-list\"").nth(1).unwrap_or_default();
        let own = own.split("id=\"trait-implementations\"").next().unwrap_or_default();
        let own = own.split("id=\"synthetic-implementations\"").next().unwrap_or_default();
        let of_type = ["method.", "associatedconstant."]
            .map(|kind| quoted(own, &format!("<section id=\"{kind}")).len());
        let of_trait = quoted(&page, "<section id=\"tymethod.").len();
        of_type[0] + of_type[1] + of_trait
    });
    items.len() + methods.sum::<usize>()
}

#[test]
fn the_interface_stays_small() {
    let [own, more] = ["default", "default,internals"].map(|features| count(&documented(features)));
    println!("{own} items and methods, {more} with internals");
    assert!((100..=MOST).contains(&own), "{own} items and methods");
    assert!(more > own + 100, "the control: {more} with internals");
}
