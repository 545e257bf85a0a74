//! Small crates with and without circles, and the crates of this repository.

use super::check;
use super::check::check_crate;
use super::tokens::tokens;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Checks a crate of these files; the first file is the root.
fn checked(files: &[(&str, &str)]) -> Result<(), String> {
    let text = files.iter().map(|(path, text)| (PathBuf::from(path), (*text).to_owned()));
    let text: BTreeMap<_, _> = text.collect();
    check_crate(Path::new(files[0].0), &|path| text.get(path).cloned())
}

fn circle(files: &[(&str, &str)]) -> String {
    checked(files).expect_err("there is a circle").replace("imports in a circle: ", "")
}

#[test]
fn the_crates_import_one_way() {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    if let Err(error) = check(&repository) {
        panic!("{error}");
    }
}

#[test]
fn one_way_is_no_circle() {
    let files = [
        ("lib.rs", "mod a; mod b; mod c; pub use a::A;"),
        ("a.rs", "use crate::b::B; use super::c::{self, C}; pub struct A(B, C, c::D);"),
        ("b.rs", "use crate::c::C; pub struct B(C);"),
        ("c.rs", "pub struct C; pub struct D;"),
    ];
    assert_eq!(checked(&files), Ok(()));
}

#[test]
fn two_files_make_a_circle() {
    let files = [
        ("lib.rs", "mod a; mod b; mod c;"),
        ("a.rs", "use crate::b::B; pub struct A(B);"),
        ("b.rs", "pub struct B; fn f(_: &crate::a::A) {}"),
        ("c.rs", "use crate::a::A; fn f(_: A) {}"),
    ];
    assert_eq!(circle(&files), "a.rs -> b.rs -> a.rs");
}

#[test]
fn three_files_make_a_circle() {
    let files = [
        ("lib.rs", "mod a; mod b; mod c;"),
        ("a.rs", "use crate::{b::{B as Other}}; pub fn a(_: Other) {}"),
        ("b.rs", "use super::c; pub struct B; fn f() { c::c() }"),
        ("c.rs", "pub fn c() { let run = super::a::a; }"),
    ];
    assert_eq!(circle(&files), "a.rs -> b.rs -> c.rs -> a.rs");
}

#[test]
fn a_circle_through_a_re_export_is_one_of_the_files_that_define() {
    let files = [
        ("lib.rs", "mod a; mod folder; pub use folder::B;"),
        ("a.rs", "use crate::folder::B; pub struct A(B);"),
        ("folder/mod.rs", "mod b; pub use b::B;"),
        ("folder/b.rs", "pub struct B; impl B { fn f(_: super::super::a::A) {} }"),
    ];
    assert_eq!(circle(&files), "a.rs -> folder/b.rs -> a.rs");
    // Also through a re-export of the root, and through a re-export under another name.
    let mut files = files;
    files[1].1 = "use crate::B; pub struct A(B);";
    assert_eq!(circle(&files), "a.rs -> folder/b.rs -> a.rs");
    files[0].1 = "mod a; mod folder; pub use folder::B as Renamed;";
    files[1].1 = "use crate::Renamed; pub struct A(Renamed);";
    assert_eq!(circle(&files), "a.rs -> folder/b.rs -> a.rs");
    files[0].1 = "mod a; mod folder; pub use folder::*;";
    files[1].1 = "use crate::B; pub struct A(B);";
    assert_eq!(circle(&files), "a.rs -> folder/b.rs -> a.rs");
}

#[test]
fn a_module_that_re_exports_and_defines_what_its_children_use_is_a_circle() {
    let files = [
        ("lib.rs", "mod folder;"),
        ("folder/mod.rs", "mod b; pub use self::b::B; pub(crate) const ALL: usize = 1;"),
        ("folder/b.rs", "use super::ALL; pub struct B([u8; ALL]);"),
    ];
    assert_eq!(circle(&files), "folder/b.rs -> folder/mod.rs -> folder/b.rs");
    // A file that only re-exports is never in a circle, whoever imports through it.
    let files = [
        ("lib.rs", "mod folder;"),
        ("folder/mod.rs", "mod b; mod sizes; pub use b::B; pub(crate) use sizes::ALL;"),
        ("folder/b.rs", "use super::ALL; pub struct B([u8; ALL]);"),
        ("folder/sizes.rs", "pub(crate) const ALL: usize = 1;"),
    ];
    assert_eq!(checked(&files), Ok(()));
}

#[test]
fn a_root_that_uses_its_modules_and_defines_for_them_is_a_circle() {
    let files = [
        ("lib.rs", "mod a; macro_rules! made { () => {} } fn f() { a::a() }"),
        ("a.rs", "use crate::made; pub fn a() { made!() }"),
    ];
    assert_eq!(circle(&files), "a.rs -> lib.rs -> a.rs");
}

#[test]
fn a_glob_imports_what_is_behind_it() {
    let files = [
        ("lib.rs", "mod a; mod folder;"),
        ("a.rs", "use crate::folder::*; pub struct A(B);"),
        ("folder/mod.rs", "mod b; pub use b::*;"),
        ("folder/b.rs", "use crate::a::A; pub struct B(A);"),
    ];
    assert_eq!(circle(&files), "a.rs -> folder/b.rs -> a.rs");
}

#[test]
fn imports_within_functions_and_inner_modules_count() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "pub fn a() { use crate::b::inner::{B}; let _ = B::new(); }"),
        ("b.rs", "pub mod inner { pub struct B; fn f() { super::super::a::a() } }"),
    ];
    assert_eq!(circle(&files), "a.rs -> b.rs -> a.rs");
}

#[test]
fn tests_comments_and_text_do_not_count() {
    let files = [
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", "use crate::b::B; pub struct A<'a>(&'a B);"),
        (
            "b.rs",
            "//! [`crate::a::A`]\n/* crate::a::A /* use crate::a::A; */ crate::a::A */\n\
             pub struct B; const C: [char; 3] = ['\"', '\\'', ':'];\n\
             const D: &str = \"crate::a::A \\\" crate::a::A\"; const E: &str = r#\"crate::a::A\"#;\n\
             #[cfg(test)] use crate::a::{A};\n#[cfg(all(test, unix))] fn f() { crate::a::A; }\n\
             #[cfg(test)]\nmod tests { use super::*; use crate::a::A; mod more { } }",
        ),
    ];
    assert_eq!(checked(&files), Ok(()));
    let mut files = files;
    files[2].1 = "pub struct B; #[cfg(not(test))] use crate::a::A;";
    assert_eq!(circle(&files), "a.rs -> b.rs -> a.rs");
}

#[test]
fn other_crates_of_a_modules_name_are_no_imports() {
    let files = [
        ("lib.rs", "pub mod wgpu; mod b;"),
        ("wgpu/mod.rs", "mod bound; pub use bound::Bound;"),
        ("wgpu/bound.rs", "use wgpu::Device; use crate::b::B; pub struct Bound(Device, B);"),
        ("b.rs", "use wgpu::Buffer; pub struct B(wgpu::Device, ::wgpu::Buffer);"),
    ];
    assert_eq!(checked(&files), Ok(()));
}

#[test]
fn a_path_says_where_a_module_lies() {
    let files = [
        ("src/lib.rs", "#[path = \"../golden/bits.rs\"] #[allow(dead_code)] mod bits; mod a;"),
        ("golden/bits.rs", "mod rng; pub use rng::Rng;"),
        ("golden/rng.rs", "use crate::a::A; pub struct Rng(A);"),
        ("src/a.rs", "pub struct A; fn a(_: crate::bits::Rng) {}"),
    ];
    assert_eq!(circle(&files), format!("{0} -> a.rs -> {0}", Path::new("golden/rng.rs").display()));
    // In an inline module, the path is relative to the folder for that module's files.
    let files = [
        ("lib.rs", "mod a;"),
        ("a.rs", "pub mod b { #[path = \"other.rs\"] pub mod c; } pub fn a() { b::c::c() }"),
        ("a/b/other.rs", "pub fn c() { crate::a::a() }"),
    ];
    assert_eq!(circle(&files), "a/b/other.rs -> a.rs -> a/b/other.rs");
    // With `path`, the default file a.rs is not read.
    let lost = checked(&[("lib.rs", "#[path = \"b.rs\"] mod a;"), ("a.rs", "")]);
    assert_eq!(lost, Err("cannot read b.rs".to_owned()));
}

#[test]
fn code_under_every_cfg_counts() {
    // Two modules of one name; one of them closes a circle.
    let unix = "#[cfg(unix)] mod sys { pub use crate::a::open; }";
    let other = "#[cfg(not(unix))] mod sys { pub fn open() {} }";
    for pair in [[unix, other].concat(), [other, unix].concat()] {
        let files = [
            ("lib.rs", &*[&*pair, "mod a; mod b;"].concat()),
            ("a.rs", "pub fn open() { crate::b::b() }"),
            ("b.rs", "pub fn b() { crate::sys::open() }"),
        ];
        let found = circle(&files);
        assert!(found.starts_with("a.rs -> b.rs -> a.rs;"), "{found}");
    }
    // `cfg` chooses one of several files; the default file need not exist.
    let chosen =
        "#[cfg_attr(unix, path = \"unix.rs\")] #[cfg_attr(windows, path = \"windows.rs\")]";
    for (name, far) in [("unix.rs", "windows.rs"), ("windows.rs", "unix.rs")] {
        let files = [
            ("lib.rs", &*format!("{chosen} pub(crate) mod target; mod user;")),
            ("user.rs", "pub fn user() { super::target::call() }"),
            (name, "pub fn call() { super::user::user() }"),
            (far, "pub fn call() {}"),
        ];
        // A circle starts with its first name in order.
        let (first, second) = (name.min("user.rs"), name.max("user.rs"));
        assert_eq!(circle(&files), format!("{first} -> {second} -> {first}"));
    }
    // Code in tests and elsewhere counts.
    let files = [
        ("lib.rs", "#[cfg(any(test, unix))] mod a; mod b;"),
        ("a.rs", "pub fn a() { crate::b::b() }"),
        ("b.rs", "pub fn b() { crate::a::a() }"),
    ];
    assert_eq!(circle(&files), "a.rs -> b.rs -> a.rs");
    let mut files = files;
    files[0].1 = "#[cfg(any(test, all(unix, test)))] mod a; mod b;";
    assert_eq!(checked(&files), Ok(()));
}

#[test]
fn every_circle_is_reported() {
    let files = [
        ("lib.rs", "mod a; mod b; mod c; mod d;"),
        ("a.rs", "pub struct A(crate::b::B);"),
        ("b.rs", "pub struct B(crate::a::A);"),
        ("c.rs", "pub struct C(crate::d::D);"),
        ("d.rs", "pub struct D(crate::c::C);"),
    ];
    assert_eq!(circle(&files), "a.rs -> b.rs -> a.rs; c.rs -> d.rs -> c.rs");
}

#[test]
fn a_module_without_a_file_and_a_crate_without_imports_are_reported() {
    let lost = checked(&[("lib.rs", "mod a;")]).unwrap_err();
    assert_eq!(lost, format!("cannot read {}", Path::new("a/mod.rs").display()));
    let files = [("lib.rs", "mod a; mod b; mod c;"), ("a.rs", ""), ("b.rs", ""), ("c.rs", "")];
    assert_eq!(checked(&files), Err("only 0 of 4 files import others".to_owned()));
}

#[test]
fn tokens_are_names_and_signs() {
    let found = tokens("a::b<'a, u8>(r#type, b'x', 'y', \"::\", br\"\\\", 0x1_f, c'\\n')");
    let expected = ["a", "::", "b", "<", ",", "u8", ">", "(", "type", ",", ",", ",", ",", ",", ","];
    assert_eq!(found, [&expected[..], &[")"]].concat());
}
