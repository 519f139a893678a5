//! The view: a camera that turns, moves, zooms and flies.
//!
//! It is kept in the volume's grid coordinates (voxels), which is what `--camera` reads: the camera that a picture is drawn
//! with follows from those numbers by the same arithmetic as the command's, so that both draw the same bits.

use glam::{DQuat, DVec3};

use crate::camera::{Camera, DEFAULT_FOV_Y_DEGREES, Orbit, Projection};

/// Where a picture is taken from, in voxels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Where the camera stands.
    pub eye: DVec3,
    /// The point in the middle of the picture, about which it turns.
    pub target: DVec3,
    /// Upwards in the picture.
    pub up: DVec3,
    /// How rays spread; heights are in voxels of the smallest spacing.
    pub projection: Projection,
}

/// The nearest that zooming comes to the target, in voxels of the smallest spacing.
const NEAREST: f64 = 0.5;

impl View {
    /// The command's default view of a box of edges `extent` (local units) with voxels of `voxel_size`.
    pub fn home(extent: DVec3, voxel_size: DVec3) -> Self {
        Self::of(&Orbit::default().camera(extent), voxel_size)
    }

    /// The view of a camera in local coordinates.
    fn of(camera: &Camera, voxel_size: DVec3) -> Self {
        Self {
            eye: camera.eye / voxel_size,
            target: camera.target / voxel_size,
            up: camera.up / voxel_size,
            projection: camera.projection,
        }
    }

    /// The camera in local coordinates.
    pub fn camera(&self, voxel_size: DVec3) -> Camera {
        Camera {
            eye: self.eye * voxel_size,
            target: self.target * voxel_size,
            up: self.up * voxel_size,
            projection: self.projection,
        }
    }

    /// Changes the camera in local coordinates, where lengths and angles are true.
    fn change(&mut self, voxel_size: DVec3, change: impl FnOnce(&mut Camera)) {
        let mut camera = self.camera(voxel_size);
        change(&mut camera);
        if camera.check().is_ok() {
            *self = Self::of(&camera, voxel_size);
        }
    }

    /// Turns about the target: `turn` radians about the volume's z axis, `tilt` about the picture's horizontal.
    pub fn orbit(&mut self, turn: f64, tilt: f64, voxel_size: DVec3) {
        self.change(voxel_size, |camera| {
            let rotation = rotation(camera, turn, tilt);
            camera.eye = camera.target + rotation * (camera.eye - camera.target);
            camera.up = rotation * camera.up;
        });
    }

    /// Looks elsewhere from where the eye is, by the same angles.
    pub fn look(&mut self, turn: f64, tilt: f64, voxel_size: DVec3) {
        self.change(voxel_size, |camera| {
            let rotation = rotation(camera, turn, tilt);
            camera.target = camera.eye + rotation * (camera.target - camera.eye);
            camera.up = rotation * camera.up;
        });
    }

    /// Moves eye and target across the view, by parts of the picture's height: what is at the target follows the pointer.
    pub fn pan(&mut self, right: f64, down: f64, voxel_size: DVec3) {
        self.change(voxel_size, |camera| {
            let height = height_at_target(camera);
            let (to_right, to_top) = across(camera);
            let shift = (-to_right * right + to_top * down) * height;
            camera.eye += shift;
            camera.target += shift;
        });
    }

    /// Comes nearer (factor below 1) or goes away; parallel rays are spread less or more.
    pub fn zoom(&mut self, factor: f64, voxel_size: DVec3) {
        self.change(voxel_size, |camera| {
            let offset = camera.eye - camera.target;
            match &mut camera.projection {
                Projection::Perspective { .. } => {
                    let length = (offset.length() * factor).max(NEAREST);
                    camera.eye = camera.target + offset.normalize() * length;
                }
                Projection::Orthographic { height } => *height = (*height * factor).max(NEAREST),
            }
        });
    }

    /// Flies: moves eye and target along the view, to the right and up, in local units.
    pub fn fly(&mut self, forward: f64, right: f64, up: f64, voxel_size: DVec3) {
        self.change(voxel_size, |camera| {
            let (to_right, to_top) = across(camera);
            let shift = camera.forward() * forward + to_right * right + to_top * up;
            camera.eye += shift;
            camera.target += shift;
        });
    }

    /// Looks at another point, from the same side and distance.
    pub fn centre_on(&mut self, point: DVec3, voxel_size: DVec3) {
        let shift = point - self.target;
        self.change(voxel_size, |camera| {
            camera.eye += shift * voxel_size;
            camera.target += shift * voxel_size;
        });
    }

    /// Looks along an axis at the target: from its positive end, or from its negative one.
    pub fn along(&mut self, axis: usize, from_positive: bool, voxel_size: DVec3) {
        self.change(voxel_size, |camera| {
            let mut side = DVec3::ZERO;
            side[axis] = if from_positive { 1.0 } else { -1.0 };
            let distance = (camera.eye - camera.target).length();
            camera.eye = camera.target + side * distance;
            camera.up = if axis == 2 { DVec3::Y } else { DVec3::Z };
        });
    }

    /// Whether rays are parallel.
    pub fn is_parallel(&self) -> bool {
        matches!(self.projection, Projection::Orthographic { .. })
    }

    /// Parallel rays instead of a perspective, or back, showing as much at the target.
    pub fn toggle_parallel(&mut self, voxel_size: DVec3) {
        self.change(voxel_size, |camera| {
            let height = height_at_target(camera);
            let half = (DEFAULT_FOV_Y_DEGREES * 0.5).to_radians().tan();
            match camera.projection {
                Projection::Perspective { .. } => {
                    camera.projection = Projection::Orthographic { height };
                }
                Projection::Orthographic { .. } => {
                    let offset = (camera.eye - camera.target).normalize();
                    camera.eye = camera.target + offset * (height * 0.5 / half);
                    camera.projection = Projection::Perspective {
                        fov_y_degrees: DEFAULT_FOV_Y_DEGREES,
                    };
                }
            }
        });
    }

    /// Turned by `degrees` about the volume's z axis through its target: one picture of an orbit.
    pub fn turned(&self, degrees: f64, voxel_size: DVec3) -> Self {
        let mut view = *self;
        view.change(voxel_size, |camera| {
            let rotation = DQuat::from_rotation_z(degrees.to_radians());
            camera.eye = camera.target + rotation * (camera.eye - camera.target);
            camera.up = rotation * camera.up;
        });
        view
    }
}

/// Right and up of the picture; unit length.
pub(super) fn across(camera: &Camera) -> (DVec3, DVec3) {
    let forward = camera.forward();
    let right = forward.cross(camera.up);
    let right = if right.length() > 1e-9 * camera.up.length() {
        right.normalize()
    } else {
        forward.any_orthonormal_vector()
    };
    (right, right.cross(forward))
}

/// Height of what the picture shows at the target, in local units.
fn height_at_target(camera: &Camera) -> f64 {
    match camera.projection {
        Projection::Perspective { fov_y_degrees } => {
            let distance = (camera.eye - camera.target).length();
            2.0 * distance * (fov_y_degrees * 0.5).to_radians().tan()
        }
        Projection::Orthographic { height } => height,
    }
}

/// A turn about z and a tilt about the picture's horizontal; upside down, the turn still follows the pointer.
fn rotation(camera: &Camera, turn: f64, tilt: f64) -> DQuat {
    let (right, top) = across(camera);
    let turn = if top.z < 0.0 { -turn } else { turn };
    DQuat::from_rotation_z(turn) * DQuat::from_axis_angle(right, tilt)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: DVec3 = DVec3::new(1.0, 1.0, 2.5);

    fn home() -> View {
        View::home(DVec3::new(40.0, 30.0, 50.0), SIZE)
    }

    fn distance(view: &View) -> f64 {
        let camera = view.camera(SIZE);
        (camera.eye - camera.target).length()
    }

    #[test]
    fn turning_keeps_distance_target_and_the_picture_upright() {
        let mut view = home();
        for i in 0..200 {
            view.orbit(0.13, if i % 3 == 0 { 0.4 } else { -0.1 }, SIZE);
        }
        assert!((distance(&view) - distance(&home())).abs() < 1e-6);
        assert!((view.target - home().target).length() < 1e-9);
        let camera = view.camera(SIZE);
        // No roll: the picture's horizontal stays level.
        assert!(across(&camera).0.z.abs() < 1e-6);
    }

    #[test]
    fn both_projections_show_as_much_at_the_target() {
        let mut view = home();
        let before = height_at_target(&view.camera(SIZE));
        view.toggle_parallel(SIZE);
        assert!(view.is_parallel());
        assert!((height_at_target(&view.camera(SIZE)) - before).abs() < 1e-9);
        view.zoom(0.5, SIZE);
        view.toggle_parallel(SIZE);
        assert!((height_at_target(&view.camera(SIZE)) - before * 0.5).abs() < 1e-9);
    }

    #[test]
    fn what_is_panned_follows_the_pointer_and_zooming_stops_before_the_target() {
        let mut view = home();
        let point = view.target * SIZE;
        view.pan(0.25, 0.0, SIZE);
        let camera = view.camera(SIZE);
        let clip = camera.clip_from_local([100, 100]) * point.extend(1.0);
        assert!((clip.x / clip.w - 0.5).abs() < 1e-9 && (clip.y / clip.w).abs() < 1e-9);
        for _ in 0..100 {
            view.zoom(0.5, SIZE);
        }
        assert!((distance(&view) - NEAREST).abs() < 1e-9);
        view.camera(SIZE).check().unwrap();
    }

    #[test]
    fn axis_views_look_along_their_axis() {
        for axis in 0..3 {
            for side in [false, true] {
                let mut view = home();
                view.along(axis, side, SIZE);
                let forward = view.camera(SIZE).forward();
                let expected = if side { -1.0 } else { 1.0 };
                assert!((forward[axis] - expected).abs() < 1e-12);
                assert!((distance(&view) - distance(&home())).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn flying_moves_eye_and_target_alike() {
        let mut view = home();
        let forward = view.camera(SIZE).forward();
        view.fly(3.0, 0.0, 0.0, SIZE);
        let moved = (view.eye - home().eye) * SIZE;
        assert!((moved - forward * 3.0).length() < 1e-9);
        assert!(((view.target - home().target) * SIZE - moved).length() < 1e-9);
        view.look(0.3, 0.1, SIZE);
        assert!(((view.eye - home().eye) * SIZE - moved).length() < 1e-9);
    }
}
