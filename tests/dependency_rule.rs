//! Who may depend on whom: the promise that a sweep runs on the trace alone, on a machine that has no scene.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The machine this runs on: packages of others need not be downloaded.
fn host() -> String {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = Command::new(rustc).arg("-vV").output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().find_map(|line| line.strip_prefix("host: ")).unwrap().to_string()
}

fn metadata() -> Value {
    let host = host();
    let ask = |offline: &[&str]| {
        let mut command = Command::new(env!("CARGO"));
        command.args(["metadata", "--format-version", "1", "--locked", "--filter-platform", &host]).args(offline);
        command.current_dir(root()).output().unwrap()
    };
    // Offline first; only a package that no build has needed yet makes it ask the registry.
    let mut output = ask(&["--offline"]);
    if !output.status.success() {
        output = ask(&[]);
    }
    assert!(output.status.success(), "cargo metadata: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The resolved graph by package name: what each depends on in a build, tests and benches left out.
struct Graph {
    names: BTreeMap<String, String>,
    nodes: BTreeMap<String, Value>,
}

impl Graph {
    fn new() -> Self {
        let metadata = metadata();
        let list = |value: &Value| value.as_array().unwrap().clone();
        let id = |value: &Value| value["id"].as_str().unwrap().to_string();
        let names = list(&metadata["packages"]).iter().map(|p| (id(p), p["name"].as_str().unwrap().into())).collect();
        let nodes = list(&metadata["resolve"]["nodes"]).into_iter().map(|n| (id(&n), n)).collect();
        Self { names, nodes }
    }

    fn node(&self, name: &str) -> &Value {
        let mut found = self.nodes.iter().filter(|(id, _)| self.names[*id] == name);
        let node = found.next().unwrap_or_else(|| panic!("no package {name}")).1;
        assert!(found.next().is_none(), "two versions of {name}");
        node
    }

    fn direct(&self, node: &Value) -> BTreeSet<String> {
        let in_build = |dep: &&Value| dep["dep_kinds"].as_array().unwrap().iter().any(|kind| kind["kind"] != "dev");
        let deps = node["deps"].as_array().unwrap().iter().filter(in_build);
        deps.map(|dep| dep["pkg"].as_str().unwrap().to_string()).collect()
    }

    /// The libraries of this workspace.
    fn members(&self) -> Vec<String> {
        self.names.values().filter(|name| name.starts_with("rayreel-")).cloned().collect()
    }

    /// The members of this workspace that a member depends on directly.
    fn siblings(&self, name: &str) -> Vec<String> {
        let names = self.direct(self.node(name)).into_iter().map(|id| self.names[&id].clone());
        names.filter(|name| name.starts_with("rayreel")).collect::<BTreeSet<_>>().into_iter().collect()
    }

    /// Everything a member depends on, however far.
    fn closure(&self, name: &str) -> BTreeSet<String> {
        let mut todo: Vec<String> = self.direct(self.node(name)).into_iter().collect();
        let mut seen = BTreeSet::new();
        while let Some(id) = todo.pop() {
            if seen.insert(id.clone()) {
                todo.extend(self.direct(&self.nodes[&id]));
            }
        }
        seen.into_iter().map(|id| self.names[&id].clone()).collect()
    }
}

/// Every member and the members that it may depend on. What is not listed here is refused.
const SIBLINGS: [(&str, &[&str]); 13] = [
    ("formats", &[]),
    ("settings", &[]),
    ("scenes", &["settings"]),
    ("machine", &["formats", "settings"]),
    ("replay", &["formats", "machine", "settings"]),
    ("columns", &["formats", "machine", "replay"]),
    ("store", &["formats"]),
    ("tracer", &["formats", "scenes"]),
    ("study", &["formats", "machine", "replay", "settings", "store"]),
    ("paper", &["formats", "machine", "replay", "scenes", "settings", "store", "study", "tracer"]),
    ("testkit", &["formats", "replay"]),
    ("python", &["columns", "formats", "machine", "replay", "study"]),
    ("fuzz", &["formats", "machine", "replay", "scenes", "settings", "store", "study", "tracer"]),
];

/// What only tracing needs.
const TRACING: [&str; 5] = ["rayreel-tracer", "rayreel-scenes", "obvhs", "tobj", "glam"];

/// What is wrong with a member that depends on these others.
fn refused(member: &str, siblings: &[String]) -> Vec<String> {
    let row = SIBLINGS.iter().find(|(name, _)| format!("rayreel-{name}") == member);
    let Some((_, allowed)) = row else { return vec![format!("{member} has no place in the table")] };
    let known = |sibling: &String| allowed.iter().any(|name| *sibling == format!("rayreel-{name}"));
    let foreign = siblings.iter().filter(|sibling| !known(sibling));
    foreign.map(|sibling| format!("{member} depends on {sibling}, not only on {allowed:?}")).collect()
}

#[test]
fn siblings_are_those_of_the_design() {
    let graph = Graph::new();
    let found: Vec<String> =
        graph.members().iter().flat_map(|member| refused(member, &graph.siblings(member))).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
    // The walk finds what is there, and the table refuses what is not in it.
    assert_eq!(graph.siblings("rayreel-tracer"), ["rayreel-formats", "rayreel-scenes"]);
    assert_eq!(refused("rayreel-replay", &["rayreel-formats".into(), "rayreel-tracer".into()]).len(), 1);
    assert_eq!(refused("rayreel-attic", &[]), ["rayreel-attic has no place in the table"]);
}

#[test]
fn a_replay_needs_no_scene() {
    let graph = Graph::new();
    for member in ["formats", "settings", "machine", "replay", "columns", "store", "study"] {
        let closure = graph.closure(&format!("rayreel-{member}"));
        for name in TRACING {
            assert!(!closure.contains(name), "{member} depends on {name}");
        }
    }
    // The walk finds what is there: the tracer does depend on all of these.
    let tracer = graph.closure("rayreel-tracer");
    assert!(["rayreel-formats", "rayreel-scenes", "obvhs", "tobj", "glam"].iter().all(|name| tracer.contains(*name)));
}

/// It holds second implementations and made-up frames.
#[test]
fn the_testkit_is_for_tests_only() {
    let graph = Graph::new();
    for member in graph.members().into_iter().chain(["rayreel".to_string()]) {
        assert!(!graph.closure(&member).contains("rayreel-testkit"), "{member} depends on the testkit in a build");
    }
    // Tests do depend on it: the graph holds the arrow that is left out of builds.
    let tested = graph.node("rayreel-replay")["deps"].as_array().unwrap().clone();
    assert!(tested.iter().any(|dep| dep["name"] == "rayreel_testkit"));
}

/// A library user gets neither tables nor pages nor a cluster's scripts with the simulator.
#[test]
fn the_simulator_brings_no_tables_and_no_pages() {
    let graph = Graph::new();
    for member in ["formats", "settings", "machine", "replay"] {
        let closure = graph.closure(&format!("rayreel-{member}"));
        for name in ["parquet", "minijinja", "csv", "clap", "indicatif", "serde_json"] {
            assert!(!closure.contains(name), "{member} depends on {name}");
        }
    }
    assert!(graph.closure("rayreel-study").contains("serde_json"));
}

/// These features build another tree, and with it other traces.
#[test]
fn obvhs_builds_the_same_tree_everywhere() {
    let graph = Graph::new();
    let features: Vec<&str> =
        graph.node("obvhs")["features"].as_array().unwrap().iter().map(|f| f.as_str().unwrap()).collect();
    for feature in ["parallel", "small_bvh2_node"] {
        assert!(!features.contains(&feature), "feature {feature} of obvhs is on: {features:?}");
    }
}

/// The level of `unsafe_code` in a manifest; `deny` where it takes the workspace's table.
fn lint(manifest: &Path) -> Option<String> {
    let table: toml::Table = std::fs::read_to_string(manifest).unwrap().parse().unwrap();
    let lints = table.get("lints")?;
    if lints.get("workspace").and_then(toml::Value::as_bool) == Some(true) {
        return Some("deny".into());
    }
    Some(lints.get("rust")?.get("unsafe_code")?.as_str()?.to_string())
}

/// URLs are for those who ask for them: they bring as many packages as everything else.
#[test]
fn the_network_is_off_by_default() {
    let closure = Graph::new().closure("rayreel");
    for name in ["object_store", "tokio", "reqwest", "rustls", "hyper", "url"] {
        assert!(!closure.contains(name), "the default build depends on {name}");
    }
}

/// The crates that read files from anywhere, and all that stands between them and a result.
#[test]
fn readers_of_foreign_files_are_safe_code() {
    for member in
        ["formats", "settings", "scenes", "machine", "replay", "columns", "store", "study", "paper", "testkit"]
    {
        assert_eq!(lint(&root().join(member).join("Cargo.toml")).as_deref(), Some("forbid"), "{member}");
    }
}

/// Elsewhere unsafe code is refused unless a place asks for it with its reason. The root's table is the workspace's.
#[test]
fn no_member_leaves_the_safety_lint_out() {
    let workspace: toml::Table = std::fs::read_to_string(root().join("Cargo.toml")).unwrap().parse().unwrap();
    assert_eq!(workspace["workspace"]["lints"]["rust"]["unsafe_code"].as_str(), Some("deny"));
    for member in workspace["workspace"]["members"].as_array().unwrap() {
        let manifest = root().join(member.as_str().unwrap()).join("Cargo.toml");
        assert!(lint(&manifest).is_some_and(|level| level != "allow"), "{}", manifest.display());
    }
}
