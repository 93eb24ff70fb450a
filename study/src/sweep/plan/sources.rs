//! What a plan names: its traces, machines and policies, found and read.

use std::ops::Range;
use std::path::Path;

use rayreel_formats::trace::Trace;

use crate::error::Result;
use crate::sweep::plan::file::{At, PlanFile};
use crate::sweep::plan::locate::Text;
use crate::sweep::plan::{Base, TraceRef};
use rayreel_machine::config::NamedMachine;
use rayreel_replay::Detail;
use rayreel_replay::policy::NamedPolicy;
use rayreel_store::{Location, in_folder};

/// What a plan is made from.
pub struct Sources<'a> {
    /// The file.
    pub text: Text<'a>,
    /// Its folder: relative paths begin there.
    pub folder: &'a Path,
    /// Where relative traces begin instead: a folder, or an address.
    pub traces: Option<&'a str>,
    /// Name of the plan if the file gives none.
    pub stem: &'a str,
    /// How much is simulated cycle by cycle, whatever the file says.
    pub detail: Option<Detail>,
    /// Opens a trace at a path or address.
    pub open: &'a dyn Fn(&str) -> Result<Trace, String>,
}

/// A list that must not be empty.
fn filled<'a>(list: &'a At<Vec<At<String>>>, what: &str, text: Text<'_>) -> Result<&'a [At<String>]> {
    if list.get_ref().is_empty() {
        return Err(text.error(&list.span(), format!("{what} is empty; name at least one")));
    }
    Ok(list.get_ref())
}

fn is_address(location: &str) -> bool {
    location.contains("://")
}

/// The traces of a plan, each once.
///
/// # Errors
/// One that is not there, incomplete, or called as another.
pub fn traces(file: &PlanFile, sources: &Sources<'_>) -> Result<Vec<TraceRef>> {
    let text = sources.text;
    let mut all: Vec<TraceRef> = Vec::new();
    // All traces that cannot be opened are reported at once: whoever fetches them needs the whole list.
    let mut missing: Vec<(Range<usize>, String, String)> = Vec::new();
    for entry in filled(&file.traces, "traces", text)? {
        for location in locations(entry, sources)? {
            match (sources.open)(&location) {
                Ok(trace) => add(&mut all, &trace, &location).map_err(|detail| text.error(&entry.span(), detail))?,
                Err(why) => missing.push((entry.span(), shown(&location), why)),
            }
        }
    }
    let Some((span, location, why)) = missing.first() else { return Ok(all) };
    let others: Vec<&str> = missing[1..].iter().map(|(_, location, _)| location.as_str()).collect();
    let others =
        if others.is_empty() { String::new() } else { format!("; nor can these be opened: {}", others.join(", ")) };
    Err(text.error(span, format!("trace {location}: {why}{others}")))
}

/// What may be written down of a location: an address without user, password and query, any of which may be a secret.
fn shown(location: &str) -> String {
    Location::from(location).to_string()
}

/// Adds a trace, unless it is there already. An error says what is wrong with it.
fn add(all: &mut Vec<TraceRef>, trace: &Trace, whole: &str) -> Result<(), String> {
    let location = &shown(whole);
    if let Some((frame, tile)) = trace.missing_tiles().first() {
        return Err(format!(
            "trace {location} is incomplete: tile {tile} of frame {frame} is missing; capture it again"
        ));
    }
    let found = reference(trace, whole).map_err(|e| format!("trace {location}: {e}"))?;
    if let Some(other) = all.iter().find(|known| known.name == found.name && known.location != found.location) {
        let (name, other) = (&found.name, &other.location);
        return Err(format!("two traces are called {name}: {other} and {location}; rename one"));
    }
    match all.iter().find(|known| known.location == found.location) {
        // Rows and RAYREEL_TRACE_URLS could not tell them apart either.
        Some(other) if other.fingerprint != found.fingerprint => Err(format!(
            "two traces are at {location}, by addresses that differ in what a plan does not keep (user, password, query); give one of \
             them another path"
        )),
        Some(_) => Ok(()),
        None => {
            all.push(found);
            Ok(())
        }
    }
}

/// What a plan says of an open trace.
fn reference(trace: &Trace, location: &str) -> rayreel_formats::Result<TraceRef> {
    let meta = trace.meta();
    let (signed, location) = (Location::from(location).has_secret(), shown(location));
    let name = location.rsplit(['/', '\\']).next().unwrap_or(&location).to_owned();
    Ok(TraceRef {
        name,
        location,
        signed,
        fingerprint: trace.fingerprint()?.to_string(),
        scene: meta.scene.clone(),
        size: (meta.width, meta.height),
        samples: meta.samples,
        frames: (meta.first_frame, meta.frames),
    })
}

/// The traces that an entry names, sorted.
fn locations(entry: &At<String>, sources: &Sources<'_>) -> Result<Vec<String>> {
    let (name, wrong) = (entry.get_ref(), |detail: String| sources.text.error(&entry.span(), detail));
    let far = sources.traces.filter(|base| is_address(base));
    let is_pattern = name.contains(['*', '?', '[']);
    // Names of objects may have brackets in them, and a question mark begins a query.
    let object = name.split(['?', '#']).next().unwrap_or_default();
    if object.contains('*') && (is_address(name) || far.is_some()) {
        return Err(wrong(format!(
            "traces {name:?}: patterns are for files on this machine; name each object by itself"
        )));
    }
    if is_address(name) {
        return Ok(vec![name.clone()]);
    }
    if let Some(base) = far {
        return Ok(vec![in_folder(base, name)]);
    }
    let text =
        |path: &Path| path.to_str().map(str::to_owned).ok_or_else(|| wrong(format!("{} is no text", path.display())));
    // The folder of a plan in the current one is empty.
    let folder = std::path::absolute(Path::new(".").join(sources.traces.map_or(sources.folder, Path::new)));
    let folder = folder.map_err(|e| wrong(format!("trace {name:?}: {e}")))?;
    let path = std::path::absolute(folder.join(name)).map_err(|e| wrong(format!("trace {name:?}: {e}")))?;
    if !is_pattern {
        return Ok(vec![text(&path)?]);
    }
    // The folder is no part of the pattern.
    let pattern = Path::new(&glob::Pattern::escape(&text(&folder)?)).join(name);
    let found = glob::glob(&text(&pattern)?).map_err(|e| wrong(format!("traces {name:?}: {e}")))?;
    let mut all = Vec::new();
    for path in found {
        let path = path.map_err(|e| wrong(format!("traces {name:?}: {e}")))?;
        all.push(text(&path)?);
    }
    if all.is_empty() {
        return Err(wrong(format!("no file matches {}; capture traces first, or correct the pattern", path.display())));
    }
    Ok(all)
}

/// The name of a preset, or the path of a file relative to the plan.
fn spec(entry: &str, folder: &Path) -> String {
    if entry.ends_with(".toml") || entry.contains(['/', '\\']) {
        return folder.join(entry).display().to_string();
    }
    entry.to_owned()
}

/// The machines of a plan; `sgrt-ti2` if it names none.
///
/// # Errors
/// One that does not exist or cannot be read, or is named twice.
pub fn machines(file: &PlanFile, sources: &Sources<'_>) -> Result<Vec<Base>> {
    let load = |entry: &str, at: &Range<usize>| {
        if entry == "none" {
            return Ok(Base { name: "none".into(), toml: String::new() });
        }
        let machine = NamedMachine::load(&spec(entry, sources.folder), &[]);
        let machine = machine.map_err(|e| sources.text.error(at, e.to_string()))?;
        Ok(Base { toml: machine.to_toml(), name: machine.name })
    };
    let Some(list) = &file.machines else { return Ok(vec![load("sgrt-ti2", &(0..0))?]) };
    let all = filled(list, "machines", sources.text)?;
    distinct(all.iter().map(|entry| load(entry.get_ref(), &entry.span())).collect::<Result<_>>()?, all, sources.text)
}

/// The policies of a plan.
///
/// # Errors
/// One that does not exist or cannot be read, or is named twice.
pub fn policies(file: &PlanFile, sources: &Sources<'_>) -> Result<Vec<Base>> {
    let load = |entry: &At<String>| {
        let policy = NamedPolicy::load(&spec(entry.get_ref(), sources.folder), &[]);
        let policy = policy.map_err(|e| sources.text.error(&entry.span(), e.to_string()))?;
        Ok(Base { toml: policy.to_toml()?, name: policy.name })
    };
    let all = filled(&file.policies, "policies", sources.text)?;
    distinct(all.iter().map(load).collect::<Result<_>>()?, all, sources.text)
}

/// Refuses two of one name: their rows could not be told apart.
fn distinct(all: Vec<Base>, entries: &[At<String>], text: Text<'_>) -> Result<Vec<Base>> {
    for (i, base) in all.iter().enumerate() {
        if all[..i].iter().any(|other| other.name == base.name) {
            return Err(text.error(&entries[i].span(), format!("{:?} stands here twice; rename one", base.name)));
        }
    }
    Ok(all)
}
