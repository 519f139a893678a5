//! Arguments that clip the volume.

use std::str::FromStr;

use glam::DVec3;
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
        let grid_from_local = 1.0 / volume.voxel_size();
        let mut clipping = Clipping::NONE;
        for (axis, range) in self.clip_box.iter().flat_map(|b| b.0).enumerate() {
            let mut normal = DVec3::ZERO;
            normal[axis] = 1.0;
            for (at, side) in [(range[0], 1.0), (range[1], -1.0)] {
                if let Some(at) = at {
                    clipping.keep(side * normal * grid_from_local, side * at)?;
                }
            }
        }
        for ClipPlane([x, y, z, offset]) in &self.clip_plane {
            clipping.keep(DVec3::new(*x, *y, *z) * grid_from_local, *offset)?;
        }
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
