//! Settings of machines and policies: each declared once, with rule, unit and meaning; files that extend presets; overrides; errors
//! that say what is allowed.
//!
//! ```
//! use std::sync::LazyLock;
//! use rayreel_settings::{Family, Rule, Schema, Settings, settings};
//!
//! settings! {
//!     /// A cache.
//!     pub struct Cache {
//!         size: u64 = Rule::Size(1 << 10, 1 << 20), "what it holds", "bytes";
//!         ways: u32 = Rule::Integer(1, 64), "lines of a set";
//!     }
//! }
//!
//! static SCHEMA: LazyLock<Schema> = LazyLock::new(|| Schema::new("a cache", Cache::ENTRIES));
//! static CACHES: Family = Family {
//!     what: "cache", expected: "a valid cache", example: "ways=4", base: "small", kinds: &[],
//!     presets: &[("small", "size = \"16KiB\"\nways = 4"), ("wide", "extends = \"small\"\nways = 8")],
//!     schema: |_| &SCHEMA,
//! };
//!
//! let mut mine = CACHES.parse("mine", "extends = \"wide\"\nsize = \"32KiB\"")?;
//! mine.set("ways=2")?;
//! assert_eq!(mine.build::<Cache>()?, Cache { size: 32 << 10, ways: 2 });
//!
//! let error = mine.set("way=2").unwrap_err();
//! assert_eq!(error.to_string(), "override \"way=2\": no key \"way\" in a cache; did you mean ways?");
//! # Ok::<(), rayreel_settings::SettingsError>(())
//! ```

mod chain;
mod declare;
mod error;
mod family;
mod file;
pub mod files;
mod key;
mod loaded;
mod near;
mod rule;
mod schema;
mod source;
pub mod text;
pub mod units;

pub use chain::Ancestor;
pub use error::{Result, SettingsError};
pub use family::{Family, Preset, is_path};
pub use key::{Entry, Key, Settings};
pub use loaded::Loaded;
pub use near::{near, nearest, one_table, with_near_key};
pub use rule::Rule;
pub use schema::Schema;
pub use source::{Class, Sourced};
pub use units::{Bytes, Picojoules};
