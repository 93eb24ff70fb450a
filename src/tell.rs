//! What is said beside the results, on standard error.

/// Says a line on standard error. The work goes on where nobody reads it any more, or what it is written to is full: `eprintln!`
/// would end the program in the middle.
macro_rules! tell {
    ($($text:tt)*) => {{
        use std::io::Write;
        // Whoever should hear of it does not.
        let _ = writeln!(std::io::stderr(), $($text)*);
    }};
}
