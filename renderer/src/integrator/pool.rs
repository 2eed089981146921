//! The state of paths, in columns that exist only if the scene needs them.

use super::media::{Media, Medium};
use crate::geometry::ray::Vec3Column;
use crate::geometry::{HitBatch, RayBatch};

/// Which columns there are beyond those of every path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PathFields {
    /// Volumes that a path is in: a material's interior can be entered.
    pub media: bool,
    /// What volumes that scatter or emit need, and how often a path was scattered at surfaces.
    pub inner: bool,
    /// Distance since the last scattering: rays pass cutouts.
    pub traveled: bool,
    /// Coverage: the environment is not seen.
    pub alpha: bool,
}

impl PathFields {
    /// Bytes of a path that every scene needs.
    pub const COMMON_BYTES: usize = 24 + 20 + 12 + 12 + 4 + 1;
    /// Bytes of a path that can be scattered in volumes.
    pub const INNER_BYTES: usize = Media::INNER_BYTES + 4;
    /// Bytes of a path for the distance since the last scattering.
    pub const TRAVELED_BYTES: usize = 4;
    /// Bytes of a path for its coverage.
    pub const ALPHA_BYTES: usize = 4;

    /// Bytes of a path.
    pub fn bytes(self) -> usize {
        Self::COMMON_BYTES
            + if self.media { Media::BYTES } else { 0 }
            + if self.inner { Self::INNER_BYTES } else { 0 }
            + if self.traveled { Self::TRAVELED_BYTES } else { 0 }
            + if self.alpha { Self::ALPHA_BYTES } else { 0 }
    }
}

/// Paths of a wave.
#[derive(Default)]
pub struct Paths {
    /// Where each goes; directions have unit length.
    pub rays: RayBatch,
    /// What it meets.
    pub hits: HitBatch,
    /// What its light is multiplied by.
    pub throughput: Vec3Column,
    /// Light gathered so far.
    pub radiance: Vec3Column,
    /// Density of the scattering that made the ray, sr⁻¹; 0 for the camera and specular scattering.
    pub pdf: Vec<f32>,
    /// Whether all values were finite.
    pub valid: Vec<bool>,
    /// Distance since the last scattering, up to the origin of the ray.
    pub traveled: Vec<f32>,
    /// Scattering events at surfaces.
    pub bounces: Vec<u32>,
    /// Coverage.
    pub alpha: Vec<f32>,
    /// Volumes that it is in.
    pub media: Option<Media>,
    /// Paths with a value that is no finite number, and the material slot where it came up.
    pub faults: Vec<(u32, u32)>,
}

impl Paths {
    /// Makes room for `len` new paths, which begin in the volumes of `start`.
    pub fn reset(&mut self, len: usize, fields: PathFields, start: &[(u32, Medium)]) {
        self.rays.resize(len);
        self.hits.resize(len);
        self.throughput.resize(len);
        self.radiance.resize(len);
        self.pdf.resize(len, 0.0);
        self.valid.resize(len, true);
        for column in [&mut self.throughput.x, &mut self.throughput.y, &mut self.throughput.z] {
            column.fill(1.0);
        }
        for column in [&mut self.radiance.x, &mut self.radiance.y, &mut self.radiance.z] {
            column.fill(0.0);
        }
        self.pdf.fill(0.0);
        self.valid.fill(true);
        if fields.traveled {
            self.traveled.resize(len, 0.0);
            self.traveled.fill(0.0);
        }
        if fields.inner {
            self.bounces.resize(len, 0);
            self.bounces.fill(0);
        }
        if fields.alpha {
            self.alpha.resize(len, 1.0);
            self.alpha.fill(1.0);
        }
        if fields.media {
            self.media.get_or_insert_default().reset(len, fields.inner, start);
        }
    }

    /// Notes that a value of a path is no finite number; its sample will not count.
    #[cold]
    pub fn fail(&mut self, path: u32, slot: u32) {
        if std::mem::replace(&mut self.valid[path as usize], false) {
            self.faults.push((path, slot));
        }
    }

    /// Distance of the hit of a path from where it last scattered.
    #[inline]
    pub fn distance(&self, path: usize) -> f32 {
        self.hits.t[path] + self.traveled.get(path).copied().unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_those_of_the_columns() {
        for (media, traveled, alpha) in [(false, false, false), (true, false, true), (true, true, true)] {
            let fields = PathFields { media, inner: media && traveled, traveled, alpha };
            let mut paths = Paths::default();
            paths.reset(10, fields, &[]);
            let rays = 4 * 6 * paths.rays.len();
            let hits = 4 * 5 * paths.hits.t.len();
            let colours = 4 * 3 * (paths.throughput.len() + paths.radiance.len());
            let scalars = 4
                * (paths.pdf.len() + paths.traveled.len() + paths.bounces.len() + paths.alpha.len())
                + paths.valid.len();
            let media = paths.media.as_ref().map_or(0, Media::bytes);
            assert_eq!(rays + hits + colours + scalars + media, 10 * fields.bytes());
        }
    }
}
