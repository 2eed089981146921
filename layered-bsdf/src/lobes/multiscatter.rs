//! Energy that glossy lobes miss in one scattering, given back with the author's tint (MDL
//! `multiscatter_tint`), and the albedo of sheen.
//!
//! Source: C. Kelemen, L. Szirmay-Kalos, "A Microfacet Based Coupled Specular-Matte BRDF Model with
//! Importance Sampling", Eurographics 2001, eq. 11: with L = 1 − E the loss at a direction and L̄ its mean
//! over the hemisphere, the lobe L(o) L(i)/(π L̄) is reciprocal and has the energy L(o).
//!
//! L and L̄ are fits over an isotropic reflector, by t = μ/(μ + α) and α.
//! GGX with Smith masking is fitted within 8e-4, and compensated it loses nothing. The others are fitted
//! from below: they never gain. Of all light they still lose up to 5.5 % for α ≥ 0.12, and 15 % (Ward, 0.02)
//! below. Anisotropic lobes get a share of what either roughness alone loses, and still lose up to 40 %. Where light passes, the same loss counts: a thin sheet gives it to both sides as Fresnel's
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
    pub const ANISOTROPIC_SHARE: f32 = 0.33;

    /// c0 + c1 x + … + c5 x⁵
    pub fn quintic(x: f32, c0: f32, c1: f32, c2: f32, c3: f32, c4: f32, c5: f32) -> f32 {
        c0 + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * c5))))
    }

    /// a0 x + a1 x² + … + b3 x⁸
    pub fn septic(a: Vec4f, b: Vec4f, x: f32) -> f32 {
        let x2 = x * x;
        x * (cubic(a, x) + x2 * x2 * cubic(b, x))
    }

    /// Which fits are for a lobe: its operation, flagged where heights are correlated.
    pub fn loss_kind(lobe: Glossy) -> u32 {
        lobe.op | select(0u32, FLAG_CORRELATED, lobe.ggx.correlated)
    }

    /// The loss 1 − E of a kind of lobe at cosine `mu`; at most that, but for GGX.
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
                cubic(vec4f(0.021866, 0.036548, -0.116330, 0.141893), alpha),
                cubic(vec4f(0.986037, -1.638502, 6.016981, -6.246905), alpha),
                cubic(vec4f(-9.069356, 12.080729, -46.312368, 62.466531), alpha),
                cubic(vec4f(34.629537, -29.873240, 121.822790, -221.238919), alpha),
                cubic(vec4f(-50.580212, 33.783996, -129.002715, 343.954927), alpha),
                cubic(vec4f(24.213737, -8.550887, 9.255230, -149.277097), alpha),
            ) * (1.0 - t)
                - 0.0119;
        }
        if op == (OP_BECKMANN_SMITH | FLAG_CORRELATED) {
            return quintic(
                t,
                cubic(vec4f(-0.012070, 0.033214, -0.119957, 0.110431), alpha),
                cubic(vec4f(1.078240, -1.714757, 6.277661, -6.328772), alpha),
                cubic(vec4f(-9.050296, 12.552000, -47.616779, 63.009265), alpha),
                cubic(vec4f(34.399414, -30.570156, 123.712075, -220.821026), alpha),
                cubic(vec4f(-50.402222, 33.792275, -129.260595, 341.172655), alpha),
                cubic(vec4f(24.192633, -8.218997, 8.715681, -147.494675), alpha),
            ) * (1.0 - t)
                - 0.0119;
        }
        if op == (OP_GGX_SMITH | FLAG_CORRELATED) {
            return quintic(
                t,
                cubic(vec4f(-0.002193, -0.003929, 0.019700, -0.009909), alpha),
                cubic(vec4f(0.389514, 0.276278, 3.602155, -0.153941), alpha),
                cubic(vec4f(-1.884535, 0.799644, -8.848353, -10.377415), alpha),
                cubic(vec4f(9.441536, -15.514724, 46.543361, 51.055802), alpha),
                cubic(vec4f(-13.996536, 36.710452, -59.939266, -145.717144), alpha),
                cubic(vec4f(6.043220, -22.636623, 10.802714, 146.711971), alpha),
            ) * (1.0 - t)
                - 0.0039;
        }
        if op == OP_GGX_VCAVITIES {
            return quintic(
                t,
                cubic(vec4f(0.004576, 0.041367, -0.112244, 0.057583), alpha),
                cubic(vec4f(-0.210112, -2.435367, 5.088588, -0.941911), alpha),
                cubic(vec4f(2.703446, 27.413009, -42.366882, 2.242607), alpha),
                cubic(vec4f(-7.317091, -99.204317, 109.273817, 52.875048), alpha),
                cubic(vec4f(10.293373, 122.091267, -13.652756, -213.643385), alpha),
                cubic(vec4f(-5.817452, -44.807848, -69.977269, 184.795958), alpha),
            ) * (1.0 - t)
                - 0.0091;
        }
        if op == OP_BECKMANN_VCAVITIES {
            return quintic(
                t,
                cubic(vec4f(-0.010304, 0.026959, -0.098387, 0.091693), alpha),
                cubic(vec4f(0.890890, -3.064467, 6.620376, -4.568157), alpha),
                cubic(vec4f(-8.662196, 36.733745, -55.631454, 31.933835), alpha),
                cubic(vec4f(33.213867, -132.826896, 111.506443, -23.793283), alpha),
                cubic(vec4f(-47.370721, 174.350391, 30.974288, -131.846028), alpha),
                cubic(vec4f(22.025890, -68.265414, -160.801484, 204.672060), alpha),
            ) * (1.0 - t)
                - 0.0102;
        }
        if op == OP_WARD {
            return quintic(
                t,
                cubic(vec4f(0.001529, 0.002360, 0.000942, -0.000811), alpha),
                cubic(vec4f(1.880037, -0.201461, 1.570437, -0.017933), alpha),
                cubic(vec4f(-8.388028, 2.587254, -3.034493, -4.328010), alpha),
                cubic(vec4f(25.278350, -11.149513, 6.221193, 30.245513), alpha),
                cubic(vec4f(-33.826014, 16.184907, 25.545393, -95.085965), alpha),
                cubic(vec4f(15.051414, -4.966080, -48.585016, 104.673753), alpha),
            ) * (1.0 - t)
                - 0.0042;
        }
        quintic(
            t,
            cubic(vec4f(-0.013516, 0.076712, -0.188384, 0.116670), alpha),
            cubic(vec4f(1.115230, -9.128073, 20.113239, -10.726370), alpha),
            cubic(vec4f(-10.869623, 110.646688, -223.222328, 109.119772), alpha),
            cubic(vec4f(40.455348, -411.078839, 726.252177, -273.870593), alpha),
            cubic(vec4f(-56.712615, 575.451629, -797.921680, 116.722843), alpha),
            cubic(vec4f(26.116329, -263.050487, 201.867514, 158.453524), alpha),
        ) * (1.0 - t)
            - 0.0132
    }

    /// The mean of `glossy_loss` over the hemisphere; at least that, but for GGX.
    pub fn glossy_mean_loss(op: u32, alpha: f32) -> f32 {
        if op == OP_GGX_SMITH {
            let root = sqrt(alpha);
            let low = septic(
                vec4f(0.001421, -0.066154, 0.656688, 3.604301),
                vec4f(-12.275078, 25.129295, -32.551043, 22.004815),
                root,
            );
            let square = alpha * alpha;
            let fit = low - 5.881026 * square * square * root;
            return select(1.5e-3, fit, alpha > 0.0158);
        }
        let low = select(select(0.08, 0.055, op == OP_GGX_VCAVITIES), 0.035, op == OP_WARD);
        select(4e-3, glossy_mean_fit(op, alpha), alpha > low)
    }

    /// The fits of `glossy_mean_loss`, raised by their largest error.
    pub fn glossy_mean_fit(op: u32, alpha: f32) -> f32 {
        if op == OP_BECKMANN_SMITH {
            return 1.034
                * septic(
                    vec4f(0.769377, -9.761946, 48.764537, -121.692648),
                    vec4f(161.355696, -107.091346, 27.982531, 0.000000),
                    sqrt(alpha),
                );
        }
        if op == (OP_BECKMANN_SMITH | FLAG_CORRELATED) {
            return 1.019
                * septic(
                    vec4f(0.769040, -9.758975, 48.757141, -121.697163),
                    vec4f(161.374213, -107.100001, 27.974245, 0.000000),
                    sqrt(alpha),
                );
        }
        if op == (OP_GGX_SMITH | FLAG_CORRELATED) {
            return 1.010
                * septic(
                    vec4f(0.047996, -0.535666, 1.214514, 6.285924),
                    vec4f(-16.741533, 15.685147, -5.375737, 0.000000),
                    sqrt(alpha),
                );
        }
        if op == OP_GGX_VCAVITIES {
            return 1.050
                * septic(
                    vec4f(0.430624, -4.851440, 18.641040, -26.925715),
                    vec4f(12.082475, 6.714142, -5.665598, 0.000000),
                    sqrt(alpha),
                );
        }
        if op == OP_BECKMANN_VCAVITIES {
            return 1.037
                * septic(
                    vec4f(0.751290, -10.484129, 57.828211, -160.067098),
                    vec4f(235.237994, -172.937206, 50.003273, 0.000000),
                    sqrt(alpha),
                );
        }
        if op == OP_WARD {
            return 1.028
                * septic(
                    vec4f(0.163873, -2.384024, 12.207345, -25.057892),
                    vec4f(28.838545, -17.351150, 4.086057, 0.000000),
                    sqrt(alpha),
                );
        }
        1.037
            * septic(
                vec4f(0.725637, -10.199080, 56.687442, -158.425591),
                vec4f(235.608495, -175.338975, 51.278755, 0.000000),
                sqrt(alpha),
            )
    }

    /// Albedo of sheen at cosine `mu`, at least: a fit by x = μ/(μ + √r) and √r, raised by its largest error.
    pub fn sheen_albedo(roughness: f32, mu: f32) -> f32 {
        let s = sqrt(sane_alpha(roughness));
        let x = mu / (mu + s);
        let high = quintic(
            x,
            cubic(vec4f(0.182386, -1.750024, 8.450559, -6.139677), s),
            cubic(vec4f(6.360615, 25.636229, -118.253925, 88.956734), s),
            cubic(vec4f(-29.597860, -124.794808, 602.452339, -456.201103), s),
            cubic(vec4f(72.266909, 261.505770, -1370.659008, 1053.828265), s),
            cubic(vec4f(-76.794117, -252.693863, 1472.390364, -1139.899303), s),
            cubic(vec4f(28.570965, 93.408071, -607.751661, 459.298155), s),
        );
        unit(1.0 - (cubic(vec4f(0.004206, 0.029186, -0.141438, 0.113149), s) + x * high) + 0.0061)
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
        let loss = glossy_loss(loss_kind(lobe), lobe.ggx.alpha.x, mu);
        if lobe.ggx.alpha.x == lobe.ggx.alpha.y {
            return loss;
        }
        ANISOTROPIC_SHARE * min(loss, glossy_loss(loss_kind(lobe), lobe.ggx.alpha.y, mu))
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
        let mut mean_loss: f32 = glossy_mean_loss(loss_kind(lobe), alpha.x);
        if alpha.x != alpha.y {
            mean_loss = ANISOTROPIC_SHARE * min(mean_loss, glossy_mean_loss(loss_kind(lobe), alpha.y));
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
