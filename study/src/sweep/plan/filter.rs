//! Constraints: expressions over the axes that leave points out.
//!
//! The language is that of Jinja expressions: `l1 > 65536 and trv == 8`, `machine in ["raycore"]`, `l1 * trv >= 2 * l2`. Sizes
//! are bytes. A name that is none is an error and not false.

use std::collections::BTreeMap;

use minijinja::value::Value;
use minijinja::{Environment, ErrorKind, Expression, UndefinedBehavior};
use toml::Spanned;

use crate::error::{Result, StudyError};
use crate::sweep::plan::locate::Text;
use crate::sweep::plan::scalar::Scalar;

/// The expressions of a plan.
pub struct Filters<'a> {
    all: Vec<(&'a Spanned<String>, Expression<'a, 'a>)>,
    text: Text<'a>,
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
        let compile = |source: &'a Spanned<String>| {
            let compiled = environment.compile_expression(source.get_ref().as_str());
            compiled.map(|compiled| (source, compiled)).map_err(|e| wrong(source, text, &e, &[]))
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
        for (source, expression) in &self.all {
            let names: Vec<&str> = variables.iter().map(|(name, _)| name.as_str()).collect();
            let value = expression.eval(&context).map_err(|e| wrong(source, self.text, &e, &names))?;
            if value.is_true() {
                return Ok(true);
            }
        }
        Ok(false)
    }
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

fn wrong(source: &Spanned<String>, text: Text<'_>, error: &minijinja::Error, names: &[&str]) -> StudyError {
    let why = match (error.kind(), error.detail()) {
        (ErrorKind::UndefinedError, _) => format!("a name in it is none of {}", names.join(", ")),
        (_, Some(detail)) => detail.to_owned(),
        (kind, None) => kind.to_string(),
    };
    text.error(&source.span(), format!("exclude {:?}: {why}", source.get_ref()))
}
