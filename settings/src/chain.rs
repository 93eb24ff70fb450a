//! Files that extend one another.

use std::path::{Path, PathBuf};

use toml::Value;

use crate::error::{Result, SettingsError};
use crate::family::{Family, is_path};
use crate::file::File;
use crate::files::{TEXT_MAX, read_text};
use crate::rule::Rule;

/// Files that may extend one another in a row.
const CHAIN_MAX: usize = 16;

/// A preset or file in a chain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ancestor {
    /// Preset name or file stem.
    pub name: String,
    /// How it differs from the next of the chain, and why.
    pub why: String,
}

/// The preset or file `spec`, what it extends, and so on to the base.
pub(crate) fn load(family: &Family, spec: &str) -> Result<Vec<File>> {
    let mut folder = PathBuf::new();
    let first = read(family, spec, None, &mut folder)?;
    follow(family, first, folder)
}

/// `first`, what it extends, and so on to the base. A path in `extends` is relative to the folder of the file that holds it.
pub(crate) fn follow(family: &Family, first: File, mut folder: PathBuf) -> Result<Vec<File>> {
    let mut chain = vec![first];
    while let Some(spec) = base(family, &chain[chain.len() - 1])? {
        let by = &chain[chain.len() - 1].origin;
        let next = read(family, &spec, Some(by), &mut folder)?;
        let seen = chain.iter().any(|known| known.origin == next.origin);
        chain.push(next);
        if seen || chain.len() > CHAIN_MAX {
            let names: Vec<_> = chain.iter().map(|file| file.origin.as_str()).collect();
            return Err(SettingsError::Circle { what: family.what, chain: names.join(" -> "), limit: CHAIN_MAX });
        }
    }
    Ok(chain)
}

/// The kind of a chain: that of its base, which every other file may repeat. Empty if the family has no kinds.
pub(crate) fn kind(chain: &[File]) -> Result<&'static str> {
    let kind = chain.last().and_then(|base| base.kind).unwrap_or_default();
    for file in chain {
        if let Some(other) = file.kind.filter(|other| *other != kind) {
            let allowed = format!("{kind:?}, the kind of what it extends");
            return Err(SettingsError::bad_value(&file.origin, "kind", &Value::String(other.into()), allowed));
        }
    }
    Ok(kind)
}

/// Whether `spec` is a preset of the family, or a file that leads to one or names one of its kinds. False for what cannot be read.
pub(crate) fn leads_to(family: &Family, spec: &str) -> bool {
    let (mut spec, mut folder) = (spec.to_owned(), PathBuf::new());
    for _ in 0..CHAIN_MAX {
        if family.preset(&spec).is_some() {
            return true;
        }
        let Ok(text) = read_text(&folder.join(&spec), TEXT_MAX) else { return false };
        let Ok(table) = text.parse::<toml::Table>() else { return false };
        if !family.kinds.is_empty() && table.contains_key("kind") {
            return true;
        }
        let Some(next) = table.get("extends").and_then(Value::as_str) else { return false };
        folder = folder.join(&spec).parent().map(Path::to_path_buf).unwrap_or_default();
        spec = next.to_owned();
    }
    false
}

/// What `file` extends, in words or because it names a kind.
fn base(family: &Family, file: &File) -> Result<Option<String>> {
    if file.extends.is_some() || family.kinds.is_empty() {
        return Ok(file.extends.clone());
    }
    let kind = file.kind.ok_or_else(|| SettingsError::Unsaid {
        origin: file.origin.clone(),
        key: "kind".into(),
        allowed: Rule::Word(family.kinds).describe(),
    })?;
    Ok((file.origin != preset_origin(kind)).then(|| kind.to_owned()))
}

/// One preset or file, which the file `by` extends, if there is one; `folder` becomes that of the file.
fn read(family: &Family, spec: &str, by: Option<&str>, folder: &mut PathBuf) -> Result<File> {
    if let Some((name, text)) = family.preset(spec) {
        return File::parse(family, name, &preset_origin(name), text);
    }
    if !is_path(spec) {
        return Err(family.unknown_preset(spec, by));
    }
    let path = folder.join(spec);
    // A file of a stranger may extend any file that the reader can read: it says nothing of what stands in one of another kind.
    if let Some(by) = by.filter(|_| !spec.ends_with(".toml")) {
        return Err(SettingsError::Extends { by: by.into(), what: family.what, spec: spec.into() });
    }
    let text = read_text(&path, TEXT_MAX).map_err(|source| SettingsError::File {
        by: by.map(str::to_owned),
        what: family.what,
        path: path.clone(),
        source,
    })?;
    *folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
    let name = path.file_stem().map_or_else(|| spec.into(), |stem| stem.to_string_lossy().into_owned());
    let origin = path.display().to_string();
    if by.is_some()
        && let Err(error) = text.parse::<toml::Table>()
    {
        let line = error.span().map_or(1, |span| text[..span.start.min(text.len())].matches('\n').count() + 1);
        let detail = format!("it is no TOML, from line {line} on");
        return Err(SettingsError::Syntax { origin, expected: family.expected, detail });
    }
    File::parse(family, &name, &origin, &text)
}

/// What messages call a preset.
fn preset_origin(name: &str) -> String {
    format!("preset {name}")
}
