//! Weights of layers and factors as functions of the angle.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::film::code::*;
    use crate::frame::code::*;
    use crate::fresnel::code::*;
    use crate::lobes::microflake::code::*;
    use crate::lobes::multiscatter::code::*;
    use crate::math::code::*;
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
    #[wgsl_inline::always]
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

    /// The film of node `n`, which has one.
    pub fn node_film(n: Vec4u, p: ptr!(function, Params)) -> Film {
        let slot = film_slot(n);
        Film { thickness: param(p, slot), ior: param3(p, slot + 1) }
    }

    /// The slot of the film of node `n`: behind everything else.
    pub fn film_slot(n: Vec4u) -> u32 {
        let op = n.x & OP_MASK;
        let vector = select(0u32, 3u32, (n.x & FLAG_VECTOR) != 0);
        let color = select(0u32, 3u32, (n.x & FLAG_COLOR) != 0);
        if op >= OP_WEIGHTED_LAYER {
            return layer_normal_slot(n) + vector;
        }
        if op == OP_FRESNEL_FACTOR {
            return n.y + 6;
        }
        if op == OP_DIRECTIONAL_FACTOR {
            return n.y + SLOT_FACTOR_F82 + color;
        }
        if op == OP_SPECULAR {
            return n.y + 3;
        }
        n.y + SLOT_GLOSSY_TANGENT + vector + color
    }

    /// Reflectance of a coating of index `ior` under a film, at cosine `c` on the side of `wo`. From inside, the
    /// coating is the near side.
    pub fn coating_film(film: Film, ior: Vec3f, point: ShadingPoint, c: f32) -> Vec3f {
        let inside = (point.flags & POINT_INSIDE) != 0;
        let coat = vec3f(
            sane_ior(ior.x, point.ior_near.x),
            sane_ior(ior.y, point.ior_near.y),
            sane_ior(ior.z, point.ior_near.z),
        );
        let near = select(point.ior_near, coat, inside);
        let far = select(coat, point.ior_far, inside);
        unit3(film_reflectance(film, near, far, splat3(0.0), c))
    }

    /// An index n + ik of a medium that reflects `r` at normal incidence: real, like that of a dielectric, up to
    /// 20 %, and like that of aluminium, 1 + ik, from 50 % on. Ours: a reflectance does not tell the phase.
    pub fn mirror_index(r: f32) -> Vec2f {
        let root = sqrt(min(r, 0.2));
        let dielectric = (1.0 + root) / (1.0 - root);
        if r <= 0.2 {
            return vec2f(dielectric, 0.0);
        }
        let most = min(r, 0.999);
        let n = dielectric + (1.0 - dielectric) * unit((most - 0.2) / 0.3);
        let k2 = ((n + 1.0) * (n + 1.0) * most - (n - 1.0) * (n - 1.0)) / (1.0 - most);
        vec2f(n, sqrt(max(k2, 0.0)))
    }

    /// A curve that has the values `plain` at cosine `c` and `front` at normal incidence, under a film: changed by
    /// what the film changes at a medium with the reflectance `front`.
    pub fn filmed_curve(film: Film, plain: Vec3f, front: Vec3f, near: Vec3f, c: f32) -> Vec3f {
        let x = mirror_index(front.x);
        let y = mirror_index(front.y);
        let z = mirror_index(front.z);
        let n = vec3f(x.x, y.x, z.x) * near;
        let k = vec3f(x.y, y.y, z.y) * near;
        let bare = film_reflectance(Film { thickness: 0.0, ior: film.ior }, near, n, k, c);
        unit3(plain + film_reflectance(film, near, n, k, c) - bare)
    }

    /// A measured curve at cosine `c`: its `count` colours from `slot` on lie at equal angles from 0 to π/2, and
    /// between them it is straight. Without colours it is black.
    pub fn measured_curve(p: ptr!(function, Params), slot: u32, count: u32, c: f32) -> Vec3f {
        if count == 0 {
            return splat3(0.0);
        }
        let x = math_acos(unit(c)) * (2.0 * FRAC_1_PI) * f32(count - 1);
        let first = min(u32(x), count - 1);
        let second = min(first + 1, count - 1);
        let t = x - f32(first);
        unit3(param3(p, slot + 3 * first)) * (1.0 - t) + unit3(param3(p, slot + 3 * second)) * t
    }

    /// The largest values of a measured curve from normal incidence to cosine `c`.
    pub fn measured_most(p: ptr!(function, Params), slot: u32, count: u32, c: f32) -> Vec3f {
        let mut most: Vec3f = measured_curve(p, slot, count, c);
        let x = math_acos(unit(c)) * (2.0 * FRAC_1_PI) * f32(max(count, 1) - 1);
        #[wgsl_allow(non_literal_loop_bounds)]
        for i in 0..count {
            if f32(i) <= x {
                most = max(most, unit3(param3(p, slot + 3 * i)));
            }
        }
        most
    }

    /// The curve of a layer at three cosines, each a colour in [0, 1].
    #[derive(Clone, Copy, Debug)]
    pub struct LayerCurve {
        /// Seen from `wo`.
        pub seen: Vec3f,
        /// At the half vector.
        pub half: Vec3f,
        /// The largest of `wo`, of `wi`, and of all nearer to normal incidence where that can be larger.
        pub most: Vec3f,
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

    /// Schlick's curve of node `n` whose own slots start at `slot`, seen from a medium of index `near`.
    pub fn node_schlick(n: Vec4u, p: ptr!(function, Params), near: Vec3f, slot: u32, c: f32) -> Vec3f {
        let plain = node_schlick_bare(n, p, slot, c);
        if (n.x & FLAG_FILM) != 0 {
            return filmed_curve(node_film(n, p), plain, unit3(param3(p, slot)), near, c);
        }
        plain
    }

    /// The same without a film.
    pub fn node_schlick_bare(n: Vec4u, p: ptr!(function, Params), slot: u32, c: f32) -> Vec3f {
        let normal = param3(p, slot);
        let grazing = param3(p, slot + 3);
        let exponent = param(p, slot + 6);
        if (n.x & FLAG_COLOR) != 0 {
            return f82_curve(normal, grazing, param3(p, slot + 7), exponent, c);
        }
        schlick_curve(normal, grazing, exponent, c)
    }

    /// The curve of the layer of node `n` at cosine `c`, without its weight.
    pub fn layer_value(n: Vec4u, p: ptr!(function, Params), point: ShadingPoint, c: f32) -> Vec3f {
        let op = n.x & OP_MASK;
        let slot = n.y + SLOT_LAYER_CURVE;
        if op == OP_FRESNEL_LAYER {
            return splat3(fresnel_dielectric(
                c,
                coating_eta(param(p, slot), point.near, point.far, point.flags),
            ));
        }
        if op == OP_COLOR_FRESNEL_LAYER {
            if (n.x & FLAG_FILM) != 0 {
                return coating_film(node_film(n, p), param3(p, slot), point, c);
            }
            return color_fresnel(c, color_coating_eta(param3(p, slot), point));
        }
        if op == OP_CUSTOM_CURVE_LAYER {
            return node_schlick(n, p, point.ior_near, slot, c);
        }
        if op == OP_MEASURED_LAYER {
            return measured_curve(p, slot, n.w, c);
        }
        if op == OP_SHEEN_LAYER {
            return splat3(sheen_albedo(param(p, slot), c));
        }
        if op == OP_MICROFLAKE_LAYER {
            return splat3(microflake_albedo(param(p, slot), c));
        }
        splat3(1.0)
    }

    /// The curve of the layer of node `n` seen from `wo` at cosine `c`: what selection is based on.
    #[wgsl_inline::always]
    pub fn layer_seen(n: Vec4u, p: ptr!(function, Params), point: ShadingPoint, c: f32) -> Vec3f {
        unit3(param3(p, n.y + SLOT_LAYER_WEIGHT)) * layer_value(n, p, point, c)
    }

    /// The curve of the layer of node `n`, which has one, at the cosines seen, lit and half.
    #[wgsl_inline::always]
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
            // The most common curve, which the following would find out three times.
            let eta = coating_eta(param(p, slot), point.near, point.far, point.flags);
            let at_seen = fresnel_dielectric(seen, eta);
            return LayerCurve {
                seen: weight * at_seen,
                half: weight * fresnel_dielectric(half, eta),
                most: weight * max(at_seen, fresnel_dielectric(lit, eta)),
            };
        }
        let at_seen = weight * layer_value(n, p, point, seen);
        let most = max(at_seen, weight * layer_value(n, p, point, lit));
        if op == OP_SHEEN_LAYER || op == OP_MICROFLAKE_LAYER {
            // All of the lobe, over what its albedo leaves.
            return LayerCurve { seen: at_seen, half: weight, most };
        }
        let at_half = weight * layer_value(n, p, point, half);
        let mut front: Vec3f = splat3(0.0);
        if (n.x & FLAG_FILM) != 0 {
            // Fringes rise and fall.
            front = max(at_half, weight * layer_value(n, p, point, 1.0));
        } else if op == OP_CUSTOM_CURVE_LAYER {
            front = weight * unit3(param3(p, slot));
        } else if op == OP_MEASURED_LAYER {
            front = weight * measured_most(p, slot, n.w, min(seen, lit));
        }
        LayerCurve { seen: at_seen, half: at_half, most: max(most, front) }
    }

    /// The slot of a layer's normal.
    #[wgsl_inline::always]
    pub fn layer_normal_slot(n: Vec4u) -> u32 {
        let op = n.x & OP_MASK;
        let slot = n.y + SLOT_LAYER_CURVE;
        if op == OP_FRESNEL_LAYER || op == OP_SHEEN_LAYER || op == OP_MICROFLAKE_LAYER {
            return slot + 1;
        }
        if op == OP_COLOR_FRESNEL_LAYER {
            return slot + 3;
        }
        if op == OP_MEASURED_LAYER {
            return slot + 3 * n.w;
        }
        if op == OP_CUSTOM_CURVE_LAYER {
            return slot + select(7u32, 10u32, (n.x & FLAG_COLOR) != 0);
        }
        slot
    }
}
pub use code::*;
