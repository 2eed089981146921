//! Modifiers: what multiplies a tree by a tint, a curve of the angle, or the transmittance of a coat.
//!
//! Curves are looked up at the half vector, for transmission with `wi` mirrored to the side of `wo`.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::curves::code::*;
    use crate::film::code::*;
    use crate::frame::code::*;
    use crate::fresnel::code::*;
    use crate::math::code::*;
    use crate::nodes::code::*;
    use wgsl_rs::std::*;

    /// The shading normal is that of the frame.
    pub const NO_SLOT: u32 = 0xffffffff;
    /// Optical depth from which on nothing is left.
    pub const OPAQUE: f32 = 80.0;

    /// The shading normal in a slot, on the side of `wo`.
    pub fn normal_at(p: ptr!(function, Params), slot: u32) -> Vec3f {
        let up = vec3f(0.0, 0.0, 1.0);
        if slot == NO_SLOT {
            return up;
        }
        let own = normalize_or(param3(p, slot), up);
        own * select(-1.0, 1.0, own.z >= 0.0)
    }

    /// The factor of the modifier at node `n` for a pair of directions.
    pub fn modifier_factor(
        n: Vec4u,
        p: ptr!(function, Params),
        point: ShadingPoint,
        normal: u32,
        wo: Vec3f,
        wi: Vec3f,
        transmits: bool,
    ) -> Vec3f {
        let op = n.x & OP_MASK;
        if op == OP_TINT {
            let second = transmits && (n.x & FLAG_COLOR) != 0;
            return unit3(param3(p, n.y + select(SLOT_TINT, SLOT_TINT_TRANSMISSION, second)));
        }
        if op == OP_SCALE {
            let s = param3(p, n.y + SLOT_TINT);
            return vec3f(nonnegative(s.x), nonnegative(s.y), nonnegative(s.z));
        }
        let z = normal_at(p, normal);
        let no = dot(z, wo);
        let ni = dot(z, wi);
        if op == OP_COAT_ABSORPTION {
            return node_coat_absorption(n, p, point, unit(abs(no)), unit(abs(ni)), transmits);
        }
        let c = half_cosine(no, ni, dot(wo, wi));
        if op == OP_MEASURED_FACTOR {
            return measured_curve(p, n.y, n.w, c);
        }
        if op == OP_FRESNEL_FACTOR {
            return node_fresnel_factor(n, p, point, c);
        }
        node_schlick(n, p, point.ior_near, n.y + SLOT_TINT, c)
    }

    /// Reflectance of a medium with complex index, seen from the medium outside.
    pub fn node_fresnel_factor(n: Vec4u, p: ptr!(function, Params), point: ShadingPoint, c: f32) -> Vec3f {
        let near = select(point.ior_near, point.ior_far, (point.flags & POINT_INSIDE) != 0);
        let ior = param3(p, n.y);
        let k = param3(p, n.y + SLOT_FACTOR_EXTINCTION);
        let real = vec3f(sane_ior(ior.x, near.x), sane_ior(ior.y, near.y), sane_ior(ior.z, near.z));
        let imaginary = vec3f(sane_ior(k.x, 0.0), sane_ior(k.y, 0.0), sane_ior(k.z, 0.0));
        if (n.x & FLAG_FILM) != 0 {
            return unit3(film_reflectance(node_film(n, p), near, real, imaginary, c));
        }
        film_reflectance(Film { thickness: 0.0, ior: near }, near, real, imaginary, c)
    }

    /// Inverse cosine in a coat of index `ior` of light at cosine `c` in a medium of index `side`.
    pub fn coat_path(ior: f32, side: f32, c: f32) -> f32 {
        let ratio = side / ior;
        1.0 / sqrt(max(1.0 - (1.0 - c) * (1.0 + c) * (ratio * ratio), 1e-12))
    }

    /// Transmittance of a coat on the way in and out (A. Beer's law along the refracted directions): reflected
    /// light passes it twice, transmitted light half as long. Light that cannot enter the coat is absorbed as if
    /// it went along it.
    pub fn node_coat_absorption(
        n: Vec4u,
        p: ptr!(function, Params),
        point: ShadingPoint,
        co: f32,
        ci: f32,
        transmits: bool,
    ) -> Vec3f {
        let ior = param3(p, n.y);
        let coefficient = param3(p, n.y + SLOT_COAT_ABSORPTION);
        let depth = nonnegative(param(p, n.y + SLOT_COAT_THICKNESS)) * select(1.0, 0.5, transmits);
        let near = point.ior_near;
        let far = select(point.ior_near, point.ior_far, transmits);
        let rx = sane_ior(ior.x, near.x);
        let ry = sane_ior(ior.y, near.y);
        let rz = sane_ior(ior.z, near.z);
        vec3f(
            coat_transmittance(coefficient.x, depth, coat_path(rx, near.x, co) + coat_path(rx, far.x, ci)),
            coat_transmittance(coefficient.y, depth, coat_path(ry, near.y, co) + coat_path(ry, far.y, ci)),
            coat_transmittance(coefficient.z, depth, coat_path(rz, near.z, co) + coat_path(rz, far.z, ci)),
        )
    }

    /// e^(−τ) of an absorption coefficient, a depth and a slant, none of them infinite.
    pub fn coat_transmittance(coefficient: f32, depth: f32, slant: f32) -> f32 {
        math_exp(-min(nonnegative(coefficient) * depth * slant, OPAQUE))
    }
}
pub use code::*;
