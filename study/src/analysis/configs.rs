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
            Self::Machine => NamedMachine::load(name, &[]).ok().map(|found| machine(&machine_json(&found))),
            Self::Policy => {
                let found = NamedPolicy::load(name, &[]).ok()?;
                serde_json::to_string(&found.policy).ok().map(|text| policy(&text))
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
    let mut config = Config::new();
    flatten("", &serde_json::from_str(text).unwrap_or_default(), &mut config);
    config
}

fn flatten(prefix: &str, value: &Value, config: &mut Config) {
    match value {
        Value::Object(table) => {
            for (key, value) in table {
                let name = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
                flatten(&name, value, config);
            }
        }
        Value::Null => {}
        Value::String(word) => drop(config.insert(prefix.into(), word.clone())),
        other => drop(config.insert(prefix.into(), other.to_string())),
    }
}

/// The configurations of the rows of a table, each different one kept once.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Configs {
    /// The different configurations.
    pub distinct: Vec<Config>,
    /// For each row the index of its configuration; none where the table has none.
    pub of: Vec<Option<usize>>,
}

impl Configs {
    /// The configurations of one half.
    pub fn new(results: &Results, half: Half) -> Self {
        let read = if half == Half::Machine { machine } else { policy };
        let Some(Cells::Text(texts)) = results.field(half.column()).map(|field| &field.cells) else {
            return Self { distinct: Vec::new(), of: vec![None; results.rows()] };
        };
        let (mut distinct, mut known) = (Vec::new(), BTreeMap::new());
        let mut index = |text: &String| {
            *known.entry(text.clone()).or_insert_with(|| {
                distinct.push(read(text));
                distinct.len() - 1
            })
        };
        let of = texts.iter().map(|text| text.as_ref().filter(|text| !text.is_empty()).map(&mut index)).collect();
        Self { distinct, of }
    }

    /// The configuration of a row.
    pub fn row(&self, row: usize) -> Option<&Config> {
        self.of[row].map(|index| &self.distinct[index])
    }

    /// All keys, in order.
    pub fn keys(&self) -> Vec<&str> {
        let mut keys: Vec<&str> = self.distinct.iter().flat_map(|config| config.keys().map(String::as_str)).collect();
        keys.sort_unstable();
        keys.dedup();
        keys
    }

    /// The keys that are not the same everywhere.
    pub fn varying(&self) -> Vec<&str> {
        let differs = |key: &&str| self.distinct.iter().any(|config| config.get(*key) != self.distinct[0].get(*key));
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
        let found = NamedMachine::load("sgrt-ti2", &["ti.trv_l1.size=32KiB".into(), "srp.ideal=true".into()]).unwrap();
        let (config, preset) = (machine(&machine_json(&found)), Half::Machine.preset("sgrt-ti2").unwrap());
        let changed: Vec<_> = config.iter().filter(|(key, value)| preset.get(*key) != Some(value)).collect();
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
        let configs = Configs::new(&table(vec![words("machine_config", Role::Config, &texts)]), Half::Machine);
        assert_eq!((configs.of.as_slice(), configs.distinct.len()), (&[Some(0), Some(1), Some(0), None][..], 2));
        assert_eq!((configs.keys(), configs.varying()), (vec!["a", "b"], vec!["a"]));
        assert_eq!(configs.row(1).unwrap()["a"], "3");
        let none = Configs::new(&table(vec![words("x", Role::Config, &["", ""])]), Half::Policy);
        assert!(none.varying().is_empty() && none.row(0).is_none());
    }
}
