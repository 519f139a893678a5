//! What a classification needs of the table, kept as long as the table is; and what does not go with it.

use std::sync::Arc;
use std::time::Instant;

use super::{Settings, ms_since};
use crate::error::{Error, Result};
use crate::sample::{Classification, PreIntegrated};
use crate::skip::Skip;
use crate::transfer::Table;

/// The pairs made last.
#[derive(Default)]
pub(super) struct Classes {
    pairs: Option<Pairs>,
    /// Names the pairs, so that what is on the device can be told apart.
    next_id: u64,
}

/// What a table was pre-integrated to.
#[derive(Clone)]
pub(super) struct Pairs {
    table: Arc<Table>,
    pub(super) id: u64,
    pub(super) content: Arc<PreIntegrated>,
    /// What making them took.
    pub(super) ms: f64,
}

impl Classes {
    /// The pairs of a table over data in this range of stored numbers, where the settings ask for them.
    pub(super) fn pairs(
        &mut self,
        settings: &Settings,
        table: &Arc<Table>,
        stored_range: [f64; 2],
    ) -> Option<Pairs> {
        if settings.classification != Classification::PreIntegrated {
            return None;
        }
        let is_current = |p: &Pairs| Arc::ptr_eq(&p.table, table);
        if !self.pairs.as_ref().is_some_and(is_current) {
            let start = Instant::now();
            let content = Arc::new(PreIntegrated::new(table, stored_range));
            self.next_id += 1;
            self.pairs = Some(Pairs {
                table: Arc::clone(table),
                id: self.next_id,
                content,
                ms: ms_since(start),
            });
        }
        self.pairs.clone()
    }
}

/// Checks that backend, mode and method go with the settings' classification.
pub(crate) fn check(settings: &Settings, backend: &str) -> Result<()> {
    let classification = settings.classification;
    if classification == Classification::Post {
        return Ok(());
    }
    classification.check_backend(backend)?;
    if !settings.mode.takes_table() {
        let reason = format!(
            "{} colours samples by the transfer function, of which {} makes no use",
            classification.name(),
            settings.mode.name()
        );
        return Err(Error::setting("classification", reason));
    }
    if settings.skip == Skip::Adaptive {
        let reason = format!(
            "adaptive lets one value stand for several samples, which {} does not give; take another method or post",
            classification.name()
        );
        return Err(Error::setting("method", reason));
    }
    Ok(())
}
