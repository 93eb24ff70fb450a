//! Which file uses what another file declares.
//!
//! A path leads to the file that declares the thing: re-exports are followed, so a sibling reached through the parent's
//! `pub use` is a use of the sibling. A `pub use` of a module's descendants alone is a shop window and no use, as long as the
//! module's code does not name what stands in it. Inline modules count as part of their file, a macro as part of the file that
//! declares it. Methods are not followed: a call names no path.

use std::collections::BTreeSet;

use crate::modules::{Import, Module, Modules, Segments};

/// From the module that uses to the module that declares.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Arrow {
    pub from: Segments,
    pub line: usize,
    pub to: Segments,
    /// The path as it is written.
    pub written: String,
}

/// All uses between different modules of a crate, by line.
pub fn arrows(modules: &Modules) -> Vec<Arrow> {
    let mut found = BTreeSet::new();
    for module in modules.values() {
        for (path, line) in imports(module).into_iter().chain(inline(module)) {
            let Some(to) = Names { modules }.home(module, &path, 0) else { continue };
            if to.path != module.path {
                let (from, to) = (module.path.clone(), to.path.clone());
                found.insert(Arrow { from, line, to, written: path.join("::") });
            }
        }
    }
    found.into_iter().collect()
}

fn imports(module: &Module) -> Vec<(Segments, usize)> {
    let used = module.imports.iter().filter(|import| !is_window(module, import));
    used.map(|import| (import.path.clone(), import.line)).collect()
}

fn is_window(module: &Module, import: &Import) -> bool {
    let first = import.path.iter().find(|segment| *segment != "self");
    let below = first.is_some_and(|first| module.children.contains(first));
    import.public && below && !module.code.iter().any(|token| token.text == import.name)
}

/// Paths in the code: a name followed by `::`, and macros.
fn inline(module: &Module) -> Vec<(Segments, usize)> {
    let code = &module.code;
    let text = |at: usize| code.get(at).map_or("", |token| token.text.as_str());
    let mut found = Vec::new();
    let mut at = 0;
    while at < code.len() {
        let starts = code[at].is_name() && (at == 0 || text(at - 1) != "::");
        let line = code[at].line;
        let mut path = vec![code[at].text.clone()];
        while starts && text(at + 1) == "::" && code.get(at + 2).is_some_and(|token| token.is_name()) {
            at += 2;
            path.push(text(at).to_string());
        }
        if starts && (path.len() > 1 || text(at + 1) == "!") {
            found.push((path, line));
        }
        at += 1;
    }
    found
}

struct Names<'a> {
    modules: &'a Modules,
}

impl<'a> Names<'a> {
    /// The module that declares what `path`, written in `module`, leads to; `None` if that is another crate's.
    fn home(&self, module: &'a Module, path: &[String], depth: usize) -> Option<&'a Module> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            _ if depth > 20 => None,
            "crate" => self.inside(self.modules.get(&Segments::new())?, rest, depth),
            "self" => self.inside(module, rest, depth),
            "super" => {
                let (_, parent) = module.path.split_last()?;
                self.inside(self.modules.get(parent)?, rest, depth)
            }
            _ => self.inside_or(module, path, depth, None),
        }
    }

    fn inside(&self, module: &'a Module, path: &[String], depth: usize) -> Option<&'a Module> {
        if path.first().is_some_and(|first| first == "super" || first == "self") {
            return self.home(module, path, depth + 1);
        }
        self.inside_or(module, path, depth, Some(module))
    }

    /// As `inside`; `otherwise` where the module has no such name.
    fn inside_or(
        &self,
        module: &'a Module,
        path: &[String],
        depth: usize,
        otherwise: Option<&'a Module>,
    ) -> Option<&'a Module> {
        let Some((first, rest)) = path.split_first() else { return Some(module) };
        let child: Segments = module.path.iter().chain([first]).cloned().collect();
        if let Some(child) = self.modules.get(&child) {
            return self.inside(child, rest, depth + 1);
        }
        if module.declared.contains(first) {
            return Some(module);
        }
        if let Some(import) =
            module.imports.iter().find(|import| import.name == *first && import.path != [first.as_str()])
        {
            let whole: Segments = import.path.iter().chain(rest).cloned().collect();
            return self.home(module, &whole, depth + 1);
        }
        let globs = module.imports.iter().filter(|import| import.name == "*" && depth <= 20);
        let mut through =
            globs.filter_map(|import| self.home(module, &import.path[..import.path.len() - 1], depth + 1));
        if let Some(home) = through.find_map(|glob| self.declared(glob, path, depth + 1)) {
            return Some(home);
        }
        let with_macro = self.modules.values().find(|module| rest.is_empty() && module.macros.contains(first));
        with_macro.or(otherwise)
    }

    fn declared(&self, module: &'a Module, path: &[String], depth: usize) -> Option<&'a Module> {
        if depth > 20 { None } else { self.inside_or(module, path, depth, None) }
    }
}
