//! An open volume with all that was set for it.

use std::sync::Arc;

use crate::error::Result;
use crate::render::Choice;
use crate::volume::{Source, Statistics, Volume};

use super::editor::{Axes, bars};
use super::history::History;
use super::look::{Look, Way};
use super::overlay::{Key, Overlay};
use super::session::Kept;
use super::view::View;

/// What undo goes back over.
pub type Edit = (Look, Way, Way);

/// A volume, how it is looked at, and what is known of it.
pub struct Document {
    /// Tells it from others.
    pub id: u64,
    /// Where the volume is from.
    pub source: Source,
    /// The voxels.
    pub volume: Arc<Volume>,
    /// Its values.
    pub statistics: Statistics,
    /// The histogram's bars.
    pub bars: Vec<([f64; 2], f64)>,
    /// WHAT is shown.
    pub look: Look,
    /// HOW.
    pub way: Way,
    /// The way that it is compared with.
    pub other: Way,
    /// From where.
    pub view: View,
    /// What the transfer function's editor shows.
    pub axes: Axes,
    /// The point that is selected there.
    pub selected: Option<usize>,
    /// Edits to go back over.
    pub history: History<Edit>,
    /// The blocks as classified last.
    pub overlay: Option<(Key, Overlay)>,
    /// What the last sweep timed, in ms.
    pub sweep: Vec<(Choice, f64)>,
}

impl Document {
    /// A volume as the command shows it where nothing is said.
    ///
    /// # Errors
    /// None that finite statistics can cause.
    pub fn new(
        id: u64,
        source: Source,
        volume: Arc<Volume>,
        statistics: Statistics,
    ) -> Result<Self> {
        let look = Look::of(&statistics)?;
        let way = Way::default();
        let view = View::home(volume.extent(), volume.voxel_size());
        Ok(Self {
            id,
            source,
            bars: bars(&statistics),
            axes: Axes::whole(&statistics),
            history: History::new((look.clone(), way, way)),
            volume,
            statistics,
            look,
            way,
            other: way,
            view,
            selected: None,
            overlay: None,
            sweep: Vec::new(),
        })
    }

    /// The name without its folder.
    pub fn short_name(&self) -> &str {
        let name = &self.source.volume;
        name.rsplit(['/', '\\']).next().unwrap_or(name)
    }

    /// What a session keeps of it.
    pub fn kept(&self) -> Kept {
        Kept {
            source: self.source.clone(),
            look: self.look.clone(),
            way: self.way,
            other: self.other,
            view: self.view,
        }
    }

    /// Takes what a session kept.
    pub fn restore(&mut self, kept: &Kept) {
        self.look = kept.look.clone();
        self.way = kept.way;
        self.other = kept.other;
        self.view = kept.view;
        self.history = History::new(self.edit());
    }

    /// What undo goes back over, as it is.
    pub fn edit(&self) -> Edit {
        (self.look.clone(), self.way, self.other)
    }

    /// Goes back to an edit, or forth.
    pub fn take(&mut self, edit: Option<Edit>) {
        if let Some((look, way, other)) = edit {
            self.look = look;
            self.way = way;
            self.other = other;
            self.selected = None;
        }
    }
}
