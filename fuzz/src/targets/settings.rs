//! Machines, policies, overrides.

use std::sync::LazyLock;

use rayreel_machine::config::{MACHINES, NamedMachine};
use rayreel_replay::policy::{NamedPolicy, POLICIES};
use rayreel_settings::Loaded;

use crate::target::{Target, text, told};

/// A machine that changes some of a preset.
const MACHINE: &str = "extends = \"sgrt-ti2\"\n[gpu]\ncores = 2\n[ti]\ntrv = 3\ntrv_l1 = { size = \"8KiB\", ways = 2 }\n\
    miss_handling = \"reorder\"\n[srp]\nideal = true\n";

pub fn targets() -> Vec<Target> {
    let target = |name, seeds, read| Target { name, seeds, read, change: None, mend: None };
    vec![
        target("machine", machines, |bytes| {
            let loaded = NamedMachine::parse("m", &text(bytes), &[]);
            if let Ok(machine) = &loaded {
                let again = NamedMachine::parse("m", &machine.to_toml(), &[]).expect("what is printed loads again");
                assert_eq!(again.canonical(), machine.canonical());
            }
            told(&loaded)
        }),
        target("policy", policies, |bytes| {
            let loaded = NamedPolicy::parse("p", &text(bytes), &[]);
            if let Ok(policy) = &loaded {
                let printed = policy.to_toml().expect("a policy can be printed");
                NamedPolicy::parse("p", &printed, &[]).expect("what is printed loads again");
            }
            told(&loaded)
        }),
        target("override", overrides, |bytes| {
            static PRESETS: LazyLock<[Loaded; 2]> = LazyLock::new(|| {
                [MACHINES.load("sgrt-ti2").expect("a preset"), POLICIES.load("adaptive").expect("a preset")]
            });
            let mut said = String::new();
            for mut loaded in PRESETS.iter().cloned() {
                for line in text(bytes).lines().take(20) {
                    said = said + &told(&loaded.set(line)) + " ";
                }
            }
            said
        }),
    ]
}

fn machines() -> Vec<Vec<u8>> {
    let whole = NamedMachine::load("raycore", &[]).expect("a preset").to_toml();
    vec![MACHINE.into(), whole.into()]
}

fn policies() -> Vec<Vec<u8>> {
    let whole = |name| NamedPolicy::load(name, &[]).and_then(|policy| policy.to_toml()).expect("a preset").into_bytes();
    vec![b"extends = \"adaptive\"\n".to_vec(), whole("multirate"), whole("full")]
}

fn overrides() -> Vec<Vec<u8>> {
    let lines = ["gpu.cores=2\nti.trv_l1.size=32KiB", "kind=multirate", "srp.ideal=true", "ti={ trv = 3 }"];
    lines.map(|line| line.as_bytes().to_vec()).to_vec()
}
