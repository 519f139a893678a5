//! How fast and how exact: comparisons of methods over steps, blocks and backends.

pub mod compare;
pub mod metrics;
pub mod statistics;
pub mod verify;
