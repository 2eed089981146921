//! The volumes that paths are in.
//!
//! A path remembers the volumes it has entered, the last on top. Leaving an object removes its entry
//! wherever it is, so objects may overlap or touch; the medium on the other side is what is on top then.
//! Space without a volume has index 1 and absorbs nothing. Volumes are homogeneous: each is as it was where the
//! path entered it.

pub use super::medium::{Medium, transmittance};
use crate::geometry::ray::Vec3Column;

/// Volumes that a path can be in at once.
pub const DEPTH: usize = 4;

/// Stacks of volumes in columns.
#[derive(Default)]
pub struct Media {
    /// Entries in use.
    depth: Vec<u8>,
    /// By entry.
    instance: [Vec<u32>; DEPTH],
    ior: [Vec3Column; DEPTH],
    absorption: [Vec3Column; DEPTH],
    /// The rest of a medium, if volumes scatter or emit.
    inner: Option<Inner>,
}

/// What scattering and emission need, by entry.
#[derive(Default)]
struct Inner {
    scattering: [Vec3Column; DEPTH],
    emission: [Vec3Column; DEPTH],
    slot: [Vec<u32>; DEPTH],
}

impl Media {
    /// Bytes of a path.
    pub const BYTES: usize = 1 + DEPTH * (4 + 12 + 12);
    /// Bytes of a path that scattering and emission add.
    pub const INNER_BYTES: usize = DEPTH * (12 + 12 + 4);

    /// Puts `len` paths into the volumes of `start`, the outermost first.
    pub fn reset(&mut self, len: usize, inner: bool, start: &[(u32, Medium)]) {
        self.depth.resize(len, 0);
        self.depth.fill(0);
        if inner {
            self.inner.get_or_insert_default();
        }
        for entry in 0..DEPTH {
            self.instance[entry].resize(len, 0);
            self.ior[entry].resize(len);
            self.absorption[entry].resize(len);
            if let Some(inner) = &mut self.inner {
                inner.scattering[entry].resize(len);
                inner.emission[entry].resize(len);
                inner.slot[entry].resize(len, 0);
            }
        }
        for path in if start.is_empty() { 0..0 } else { 0..len } {
            for (instance, medium) in start {
                self.enter(path, *instance, *medium);
            }
        }
    }

    /// Size of all columns in bytes.
    pub fn bytes(&self) -> usize {
        let outer =
            |e: usize| 4 * self.instance[e].len() + 12 * (self.ior[e].len() + self.absorption[e].len());
        let inner = self.inner.as_ref().map_or(0, |i| {
            let entry = |e: usize| 12 * (i.scattering[e].len() + i.emission[e].len()) + 4 * i.slot[e].len();
            (0..DEPTH).map(entry).sum()
        });
        self.depth.len() + (0..DEPTH).map(outer).sum::<usize>() + inner
    }

    #[inline]
    fn entry(&self, path: usize, entry: usize) -> Medium {
        let outer = Medium {
            ior: self.ior[entry].get(path),
            absorption: self.absorption[entry].get(path),
            ..Medium::VACUUM
        };
        match &self.inner {
            Some(inner) => Medium {
                scattering: inner.scattering[entry].get(path),
                emission: inner.emission[entry].get(path),
                slot: inner.slot[entry][path],
                ..outer
            },
            None => outer,
        }
    }

    #[inline]
    fn set(&mut self, path: usize, entry: usize, instance: u32, medium: Medium) {
        self.instance[entry][path] = instance;
        self.ior[entry].set(path, medium.ior);
        self.absorption[entry].set(path, medium.absorption);
        if let Some(inner) = &mut self.inner {
            inner.scattering[entry].set(path, medium.scattering);
            inner.emission[entry].set(path, medium.emission);
            inner.slot[entry][path] = medium.slot;
        }
    }

    /// The medium that a path is in.
    #[inline]
    pub fn current(&self, path: usize) -> Medium {
        match self.depth[path] {
            0 => Medium::VACUUM,
            depth => self.entry(path, usize::from(depth) - 1),
        }
    }

    /// The instance whose volume a path is in.
    #[inline]
    pub fn top(&self, path: usize) -> Option<u32> {
        let top = usize::from(self.depth[path]).checked_sub(1)?;
        Some(self.instance[top][path])
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
        self.set(path, depth, instance, medium);
        self.depth[path] += 1;
        true
    }

    /// Leaves an instance, if the path is in it.
    #[inline]
    pub fn leave(&mut self, path: usize, instance: u32) {
        let Some(found) = self.find(path, instance) else { return };
        for entry in found + 1..usize::from(self.depth[path]) {
            let (medium, instance) = (self.entry(path, entry), self.instance[entry][path]);
            self.set(path, entry - 1, instance, medium);
        }
        self.depth[path] -= 1;
    }

    /// Goes straight through the boundary of an instance that encloses `own`, if the index of refraction does not
    /// change there and there is room; otherwise nothing happens and the answer is false.
    #[inline]
    pub fn pass(&mut self, path: usize, instance: u32, back: bool, own: Medium) -> bool {
        let inside = self.contains(path, instance);
        let (near, far) = match (back, inside) {
            (false, _) => (self.current(path), own),
            (true, true) => (self.current(path), self.without(path, instance)),
            (true, false) => (own, self.current(path)),
        };
        if near.ior != far.ior {
            return false;
        }
        if back {
            self.leave(path, instance);
            return true;
        }
        self.enter(path, instance, own)
    }

    /// Copies the stack of a row of `other` to a new row at the end.
    pub fn push_from(&mut self, other: &Media, row: usize) {
        let path = self.depth.len();
        self.reset_rows(path + 1, other.inner.is_some());
        for entry in 0..usize::from(other.depth[row]) {
            self.set(path, entry, other.instance[entry][row], other.entry(row, entry));
        }
        self.depth[path] = other.depth[row];
    }

    /// Forgets all rows.
    pub fn clear(&mut self) {
        self.depth.clear();
    }

    /// Makes room for rows without a change of those there are.
    fn reset_rows(&mut self, len: usize, inner: bool) {
        if inner {
            self.inner.get_or_insert_default();
        }
        self.depth.resize(len, 0);
        if self.instance[0].len() >= len {
            return;
        }
        let room = (2 * len).max(64);
        for entry in 0..DEPTH {
            self.instance[entry].resize(room, 0);
            self.ior[entry].resize(room);
            self.absorption[entry].resize(room);
            if let Some(inner) = &mut self.inner {
                inner.scattering[entry].resize(room);
                inner.emission[entry].resize(room);
                inner.slot[entry].resize(room, 0);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn medium(ior: f32) -> Medium {
        Medium { ior: Vec3::splat(ior), ..Medium::VACUUM }
    }

    #[test]
    fn overlapping_volumes_are_left_in_any_order() {
        let mut media = Media::default();
        media.reset(2, false, &[]);
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
        media.reset(1, false, &[]);
        for instance in 0..DEPTH as u32 {
            assert!(media.enter(0, instance, medium(1.5)));
        }
        assert!(!media.enter(0, 99, medium(2.0)));
        assert_eq!(media.current(0), medium(1.5));
    }

    #[test]
    fn paths_begin_in_the_volumes_of_the_camera_and_are_copied_with_all_of_them() {
        let fog = Medium { scattering: Vec3::new(1.0, 2.0, 3.0), slot: 5, ..medium(1.0) };
        let mut media = Media::default();
        media.reset(3, true, &[(2, medium(1.3)), (4, fog)]);
        assert_eq!((media.current(2), media.top(2)), (fog, Some(4)));
        let mut copies = Media::default();
        copies.push_from(&media, 1);
        media.leave(0, 4);
        copies.push_from(&media, 0);
        assert_eq!((copies.current(0), copies.current(1)), (fog, medium(1.3)));
        assert_eq!(copies.without(0, 4), medium(1.3));
    }

    #[test]
    fn boundaries_are_passed_where_the_index_stays() {
        let mut media = Media::default();
        media.reset(1, true, &[]);
        assert!(media.pass(0, 1, false, medium(1.0)));
        assert!(!media.pass(0, 2, false, medium(1.5)) && media.top(0) == Some(1));
        assert!(media.pass(0, 1, true, medium(1.0)) && media.top(0).is_none());
        // Of an object that was not entered: its own index counts.
        assert!(!media.pass(0, 3, true, medium(1.5)) && media.pass(0, 3, true, medium(1.0)));
    }
}
