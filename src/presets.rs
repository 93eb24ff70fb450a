//! `rayreel presets`: the machines and policies that replays can name, and where each number of a machine is from.

use anyhow::Result;
use clap::Subcommand;
use rayreel_machine::config::{MACHINES, NamedMachine, PRESETS, Sourced};
use rayreel_machine::MachineError;
use rayreel_replay::policy::{self, POLICIES, Policy};
use rayreel_replay::{NamedPolicy, ReplayError};
use rayreel_settings::{Family, SettingsError, is_path};
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
        Action::Show { preset, set, json } => show(preset, set, *json)?,
    }
    Ok(Exit::Done)
}

fn show(preset: &str, set: &[String], as_json: bool) -> Result<()> {
    if POLICIES.owns(preset) || (!is_path(preset) && !MACHINES.owns(preset) && nearer_to_policies(preset)) {
        let policy = NamedPolicy::load(preset, set)?;
        return if as_json { print_json(&policy_json(&policy)?) } else { print(&policy.page()) };
    }
    let machine = NamedMachine::load(preset, set)?;
    if as_json { print_json(&machine_json(&machine)) } else { print(&machine.page()) }
}

/// What a policy preset does, in one sentence.
pub fn policy_summary(preset: &str) -> String {
    let text = policy::PRESETS.iter().find(|(name, _)| *name == preset).map_or("", |(_, text)| text);
    first_sentence(&comment(text)).to_owned()
}

/// Every value of a policy, as a policy file.
pub fn policy_values(policy: &Policy) -> Result<String> {
    let own = serde_json::to_value(policy)?;
    Ok(keys(policy).iter().map(|key| format!("{} = {}\n", key.name, value_of(&own, key))).collect())
}

/// The value of a key.
fn value_of<'a>(own: &'a Value, key: &schema::Key) -> &'a Value {
    key.name.split('.').try_fold(own, |value, part| value.get(part)).unwrap_or(&Value::Null)
}

/// The comment at the head of a policy preset.
fn comment(text: &str) -> String {
    let lines = text.lines().map_while(|line| line.strip_prefix('#'));
    lines.map(str::trim).collect::<Vec<_>>().join(" ")
}

fn first_sentence(text: &str) -> &str {
    // "et al. 2016" and "2.0:" are no ends: a sentence ends where a capital letter follows.
    let ends = text.match_indices(". ").map(|(i, _)| i);
    let mut ends = ends.filter(|i| text[i + 2..].starts_with(|c: char| c.is_ascii_uppercase()));
    ends.next().map_or(text, |end| &text[..=end])
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
        text += &format!("{:<40}  # {}\n", format!("{} = {}", key.name, value_of(&own, key)), key.doc);
    }
    print(&text)
}

fn keys(policy: &Policy) -> Vec<schema::Key> {
    schema::keys(policy.kind()).unwrap_or_default()
}
