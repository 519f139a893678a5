//! How fast and how exact: comparisons of methods over steps, blocks and backends, the search for the fastest,
//! and suites of all that.

pub mod bounds;
pub mod budget;
pub mod compare;
pub mod errors;
pub mod machine;
pub mod metrics;
pub mod profile;
pub mod race;
pub mod stability;
pub mod statistics;
pub mod suite;
mod toml_text;
pub mod truth;
pub mod tune;
pub mod verify;
