//! Suites: sweeps over scenes and choices, described in a TOML file, measured in interleaved runs and kept as JSON Lines.
//!
//! A case is one line of the results, and the command that makes it again is its name.

mod case;
mod check;
mod file;
mod pictures;
mod record;
mod results;
mod runner;

pub use case::{Case, Group};
pub use file::{Paper, PictureRow, SceneRow, Suite, Sweep};
pub use pictures::{Shown, pictures};
pub use record::{
    AdapterRecord, CaseRecord, ErrorRecord, Header, MachineRecord, PictureRecord, Record,
    SceneRecord, What,
};
pub use results::{Results, Writer};
pub use runner::{Contestant, Heat, run};
