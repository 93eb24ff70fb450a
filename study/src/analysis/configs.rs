//! Resolved configurations, key by key: what a point is made of, what it changes of its preset, and what two tables differ in.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::point::key::machine_json;
use crate::table::{Cells, Results};
use rayreel_machine::config::NamedMachine;
use rayreel_machine::config::schema::KEYS;
use rayreel_replay::policy::NamedPolicy;

/// The two halves of a configuration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// The machine: its keys begin with one of its tables, such as `ti` or `l2`.
    Machine,
    /// The policy: all other keys.
    Policy,
}

impl Half {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Machine, Self::Policy];

    /// The column of results with the name of the preset or file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Machine => "machine",
            Self::Policy => "policy",
        }
    }

    /// The column of results with all values.
    pub fn column(self) -> &'static str {
        match self {
            Self::Machine => "machine_config",
            Self::Policy => "policy_config",
        }
    }

    /// The values of a preset of this program; nothing if there is none of this name.
    pub fn preset(self, name: &str) -> Option<Config> {
        // A name with a dot or a slash would be read as a file, which need not be what the results were made with.
        if name.contains(['.', '/', '\\']) {
            return None;
        }
        match self {
            Self::Machine => NamedMachine::load(name, &[]).ok().map(|own| machine(&machine_json(&own))),
            Self::Policy => {
                let own = NamedPolicy::load(name, &[]).ok()?;
                serde_json::to_string(&own.policy).ok().map(|text| policy(&text))
            }
        }
    }
}

/// Values by key, as overrides write them.
pub type Config = BTreeMap<String, String>;

/// Reads the JSON of a machine.
pub fn machine(text: &str) -> Config {
    let show = |key: &str, value: &Value| {
        let rule = KEYS.iter().find(|known| known.name == key).map(|known| known.rule);
        let text = value.to_string();
        // Numbers, flags and words are written alike in JSON and TOML.
        let shown = rule.and_then(|rule| text.parse().ok().map(|value| rule.show(&value)));
        shown.unwrap_or(text).trim_matches('"').to_owned()
    };
    let values: BTreeMap<String, Value> = serde_json::from_str(text).unwrap_or_default();
    values.iter().map(|(key, value)| (key.clone(), show(key, value))).collect()
}

/// Reads the JSON of a policy: tables become keys with dots.
pub fn policy(text: &str) -> Config {
    let mut own = Config::new();
    flatten("", &serde_json::from_str(text).unwrap_or_default(), &mut own);
    own
}

fn flatten(prefix: &str, value: &Value, own: &mut Config) {
    match value {
        Value::Object(table) => {
            for (key, value) in table {
                let name = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
                flatten(&name, value, own);
            }
        }
        Value::Null => {}
        Value::String(word) => drop(own.insert(prefix.into(), word.clone())),
        other => drop(own.insert(prefix.into(), other.to_string())),
    }
}

/// The configurations of a table: few different ones for many rows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Configs {
    /// The different ones.
    pub own: Vec<Config>,
    /// For each row the index of its own; none where the table has none.
    pub of: Vec<Option<usize>>,
}

impl Configs {
    /// The configurations of one half.
    pub fn new(results: &Results, half: Half) -> Self {
        let read = if half == Half::Machine { machine } else { policy };
        let Some(Cells::Text(texts)) = results.field(half.column()).map(|field| &field.cells) else {
            return Self { own: Vec::new(), of: vec![None; results.rows()] };
        };
        let (mut own, mut known) = (Vec::new(), BTreeMap::new());
        let mut index = |text: &String| {
            *known.entry(text.clone()).or_insert_with(|| {
                own.push(read(text));
                own.len() - 1
            })
        };
        let of = texts.iter().map(|text| text.as_ref().filter(|text| !text.is_empty()).map(&mut index)).collect();
        Self { own, of }
    }

    /// The configuration of a row.
    pub fn row(&self, row: usize) -> Option<&Config> {
        self.of[row].map(|index| &self.own[index])
    }

    /// All keys, in order.
    pub fn keys(&self) -> Vec<&str> {
        let mut keys: Vec<&str> = self.own.iter().flat_map(|own| own.keys().map(String::as_str)).collect();
        keys.sort_unstable();
        keys.dedup();
        keys
    }

    /// The keys that are not the same everywhere.
    pub fn varying(&self) -> Vec<&str> {
        let differs = |key: &&str| self.own.iter().any(|own| own.get(*key) != self.own[0].get(*key));
        self.keys().into_iter().filter(differs).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::tables::{table, words};
    use super::*;
    use crate::table::Role;

    #[test]
    fn machines_and_policies_are_read_back_as_overrides_write_them() {
        let own = NamedMachine::load("sgrt-ti2", &["ti.trv_l1.size=32KiB".into(), "srp.ideal=true".into()]).unwrap();
        let (own, preset) = (machine(&machine_json(&own)), Half::Machine.preset("sgrt-ti2").unwrap());
        let changed: Vec<_> = own.iter().filter(|(key, value)| preset.get(*key) != Some(value)).collect();
        assert_eq!(
            changed.iter().map(|(k, v)| format!("{k}={v}")).collect::<Vec<_>>(),
            ["srp.ideal=true", "ti.trv_l1.size=32KiB"]
        );
        assert_eq!(preset["ti.miss_handling"], "retry");
        let preset = Half::Policy.preset("adaptive").unwrap();
        assert_eq!((preset["block"].as_str(), preset["similarity.normal_deg"].as_str()), ("2", "10.0"));
        assert_eq!(preset["similarity.colour"], "off");
        assert_eq!(Half::Machine.preset("nonsense"), None);
        assert_eq!(Half::Machine.preset("../x.toml"), None);
    }

    #[test]
    fn equal_ones_are_kept_once() {
        let texts = [r#"{"b":1,"a":2}"#, r#"{"a":3,"b":1}"#, r#"{"b":1,"a":2}"#, ""];
        let own = Configs::new(&table(vec![words("machine_config", Role::Config, &texts)]), Half::Machine);
        assert_eq!((own.of.as_slice(), own.own.len()), (&[Some(0), Some(1), Some(0), None][..], 2));
        assert_eq!((own.keys(), own.varying()), (vec!["a", "b"], vec!["a"]));
        assert_eq!(own.row(1).unwrap()["a"], "3");
        let none = Configs::new(&table(vec![words("x", Role::Config, &["", ""])]), Half::Policy);
        assert!(none.varying().is_empty() && none.row(0).is_none());
    }
}
