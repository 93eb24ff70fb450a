//! Every kind of input.

mod scenes;
#[cfg(feature = "s3")]
mod server;
mod settings;
mod sweeps;
mod trace;
mod url;

use crate::target::Target;

/// All of them.
pub fn all() -> Vec<Target> {
    let mut all: Vec<Target> =
        [trace::targets(), scenes::targets(), settings::targets(), sweeps::targets()].into_iter().flatten().collect();
    all.push(url::target());
    #[cfg(feature = "s3")]
    all.push(server::target());
    all
}
