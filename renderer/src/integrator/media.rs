//! The volumes that paths are in.
//!
//! A path remembers the volumes it has entered, the last on top. Leaving an object removes its entry
//! wherever it is, so objects may overlap or touch; the medium on the other side is what is on top then.
//! Space without a volume has index 1 and absorbs nothing.

use crate::geometry::ray::Vec3Column;
use glam::Vec3;
use layered_bsdf::math::math_exp;

/// Volumes that a path can be in at once.
pub const DEPTH: usize = 4;

/// What a volume does to light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// Index of refraction by colour channel.
    pub ior: Vec3,
    /// Absorption coefficient per scene unit.
    pub absorption: Vec3,
}

impl Medium {
    /// Nothing.
    pub const VACUUM: Medium = Medium { ior: Vec3::ONE, absorption: Vec3::ZERO };

    /// Share of light that passes `distance` of it (Beer, Lambert).
    #[inline]
    pub fn transmittance(&self, distance: f32) -> Vec3 {
        if self.absorption == Vec3::ZERO {
            return Vec3::ONE;
        }
        // 0·∞ is no distance: without absorption all passes.
        let channel = |a: f32| if a > 0.0 { math_exp(-(a * distance).min(100.0)) } else { 1.0 };
        Vec3::from(self.absorption.to_array().map(channel))
    }
}

/// Stacks of volumes in columns.
#[derive(Default)]
pub struct Media {
    /// Entries in use.
    depth: Vec<u8>,
    /// By entry.
    instance: [Vec<u32>; DEPTH],
    ior: [Vec3Column; DEPTH],
    absorption: [Vec3Column; DEPTH],
}

impl Media {
    /// Bytes of a path.
    pub const BYTES: usize = 1 + DEPTH * (4 + 12 + 12);

    /// Puts `len` paths outside of everything.
    pub fn reset(&mut self, len: usize) {
        self.depth.resize(len, 0);
        self.depth.fill(0);
        for entry in 0..DEPTH {
            self.instance[entry].resize(len, 0);
            self.ior[entry].resize(len);
            self.absorption[entry].resize(len);
        }
    }

    /// Size of all columns in bytes.
    pub fn bytes(&self) -> usize {
        let entry =
            |e: usize| 4 * self.instance[e].len() + 12 * (self.ior[e].len() + self.absorption[e].len());
        self.depth.len() + (0..DEPTH).map(entry).sum::<usize>()
    }

    #[inline]
    fn entry(&self, path: usize, entry: usize) -> Medium {
        Medium { ior: self.ior[entry].get(path), absorption: self.absorption[entry].get(path) }
    }

    /// The medium that a path is in.
    #[inline]
    pub fn current(&self, path: usize) -> Medium {
        match self.depth[path] {
            0 => Medium::VACUUM,
            depth => self.entry(path, usize::from(depth) - 1),
        }
    }

    /// The entry of an instance, if the path is in it.
    #[inline]
    fn find(&self, path: usize, instance: u32) -> Option<usize> {
        (0..usize::from(self.depth[path])).rev().find(|&e| self.instance[e][path] == instance)
    }

    /// Whether the path entered an instance.
    #[inline]
    pub fn contains(&self, path: usize, instance: u32) -> bool {
        self.find(path, instance).is_some()
    }

    /// The medium that a path would be in without an instance.
    #[inline]
    pub fn without(&self, path: usize, instance: u32) -> Medium {
        let depth = usize::from(self.depth[path]);
        let top = depth.checked_sub(1);
        let top = if top.is_some() && self.find(path, instance) == top { depth.checked_sub(2) } else { top };
        top.map_or(Medium::VACUUM, |entry| self.entry(path, entry))
    }

    /// Enters an instance; false if there is no room, and the volume will be missing.
    #[inline]
    pub fn enter(&mut self, path: usize, instance: u32, medium: Medium) -> bool {
        let depth = usize::from(self.depth[path]);
        if depth == DEPTH {
            return false;
        }
        self.instance[depth][path] = instance;
        self.ior[depth].set(path, medium.ior);
        self.absorption[depth].set(path, medium.absorption);
        self.depth[path] += 1;
        true
    }

    /// Leaves an instance, if the path is in it.
    #[inline]
    pub fn leave(&mut self, path: usize, instance: u32) {
        let Some(found) = self.find(path, instance) else { return };
        for entry in found + 1..usize::from(self.depth[path]) {
            let medium = self.entry(path, entry);
            self.instance[entry - 1][path] = self.instance[entry][path];
            self.ior[entry - 1].set(path, medium.ior);
            self.absorption[entry - 1].set(path, medium.absorption);
        }
        self.depth[path] -= 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn medium(ior: f32) -> Medium {
        Medium { ior: Vec3::splat(ior), absorption: Vec3::ZERO }
    }

    #[test]
    fn overlapping_volumes_are_left_in_any_order() {
        let mut media = Media::default();
        media.reset(2);
        assert_eq!(media.current(1), Medium::VACUUM);
        assert!(media.enter(1, 7, medium(1.5)) && media.enter(1, 8, medium(1.3)));
        assert_eq!(media.current(1), medium(1.3));
        // Leaving the outer object first changes nothing at its boundary.
        assert_eq!(media.without(1, 7), medium(1.3));
        assert_eq!(media.without(1, 8), medium(1.5));
        media.leave(1, 7);
        assert_eq!(media.current(1), medium(1.3));
        assert!(!media.contains(1, 7) && media.contains(1, 8));
        media.leave(1, 7);
        media.leave(1, 8);
        assert_eq!(media.current(1), Medium::VACUUM);
        assert_eq!(media.current(0), Medium::VACUUM);
    }

    #[test]
    fn entering_too_many_volumes_is_noticed() {
        let mut media = Media::default();
        media.reset(1);
        for instance in 0..DEPTH as u32 {
            assert!(media.enter(0, instance, medium(1.5)));
        }
        assert!(!media.enter(0, 99, medium(2.0)));
        assert_eq!(media.current(0), medium(1.5));
    }

    #[test]
    fn transmittance_is_exponential_and_safe() {
        let medium = Medium { ior: Vec3::ONE, absorption: Vec3::new(0.0, 1.0, 1e6) };
        let t = medium.transmittance(2.0);
        assert_eq!(t.x, 1.0);
        assert!((t.y - (-2f32).exp()).abs() < 1e-7);
        assert!(t.z < 1e-30);
        assert_eq!(medium.transmittance(f32::INFINITY).x, 1.0);
        assert!(medium.transmittance(f32::INFINITY).y < 1e-30);
    }
}
