//! Tests of the SRP between a mock T&I unit and a mock memory.
