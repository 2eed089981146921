//! A factor given as a picture over two angles (MDL `df::measured_factor`).
//!
//! The horizontal axis is the angle between the normal and the half vector, the vertical one that between the
//! half vector and either direction, both from 0 to 90° (the axes of A. Rusinkiewicz's, "A New Change of
//! Variables for Efficient BRDF Representation", 1998, without azimuths). Between the centres of texels it is
//! linear, beyond the outermost constant. It does not change when the directions are exchanged. Values are
//! limited to [0, 1], so that no energy is gained.

use crate::tables::{Table, TableSize};
use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::factors::code::*;
    use crate::frame::code::*;
    use crate::fresnel::code::*;
    use crate::lobes::measured::code::*;
    use crate::math::code::*;
    use crate::nodes::code::*;
    use wgsl_rs::std::*;

    /// Cosine between normal and half vector, from those of normal and directions and `c` = wo·h: with
    /// |wo + wi| = 2c. A transmitted direction counts as mirrored.
    pub fn facet_cosine(no: f32, ni: f32, c: f32) -> f32 {
        unit(0.5 * (abs(no) + abs(ni)) / max(c, 1e-20))
    }

    /// Texels before and behind an angle of cosine `c`, and where between them.
    pub fn picture_place(c: f32, count: u32) -> Vec3f {
        let x = clamp(math_acos(unit(c)) * (2.0 * FRAC_1_PI) * f32(count) - 0.5, 0.0, f32(count - 1));
        let first = floor(x);
        vec3f(first, min(first + 1.0, f32(count - 1)), x - first)
    }

    /// The factor of node `n` for a pair of directions; black without a picture.
    pub fn node_picture_factor(
        program: ptr!(function, Program),
        n: Vec4u,
        p: ptr!(function, Params),
        normal: u32,
        wo: Vec3f,
        wi: Vec3f,
    ) -> Vec3f {
        let z = normal_at(p, normal);
        let no = dot(z, wo);
        let ni = dot(z, wi);
        let difference = half_cosine(no, ni, dot(wo, wi));
        let half = facet_cosine(no, ni, difference);
        let table = table_number(param(p, n.y));
        let size = table_record(program, table, 0);
        let columns = u32(size.x);
        if columns == 0 {
            return splat3(0.0);
        }
        let x = picture_place(half, columns);
        let y = picture_place(difference, u32(size.y));
        let low = 1 + u32(y.x) * columns;
        let high = 1 + u32(y.y) * columns;
        let a = table_record(program, table, low + u32(x.x)).xyz();
        let b = table_record(program, table, low + u32(x.y)).xyz();
        let c = table_record(program, table, high + u32(x.x)).xyz();
        let d = table_record(program, table, high + u32(x.y)).xyz();
        let near = a * (1.0 - x.z) + b * x.z;
        let far = c * (1.0 - x.z) + d * x.z;
        unit3(near * (1.0 - y.z) + far * y.z)
    }
}
pub use code::*;

/// The table of a picture with texels row by row from the bottom.
pub fn picture_table(
    columns: u32,
    rows: u32,
    texel: impl Fn(u32, u32) -> [f32; 3],
) -> Result<Table, TableSize> {
    let count = columns as usize * rows as usize;
    if count >= crate::tables::MAX_RECORDS {
        return Err(TableSize(count + 1));
    }
    let mut records = vec![[columns as f32, rows as f32, 0.0, 0.0]];
    for row in 0..rows {
        records.extend((0..columns).map(|column| {
            let [r, g, b] = texel(column, row);
            [r, g, b, 0.0]
        }));
    }
    Table::new(records)
}
