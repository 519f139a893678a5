//! How fast and how exact: comparisons of methods over steps, blocks and backends, and the search for the fastest.

pub mod compare;
pub mod metrics;
pub mod profile;
pub mod race;
pub mod stability;
pub mod statistics;
pub mod tune;
pub mod verify;
