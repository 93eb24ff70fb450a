//! `rayreel presets`: the machines and policies that replays can name, and where each number of a machine is from.

use anyhow::Result;
use clap::Subcommand;
use rayreel_machine::MachineError;
use rayreel_machine::config::schema::KEYS;
use rayreel_machine::config::{self, NamedMachine, Sourced};
use rayreel_replay::policy::{self, Policy, schema};
use rayreel_replay::{NamedPolicy, ReplayError};
use rayreel_study::policy_text::{comment, first_sentence, value_of};
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
    /// Show a preset, or a machine file (.toml): every value, how far it can be trusted, and where it is from.
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
        Action::Show { preset, set, json } => match NamedMachine::load(preset, set) {
            Ok(machine) if *json => print_json(&machine_json(&machine))?,
            Ok(machine) => print(&machine_text(&machine))?,
            Err(error @ MachineError::UnknownMachine { .. }) => match NamedPolicy::load(preset, set) {
                Ok(policy) => show_policy(&policy, *json)?,
                // Neither: the message that knows a similar name is the better one.
                Err(ReplayError::UnknownPreset { near, .. }) if !near.starts_with("did you mean") => {
                    return Err(error.into());
                }
                Err(error) => return Err(error.into()),
            },
            Err(error) => return Err(error.into()),
        },
    }
    Ok(Exit::Done)
}

fn list(as_json: bool) -> Result<()> {
    let mut machines = Vec::new();
    for (name, _) in config::PRESETS {
        let machine = NamedMachine::load(name, &[])?;
        let extends = machine.chain.get(1).map(|a| a.name.clone());
        machines.push((*name, extends, machine.chain[0].why.clone()));
    }
    let policies: Vec<_> = policy::PRESETS.iter().map(|(name, text)| (*name, comment(text))).collect();
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

fn machine_text(machine: &NamedMachine) -> String {
    let mut text = format!("# {}\n", machine.name);
    for ancestor in &machine.chain {
        text += &format!("# {}: {}\n", ancestor.name, ancestor.why);
    }
    let row = |v: &Sourced| {
        let (table, name) = v.key.rsplit_once('.').unwrap_or(("", v.key));
        let rule = KEYS.iter().find(|k| k.name == v.key).map(|k| k.rule);
        let shown = rule.map_or_else(|| v.value.to_string(), |rule| rule.show(&v.value));
        let from = if v.from == machine.chain[machine.chain.len() - 1].name {
            String::new()
        } else {
            format!(" [{}]", v.from)
        };
        (table, format!("{name} = {shown}"), format!("# {}: {}{from}", v.class, v.source))
    };
    let rows: Vec<_> = machine.values.iter().map(row).collect();
    let width = rows.iter().map(|(_, value, _)| value.len()).max().unwrap_or(0);
    let mut last = "";
    for (table, value, source) in &rows {
        if *table != last {
            text += &format!("\n[{table}]\n");
            last = table;
        }
        text += &format!("{value:<width$}  {source}\n");
    }
    text
}

fn show_policy(policy: &NamedPolicy, as_json: bool) -> Result<()> {
    let own = serde_json::to_value(&policy.policy)?;
    if as_json {
        return print_json(&json!({"name": policy.name, "policy": own}));
    }
    let mut text = format!("# {}\n", policy.name);
    for key in &keys(&policy.policy) {
        text += &format!("{:<40}  # {}\n", format!("{} = {}", key.name, value_of(&own, key.name)), key.doc);
    }
    print(&text)
}

fn keys(policy: &Policy) -> Vec<schema::Key> {
    schema::keys(policy.kind()).unwrap_or_default()
}
