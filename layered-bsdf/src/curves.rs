//! Weights of layers and factors as functions of the angle.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::frame::code::*;
    use crate::fresnel::code::*;
    use crate::nodes::code::*;
    use wgsl_rs::std::*;

    /// The media on the two sides of a surface and where it is seen from.
    #[derive(Clone, Copy, Debug)]
    pub struct ShadingPoint {
        /// Geometric normal on the side of `wo`, in the local frame, unit length.
        pub geometry_normal: Vec3f,
        /// Index of refraction on the side of `wo`.
        pub ior_near: Vec3f,
        /// Index of refraction on the other side.
        pub ior_far: Vec3f,
        /// `POINT_*` bits.
        pub flags: u32,
    }

    /// The surface has no inside: transmission goes straight through.
    pub const POINT_THIN_WALLED: u32 = 1;
    /// `wo` lies inside the volume that the surface bounds.
    pub const POINT_INSIDE: u32 = 2;

    /// The index of the far side over that of the near side, colours averaged.
    pub fn point_eta(point: ShadingPoint) -> f32 {
        mean3(point.ior_far) / mean3(point.ior_near)
    }

    /// Index ratio at a coating of index `ior`: from outside the coating is the far side, from inside the
    /// near one.
    pub fn coating_eta(ior: f32, near: f32, far: f32, flags: u32) -> f32 {
        sane_eta(select(ior / near, far / ior, (flags & POINT_INSIDE) != 0))
    }

    /// Schlick's curve between the reflectances `normal` and `grazing`, limited to [0, 1].
    pub fn schlick_curve(normal: Vec3f, grazing: Vec3f, exponent: f32, c: f32) -> Vec3f {
        unit3(normal + (grazing - normal) * schlick_weight(c, exponent))
    }

    /// Schlick's curve lowered to `f82` times itself around cos θ = 1/7 (N. Hoffman, "Fresnel Equations
    /// Considered Harmful", 2019): the correction is a·c(1−c)⁶, and a follows from the value at 1/7.
    pub fn f82_curve(normal: Vec3f, grazing: Vec3f, f82: Vec3f, exponent: f32, c: f32) -> Vec3f {
        let plain = normal + (grazing - normal) * schlick_weight(c, exponent);
        let at_82 = normal + (grazing - normal) * schlick_weight(1.0 / 7.0, exponent);
        // 1/(c(1−c)⁶) at c = 1/7 is 7·(7/6)⁶.
        let m = 1.0 - c;
        let m2 = m * m;
        let bump = 17.651384 * c * m2 * m2 * m2;
        unit3(plain - at_82 * (splat3(1.0) - unit3(f82)) * bump)
    }

    /// The weight of the layer of node `n` at cosine `c`, a colour in [0, 1].
    pub fn layer_curve(n: Vec4u, p: ptr!(function, Params), point: ShadingPoint, c: f32) -> Vec3f {
        let op = n.x & OP_MASK;
        let weight = unit3(param3(p, n.y + SLOT_LAYER_WEIGHT));
        let slot = n.y + SLOT_LAYER_CURVE;
        if op == OP_FRESNEL_LAYER {
            let eta = coating_eta(param(p, slot), mean3(point.ior_near), mean3(point.ior_far), point.flags);
            return weight * fresnel_dielectric(c, eta);
        }
        if op == OP_COLOR_FRESNEL_LAYER {
            let ior = param3(p, slot);
            return weight
                * vec3f(
                    fresnel_dielectric(c, coating_eta(ior.x, point.ior_near.x, point.ior_far.x, point.flags)),
                    fresnel_dielectric(c, coating_eta(ior.y, point.ior_near.y, point.ior_far.y, point.flags)),
                    fresnel_dielectric(c, coating_eta(ior.z, point.ior_near.z, point.ior_far.z, point.flags)),
                );
        }
        if op == OP_CUSTOM_CURVE_LAYER {
            let normal = param3(p, slot);
            let grazing = param3(p, slot + 3);
            let exponent = param(p, slot + 6);
            if (n.x & FLAG_COLOR) != 0 {
                return weight * f82_curve(normal, grazing, param3(p, slot + 7), exponent, c);
            }
            return weight * schlick_curve(normal, grazing, exponent, c);
        }
        weight
    }

    /// The weight of the layer of node `n` at normal incidence where that can be the largest; else zero.
    pub fn layer_curve_floor(n: Vec4u, p: ptr!(function, Params)) -> Vec3f {
        if (n.x & OP_MASK) != OP_CUSTOM_CURVE_LAYER {
            return splat3(0.0);
        }
        let weight = unit3(param3(p, n.y + SLOT_LAYER_WEIGHT));
        weight * unit3(param3(p, n.y + SLOT_LAYER_CURVE))
    }

    /// The slot of a layer's normal.
    pub fn layer_normal_slot(n: Vec4u) -> u32 {
        let op = n.x & OP_MASK;
        let slot = n.y + SLOT_LAYER_CURVE;
        if op == OP_FRESNEL_LAYER {
            return slot + 1;
        }
        if op == OP_COLOR_FRESNEL_LAYER {
            return slot + 3;
        }
        if op == OP_CUSTOM_CURVE_LAYER {
            return slot + select(7u32, 10u32, (n.x & FLAG_COLOR) != 0);
        }
        slot
    }
}
pub use code::*;
