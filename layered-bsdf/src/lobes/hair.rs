//! Fibers of hair (MDL `df::chiang_hair_bsdf`).
//!
//! Source: M. J.-Y. Chiang et al., "A Practical and Controllable Hair and Fur Model for Production Path Tracing",
//! Computer Graphics Forum 35(2), 2016, on E. d'Eon et al., "An Energy-Conserving Hair Reflectance Model", 2011.
//! Light is reflected (R), goes through (TT), or is reflected within once (TRT) or more often; each lobe is a
//! product of an attenuation A, a longitudinal function M of the angles θ to the cross section, and an azimuthal
//! function N of the angle φ around the fiber.
//!
//! Frame: x along the fiber, towards its tip; z the normal where light from the eye meets the round fiber, so that
//! the offset h across it follows from `wo`. The value includes the cosine of its own cross section: it integrates
//! over the sphere to the sum of the attenuations, which is 1 without absorption.
//!
//! The parameters are those of MDL's reference: a roughness is (v, β) with M's variance v and N's scale s = β √(π/8);
//! the cuticle angle is in radians, and tilts R by 2α, TT by −α, TRT by −4α. Differs from the reference: the tilt turns
//! `wo` (as in the paper), not `wi`, for which M would not be normalised; and the logarithm of Bessel's function has
//! its digits.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::frame::code::*;
    use crate::fresnel::code::*;
    use crate::math::code::*;
    use crate::nodes::code::*;
    use crate::sampling::code::*;
    use wgsl_rs::std::*;

    /// Slot of the tint of all that is scattered.
    pub const SLOT_HAIR_TINT: u32 = 0;
    /// Slot of the weight of the diffuse lobe.
    pub const SLOT_HAIR_DIFFUSE: u32 = 3;
    /// Slot of the tint of the diffuse lobe.
    pub const SLOT_HAIR_DIFFUSE_TINT: u32 = 4;
    /// Slot of the roughnesses of R, TT and TRT, two each.
    pub const SLOT_HAIR_ROUGHNESS: u32 = 7;
    /// Slot of the cuticle angle.
    pub const SLOT_HAIR_CUTICLE: u32 = 13;
    /// Slot of the absorption coefficient, for a fiber of radius 1.
    pub const SLOT_HAIR_ABSORPTION: u32 = 14;
    /// Slot of the index of refraction.
    pub const SLOT_HAIR_IOR: u32 = 17;
    /// Number of slots.
    pub const HAIR_SLOTS: u32 = 18;

    /// Least longitudinal variance: a highlight of 0.06°.
    pub const HAIR_V_MIN: f32 = 1e-6;
    /// Least azimuthal scale, radians: below, angles have too few digits.
    pub const HAIR_S_MIN: f32 = 1e-3;
    /// √(π/8)
    pub const SQRT_PI_8: f32 = 0.62665707;

    /// Value and density of scattering into a direction.
    #[derive(Clone, Copy, Debug)]
    pub struct HairValue {
        /// Scattered share, sr⁻¹.
        pub value: Vec3f,
        /// Density of `hair_sample`, sr⁻¹.
        pub pdf: f32,
    }

    /// A direction in which a path goes on.
    #[derive(Clone, Copy, Debug)]
    pub struct HairSample {
        /// The direction.
        pub wi: Vec3f,
        /// Its density, sr⁻¹; 0: everything is absorbed.
        pub pdf: f32,
        /// Value over density.
        pub weight: Vec3f,
    }

    /// A fiber as seen from `wo`.
    #[derive(Clone, Copy, Debug)]
    pub struct Fiber {
        /// Attenuations of R, TT, TRT and what follows.
        pub a0: Vec3f,
        /// Of TT.
        pub a1: Vec3f,
        /// Of TRT.
        pub a2: Vec3f,
        /// Of what is reflected within more often.
        pub a3: Vec3f,
        /// Angle between the normal and `wo` in the cross section.
        pub gamma_o: f32,
        /// The same after refraction.
        pub gamma_t: f32,
        /// Weight of the diffuse lobe; 0 where the fiber is seen from behind.
        pub diffuse: f32,
    }

    /// e^(−x) I₀(x) for x ≥ 0: Abramowitz and Stegun, "Handbook of Mathematical Functions", 9.8.1 and 9.8.2.
    pub fn bessel_i0_scaled(x: f32) -> f32 {
        if x < 3.75 {
            let t = x * (1.0 / 3.75);
            let z = t * t;
            let p = 0.2659732 + z * (0.0360768 + z * 0.0045813);
            return (1.0 + z * (3.5156229 + z * (3.0899424 + z * (1.2067492 + z * p)))) * math_exp(-x);
        }
        let r = 3.75 / x;
        let p = 0.00916281 + r * (-0.02057706 + r * (0.02635537 + r * (-0.01647633 + r * 0.00392377)));
        (0.3989423 + r * (0.01328592 + r * (0.00225319 + r * (-0.00157565 + r * p)))) / sqrt(x)
    }

    /// The longitudinal function: the density of sin θi for light around −θo with variance `v`. `to` and `ti` are
    /// (cos θ, sin θ). All exponents are taken together as (cos(θo + θi) − 1)/v, by the chord, so that no term
    /// overflows and small variances keep their digits.
    pub fn hair_longitudinal(to: Vec2f, ti: Vec2f, v: f32) -> f32 {
        let across = ti.x - to.x;
        let along = ti.y + to.y;
        let exponent = -0.5 * (across * across + along * along) / v;
        // v (1 − e^(−2/v)), which tends to 2.
        let wide = 2.0 * v * math_exp(-1.0 / max(v, 0.1)) * math_sinh(1.0 / max(v, 0.1));
        let norm = select(wide, v, v < 0.1);
        math_exp(exponent) * bessel_i0_scaled(to.x * ti.x / v) / norm
    }

    /// The logistic function with scale `s`, trimmed to [−π, π] and normalised there.
    pub fn hair_logistic(x: f32, s: f32) -> f32 {
        let e = math_exp(-abs(x) / s);
        e / (s * (1.0 + e) * (1.0 + e) * math_tanh(0.5 * PI / s))
    }

    /// An angle for `u` with the density of `hair_logistic`.
    pub fn hair_logistic_sample(u: f32, s: f32) -> f32 {
        let x = 2.0 * s * math_atanh(clamp(2.0 * u - 1.0, -0.9999999, 0.9999999) * math_tanh(0.5 * PI / s));
        clamp(x, -PI, PI)
    }

    /// The change of azimuth of light that takes the way `p`: 0 for R, 1 for TT, 2 for TRT.
    pub fn hair_turn(fiber: Fiber, p: f32) -> f32 {
        2.0 * p * fiber.gamma_t - 2.0 * fiber.gamma_o + p * PI
    }

    /// The azimuthal function of the way `p` at the change of azimuth `dphi`.
    pub fn hair_azimuthal(fiber: Fiber, p: f32, s: f32, dphi: f32) -> f32 {
        let x = dphi - hair_turn(fiber, p);
        hair_logistic(x - 2.0 * PI * math_round_half_even(x * (0.5 * FRAC_1_PI)), s)
    }

    /// Variance and scale of the way `p`.
    pub fn hair_roughness(h: ptr!(function, Params), p: u32) -> Vec2f {
        let v = param(h, SLOT_HAIR_ROUGHNESS + 2 * p);
        let beta = param(h, SLOT_HAIR_ROUGHNESS + 2 * p + 1);
        let s = nonnegative(beta) * SQRT_PI_8;
        vec2f(clamp(nonnegative(v), HAIR_V_MIN, 1e4), clamp(s, HAIR_S_MIN, 1e4))
    }

    /// (cos θo, sin θo) of a direction, turned by the cuticle's tilt for the way `p`; the cosine is not negative.
    pub fn hair_tilted(h: ptr!(function, Params), p: u32, wo: Vec3f) -> Vec2f {
        let plain = vec2f(sqrt(wo.y * wo.y + wo.z * wo.z), wo.x);
        let angle = param(h, SLOT_HAIR_CUTICLE);
        if p > 2 || !(abs(angle) < 100.0) {
            return plain;
        }
        let sc = math_sincos((2.0 - 3.0 * f32(p)) * angle);
        vec2f(abs(plain.x * sc.y - plain.y * sc.x), plain.y * sc.y + plain.x * sc.x)
    }

    /// The fiber with parameters `h`.
    pub fn fiber_new(h: ptr!(function, Params), wo: Vec3f) -> Fiber {
        let eta = sane_eta(param(h, SLOT_HAIR_IOR));
        let cos_o = max(sqrt(wo.y * wo.y + wo.z * wo.z), 1e-18);
        let offset = clamp(-wo.y / cos_o, -1.0, 1.0);
        let sin_t = wo.x / eta;
        let cos_t = sqrt(max((1.0 - sin_t) * (1.0 + sin_t), 1e-12));
        // The index of refraction in the cross section (R. Bravais).
        let inner = sqrt(max((eta - wo.x) * (eta + wo.x), 1e-12)) / cos_o;
        let bent = clamp(offset / inner, -1.0, 1.0);
        let cos_bent = sqrt((1.0 - bent) * (1.0 + bent));
        let fresnel = fresnel_dielectric(unit(abs(wo.z)), eta);
        let rest = 1.0 - fresnel;
        let depth = 2.0 * cos_bent / cos_t;
        let sigma = param3(h, SLOT_HAIR_ABSORPTION);
        let t = vec3f(
            math_exp(-min(nonnegative(sigma.x) * depth, 80.0)),
            math_exp(-min(nonnegative(sigma.y) * depth, 80.0)),
            math_exp(-min(nonnegative(sigma.z) * depth, 80.0)),
        );
        let a1 = t * (rest * rest);
        let a2 = a1 * t * fresnel;
        // 1 − TF, not below what is left of 1 − F.
        let lost = vec3f(
            max(1.0 - t.x * fresnel, 1e-20),
            max(1.0 - t.y * fresnel, 1e-20),
            max(1.0 - t.z * fresnel, 1e-20),
        );
        let weight = unit(param(h, SLOT_HAIR_DIFFUSE));
        Fiber {
            a0: splat3(fresnel),
            a1,
            a2,
            a3: a2 * t * fresnel / lost,
            gamma_o: math_atan2(-wo.y, max(abs(wo.z), 1e-30)),
            gamma_t: math_asin(bent),
            diffuse: select(0.0, weight, wo.z > 0.0),
        }
    }

    /// Value and density for a pair of directions.
    pub fn hair_eval(h: ptr!(function, Params), wo: Vec3f, wi: Vec3f) -> HairValue {
        let fiber = fiber_new(h, wo);
        hair_eval_fiber(h, fiber, wo, wi)
    }

    /// The same for a fiber that is known.
    pub fn hair_eval_fiber(h: ptr!(function, Params), fiber: Fiber, wo: Vec3f, wi: Vec3f) -> HairValue {
        let ti = vec2f(sqrt(wi.y * wi.y + wi.z * wi.z), wi.x);
        let dphi = math_atan2(wi.z * wo.y - wi.y * wo.z, wi.y * wo.y + wi.z * wo.z);
        let r0 = hair_roughness(h, 0);
        let r1 = hair_roughness(h, 1);
        let r2 = hair_roughness(h, 2);
        let n0 = hair_longitudinal(hair_tilted(h, 0, wo), ti, r0.x) * hair_azimuthal(fiber, 0.0, r0.y, dphi);
        let n1 = hair_longitudinal(hair_tilted(h, 1, wo), ti, r1.x) * hair_azimuthal(fiber, 1.0, r1.y, dphi);
        let n2 = hair_longitudinal(hair_tilted(h, 2, wo), ti, r2.x) * hair_azimuthal(fiber, 2.0, r2.y, dphi);
        let n3 = hair_longitudinal(hair_tilted(h, 3, wo), ti, r2.x) * (0.5 * FRAC_1_PI);
        let lobes = fiber.a0 * n0 + fiber.a1 * n1 + fiber.a2 * n2 + fiber.a3 * n3;
        let m = vec4f(mean3(fiber.a0), mean3(fiber.a1), mean3(fiber.a2), mean3(fiber.a3));
        let pdf = (m.x * n0 + m.y * n1 + m.z * n2 + m.w * n3) / (m.x + m.y + m.z + m.w);
        let cosine = max(wi.z, 0.0) * FRAC_1_PI;
        let diffuse = unit3(param3(h, SLOT_HAIR_DIFFUSE_TINT)) * (cosine * fiber.diffuse);
        let weight = unit(param(h, SLOT_HAIR_DIFFUSE));
        HairValue {
            value: unit3(param3(h, SLOT_HAIR_TINT)) * (lobes * (1.0 - weight) + diffuse),
            pdf: pdf * (1.0 - fiber.diffuse) + cosine * fiber.diffuse,
        }
    }

    /// A direction: `u.xy` place it, `u.z` chooses the lobe.
    pub fn hair_sample(h: ptr!(function, Params), wo: Vec3f, u: Vec3f) -> HairSample {
        let fiber = fiber_new(h, wo);
        let wi = hair_direction(h, fiber, wo, u);
        let v = hair_eval_fiber(h, fiber, wo, wi);
        if !(v.pdf > 0.0) {
            return HairSample { wi, pdf: 0.0, weight: splat3(0.0) };
        }
        HairSample { wi, pdf: v.pdf, weight: v.value * (1.0 / max(v.pdf, 1e-37)) }
    }

    /// The direction of `hair_sample`.
    pub fn hair_direction(h: ptr!(function, Params), fiber: Fiber, wo: Vec3f, u: Vec3f) -> Vec3f {
        if u.z < fiber.diffuse {
            return sample_cosine_hemisphere(u.xy());
        }
        let m = vec4f(mean3(fiber.a0), mean3(fiber.a1), mean3(fiber.a2), mean3(fiber.a3));
        let sum = m.x + m.y + m.z + m.w;
        // What is left of u.z chooses the lobe, and what is left then a second angle.
        let choice = (u.z - fiber.diffuse) / (1.0 - fiber.diffuse) * sum;
        let after0 = m.x + m.y;
        let after1 = after0 + m.z;
        let p =
            select(select(select(3u32, 2u32, choice < after1), 1u32, choice < after0), 0u32, choice < m.x);
        let before = select(select(select(after1, after0, p == 2), m.x, p == 1), 0.0, p == 0);
        let own = select(select(select(m.w, m.z, p == 2), m.y, p == 1), m.x, p == 0);
        let rest = clamp((choice - before) / max(own, 1e-30), 0.0, 1.0);
        let r = hair_roughness(h, min(p, 2));
        let to = hair_tilted(h, p, wo);
        // Around −θo on a sphere, as d'Eon, Marschner and Hanika, "Importance Sampling for Physically-Based Hair Fiber
        // Models", 2013.
        let spread = u.y + (1.0 - u.y) * math_exp(-2.0 / r.x);
        let below = min(-r.x * math_log(max(spread, 1e-37)), 2.0);
        let radius = sqrt(max(below * (2.0 - below), 0.0));
        let sc = math_sincos(2.0 * PI * rest);
        let sin_i = radius * sc.y * to.x - to.y * (1.0 - below);
        let up = to.x * (1.0 - below) + radius * sc.y * to.y;
        let side = radius * sc.x;
        let cos_i = sqrt(up * up + side * side);
        let uniform = PI * (2.0 * u.x - 1.0);
        let turned = hair_turn(fiber, f32(p)) + hair_logistic_sample(u.x, r.y);
        let phi = math_atan2(wo.z, wo.y) + select(turned, uniform, p == 3);
        let around = math_sincos(phi);
        normalize_or(vec3f(sin_i, cos_i * around.y, cos_i * around.x), vec3f(0.0, 0.0, 1.0))
    }
}
pub use code::*;
