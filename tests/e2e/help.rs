//! The help of every command, as it was last agreed on: no flag comes, goes or changes unnoticed.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs;

use rayreel_machine::config::schema::KEYS;

use crate::common::{BLESS, blessing, repository, run};

/// The help of a command, by the words that call it.
fn help(words: &[String]) -> String {
    let mut args: Vec<OsString> = words.iter().map(OsString::from).collect();
    args.push("--help".into());
    run(&args).expect(0).out
}

/// The commands below one, as its help lists them.
fn commands(help: &str) -> Vec<String> {
    let list = help.split("Commands:\n").nth(1).unwrap_or_default();
    let lines = list.lines().take_while(|line| !line.trim().is_empty());
    // Continued descriptions are indented deeper.
    let names = lines.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    names.map(|line| line.split_whitespace().next().unwrap().to_string()).filter(|name| name != "help").collect()
}

/// All helps by file name.
fn all(words: &[String], found: &mut Vec<(String, String)>) {
    let text = help(words);
    let name = if words.is_empty() { "rayreel".to_string() } else { words.join("-") };
    for command in commands(&text) {
        all(&[words, &[command]].concat(), found);
    }
    found.push((format!("{name}.txt"), text));
}

#[test]
fn help_is_as_agreed() {
    let folder = repository("tests/help");
    let mut found = Vec::new();
    all(&[], &mut found);
    assert!(found.len() >= 13, "all commands are found: {:?}", found.iter().map(|f| &f.0).collect::<Vec<_>>());
    if blessing() {
        fs::create_dir_all(&folder).unwrap();
        fs::read_dir(&folder).unwrap().for_each(|entry| fs::remove_file(entry.unwrap().path()).unwrap());
        found.iter().for_each(|(name, text)| fs::write(folder.join(name), text).unwrap());
    }
    for (name, text) in &found {
        let expected = fs::read_to_string(folder.join(name)).unwrap_or_default();
        assert!(expected == *text, "help changed: tests/help/{name}; {BLESS}\n--- was\n{expected}\n--- is\n{text}");
    }
    let files: BTreeSet<String> =
        fs::read_dir(&folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    assert_eq!(files, found.into_iter().map(|(name, _)| name).collect(), "commands that are gone; {BLESS}");
}

/// `replay --set` tells machine and policy apart by the first part of a key; its help names all that are the machine's.
#[test]
fn the_help_of_set_names_every_table_of_a_machine() {
    let text = help(&["replay".to_owned()]);
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let list = words.split("Keys that begin with ").nth(1).and_then(|rest| rest.split(" are the machine's").next());
    let said: Vec<&str> = list.unwrap().split([',', ' ']).filter(|word| !word.is_empty() && *word != "or").collect();
    let mut tables: Vec<&str> = KEYS.iter().filter_map(|key| key.name.split('.').next()).collect();
    tables.dedup();
    assert_eq!(said, tables);
}

/// Every flag says what it does.
#[test]
fn every_flag_is_described() {
    let mut found = Vec::new();
    all(&[], &mut found);
    for (name, text) in found {
        let lines: Vec<&str> = text.lines().collect();
        // "- word: ..." is a value and not a flag.
        let flag = |line: &str| line.trim_start().starts_with('-') && !line.trim_start().starts_with("- ");
        let flags = lines.iter().enumerate().filter(|(_, line)| flag(line));
        for (i, line) in flags {
            let (same, next) = (line.trim().contains("  "), lines.get(i + 1).is_some_and(|l| !l.trim().is_empty()));
            assert!(same || next, "{name}: {line}");
        }
    }
}
