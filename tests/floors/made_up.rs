//! The rules refuse what they are to refuse: small made-up crates.

use std::path::Path;

use crate::wrong;

/// What is wrong with a crate of these files, whose modules stand in this order.
fn judge(order: &[&str], files: &[(&str, &str)]) -> Vec<String> {
    let read = |path: &Path| files.iter().find(|(name, _)| Path::new(name) == path).map(|(_, text)| text.to_string());
    wrong("src/lib.rs", order, &read)
}

fn refused(order: &[&str], files: &[(&str, &str)], with: &[&str]) {
    let found = judge(order, files).join("\n");
    assert!(with.iter().all(|text| found.contains(text)), "{with:?} is missing in:\n{found}");
}

fn allowed(order: &[&str], files: &[(&str, &str)]) {
    assert_eq!(judge(order, files), Vec::<String>::new());
}

const FRONT: (&str, &str) = ("src/lib.rs", "mod low; mod high; pub use high::High; pub use low::Low;");

#[test]
fn a_use_of_a_later_module_is_refused() {
    let low = "pub struct Low;\n";
    let high = ("src/high.rs", "pub struct High; pub mod inner { } use crate::low::Low; fn f(_: Low) {}");
    allowed(&["low", "high"], &[FRONT, ("src/low.rs", low), high]);
    for upwards in [
        "use crate::high::High;",
        "use crate::{high};",
        "use super::high::{self as other};",
        "use crate::High;", // through the front page
        "fn f() -> crate::high::High { loop {} }",
        "fn f() { super::high::call(1) }",
        "use crate::*; fn f() { High::new() }",
        "pub use crate::high::High;",
        "pub(crate) use crate::high as h;",
    ] {
        let text = format!("{low}{upwards}");
        let files = [FRONT, ("src/low.rs", text.as_str()), ("src/high.rs", "pub struct High;")];
        refused(&["low", "high"], &files, &["src/low.rs:2: ", "(in src/high.rs): high stands above low"]);
    }
}

#[test]
fn comments_strings_and_tests_may_name_anything() {
    let low = "pub struct Low;\n// crate::high::High\n/* use crate::high; */ const A: &str = \"crate::high::High\";\n\
        #[cfg(test)] mod tests { use crate::high::High; }\n#[cfg(test)] use crate::high;\n";
    allowed(&["low", "high"], &[FRONT, ("src/low.rs", low), ("src/high.rs", "pub struct High;")]);
}

#[test]
fn a_macro_belongs_to_the_file_that_declares_it() {
    let front = ("src/lib.rs", "#[macro_use] mod high; mod low;");
    let high = ("src/high.rs", "macro_rules! count { () => {} } pub(crate) use count;");
    for text in ["count!();", "crate::count!();", "use crate::high::count;"] {
        refused(&["low", "high"], &[front, high, ("src/low.rs", text)], &["src/low.rs:1: ", "high stands above low"]);
    }
}

#[test]
fn nothing_is_taken_from_the_front_page() {
    let front = ("src/lib.rs", "mod low; pub struct Options;");
    refused(&["low"], &[front, ("src/low.rs", "use crate::Options;")], &["the root stands above low"]);
}

#[test]
fn an_order_names_the_modules_that_are_there() {
    let files = [FRONT, ("src/low.rs", "pub struct Low;"), ("src/high.rs", "pub struct High;")];
    refused(&["low"], &files, &["module high has no place in the order"]);
    refused(&["low"], &files, &["an order that the sources allow: [\"high\", \"low\"]"]);
    refused(&["low", "high", "gone"], &files, &["the order names gone, which is no module"]);
}

#[test]
fn circles_of_files_are_refused() {
    let front = ("src/lib.rs", "mod a;");
    let window = "pub use b::B; pub use c::C; mod b; mod c;";
    let c = "pub struct C; use super::b::B; fn f(_: B) {}";
    allowed(&["a"], &[front, ("src/a/mod.rs", window), ("src/a/b.rs", "pub struct B;"), ("src/a/c.rs", c)]);
    for back in ["use super::c::C;", "use super::C;", "use crate::a::{C as Other};", "fn f() { super::c::g() }"] {
        let b = format!("pub struct B;\n{back}");
        let files = [front, ("src/a/mod.rs", window), ("src/a/b.rs", b.as_str()), ("src/a/c.rs", c)];
        refused(&["a"], &files, &["circle of 2 files: src/a/b.rs, src/a/c.rs", "src/a/b.rs:2: "]);
    }
}

#[test]
fn a_longer_ring_is_found_whole() {
    let front = ("src/lib.rs", "mod a; mod b; mod c; mod d;");
    let files = [
        front,
        ("src/a.rs", "use crate::b;"),
        ("src/b.rs", "use crate::c;"),
        ("src/c.rs", "use crate::a;"),
        ("src/d.rs", "use crate::a;"),
    ];
    refused(&["a", "b", "c", "d"], &files, &["circle of 3 files: src/a.rs, src/b.rs, src/c.rs"]);
}

#[test]
fn a_folder_and_its_children_use_one_another_one_way_only() {
    let front = ("src/lib.rs", "mod a;");
    let child = ("src/a/b.rs", "pub struct B; use super::Shared; fn f(_: Shared) {}");
    let shows = "mod b; pub use b::B; pub struct Shared;";
    allowed(&["a"], &[front, ("src/a/mod.rs", shows), child]);
    let uses = "mod b; struct Shared; use b::B; fn g(_: B) {}";
    refused(&["a"], &[front, ("src/a/mod.rs", uses), child], &["circle of 2 files"]);
    // To show a thing and to name it in code is to use it.
    let both = "mod b; struct Shared; pub use b::B; fn g(_: B) {}";
    refused(&["a"], &[front, ("src/a/mod.rs", both), child], &["circle of 2 files"]);
    let inline = "mod b; struct Shared; fn g() { b::new() }";
    refused(&["a"], &[front, ("src/a/mod.rs", inline), child], &["circle of 2 files"]);
}

/// What a parent imports, its children see: such a path leads to where the thing is declared.
#[test]
fn a_path_through_a_parent_leads_to_the_thing() {
    let front = ("src/lib.rs", "mod low; mod high;");
    let high = ("src/high.rs", "pub struct High;");
    let files =
        [front, ("src/low/mod.rs", "mod b; mod c;"), ("src/low/b.rs", "pub use super::super::high::High;"), high];
    let through = [&files[..], &[("src/low/c.rs", "fn f(_: super::b::High) {}")]].concat();
    refused(&["low", "high"], &through, &["src/low/b.rs:1: ", "src/low/c.rs:1: super::b::High (in src/high.rs)"]);
}
