//! Weights of layers and factors as functions of the angle.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::frame::code::*;
    use crate::fresnel::code::*;
    use crate::lobes::multiscatter::code::*;
    use crate::nodes::code::*;
    use wgsl_rs::std::*;

    /// The media on the two sides of a surface and where it is seen from.
    #[derive(Clone, Copy, Debug)]
    pub struct ShadingPoint {
        /// Geometric normal on the side of `wo`, in the local frame, unit length.
        pub geometry_normal: Vec3f,
        /// Index of refraction on the side of `wo`, per colour channel.
        pub ior_near: Vec3f,
        /// Index of refraction on the other side, per colour channel.
        pub ior_far: Vec3f,
        /// Mean of `ior_near`.
        pub near: f32,
        /// Mean of `ior_far`.
        pub far: f32,
        /// `far / near`, within the range that the formulas are made for.
        pub eta: f32,
        /// `POINT_*` bits.
        pub flags: u32,
    }

    /// The surface has no inside: transmission goes straight through.
    pub const POINT_THIN_WALLED: u32 = 1;
    /// `wo` lies inside the volume that the surface bounds.
    pub const POINT_INSIDE: u32 = 2;

    /// A shading point with its derived fields.
    pub fn shading_point(
        geometry_normal: Vec3f,
        ior_near: Vec3f,
        ior_far: Vec3f,
        flags: u32,
    ) -> ShadingPoint {
        let near = mean3(ior_near);
        let far = mean3(ior_far);
        ShadingPoint { geometry_normal, ior_near, ior_far, near, far, eta: sane_eta(far / near), flags }
    }

    /// Index ratio at a coating of index `ior`: from outside the coating is the far side, from inside the
    /// near one.
    pub fn coating_eta(ior: f32, near: f32, far: f32, flags: u32) -> f32 {
        let inside = (flags & POINT_INSIDE) != 0;
        sane_eta(select(ior, far, inside) / select(near, ior, inside))
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

    /// The curve of a layer at three cosines, each a colour in [0, 1].
    #[derive(Clone, Copy, Debug)]
    pub struct LayerCurve {
        /// Seen from `wo`.
        pub seen: Vec3f,
        /// Lit from `wi`.
        pub lit: Vec3f,
        /// At the half vector.
        pub half: Vec3f,
        /// At normal incidence where that can be the largest; else zero.
        pub front: Vec3f,
    }

    /// The index ratios of a colour Fresnel layer.
    pub fn color_coating_eta(ior: Vec3f, point: ShadingPoint) -> Vec3f {
        vec3f(
            coating_eta(ior.x, point.ior_near.x, point.ior_far.x, point.flags),
            coating_eta(ior.y, point.ior_near.y, point.ior_far.y, point.flags),
            coating_eta(ior.z, point.ior_near.z, point.ior_far.z, point.flags),
        )
    }

    /// Dielectric reflectance per channel.
    pub fn color_fresnel(c: f32, eta: Vec3f) -> Vec3f {
        vec3f(fresnel_dielectric(c, eta.x), fresnel_dielectric(c, eta.y), fresnel_dielectric(c, eta.z))
    }

    /// Schlick's curve of node `n` whose own slots start at `slot`.
    pub fn node_schlick(n: Vec4u, p: ptr!(function, Params), slot: u32, c: f32) -> Vec3f {
        let normal = param3(p, slot);
        let grazing = param3(p, slot + 3);
        let exponent = param(p, slot + 6);
        if (n.x & FLAG_COLOR) != 0 {
            return f82_curve(normal, grazing, param3(p, slot + 7), exponent, c);
        }
        schlick_curve(normal, grazing, exponent, c)
    }

    /// The curve of the layer of node `n` seen from `wo` at cosine `c`: what selection is based on.
    pub fn layer_seen(n: Vec4u, p: ptr!(function, Params), point: ShadingPoint, c: f32) -> Vec3f {
        let op = n.x & OP_MASK;
        let weight = unit3(param3(p, n.y + SLOT_LAYER_WEIGHT));
        let slot = n.y + SLOT_LAYER_CURVE;
        if op == OP_FRESNEL_LAYER {
            let eta = coating_eta(param(p, slot), point.near, point.far, point.flags);
            return weight * fresnel_dielectric(c, eta);
        }
        if op == OP_COLOR_FRESNEL_LAYER {
            return weight * color_fresnel(c, color_coating_eta(param3(p, slot), point));
        }
        if op == OP_CUSTOM_CURVE_LAYER {
            return weight * node_schlick(n, p, slot, c);
        }
        if op == OP_SHEEN_LAYER {
            return weight * sheen_albedo(param(p, slot), c);
        }
        weight
    }

    /// The curve of the layer of node `n`, which has one, at the cosines seen, lit and half.
    pub fn layer_curve(
        n: Vec4u,
        p: ptr!(function, Params),
        point: ShadingPoint,
        seen: f32,
        lit: f32,
        half: f32,
    ) -> LayerCurve {
        let op = n.x & OP_MASK;
        let weight = unit3(param3(p, n.y + SLOT_LAYER_WEIGHT));
        let slot = n.y + SLOT_LAYER_CURVE;
        if op == OP_FRESNEL_LAYER {
            let eta = coating_eta(param(p, slot), point.near, point.far, point.flags);
            return LayerCurve {
                seen: weight * fresnel_dielectric(seen, eta),
                lit: weight * fresnel_dielectric(lit, eta),
                half: weight * fresnel_dielectric(half, eta),
                front: splat3(0.0),
            };
        }
        if op == OP_COLOR_FRESNEL_LAYER {
            let eta = color_coating_eta(param3(p, slot), point);
            return LayerCurve {
                seen: weight * color_fresnel(seen, eta),
                lit: weight * color_fresnel(lit, eta),
                half: weight * color_fresnel(half, eta),
                front: splat3(0.0),
            };
        }
        if op == OP_SHEEN_LAYER {
            // All of the lobe, over what its albedo leaves.
            let roughness = param(p, slot);
            return LayerCurve {
                seen: weight * sheen_albedo(roughness, seen),
                lit: weight * sheen_albedo(roughness, lit),
                half: weight,
                front: splat3(0.0),
            };
        }
        LayerCurve {
            seen: weight * node_schlick(n, p, slot, seen),
            lit: weight * node_schlick(n, p, slot, lit),
            half: weight * node_schlick(n, p, slot, half),
            front: weight * unit3(param3(p, slot)),
        }
    }

    /// The slot of a layer's normal.
    pub fn layer_normal_slot(n: Vec4u) -> u32 {
        let op = n.x & OP_MASK;
        let slot = n.y + SLOT_LAYER_CURVE;
        if op == OP_FRESNEL_LAYER || op == OP_SHEEN_LAYER {
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
