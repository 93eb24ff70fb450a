//! Points: what is replayed under what, the key of the result, and the result.

pub mod compute;
pub mod decoded;
pub mod key;
pub mod row;
pub mod version;
