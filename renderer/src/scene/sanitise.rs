//! Meshes without what no renderer can use.

use super::description::Mesh;
use glam::{DVec3, Vec2, Vec3};

/// Coordinates beyond this are as bad as infinite ones: their products overflow.
const COORDINATE_LIMIT: f32 = 1e15;

/// What was changed in a mesh, or in all meshes of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Repairs {
    /// Triangles dropped for a vertex that is not a finite number or does not exist.
    pub broken: u64,
    /// Triangles dropped because they have no area.
    pub degenerate: u64,
    /// Normals that were no direction: the triangle's own is used.
    pub normals: u64,
    /// Texture coordinates that were no number: 0 is used.
    pub uvs: u64,
    /// Meshes wound against their normals: turned.
    pub turned: u64,
}

impl Repairs {
    /// Adds those of another mesh.
    pub fn add(&mut self, other: &Repairs) {
        self.broken += other.broken;
        self.degenerate += other.degenerate;
        self.normals += other.normals;
        self.uvs += other.uvs;
        self.turned += other.turned;
    }

    /// A sentence for each kind of repair.
    pub fn messages(&self) -> Vec<String> {
        let rows = [
            (self.broken, "triangles dropped: a vertex is missing or not a finite number"),
            (self.degenerate, "triangles dropped: no area"),
            (self.normals, "vertex normals replaced: zero or not a finite number"),
            (self.uvs, "texture coordinates replaced by 0: not a finite number"),
            (self.turned, "meshes turned: wound against their normals"),
        ];
        rows.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect()
    }
}

/// Removes broken triangles and repairs attributes in place.
pub fn sanitise(mesh: &mut Mesh) -> Repairs {
    let mut repairs = Repairs::default();
    let count = mesh.positions.len();
    // Attributes of another length belong to another mesh.
    if mesh.normals.len() != count {
        mesh.normals.clear();
    }
    if mesh.tangents.len() != count {
        mesh.tangents.clear();
    }
    mesh.uvs.retain(|set| set.len() == count);
    if mesh.groups.len() != mesh.triangles.len() {
        mesh.groups.clear();
    }
    drop_triangles(mesh, &mut repairs);
    for normal in &mut mesh.normals {
        if !(normal.is_finite() && normal.length_squared() > 1e-30) {
            repairs.normals += u64::from(*normal != Vec3::ZERO);
            *normal = Vec3::ZERO;
        }
    }
    for uv in mesh.uvs.iter_mut().flatten() {
        if !uv.is_finite() {
            repairs.uvs += 1;
            *uv = Vec2::ZERO;
        }
    }
    for tangent in &mut mesh.tangents {
        if !tangent.is_finite() {
            *tangent = glam::Vec4::ZERO;
        }
    }
    if wound_against_normals(mesh) {
        repairs.turned += 1;
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    repairs
}

fn drop_triangles(mesh: &mut Mesh, repairs: &mut Repairs) {
    let usable =
        |v: Option<&Vec3>| v.is_some_and(|v| v.is_finite() && v.abs().max_element() <= COORDINATE_LIMIT);
    let mut kept = 0;
    for index in 0..mesh.triangles.len() {
        let triangle = mesh.triangles[index];
        let corners = triangle.map(|v| mesh.positions.get(v as usize));
        if !corners.into_iter().all(usable) {
            repairs.broken += 1;
            continue;
        }
        if normal_of(mesh, triangle) == DVec3::ZERO {
            repairs.degenerate += 1;
            continue;
        }
        mesh.triangles[kept] = triangle;
        if !mesh.groups.is_empty() {
            mesh.groups[kept] = mesh.groups[index];
        }
        kept += 1;
    }
    mesh.triangles.truncate(kept);
    mesh.groups.truncate(kept);
}

/// Twice the area, along the normal.
fn normal_of(mesh: &Mesh, triangle: [u32; 3]) -> DVec3 {
    let [a, b, c] = triangle.map(|v| mesh.positions[v as usize].as_dvec3());
    (b - a).cross(c - a)
}

/// Whether most of the surface faces away from its vertex normals: files with inconsistent winding exist,
/// and normals are what their authors saw.
fn wound_against_normals(mesh: &Mesh) -> bool {
    if mesh.normals.is_empty() {
        return false;
    }
    let agreement = |&t: &[u32; 3]| {
        let sum: DVec3 = t.iter().map(|&v| mesh.normals[v as usize].as_dvec3().normalize_or_zero()).sum();
        normal_of(mesh, t).dot(sum)
    };
    mesh.triangles.iter().map(agreement).sum::<f64>() < 0.0
}
