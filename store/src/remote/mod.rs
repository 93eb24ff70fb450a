//! Remote objects as a source of bytes: the object itself ([`object`]), how much of it to fetch ([`ahead`]), what of it
//! is kept in memory ([`memory`]) and on disk ([`disk`], and what is dropped there: [`room`]; how it is called: [`places`]).

mod ahead;
mod client;
mod connect;
mod disk;
mod fault;
mod fetch;
mod memory;
mod object;
mod places;
mod room;
mod source;

pub(crate) use connect::connect;
