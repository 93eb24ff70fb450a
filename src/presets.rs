//! `rayreel presets`: the machines and policies that replays can name, and where each number of a machine is from.

use anyhow::Result;
use clap::Subcommand;
use rayreel_machine::config::{MACHINES, PRESETS};
use rayreel_replay::policy;
use rayreel_study::policy_text::{first_sentence, why};
use rayreel_study::presets::Preset;
use serde_json::json;

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
    let preset = Preset::load(preset, set)?;
    if as_json { print_json(&preset.json()?) } else { print(&preset.page()) }
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
