//! One machine file: its head (`extends`, `why`) and its leaves, checked key by key.
//!
//! ```text
//! extends = "sgrt-ti2"
//! why = "a sentence on how it differs and why"
//! [ti]
//! trv = { value = 4, class = "memory", source = "Lee et al. 2013 (SGRT, HPG)" }
//! ```
//!
//! A file may also write the bare value; it then counts as an override whose source is the file.

use toml::{Table, Value};

use super::schema::{KEYS, Key};
use super::source::{Class, Sourced};
use crate::error::{MachineError, Result};
use rayreel_settings::near;

/// A file as it is written: nothing of what it extends is in it.
#[derive(Clone, Debug)]
pub struct Layer {
    /// What it extends, if anything.
    pub extends: Option<String>,
    /// How it differs from that, and why.
    pub why: String,
    /// What it sets, in the order of the keys.
    pub values: Vec<Sourced>,
}

/// Reads the text of a file; `origin` names it in messages and `from` in results.
///
/// # Errors
/// Bad TOML, an unknown key or class, a value that is not allowed, a leaf without a source.
pub fn parse(text: &str, origin: &str, from: &str) -> Result<Layer> {
    let mut table: Table = text.parse().map_err(|e: toml::de::Error| MachineError::MachineSyntax {
        origin: origin.into(),
        detail: e.to_string().trim_end().into(),
    })?;
    let mut head = |name: &str| match table.remove(name) {
        None => Ok(None),
        Some(Value::String(text)) => Ok(Some(text)),
        Some(other) => Err(bad_value(origin, name, &other, "a text in quotes".into())),
    };
    let (extends, why) = (head("extends")?, head("why")?.unwrap_or_default());
    let mut values = Vec::new();
    collect(&table, "", origin, from, &mut values)?;
    values.sort_by_key(|v| position(v.key));
    Ok(Layer { extends, why, values })
}

/// A value given as `key=value`; words and sizes need no quotes.
///
/// # Errors
/// Not of that form, an unknown key, a value that is not allowed.
pub fn parse_override(text: &str) -> Result<Sourced> {
    let bad = || MachineError::BadMachineOverride { text: text.into() };
    let (name, value) = text.split_once('=').ok_or_else(bad)?;
    let (name, value) = (name.trim(), value.trim());
    if name.is_empty() || value.is_empty() {
        return Err(bad());
    }
    let value = value.parse::<Value>().unwrap_or_else(|_| Value::String(value.into()));
    let origin = format!("override {text:?}");
    let key = find(name, &value, &origin)?;
    let value = accept(key, &value, &origin)?;
    Ok(Sourced { key: key.name, value, class: Class::Override, source: "command line".into(), from: "override".into() })
}

/// Puts `values` over `base`; both stay in the order of the keys.
pub fn over(base: &mut Vec<Sourced>, values: Vec<Sourced>) {
    for value in values {
        let place = position(value.key);
        match base.binary_search_by_key(&place, |v| position(v.key)) {
            Ok(i) => base[i] = value,
            Err(i) => base.insert(i, value),
        }
    }
}

/// Values as the nested table that the structs are read from.
pub fn nest(values: &[Sourced]) -> Table {
    let mut root = Table::new();
    for own in values {
        let mut parts: Vec<&str> = own.key.split('.').collect();
        let leaf = parts.pop().unwrap_or_default();
        let mut table = &mut root;
        for part in parts {
            let inner = table.entry(part).or_insert_with(|| Value::Table(Table::new()));
            let Value::Table(inner) = inner else { unreachable!("no key is the table of another") };
            table = inner;
        }
        table.insert(leaf.into(), own.value.clone());
    }
    root
}

/// Place of a key in [`KEYS`].
fn position(key: &str) -> usize {
    KEYS.iter().position(|k| k.name == key).unwrap_or(usize::MAX)
}

/// The leaves of `table`. Depth is bounded by that of the keys: a table that leads to none is an unknown key.
fn collect(table: &Table, prefix: &str, origin: &str, from: &str, out: &mut Vec<Sourced>) -> Result<()> {
    for (name, value) in table {
        let name = format!("{prefix}{name}");
        let inside = format!("{name}.");
        match value {
            Value::Table(inner) if KEYS.iter().any(|k| k.name.starts_with(&inside)) => {
                collect(inner, &inside, origin, from, out)?;
            }
            _ => {
                let key = find(&name, value, origin)?;
                out.push(leaf(key, value, origin, from)?);
            }
        }
    }
    Ok(())
}

/// A leaf: `{ value, class, source }`, or the bare value.
fn leaf(key: &Key, value: &Value, origin: &str, from: &str) -> Result<Sourced> {
    let Value::Table(parts) = value else {
        let value = accept(key, value, origin)?;
        let source = format!("set in {from}");
        return Ok(Sourced { key: key.name, value, class: Class::Override, source, from: from.into() });
    };
    const PARTS: &[&str] = &["value", "class", "source"];
    if let Some(part) = parts.keys().find(|part| !PARTS.contains(&part.as_str())) {
        let key = format!("{}.{part}", key.name);
        return Err(MachineError::UnknownMachineKey { origin: origin.into(), key, near: near(part, PARTS) });
    }
    let missing = Value::String("(missing)".into());
    let part = |name: &str| parts.get(name).unwrap_or(&missing);
    let wrong = |name: &str, allowed: String| bad_value(origin, &format!("{}.{name}", key.name), part(name), allowed);
    let classes = || Class::ALL.map(|c| format!("{:?}", c.name())).join(" or ");
    let class = part("class").as_str().and_then(Class::parse).ok_or_else(|| wrong("class", classes()))?;
    let source = parts.get("source").and_then(Value::as_str).map(str::trim).filter(|s| !s.is_empty());
    let source = source.ok_or_else(|| wrong("source", "a text that says where the value is from".into()))?.into();
    Ok(Sourced { key: key.name, value: accept(key, part("value"), origin)?, class, source, from: from.into() })
}

/// The key of this name. A value where a table of keys belongs is a bad value; all else is an unknown key.
fn find(name: &str, value: &Value, origin: &str) -> Result<&'static Key> {
    if let Some(key) = KEYS.iter().find(|k| k.name == name) {
        return Ok(key);
    }
    let inside = format!("{name}.");
    let below: Vec<_> = KEYS.iter().filter_map(|k| k.name.strip_prefix(inside.as_str())).collect();
    if !below.is_empty() {
        return Err(bad_value(origin, name, value, format!("a table with {}", below.join(", "))));
    }
    // A slip of the key is likelier than one of the table.
    let table = name.rsplit_once('.').map_or("", |(table, _)| table);
    let sisters = |key: &&str| key.rsplit_once('.').is_some_and(|(own, _)| own == table);
    let names: Vec<_> = KEYS.iter().map(|k| k.name).collect();
    let own: Vec<_> = names.iter().copied().filter(sisters).collect();
    let found = [own, names].iter().map(|names| near(name, names)).find(|text| text.starts_with("did you mean"));
    let near = found.unwrap_or_else(|| "`rayreel presets show sgrt-ti2` lists all keys".into());
    Err(MachineError::UnknownMachineKey { origin: origin.into(), key: name.into(), near })
}

fn accept(key: &Key, value: &Value, origin: &str) -> Result<Value> {
    key.rule.accept(value).ok_or_else(|| bad_value(origin, key.name, value, key.rule.describe()))
}

fn bad_value(origin: &str, key: &str, value: &Value, allowed: String) -> MachineError {
    MachineError::BadValue { origin: origin.into(), key: key.into(), value: value.to_string(), allowed }
}
