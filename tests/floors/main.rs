//! The floors of the house, read from the sources: inside a crate a module uses only what stands below it, and no files use
//! one another in a ring. `tests/dependency_rule.rs` holds the same between crates. `arrows.rs` says what counts as a use.
//!
//! A folder's `mod.rs` is a file like any other: its children may use what it declares as long as it uses nothing of theirs
//! (it may show them with `pub use`), or it may use the children as long as they use nothing that it declares. Tests are
//! left out: they may look anywhere.

mod arrows;
mod floors;
mod made_up;
mod modules;
mod sizes;
mod tokens;

use std::path::{Path, PathBuf};

/// The modules at the top of each crate, lowest first: a module may use those before it.
const ORDERS: [(&str, &str); 14] = [
    (
        "formats/src/lib.rs",
        "math half oct scene tile bvh rays intersect durable id locks budget error limits payload columns container trace",
    ),
    ("settings/src/lib.rs", "near units rule key declare source error files schema family file chain loaded text"),
    (
        "machine/src/lib.rs",
        "time component counters error config work link memory ti traversal srp stats functional energy area system run ports probes timeline",
    ),
    ("replay/src/lib.rs", "error stop image counts source policy work frame maps detail simulate windows sequence"),
    ("columns/src/lib.rs", "error value schema select order rows simulated sink what data aov"),
    ("store/src/lib.rs", "traffic cache location options unavailable remote open"),
    (
        "scenes/src/lib.rs",
        "names warnings error scene pictures options validate camera mesh defaults view overrides modelling obj builtin gltf_model file load",
    ),
    (
        "tracer/src/lib.rs",
        "coincident convert grid shading texture traverse tree wording verify version accel materials waves trace against capture render",
    ),
    (
        "study/src/lib.rs",
        "error files pool policy_text presets schema figures report table point sweep cluster analysis compare html",
    ),
    (
        "paper/src/lib.rs",
        "error between frame identity live lockstep policies widths cells claims reference results rows setup plan ablations animation ledger meter points systems estimates study totals table traces jobs maker execute experiment anchors",
    ),
    (
        "testkit/src/lib.rs",
        "random golden policies switches trees synthetic rules recorded shade past reference same cells poison",
    ),
    ("python/src/lib.rs", "error arguments columns wait wanted batches view policy replay trace"),
    ("fuzz/src/lib.rs", "random memory coverage place mutate seeds traces target targets kept runner"),
    (
        "src/main.rs",
        "tell exit memory progress common named scene_args detail traces arguments edit anchors aov capture compare completions diff digest export info merge presets paper recompress render repair replay report scenes sweep trim verify",
    ),
];

/// The names of an order.
fn words(order: &str) -> Vec<&str> {
    order.split(' ').collect()
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn read(file: &Path) -> Option<String> {
    std::fs::read_to_string(root().join(file)).ok()
}

/// Everything that is wrong with the floors of one crate.
fn wrong(front: &str, order: &[&str], read: &dyn Fn(&Path) -> Option<String>) -> Vec<String> {
    let modules = modules::modules(Path::new(front), read);
    let arrows = arrows::arrows(&modules);
    let mut found = floors::unlisted(&modules, order);
    if !found.is_empty() {
        found.push(format!("an order that the sources allow: {:?}", floors::possible(&modules, &arrows)));
    }
    found.extend(floors::up(&modules, &arrows, order));
    found.extend(floors::circles(&modules, &arrows));
    found.into_iter().map(|text| format!("{front}: {text}")).collect()
}

#[test]
fn every_crate_has_an_order() {
    let listed: Vec<PathBuf> = ORDERS.iter().map(|(front, _)| root().join(front)).collect();
    for member in sizes::members(&root()) {
        let front = if member == "." { "src/main.rs".into() } else { format!("{member}/src/lib.rs") };
        assert!(listed.contains(&root().join(&front)), "{front} is missing in the orders of tests/floors");
    }
}

#[test]
fn modules_use_what_stands_below_them() {
    let found: Vec<String> = ORDERS.iter().flat_map(|(front, order)| wrong(front, &words(order), &read)).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}
