//! Arguments that clip the volume.

use std::str::FromStr;

use hollowcast::Result;
use hollowcast::lattice::Clipping;
use hollowcast::volume::Volume;

/// Planes, in the camera's coordinates: voxels, voxel i's centre at i + 1/2.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Picture")]
pub(super) struct ClipArgs {
    /// Draw only what lies in this box: FROM:TO per axis in voxels, as 10:50.5,:,20:
    #[arg(long, value_name = "X0:X1,Y0:Y1,Z0:Z1")]
    clip_box: Option<ClipBox>,

    /// Draw only where NX*x + NY*y + NZ*z >= D (voxels); up to six times
    #[arg(long, value_name = "NX,NY,NZ,D", allow_hyphen_values = true)]
    clip_plane: Vec<ClipPlane>,
}

impl ClipArgs {
    /// The planes in the volume's local coordinates. A box of which they leave nothing is told of on stderr.
    pub(super) fn clipping(&self, volume: &Volume) -> Result<Clipping> {
        let ranges = self.clip_box.map_or([[None; 2]; 3], |b| b.0);
        let planes: Vec<[f64; 4]> = self.clip_plane.iter().map(|plane| plane.0).collect();
        let clipping = Clipping::in_voxels(&ranges, &planes, volume.voxel_size())?;
        if clipping.leaves_nothing_of(volume.extent()) {
            eprintln!("warning: the clip planes leave nothing of the volume");
        }
        Ok(clipping)
    }
}

/// From where to where, per axis.
#[derive(Debug, Clone, Copy)]
struct ClipBox([[Option<f64>; 2]; 3]);

impl FromStr for ClipBox {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let end = |s: &str| match s {
            "" => Some(None),
            number => number.parse().ok().filter(|n| f64::is_finite(*n)).map(Some),
        };
        let range = |s: &str| {
            let (from, to) = s.split_once(':')?;
            let [from, to] = [end(from)?, end(to)?];
            let is_empty = from.zip(to).is_some_and(|(from, to)| from >= to);
            (!is_empty).then_some([from, to])
        };
        let ranges: Option<Vec<_>> = text.split(',').map(range).collect();
        ranges
            .and_then(|ranges| ranges.try_into().ok())
            .map(Self)
            .ok_or_else(|| "expected FROM:TO per axis, FROM below TO, as 10:50.5,:,20:".to_owned())
    }
}

/// Normal and offset.
#[derive(Debug, Clone, Copy)]
struct ClipPlane([f64; 4]);

impl FromStr for ClipPlane {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let numbers: Option<Vec<f64>> = text.split(',').map(|s| s.trim().parse().ok()).collect();
        numbers
            .and_then(|numbers| numbers.try_into().ok())
            .map(Self)
            .ok_or_else(|| "expected four numbers, as 1,0,-0.5,64".to_owned())
    }
}
