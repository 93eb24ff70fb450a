//! The document lists every table and column as they are declared.

use std::fmt::Write;
use std::path::Path;

use rayreel_columns::What;

const BEGIN: &str = "<!-- tables: begin -->\n";
const END: &str = "<!-- tables: end -->\n";

/// The tables as the document has them.
fn tables() -> String {
    let mut text = String::new();
    for what in What::ALL {
        let table = what.table();
        writeln!(text, "\n### {}\n\nA row is {}.\n", table.name, table.row).unwrap();
        text += "| column | type | unit | meaning |\n|---|---|---|---|\n";
        for column in table.columns {
            writeln!(text, "| `{}` | {} | {} | {} |", column.name, column.kind.name(), column.unit, column.meaning)
                .unwrap();
        }
    }
    text + "\n"
}

#[test]
fn the_document_says_what_is_declared() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/export.md");
    let text = std::fs::read_to_string(&file).unwrap();
    let (before, rest) = text.split_once(BEGIN).expect("the document marks where tables begin");
    let (found, after) = rest.split_once(END).expect("the document marks where tables end");
    if std::env::var_os("RAYREEL_BLESS").is_some_and(|bless| bless == "1") {
        std::fs::write(&file, [before, BEGIN, &tables(), END, after].concat()).unwrap();
        return;
    }
    let hint = "if the change is meant: RAYREEL_BLESS=1 cargo test -p rayreel-columns --test document";
    assert!(found == tables(), "docs/export.md lists other columns than are declared; {hint}");
}

/// Every column says what it is, under a name that every reader of files takes, once.
#[test]
fn every_column_is_described() {
    for what in What::ALL {
        let mut names: Vec<&str> = what.table().columns.iter().map(|column| column.name).collect();
        assert!(what.table().columns.iter().all(|column| !column.meaning.is_empty() && !column.meaning.contains('|')));
        assert!(names.iter().all(|name| name.chars().all(|c| c.is_ascii_lowercase() || c == '_')));
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), what.table().columns.len(), "{}", what.name());
    }
}
