//! What `auto` chooses between, in words and in settings.

use super::DEFAULT_BLOCK;
use crate::render::Settings;
use crate::skip::{Cuts, HalfCut, Skip, SlabCount};

/// What can be chosen to draw the same picture in less time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    /// WHERE samples are taken.
    pub skip: Skip,
    /// Leaf block edge in voxels.
    pub block: usize,
    /// Where half-split and k-cuts cut.
    pub cuts: Cuts,
}

impl Choice {
    /// The baseline.
    pub(super) const BOX: Self = Self {
        skip: Skip::Box,
        block: DEFAULT_BLOCK,
        cuts: Cuts {
            half: HalfCut::Middle,
            slabs: SlabCount::Auto,
        },
    };

    /// What is chosen in these settings.
    pub fn of(settings: &Settings) -> Self {
        Self {
            skip: settings.skip,
            block: settings.block,
            cuts: settings.cuts,
        }
    }

    /// `settings` by this choice.
    pub fn in_settings(&self, settings: &Settings) -> Settings {
        Settings {
            skip: self.skip,
            block: self.block,
            cuts: self.cuts,
            ..*settings
        }
    }

    /// Method, blocks and cuts in words: `half-split, blocks of 8, cut best`.
    pub fn words(&self) -> String {
        let name = self.skip.method().name;
        let block = self.block;
        match (self.skip, self.cut_words()) {
            (Skip::Box, _) => name.to_owned(),
            (_, Some(cut)) => format!("{name}, blocks of {block}, cut {cut}"),
            (_, None) => format!("{name}, blocks of {block}"),
        }
    }

    /// Where it cuts, by the names that flags have for it; `None` where it does not.
    pub fn cut_words(&self) -> Option<String> {
        match self.skip {
            Skip::HalfSplit => Some(self.cuts.half.name().to_owned()),
            Skip::KCuts => Some(self.cuts.slabs.to_string()),
            _ => None,
        }
    }
}

/// A method as users name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MethodChoice {
    /// The one that [`crate::render::Renderer::choose`] chooses.
    Auto,
    /// This one.
    Only(Skip),
}

impl MethodChoice {
    /// The name used by flags, files and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Only(skip) => skip.method().name,
        }
    }

    /// The choice of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        if name == Self::Auto.name() {
            Some(Self::Auto)
        } else {
            Skip::from_name(name).map(Self::Only)
        }
    }
}
