//! Energy that glossy lobes miss in one scattering, given back with the author's tint (MDL
//! `multiscatter_tint`), and the albedo of sheen.
//!
//! Source: C. Kelemen, L. Szirmay-Kalos, "A Microfacet Based Coupled Specular-Matte BRDF Model with
//! Importance Sampling", Eurographics 2001, eq. 11: with L = 1 − E the loss at a direction and L̄ its mean
//! over the hemisphere, the lobe L(o) L(i)/(π L̄) is reciprocal and has the energy L(o).
//!
//! L and L̄ are fits over an isotropic reflector, by t = μ/(μ + α) and α.
//! GGX with Smith masking is fitted within 8e-4, and compensated it loses nothing. The others are fitted
//! from below: they never gain, and lose up to 3 %. Anisotropic lobes get a share of what either roughness
//! alone loses. Where light passes, the same loss counts: a thin sheet gives it to both sides as Fresnel's
//! mean divides them; an interface reflects the share of normal incidence and transmits none.

use wgsl_rs::wgsl;

#[wgsl]
#[allow(
    missing_docs,
    clippy::excessive_precision,
    reason = "the macro adds items; coefficients are spelled as they were fitted"
)]
pub mod code {
    //! Shared with the GPU.
    use crate::frame::code::*;
    use crate::fresnel::code::*;
    use crate::lobes::code::*;
    use crate::lobes::ggx::code::*;
    use crate::lobes::ggx_albedo::code::*;
    use crate::lobes::glossy::code::*;
    use crate::nodes::code::*;
    use wgsl_rs::std::*;

    /// What an anisotropic lobe loses at least, as a share of the loss of either roughness alone.
    pub const ANISOTROPIC_SHARE: f32 = 0.4;

    /// c0 + c1 x + … + c5 x⁵
    pub fn quintic(x: f32, c0: f32, c1: f32, c2: f32, c3: f32, c4: f32, c5: f32) -> f32 {
        c0 + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * c5))))
    }

    /// a0 x + a1 x² + … + b3 x⁸
    pub fn septic(a: Vec4f, b: Vec4f, x: f32) -> f32 {
        let x2 = x * x;
        x * (cubic(a, x) + x2 * x2 * cubic(b, x))
    }

    /// The loss 1 − E of lobe `op` at cosine `mu`; at most that, but for GGX.
    pub fn glossy_loss(op: u32, alpha: f32, mu: f32) -> f32 {
        if op == OP_GGX_SMITH {
            return 1.0 - ggx_albedo_reflection(alpha, mu);
        }
        unit(glossy_loss_fit(op, alpha, mu / (mu + alpha)))
    }

    /// The fits of `glossy_loss`, less their largest error.
    pub fn glossy_loss_fit(op: u32, alpha: f32, t: f32) -> f32 {
        if op == OP_BECKMANN_SMITH {
            return quintic(
                t,
                cubic(vec4f(0.021802, 0.045393, -0.142594, 0.159352), alpha),
                cubic(vec4f(0.988651, -1.665541, 6.074658, -6.281233), alpha),
                cubic(vec4f(-9.102284, 10.638974, -41.186515, 58.886292), alpha),
                cubic(vec4f(34.781518, -21.754057, 92.344188, -200.699361), alpha),
                cubic(vec4f(-50.830193, 18.813976, -73.714033, 305.968498), alpha),
                cubic(vec4f(24.346131, 0.416989, -24.107794, -127.060070), alpha),
            ) * (1.0 - t)
                - 0.0122;
        }
        if op == OP_GGX_VCAVITIES {
            return quintic(
                t,
                cubic(vec4f(-0.008323, 0.108912, -0.236580, 0.128574), alpha),
                cubic(vec4f(0.424339, -5.695830, 13.279786, -6.594141), alpha),
                cubic(vec4f(-1.880651, 45.226224, -101.641659, 49.285747), alpha),
                cubic(vec4f(5.294266, -137.745869, 288.455789, -104.569487), alpha),
                cubic(vec4f(-4.650027, 160.118475, -264.618354, 21.517689), alpha),
                cubic(vec4f(0.537228, -59.072841, 62.261869, 56.025987), alpha),
            ) * (1.0 - t)
                - 0.0092;
        }
        if op == OP_BECKMANN_VCAVITIES {
            return quintic(
                t,
                cubic(vec4f(-0.010230, 0.018238, -0.073328, 0.075293), alpha),
                cubic(vec4f(0.889358, -2.636960, 5.424865, -3.797450), alpha),
                cubic(vec4f(-8.649434, 33.620016, -46.989163, 26.424348), alpha),
                cubic(vec4f(33.171436, -124.495237, 88.632953, -9.432715), alpha),
                cubic(vec4f(-47.312800, 164.886076, 56.530435, -147.565152), alpha),
                cubic(vec4f(21.998805, -64.394149, -171.026574, 210.811133), alpha),
            ) * (1.0 - t)
                - 0.0102;
        }
        if op == OP_WARD {
            return quintic(
                t,
                cubic(vec4f(0.001752, 0.001966, 0.002140, -0.001852), alpha),
                cubic(vec4f(1.878180, -0.151267, 1.418887, 0.069267), alpha),
                cubic(vec4f(-8.377758, 2.079050, -1.427905, -5.074465), alpha),
                cubic(vec4f(25.245173, -9.256740, 0.172648, 32.255229), alpha),
                cubic(vec4f(-33.777125, 13.250828, 34.693919, -96.458424), alpha),
                cubic(vec4f(15.026973, -3.424186, -53.048371, 103.911503), alpha),
            ) * (1.0 - t)
                - 0.0042;
        }
        quintic(
            t,
            cubic(vec4f(-0.008120, 0.003526, -0.016629, 0.020310), alpha),
            cubic(vec4f(0.728445, -1.606569, 2.006682, -0.290509), alpha),
            cubic(vec4f(-7.013312, 28.780173, -33.148672, 3.983721), alpha),
            cubic(vec4f(27.522584, -125.834159, 106.311619, 33.679482), alpha),
            cubic(vec4f(-39.542451, 187.256063, -37.511482, -185.320918), alpha),
            cubic(vec4f(18.357836, -85.225327, -87.451879, 209.495401), alpha),
        ) * (1.0 - t)
            - 0.0086
    }

    /// The mean of `glossy_loss` over the hemisphere; at least that, but for GGX.
    pub fn glossy_mean_loss(op: u32, alpha: f32) -> f32 {
        if op == OP_GGX_SMITH {
            let root = sqrt(alpha);
            let low = septic(
                vec4f(0.001451, -0.067216, 0.668570, 3.539301),
                vec4f(-12.074610, 24.764432, -32.163252, 21.782655),
                root,
            );
            let square = alpha * alpha;
            let fit = low - 5.828110 * square * square * root;
            return select(1.5e-3, fit, alpha > 0.0158);
        }
        let low = select(select(0.08, 0.055, op == OP_GGX_VCAVITIES), 0.035, op == OP_WARD);
        select(4e-3, glossy_mean_fit(op, alpha), alpha > low)
    }

    /// The fits of `glossy_mean_loss`, raised by their largest error.
    pub fn glossy_mean_fit(op: u32, alpha: f32) -> f32 {
        if op == OP_BECKMANN_SMITH {
            return 1.031
                * septic(
                    vec4f(0.776266, -9.859455, 49.316661, -123.280267),
                    vec4f(163.743781, -108.873836, 28.502858, 0.0),
                    sqrt(alpha),
                );
        }
        if op == OP_GGX_VCAVITIES {
            return 1.051
                * septic(
                    vec4f(0.703076, -8.272438, 35.092877, -65.913792),
                    vec4f(60.521567, -23.495213, 1.787187, 0.0),
                    sqrt(alpha),
                );
        }
        if op == OP_BECKMANN_VCAVITIES {
            return 1.034
                * septic(
                    vec4f(0.751613, -10.486248, 57.827619, -160.032237),
                    vec4f(235.136586, -172.824955, 49.959916, 0.0),
                    sqrt(alpha),
                );
        }
        if op == OP_WARD {
            return 1.025
                * septic(
                    vec4f(0.169989, -2.488991, 12.890915, -27.194534),
                    vec4f(32.245917, -20.014306, 4.893565, 0.0),
                    sqrt(alpha),
                );
        }
        1.032
            * septic(
                vec4f(0.234031, -3.721095, 22.868775, -69.282870),
                vec4f(110.870247, -87.351624, 26.649299, 0.0),
                sqrt(alpha),
            )
    }

    /// Albedo of sheen at cosine `mu`, at least: a fit by x = μ/(μ + √r) and √r, raised by its largest error.
    pub fn sheen_albedo(roughness: f32, mu: f32) -> f32 {
        let s = sqrt(sane_alpha(roughness));
        let x = mu / (mu + s);
        let high = quintic(
            x,
            cubic(vec4f(0.225990, -2.089430, 9.217020, -6.675080), s),
            cubic(vec4f(6.077950, 26.949260, -119.293230, 91.061080), s),
            cubic(vec4f(-29.025440, -121.993140, 574.623020, -451.231840), s),
            cubic(vec4f(72.082260, 241.820380, -1254.302160, 1034.914170), s),
            cubic(vec4f(-77.316420, -222.952150, 1312.775150, -1147.620360), s),
            cubic(vec4f(28.944620, 79.654320, -538.701070, 494.047370), s),
        );
        unit(1.0 - (cubic(vec4f(0.003170, 0.039620, -0.156030, 0.117590), s) + x * high) + 0.007)
    }

    /// The lobe of multiple scattering for one view direction.
    #[derive(Clone, Copy, Debug)]
    pub struct Multiscatter {
        /// Loss of single scattering at `wo`.
        pub loss: f32,
        /// 1/L̄
        pub inverse_mean: f32,
        /// Share of the loss that is reflected.
        pub reflected: f32,
        /// Share of the loss that is transmitted.
        pub transmitted: f32,
    }

    /// The loss of `lobe` at cosine `mu`, at most where it is anisotropic.
    pub fn lobe_loss(lobe: Glossy, mu: f32) -> f32 {
        let loss = glossy_loss(lobe.op, lobe.ggx.alpha.x, mu);
        if lobe.ggx.alpha.x == lobe.ggx.alpha.y {
            return loss;
        }
        ANISOTROPIC_SHARE * min(loss, glossy_loss(lobe.op, lobe.ggx.alpha.y, mu))
    }

    /// Multiple scattering of `lobe` seen from `wo`.
    pub fn multiscatter_new(lobe: Glossy, wo: Vec3f) -> Multiscatter {
        let alpha = lobe.ggx.alpha;
        let mode = lobe.ggx.mode;
        let mut reflected: f32 = 1.0;
        let mut transmitted: f32 = 0.0;
        if mode != MODE_REFLECT {
            reflected = select(0.0, fresnel_dielectric(1.0, lobe.ggx.eta), mode == MODE_REFLECT_TRANSMIT);
            if lobe.ggx.thin_walled {
                transmitted = 1.0 - reflected;
            }
        }
        let mut mean_loss: f32 = glossy_mean_loss(lobe.op, alpha.x);
        if alpha.x != alpha.y {
            mean_loss = ANISOTROPIC_SHARE * min(mean_loss, glossy_mean_loss(lobe.op, alpha.y));
        }
        Multiscatter {
            loss: lobe_loss(lobe, unit(wo.z)),
            inverse_mean: 1.0 / mean_loss,
            reflected,
            transmitted,
        }
    }

    /// Value and density of the compensation for `wi`.
    pub fn multiscatter_eval(m: Multiscatter, lobe: Glossy, wi: Vec3f) -> LobeValue {
        let mu = abs(wi.z);
        let share = select(m.reflected, m.transmitted, wi.z < 0.0);
        let lambert = mu * FRAC_1_PI;
        LobeValue {
            f: share * m.loss * lobe_loss(lobe, min(mu, 1.0)) * m.inverse_mean * lambert,
            pdf: select(0.0, share / (m.reflected + m.transmitted) * lambert, share > 0.0),
        }
    }

    /// Probability of sampling the single scattering of a lobe with the tints `single` and `multiple`.
    pub fn multiscatter_single(m: Multiscatter, single: Vec3f, multiple: Vec3f) -> f32 {
        let a = max3(single) * (1.0 - m.loss);
        let sum = a + max3(multiple) * m.loss * (m.reflected + m.transmitted);
        select(1.0, a / sum, sum > 0.0)
    }
}
pub use code::*;
