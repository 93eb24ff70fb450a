//! `rayreel presets`: the machines and policies that replays can name, and where each number of a machine is from.

use anyhow::{Result, bail};
use clap::Subcommand;
use rayreel_machine::config::{MACHINES, NamedMachine, PRESETS, Sourced};
use rayreel_replay::NamedPolicy;
use rayreel_replay::policy::{self, POLICIES};
use rayreel_settings::{is_path, near};
use rayreel_study::policy_text::{first_sentence, why};
use serde_json::{Map, Value, json};

use crate::common::{print, print_json};
use crate::exit::Exit;

/// List the machine and policy presets, or show one with the source of each value.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// List the machine and policy presets.
    List {
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
    /// Show a preset, or a machine or policy file (.toml): every value, how far it can be trusted, and where it is from.
    Show {
        /// Name or path.
        preset: String,
        /// Change a value, for example ti.trv_l1.size=32KiB. Can be repeated.
        #[arg(long, value_name = "KEY=VALUE")]
        set: Vec<String>,
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
}

pub fn run(args: &Args) -> Result<Exit> {
    match &args.action {
        Action::List { json } => list(*json)?,
        Action::Show { preset, set, json } => show(preset, set, *json)?,
    }
    Ok(Exit::Done)
}

fn show(preset: &str, set: &[String], as_json: bool) -> Result<()> {
    if is_policy(preset) {
        let policy = NamedPolicy::load(preset, set)?;
        return if as_json { print_json(&policy_json(&policy)?) } else { print(&policy.page()) };
    }
    let machine = match NamedMachine::load(preset, set) {
        Err(error) if !is_path(preset) && !MACHINES.owns(preset) => {
            let names: Vec<_> = policy::PRESETS.iter().map(|(name, _)| *name).collect();
            bail!("{error}; policies are {}", names.join(", "));
        }
        loaded => loaded?,
    };
    if as_json { print_json(&machine_json(&machine)) } else { print(&machine.page()) }
}

/// Whether `preset` is a policy rather than a machine. Of a name that is neither, the message that knows a similar one is better.
fn is_policy(preset: &str) -> bool {
    let similar = || {
        let names: Vec<_> = policy::PRESETS.iter().map(|(name, _)| *name).collect();
        near(preset, &names).starts_with("did you mean")
    };
    POLICIES.owns(preset) || (!is_path(preset) && !MACHINES.owns(preset) && similar())
}

fn list(as_json: bool) -> Result<()> {
    let mut machines = Vec::new();
    for (name, _) in PRESETS {
        let chain = MACHINES.load(name)?.chain;
        machines.push((*name, chain.get(1).map(|base| base.name.clone()), chain[0].why.clone()));
    }
    let policies: Vec<_> = policy::PRESETS.iter().map(|(name, _)| (*name, why(name))).collect();
    if as_json {
        let machine = |(name, extends, why): &(&str, Option<String>, String)| json!({"name": name, "extends": extends, "why": why});
        return print_json(&json!({
            "machines": machines.iter().map(machine).collect::<Vec<_>>(),
            "policies": policies.iter().map(|(name, why)| json!({"name": name, "why": why})).collect::<Vec<_>>(),
        }));
    }
    let mut text = "machines\n".to_owned();
    machines.iter().for_each(|(name, _, why)| text += &format!("  {name:<22} {}\n", first_sentence(why)));
    text += "\npolicies\n";
    policies.iter().for_each(|(name, why)| text += &format!("  {name:<22} {}\n", first_sentence(why)));
    print(&text)
}

fn machine_json(machine: &NamedMachine) -> Value {
    let value = |v: &Sourced| json!({"value": v.value, "class": v.class.name(), "source": v.source, "from": v.from});
    json!({
        "name": machine.name,
        "chain": machine.chain.iter().map(|a| json!({"name": a.name, "why": a.why})).collect::<Vec<_>>(),
        "values": machine.values.iter().map(|v| (v.key.to_owned(), value(v))).collect::<Map<_, _>>(),
    })
}

fn policy_json(policy: &NamedPolicy) -> Result<Value> {
    Ok(json!({"name": policy.name, "policy": serde_json::to_value(&policy.policy)?}))
}
