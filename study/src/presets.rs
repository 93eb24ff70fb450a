//! A preset or a file, machine or policy, as a page and as JSON: every value, and of machines where it is from.

use rayreel_machine::config::{MACHINES, NamedMachine, Sourced};
use rayreel_replay::NamedPolicy;
use rayreel_replay::policy::{self, POLICIES};
use rayreel_settings::{is_path, near};
use serde_json::{Map, Value, json};

use crate::error::{Result, StudyError};

/// What stands behind a name.
pub enum Preset {
    /// A machine.
    Machine(Box<NamedMachine>),
    /// A policy.
    Policy(Box<NamedPolicy>),
}

impl Preset {
    /// Loads the preset or file `name` with overrides `key=value`.
    ///
    /// # Errors
    /// A name that is none, a file that cannot be read or says something wrong, a wrong override.
    pub fn load(name: &str, overrides: &[String]) -> Result<Self> {
        if is_policy(name) {
            return Ok(Self::Policy(Box::new(NamedPolicy::load(name, overrides)?)));
        }
        match NamedMachine::load(name, overrides) {
            Err(error) if !is_path(name) && !MACHINES.owns(name) => {
                let names: Vec<_> = policy::PRESETS.iter().map(|(name, _)| *name).collect();
                Err(StudyError::NoPreset { detail: format!("{error}; policies are {}", names.join(", ")) })
            }
            loaded => Ok(Self::Machine(Box::new(loaded?))),
        }
    }

    /// All of it, for people; what it says loads again.
    pub fn page(&self) -> String {
        match self {
            Self::Machine(machine) => machine.page(),
            Self::Policy(policy) => policy.page(),
        }
    }

    /// All of it, for programs.
    ///
    /// # Errors
    /// Never: values are numbers, words and switches.
    pub fn json(&self) -> Result<Value> {
        match self {
            Self::Machine(machine) => Ok(of_machine(machine)),
            Self::Policy(policy) => {
                let values = serde_json::to_value(&policy.policy).map_err(StudyError::json)?;
                Ok(json!({"name": policy.name, "policy": values}))
            }
        }
    }
}

/// Whether `name` is a policy rather than a machine. Of a name that is neither, the message that knows a similar one is better.
fn is_policy(name: &str) -> bool {
    let similar = || {
        let names: Vec<_> = policy::PRESETS.iter().map(|(name, _)| *name).collect();
        near(name, &names).starts_with("did you mean")
    };
    POLICIES.owns(name) || (!is_path(name) && !MACHINES.owns(name) && similar())
}

fn of_machine(machine: &NamedMachine) -> Value {
    let value = |v: &Sourced| json!({"value": v.value, "class": v.class.name(), "source": v.source, "from": v.from});
    json!({
        "name": machine.name,
        "chain": machine.chain.iter().map(|a| json!({"name": a.name, "why": a.why})).collect::<Vec<_>>(),
        "values": machine.values.iter().map(|v| (v.key.to_owned(), value(v))).collect::<Map<_, _>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_that_of_a_machine_or_of_a_policy() {
        let loaded = |name: &str| Preset::load(name, &[]).unwrap();
        let machine = loaded("raycore").json().unwrap();
        assert_eq!((&machine["name"], machine["values"]["gpu.cores"]["class"].is_string()), (&json!("raycore"), true));
        assert_eq!(loaded("paper-ss").json().unwrap()["policy"]["kind"], "adaptive");
        let set = Preset::load("multirate", &["correct.passes=1".into()]).unwrap();
        assert_eq!(set.json().unwrap()["policy"]["correct"]["passes"], 1);
    }

    #[test]
    fn of_no_name_all_that_there_are_are_told() {
        let told = |name: &str| Preset::load(name, &[]).err().unwrap().to_string();
        assert!(told("nothing").contains("sgrt-ti2") && told("nothing").contains("policies are full"));
        assert!(told("multirat").contains("did you mean multirate"), "{}", told("multirat"));
    }
}
