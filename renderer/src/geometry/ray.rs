//! Rays and hits, one at a time and in columns.

use glam::Vec3;

/// Marks that nothing was hit, as an instance or a primitive.
pub const NO_HIT: u32 = u32::MAX;
/// Marks that a path was scattered in a volume before it met anything, as an instance.
pub const IN_VOLUME: u32 = u32::MAX - 1;

/// A half-line `origin + t·direction`, 0 < t < `limit`. The direction need not have unit length.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Where it goes.
    pub direction: Vec3,
    /// Greatest `t`.
    pub limit: f32,
}

impl Ray {
    /// A ray without end.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, limit: f32::INFINITY }
    }
}

/// Where a ray met a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Position along the ray in units of its direction.
    pub t: f32,
    /// Barycentric weight of the triangle's second vertex.
    pub b1: f32,
    /// Barycentric weight of the triangle's third vertex.
    pub b2: f32,
    /// Index of the instance; [`NO_HIT`] if nothing was hit.
    pub instance: u32,
    /// Index of the triangle in the instance's mesh.
    pub primitive: u32,
}

impl Hit {
    /// No hit before `limit`.
    pub fn none(limit: f32) -> Self {
        Self { t: limit, b1: 0.0, b2: 0.0, instance: NO_HIT, primitive: NO_HIT }
    }

    /// Whether something was hit.
    pub fn is_some(&self) -> bool {
        self.instance != NO_HIT
    }
}

/// A column per component of a vector.
#[derive(Clone, Debug, Default)]
pub struct Vec3Column {
    /// x
    pub x: Vec<f32>,
    /// y
    pub y: Vec<f32>,
    /// z
    pub z: Vec<f32>,
}

impl Vec3Column {
    /// Sets the number of rows; new ones are zero.
    pub fn resize(&mut self, len: usize) {
        self.x.resize(len, 0.0);
        self.y.resize(len, 0.0);
        self.z.resize(len, 0.0);
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Removes all rows, keeps the memory.
    pub fn clear(&mut self) {
        self.x.clear();
        self.y.clear();
        self.z.clear();
    }

    /// The vector in a row.
    #[inline(always)]
    pub fn get(&self, row: usize) -> Vec3 {
        Vec3::new(self.x[row], self.y[row], self.z[row])
    }

    /// Sets the vector in a row.
    #[inline(always)]
    pub fn set(&mut self, row: usize, value: Vec3) {
        self.x[row] = value.x;
        self.y[row] = value.y;
        self.z[row] = value.z;
    }

    /// Appends a row.
    #[inline(always)]
    pub fn push(&mut self, value: Vec3) {
        self.x.push(value.x);
        self.y.push(value.y);
        self.z.push(value.z);
    }
}

/// Rays in columns.
#[derive(Clone, Debug, Default)]
pub struct RayBatch {
    /// Origins.
    pub origin: Vec3Column,
    /// Directions.
    pub direction: Vec3Column,
}

impl RayBatch {
    /// Sets the number of rows.
    pub fn resize(&mut self, len: usize) {
        self.origin.resize(len);
        self.direction.resize(len);
    }

    /// Removes all rows, keeps the memory.
    pub fn clear(&mut self) {
        self.origin.clear();
        self.direction.clear();
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.origin.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.origin.is_empty()
    }

    /// The ray in a row, ending at `limit`.
    #[inline(always)]
    pub fn get(&self, row: usize, limit: f32) -> Ray {
        Ray { origin: self.origin.get(row), direction: self.direction.get(row), limit }
    }

    /// Sets the ray in a row.
    #[inline(always)]
    pub fn set(&mut self, row: usize, origin: Vec3, direction: Vec3) {
        self.origin.set(row, origin);
        self.direction.set(row, direction);
    }

    /// Appends a ray.
    #[inline(always)]
    pub fn push(&mut self, origin: Vec3, direction: Vec3) {
        self.origin.push(origin);
        self.direction.push(direction);
    }
}

/// Hits in columns, as [`Hit`].
#[derive(Clone, Debug, Default)]
pub struct HitBatch {
    /// Position along the ray.
    pub t: Vec<f32>,
    /// Weight of the second vertex.
    pub b1: Vec<f32>,
    /// Weight of the third vertex.
    pub b2: Vec<f32>,
    /// Instance, or [`NO_HIT`].
    pub instance: Vec<u32>,
    /// Triangle.
    pub primitive: Vec<u32>,
}

impl HitBatch {
    /// Sets the number of rows.
    pub fn resize(&mut self, len: usize) {
        self.t.resize(len, 0.0);
        self.b1.resize(len, 0.0);
        self.b2.resize(len, 0.0);
        self.instance.resize(len, NO_HIT);
        self.primitive.resize(len, NO_HIT);
    }

    /// The hit in a row.
    #[inline(always)]
    pub fn get(&self, row: usize) -> Hit {
        Hit {
            t: self.t[row],
            b1: self.b1[row],
            b2: self.b2[row],
            instance: self.instance[row],
            primitive: self.primitive[row],
        }
    }

    /// Sets the hit in a row.
    #[inline(always)]
    pub fn set(&mut self, row: usize, hit: Hit) {
        self.t[row] = hit.t;
        self.b1[row] = hit.b1;
        self.b2[row] = hit.b2;
        self.instance[row] = hit.instance;
        self.primitive[row] = hit.primitive;
    }
}
