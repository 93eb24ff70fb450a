//! What is compared, and how strictly.

use crate::compare::select::Select;

/// What to compare.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Which columns and configuration keys.
    pub select: Select,
    /// Relative change up to which numbers count as equal.
    pub tolerance: f64,
    /// Columns by which points are not matched: their changes are changes of the configuration.
    pub across: Vec<String>,
}
