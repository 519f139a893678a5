//! Ground truths of hazards: what their first frames tend to as the step goes to 0.

use super::scenery::{Frame, Scenery};
use crate::measure::truth::{Truth, Truths};
use crate::scene::Picture;

/// Pixels of the largest picture that is refined: its edge is twice that of the usual one.
const MAX_PIXELS: u32 = 90 * 90;

/// The truth of the first frame; `None` where it is too large to be refined, or has none to be found: a ray of more
/// samples than are possible, say.
pub(super) fn of_first_frame(scenery: &Scenery) -> Option<Truth> {
    let Frame { settings, transfer } = scenery.frames.first()?;
    let [width, height] = settings.size;
    if width * height > MAX_PIXELS {
        return None;
    }
    let mut truths = Truths::new(&scenery.volume, transfer).ok()?;
    truths.of(settings, |_| ()).ok()
}

/// Largest difference of any channel from the truth; pixels at discontinuities are left out.
pub(super) fn error(picture: &Picture, truth: &Truth) -> f64 {
    let pairs = picture.rgba.iter().zip(&truth.picture.rgba);
    pairs
        .zip(&truth.masked)
        .filter(|(_, masked)| !**masked)
        .flat_map(|((a, b), _)| (0..4).map(|c| f64::from(a[c]) - f64::from(b[c])))
        .fold(0.0, |most, off| most.max(off.abs()))
}
