//! A camera with a thin lens.

use crate::geometry::Ray;
use glam::{DVec3, Vec3};
use layered_bsdf::math::math_tan;
use layered_bsdf::prelude::vec2f;
use layered_bsdf::sampling::sample_concentric_disc;

/// The angle between opposite edges of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FieldOfView {
    /// Between the upper and the lower edge, degrees.
    Vertical(f32),
    /// Between the left and the right edge, degrees.
    Horizontal(f32),
}

/// Where a scene is seen from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Centre of the lens, in scene units.
    pub position: DVec3,
    /// What appears in the middle of the picture.
    pub target: DVec3,
    /// What appears upwards, any length.
    pub up: Vec3,
    /// Angle of view, in (0, 180) degrees.
    pub fov: FieldOfView,
    /// Distance along the axis of what is sharp, in scene units; none: that of the target.
    pub focus_distance: Option<f32>,
    /// Radius of the lens in scene units; 0: everything is sharp.
    pub aperture_radius: f32,
}

impl Camera {
    /// A camera at `position` that looks at `target` with the y axis upwards, without depth of field.
    pub fn look_at(position: DVec3, target: DVec3, fov: FieldOfView) -> Self {
        Self { position, target, up: Vec3::Y, fov, focus_distance: None, aperture_radius: 0.0 }
    }

    /// Why no ray can be made, if so.
    pub fn fault(&self) -> Option<&'static str> {
        let (FieldOfView::Vertical(angle) | FieldOfView::Horizontal(angle)) = self.fov;
        let axis = self.target - self.position;
        let focus = self.focus_distance.unwrap_or(1.0);
        if !(self.position.is_finite() && self.target.is_finite() && self.up.is_finite()) {
            Some("a coordinate of the camera is not a finite number")
        } else if axis.length_squared() == 0.0 {
            Some("the camera's position and target are the same point")
        } else if !(angle > 0.0 && angle < 180.0) {
            Some("the camera's angle of view is not between 0 and 180 degrees")
        } else if !(focus > 0.0 && focus.is_finite()) {
            Some("the camera's focus distance is not a positive number")
        } else if !(self.aperture_radius >= 0.0 && self.aperture_radius.is_finite()) {
            Some("the camera's aperture radius is negative or not a number")
        } else {
            None
        }
    }

    /// Distance of the plane that is sharp.
    pub fn focus(&self) -> f32 {
        self.focus_distance.unwrap_or((self.target - self.position).length() as f32)
    }
}

/// A camera made ready for a picture of a certain size.
#[derive(Clone, Copy, Debug)]
pub struct CameraRays {
    origin: Vec3,
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    /// Tangent of an angle per pixel.
    pixel: f32,
    /// Coordinates of the middle of the picture.
    center: [f32; 2],
    focus: f32,
    radius: f32,
}

impl CameraRays {
    /// For a picture of `width` × `height` pixels. `world_origin` is the point of the scene that becomes
    /// the origin of the rays' space. The camera must have no [`Camera::fault`].
    pub fn new(camera: &Camera, width: u32, height: u32, world_origin: DVec3) -> Self {
        let forward = (camera.target - camera.position).normalize();
        let up = camera.up.as_dvec3();
        // A camera that looks along its up vector has any direction upwards.
        let right = forward.cross(up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
        let up = right.cross(forward);
        let half_tangent = |degrees: f32| math_tan(degrees.to_radians() * 0.5);
        let pixel = match camera.fov {
            FieldOfView::Vertical(angle) => 2.0 * half_tangent(angle) / height as f32,
            FieldOfView::Horizontal(angle) => 2.0 * half_tangent(angle) / width as f32,
        };
        Self {
            origin: (camera.position - world_origin).as_vec3(),
            right: right.as_vec3(),
            up: up.as_vec3(),
            forward: forward.as_vec3(),
            pixel,
            center: [width as f32 * 0.5, height as f32 * 0.5],
            focus: camera.focus(),
            radius: camera.aperture_radius,
        }
    }

    /// The ray through a point of the film, in pixels from the upper left corner, and a point of the lens,
    /// given in the unit square. The direction has unit length.
    #[inline]
    pub fn ray(&self, film: [f32; 2], lens: [f32; 2]) -> Ray {
        // From film coordinates, never as a difference of positions: those cancel far from the origin.
        let x = (film[0] - self.center[0]) * self.pixel;
        let y = (self.center[1] - film[1]) * self.pixel;
        let direction = self.forward + self.right * x + self.up * y;
        if self.radius == 0.0 {
            return Ray::new(self.origin, direction.normalize());
        }
        let d = sample_concentric_disc(vec2f(lens[0], lens[1]));
        let shift = (self.right * d.x + self.up * d.y) * self.radius;
        Ray::new(self.origin + shift, (direction * self.focus - shift).normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera::look_at(DVec3::new(0.0, 0.0, 3.0), DVec3::ZERO, FieldOfView::Vertical(90.0))
    }

    #[test]
    fn picture_edges_lie_at_the_angle_of_view() {
        let rays = CameraRays::new(&camera(), 200, 100, DVec3::ZERO);
        let ray = rays.ray([100.0, 50.0], [0.5; 2]);
        assert!((ray.direction + Vec3::Z).length() < 1e-6);
        assert!((ray.origin - Vec3::Z * 3.0).length() < 1e-6);
        let top = rays.ray([100.0, 0.0], [0.5; 2]).direction;
        assert!((top.y - 0.5f32.sqrt()).abs() < 1e-6 && top.x.abs() < 1e-6);
        let right = rays.ray([200.0, 50.0], [0.5; 2]).direction;
        assert!((right.x / -right.z - 2.0).abs() < 1e-6);
    }

    #[test]
    fn lens_rays_meet_in_the_plane_of_focus() {
        let camera = Camera { aperture_radius: 0.3, focus_distance: Some(2.0), ..camera() };
        let rays = CameraRays::new(&camera, 100, 100, DVec3::ZERO);
        let at_focus = |lens| {
            let ray = rays.ray([70.0, 20.0], lens);
            ray.origin + ray.direction * ((1.0 - ray.origin.z) / ray.direction.z)
        };
        let middle = at_focus([0.5, 0.5]);
        for lens in [[0.0, 0.0], [0.9, 0.3], [0.2, 0.99]] {
            assert!((at_focus(lens) - middle).length() < 1e-5);
            assert!(rays.ray([70.0, 20.0], lens).origin.distance(Vec3::Z * 3.0) <= 0.3 + 1e-6);
        }
    }

    #[test]
    fn direction_of_a_camera_far_away_keeps_its_digits() {
        let far = DVec3::new(5e5, -3e5, 4e5);
        let camera = Camera {
            position: far,
            target: far + DVec3::new(1.0, 0.5, -2.0),
            fov: FieldOfView::Vertical(0.05),
            ..camera()
        };
        let rays = CameraRays::new(&camera, 512, 512, far);
        let forward = DVec3::new(1.0, 0.5, -2.0).normalize();
        let right = forward.cross(DVec3::Y).normalize();
        let tangent = (0.025f64).to_radians().tan() / 256.0;
        for x in [0.5f32, 100.5, 101.5, 400.5] {
            let ray = rays.ray([x, 256.0], [0.5; 2]);
            let exact = (forward + right * ((f64::from(x) - 256.0) * tangent)).normalize();
            assert!((ray.direction.as_dvec3() - exact).length() < 1e-6);
            assert_eq!(ray.origin, Vec3::ZERO);
        }
        let neighbours = [100.5, 101.5].map(|x| rays.ray([x, 256.0], [0.5; 2]).direction);
        assert_ne!(neighbours[0], neighbours[1]);
    }

    #[test]
    fn camera_that_looks_along_up_has_rays() {
        let camera = Camera::look_at(DVec3::Y, DVec3::ZERO, FieldOfView::Vertical(40.0));
        let rays = CameraRays::new(&camera, 10, 10, DVec3::ZERO);
        assert!(rays.ray([3.0, 4.0], [0.5; 2]).direction.is_finite());
    }

    #[test]
    fn faults_are_named() {
        let same = Camera { target: camera().position, ..camera() };
        assert!(same.fault().is_some_and(|f| f.contains("same point")));
        assert!(Camera { fov: FieldOfView::Vertical(180.0), ..camera() }.fault().is_some());
        assert!(Camera { fov: FieldOfView::Vertical(f32::NAN), ..camera() }.fault().is_some());
        assert!(Camera { aperture_radius: -1.0, ..camera() }.fault().is_some());
        assert!(Camera { focus_distance: Some(0.0), ..camera() }.fault().is_some());
        assert_eq!(camera().fault(), None);
    }
}
