//! The modules of one crate: which file holds each, what it declares, what it imports. Tests are no part of it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::tokens::{Token, tokens, without_tests};

/// A path in code, such as `crate::work::Op`.
pub type Segments = Vec<String>;

/// A name that `use` brings in.
#[derive(Debug)]
pub struct Import {
    /// The name in this module; `*` for all names.
    pub name: String,
    pub path: Segments,
    /// Others may reach the name through this module.
    pub public: bool,
    pub line: usize,
}

#[derive(Debug, Default)]
pub struct Module {
    /// Names from the root of the crate, which has none itself.
    pub path: Segments,
    pub file: PathBuf,
    pub children: BTreeSet<String>,
    pub declared: BTreeSet<String>,
    pub macros: BTreeSet<String>,
    pub imports: Vec<Import>,
    /// What is left without the `use` declarations.
    pub code: Vec<Token>,
}

/// By path.
pub type Modules = BTreeMap<Segments, Module>;

/// Reads a crate from its root file, following `mod name;`. `read` gives the text of a file, if there is one.
pub fn modules(root: &Path, read: &dyn Fn(&Path) -> Option<String>) -> Modules {
    let mut found = Modules::new();
    let mut todo = vec![(Segments::new(), root.to_path_buf(), root.parent().unwrap().to_path_buf())];
    while let Some((path, file, folder)) = todo.pop() {
        let text = read(&file).unwrap_or_else(|| panic!("no file {}", file.display()));
        let module = module(path, file, without_tests(&tokens(&text)));
        for child in &module.children {
            let path: Segments = module.path.iter().chain([child]).cloned().collect();
            let beside = folder.join(format!("{child}.rs"));
            let file = if read(&beside).is_some() { beside } else { folder.join(child).join("mod.rs") };
            if read(&file).is_some() {
                todo.push((path, file, folder.join(child)));
            }
        }
        found.insert(module.path.clone(), module);
    }
    found
}

fn module(path: Segments, file: PathBuf, words: Vec<Token>) -> Module {
    let mut module = Module { path, file, ..Module::default() };
    let text = |at: usize| words.get(at).map_or("", |token: &Token| token.text.as_str());
    let mut at = 0;
    while at < words.len() {
        let next = text(at + 1).to_string();
        match text(at) {
            // `use<'a>` in a type is no import.
            "use" if next != "<" => {
                let end = (at..words.len()).find(|end| text(*end) == ";").unwrap_or(words.len());
                let public = at > 0 && matches!(text(at - 1), "pub" | ")");
                let mut imports = UseTree { words: &words[at + 1..end], at: 0, public, found: Vec::new() };
                imports.branch(&Segments::new());
                module.imports.append(&mut imports.found);
                at = end;
            }
            "mod" if text(at + 2) == ";" => _ = module.children.insert(next),
            "struct" | "enum" | "union" | "fn" | "trait" | "type" | "const" | "static" | "mod" => {
                module.declared.insert(if next == "mut" { text(at + 2).to_string() } else { next });
            }
            "macro_rules" => _ = module.macros.insert(text(at + 2).to_string()),
            _ => {}
        }
        if text(at) != ";" {
            module.code.push(words[at].clone());
        }
        at += 1;
    }
    module
}

/// `a::{b, c as d, e::*}` as one import a leaf.
struct UseTree<'a> {
    words: &'a [Token],
    at: usize,
    public: bool,
    found: Vec<Import>,
}

impl UseTree<'_> {
    fn text(&self) -> &str {
        self.words.get(self.at).map_or("", |token| token.text.as_str())
    }

    fn branch(&mut self, before: &Segments) {
        let mut path = before.clone();
        let line = self.words.get(self.at).map_or(0, |token| token.line);
        loop {
            match self.text() {
                "::" => self.at += 1,
                "{" => return self.group(&path),
                "" | "," | "}" | "as" => break,
                "$" => self.at += 1,
                word => {
                    path.push(word.to_string());
                    self.at += 1;
                }
            }
        }
        // `a::{self}` is `a`.
        if path.len() > 1 && path.last().is_some_and(|last| last == "self") {
            path.pop();
        }
        let mut name = path.last().cloned().unwrap_or_default();
        if self.text() == "as" {
            self.at += 1;
            name = self.text().to_string();
            self.at += 1;
        }
        self.found.push(Import { name, path, public: self.public, line });
    }

    fn group(&mut self, path: &Segments) {
        self.at += 1;
        while !matches!(self.text(), "}" | "") {
            self.branch(path);
            if self.text() == "," {
                self.at += 1;
            }
        }
        self.at += 1;
    }
}
