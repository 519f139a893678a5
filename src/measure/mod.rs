//! How fast and how exact: comparisons of methods over steps, blocks and backends, and the search for the fastest.

pub mod bounds;
pub mod budget;
pub mod compare;
pub mod errors;
pub mod machine;
pub mod metrics;
pub mod profile;
pub mod race;
pub mod statistics;
pub mod truth;
pub mod tune;
pub mod verify;
