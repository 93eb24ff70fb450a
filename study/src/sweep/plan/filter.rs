//! Constraints: expressions over the axes that leave points out.
//!
//! The language is that of Jinja expressions: `l1 > 64KiB and trv == 8`, `machine in ["raycore"]`, `l1 * trv >= 2 * l2`; `=` is
//! `==`, and sizes are bytes. A name that is none is an error and not false, also where what stands before it decides. The filter of
//! a sweep's page reads the same expressions (`html/sweep/js/language.js`); `tests/expressions` holds both to it.

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

use minijinja::value::Value;
use minijinja::{Environment, Expression, UndefinedBehavior};
use rayreel_settings::near;
use toml::Spanned;

use crate::error::{Result, StudyError};
use crate::sweep::plan::locate::Text;
use crate::sweep::plan::quantity::jinja;
use crate::sweep::plan::scalar::Scalar;

/// The expressions of a plan.
pub struct Filters<'a> {
    all: Vec<Filter<'a>>,
    text: Text<'a>,
}

struct Filter<'a> {
    source: &'a Spanned<String>,
    expression: Expression<'a, 'a>,
    names: BTreeSet<String>,
    /// Whether it left a point out.
    used: Cell<bool>,
}

/// Compiles expressions for [`Filters::new`].
pub fn environment() -> Environment<'static> {
    let mut environment = Environment::new();
    environment.set_undefined_behavior(UndefinedBehavior::Strict);
    environment
}

impl<'a> Filters<'a> {
    /// The expressions, compiled.
    ///
    /// # Errors
    /// One that is none.
    pub fn new(environment: &'a Environment<'a>, all: &'a [Spanned<String>], text: Text<'a>) -> Result<Self> {
        let globals: BTreeSet<&str> = environment.globals().map(|(name, _)| name).collect();
        let compile = |source: &'a Spanned<String>| {
            bounded(source.get_ref()).map_err(|why| wrong(source, text, &why))?;
            let compiled = environment.compile_expression_owned(jinja(source.get_ref()));
            let expression = compiled.map_err(|e| wrong(source, text, &why(&e)))?;
            let names =
                expression.undeclared_variables(false).into_iter().filter(|name| !globals.contains(name.as_str()));
            Ok(Filter { source, names: names.collect(), expression, used: Cell::new(false) })
        };
        Ok(Self { all: all.iter().map(compile).collect::<Result<_>>()?, text })
    }

    /// Whether a point of these variables is left out.
    ///
    /// # Errors
    /// An expression that uses other names, or adds a word to a number.
    pub fn excludes(&self, variables: &[(String, Option<Scalar>)]) -> Result<bool> {
        if self.all.is_empty() {
            return Ok(false);
        }
        let context: BTreeMap<&str, Value> =
            variables.iter().map(|(name, value)| (name.as_str(), plain(value.as_ref()))).collect();
        let context = Value::from(context);
        let mut excluded = false;
        for filter in &self.all {
            // Of a point that is left out it is only asked who would leave it out too.
            if !(excluded && filter.used.get()) {
                match filter.excludes(variables, &context, self.text) {
                    Err(error) if !excluded => return Err(error),
                    found => excluded |= found.is_ok_and(|found| found),
                }
            }
        }
        Ok(excluded)
    }

    /// What there is to say of expressions that left no point out so far.
    pub fn idle(&self) -> Vec<String> {
        let idle = self.all.iter().filter(|filter| !filter.used.get());
        let hint = "it leaves no point out; a word stands in quotes, and no word equals a number";
        idle.map(|filter| wrong(filter.source, self.text, hint).to_string()).collect()
    }
}

impl Filter<'_> {
    fn excludes(&self, variables: &[(String, Option<Scalar>)], context: &Value, text: Text<'_>) -> Result<bool> {
        let Self { source, expression, names, used } = self;
        if let Some(unknown) = names.iter().find(|name| !variables.iter().any(|(known, _)| known == *name)) {
            let known: Vec<&str> = variables.iter().map(|(name, _)| name.as_str()).collect();
            return Err(wrong(source, text, &format!("{unknown} is no name of a point; {}", near(unknown, &known))));
        }
        let is_true = expression.eval(context).map_err(|e| wrong(source, text, &why(&e)))?.is_true();
        used.set(used.get() || is_true);
        Ok(is_true)
    }
}

/// Most characters of an expression that are shown.
const SHOWN_MAX: usize = 200;

/// Most characters of an expression, and most signs, brackets and joining words in it: the parser calls itself for each that
/// stands within another.
const LENGTH_MAX: usize = 10_000;
const NESTING_MAX: usize = 200;

/// Refuses what would need a deep stack.
fn bounded(source: &str) -> Result<(), String> {
    if source.chars().count() > LENGTH_MAX {
        return Err(format!("it has more than {LENGTH_MAX} characters; split it into several"));
    }
    let words = source.split(|c: char| !c.is_alphanumeric() && c != '_');
    let words = words.filter(|word| matches!(*word, "not" | "if" | "and" | "or")).count();
    if words + source.matches(|c: char| "-+*/%~|.([{<>=".contains(c)).count() > NESTING_MAX {
        return Err(format!("it has more than {NESTING_MAX} signs and brackets; split it into several"));
    }
    Ok(())
}

/// An axis that does not vary for a point is none.
fn plain(value: Option<&Scalar>) -> Value {
    match value {
        None => Value::from(()),
        Some(Scalar::Flag(flag)) => Value::from(*flag),
        Some(Scalar::Integer(i)) => Value::from(*i),
        Some(Scalar::Float(f)) => Value::from(*f),
        Some(Scalar::Word(word)) => Value::from(word.as_str()),
    }
}

fn why(error: &minijinja::Error) -> String {
    // The parser has a limit of its own, and speaks of templates.
    if error.detail().is_some_and(|detail| detail.contains("recursion limit")) {
        return "its brackets stand too deep in one another; split it into several".into();
    }
    error.detail().map_or_else(|| error.kind().to_string(), str::to_owned)
}

fn wrong(source: &Spanned<String>, text: Text<'_>, why: &str) -> StudyError {
    let mut shown: String = source.get_ref().chars().take(SHOWN_MAX).collect();
    if shown.len() < source.get_ref().len() {
        shown += "..";
    }
    text.error(&source.span(), format!("exclude {shown:?}: {why}"))
}
