//! What the derived command line leaves out: a number below zero is the value of its option, so that the error says what is allowed.

use std::any::TypeId;
use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Arg, Command};

/// The command and those below it, with options of numbers that take a minus for the beginning of a number.
pub fn with_numbers(command: Command) -> Command {
    command.mut_args(number).mut_subcommands(with_numbers)
}

/// Without it, `--frame -1` is an unknown option `-1`, and the advice to write `-- -1` leads nowhere.
fn number(arg: Arg) -> Arg {
    let words = [TypeId::of::<String>(), TypeId::of::<OsString>(), TypeId::of::<PathBuf>()];
    let is_word = words.into_iter().any(|word| arg.get_value_parser().type_id() == word);
    if arg.is_positional() || is_word || !arg.get_action().takes_values() {
        arg
    } else {
        arg.allow_negative_numbers(true)
    }
}
