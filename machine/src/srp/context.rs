//! Where an SRP is connected.

use crate::memory::Port;

/// Memory ports of an SRP.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SrpPorts {
    /// Of its L1.
    pub l1: Port,
    /// Of its DMA engine and streams.
    pub dma: Port,
}

/// What an SRP works with.
#[derive(Debug)]
pub struct SrpContext<'a, U, M> {
    /// The T&I unit of the core.
    pub unit: &'a mut U,
    /// The memory.
    pub memory: &'a mut M,
}
