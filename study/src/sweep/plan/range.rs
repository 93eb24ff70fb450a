//! The numbers of an axis that a plan gives by its ends.

use std::ops::Range;

use toml::Value;

use crate::error::Result;
use crate::sweep::plan::file::Span;
use crate::sweep::plan::locate::Text;
use crate::sweep::plan::scalar::Scalar;
use rayreel_machine::config::units::Bytes;

/// Most values of one axis.
const VALUES_MAX: usize = 65_536;

/// How the numbers go on from the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A step is added.
    Range,
    /// They are multiplied by a factor.
    Log,
}

impl Kind {
    /// The key of the plan, that of its step, and that of the other kind's step.
    fn keys(self) -> [&'static str; 3] {
        match self {
            Self::Range => ["range", "step", "factor"],
            Self::Log => ["log", "factor", "step"],
        }
    }
}

/// The numbers from the first to the last of `span`, both included; `at` is where the plan gives them.
///
/// # Errors
/// The step of the other kind, ends that are no numbers, a range that never ends or has too many values.
pub fn numbers(axis: &str, span: &Span, kind: Kind, at: &Range<usize>, text: Text<'_>) -> Result<Vec<Value>> {
    let [key, name, foreign] = kind.keys();
    let (step, other) = if kind == Kind::Log { (&span.factor, &span.step) } else { (&span.step, &span.factor) };
    if let Some(other) = other {
        return Err(text.error(&other.span(), format!("axis {axis:?}: a {key} has {name}, not {foreign}")));
    }
    let default = Value::Integer(if kind == Kind::Log { 2 } else { 1 });
    let step = step.as_ref().map_or(default, |step| step.get_ref().clone());
    let (from, to) = (span.from.get_ref(), span.to.get_ref());
    let Some(steps) = Steps::new(from, to, &step, kind) else {
        let detail = format!("axis {axis:?}: from, to and {name} are numbers, or sizes such as \"4KiB\"");
        return Err(text.error(at, detail));
    };
    if steps.size && steps.from < 0.0 {
        return Err(text.error(at, format!("axis {axis:?}: sizes begin at 0 or above, not at {from}")));
    }
    if !steps.ends() {
        let log = kind == Kind::Log;
        let need = if log { "from above 0, a factor above 1 and from <= to" } else { "a step above 0 and from <= to" };
        let detail = format!("axis {axis:?} from {from} to {to} by {step} never ends there; it needs {need}");
        return Err(text.error(at, detail));
    }
    steps.values().ok_or_else(|| {
        let detail = format!("axis {axis:?} would have more than {VALUES_MAX} values; take a larger {name}");
        text.error(at, detail)
    })
}

/// First and last number with the step between them.
struct Steps {
    from: f64,
    to: f64,
    step: f64,
    kind: Kind,
    /// All three are whole numbers.
    whole: bool,
    /// The ends are sizes in bytes.
    size: bool,
}

impl Steps {
    /// None if one of the values is no number.
    fn new(from: &Value, to: &Value, step: &Value, kind: Kind) -> Option<Self> {
        let number = |value: &Value| match Scalar::of(value)? {
            Scalar::Integer(i) => Some((i as f64, true)),
            Scalar::Float(f) => Some((f, false)),
            Scalar::Flag(_) | Scalar::Word(_) => None,
        };
        let size = from.is_str() || to.is_str();
        let [from, to, step] = [number(from)?, number(to)?, number(step)?];
        let whole = from.1 && to.1 && step.1;
        Some(Self { from: from.0, to: to.0, step: step.0, kind, whole, size })
    }

    /// Whether the last number is ever reached or passed.
    fn ends(&self) -> bool {
        let grows = match self.kind {
            Kind::Range => self.step > 0.0,
            Kind::Log => self.step > 1.0 && self.from > 0.0,
        };
        grows && self.from <= self.to
    }

    /// All numbers; none if they are more than [`VALUES_MAX`].
    fn values(&self) -> Option<Vec<Value>> {
        // Whole numbers are exact; of others a sum may miss its end by what rounding loses.
        let last = if self.whole { self.to } else { self.to + self.to.abs() * 1e-9 };
        let mut values = Vec::new();
        let mut next = self.from;
        while next <= last {
            values.push(self.value(next));
            if values.len() > VALUES_MAX {
                return None;
            }
            next = match self.kind {
                Kind::Range => values.len() as f64 * self.step + self.from,
                Kind::Log => next * self.step,
            };
        }
        Some(values)
    }

    /// A number as a plan would write it.
    fn value(&self, number: f64) -> Value {
        match (self.whole, self.size) {
            (true, true) => Value::String(Bytes(number as u64).to_string()),
            (true, false) => Value::Integer(number as i64),
            (false, _) if self.kind == Kind::Range => Value::Float(short(number, self.from.abs().max(self.step))),
            (false, _) => Value::Float(short(number, 0.0)),
        }
    }
}

/// A number of twelve digits, and 0 where it is nothing beside `scale`: what sums and products lose by rounding is not written out.
fn short(number: f64, scale: f64) -> f64 {
    if number.abs() < scale * 1e-12 { 0.0 } else { format!("{number:.11e}").parse().unwrap_or(number) }
}
