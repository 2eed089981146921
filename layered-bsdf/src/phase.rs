//! Phase functions: how a particle of a volume scatters.
//!
//! `wo` points back to where light's path came from, `wi` to where it goes on, so light that is not deflected
//! has `wi = −wo`. A phase function depends on the angle between them alone; it is its own density.
//!
//! Peaks are found by their chord: with a = |g| and Δ the difference of `wi` and the direction of the peak,
//! 1 + g² − 2g cos θ = (1 − a)² + a Δ·Δ, in which nothing cancels.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::frame::code::*;
    use crate::math::code::*;
    use wgsl_rs::std::*;

    /// 1/(4π)
    pub const FRAC_1_4PI: f32 = 0.07957747;
    /// Largest |g|: the peak is 1e-6 wide.
    pub const BIAS_MOST: f32 = 0.999999;
    /// Largest diameter of droplets that the fit knows, µm.
    pub const DROPLET_MOST: f32 = 50.0;

    /// The mean cosine of a lobe, limited; what is no number is 0.
    pub fn sane_bias(g: f32) -> f32 {
        select(0.0, clamp(g, -BIAS_MOST, BIAS_MOST), abs(g) >= 0.0)
    }

    /// The phase function of Henyey and Greenstein, sr⁻¹ ("Diffuse radiation in the galaxy", 1941), with mean
    /// cosine `g`; `rest` is 1 − |g|.
    pub fn hg_eval(g: f32, rest: f32, wo: Vec3f, wi: Vec3f) -> f32 {
        let a = abs(g);
        let apart = wi + wo * select(-1.0, 1.0, g >= 0.0);
        let d = rest * rest + a * dot(apart, apart);
        FRAC_1_4PI * rest * (1.0 + a) / (d * sqrt(d))
    }

    /// 1 less the cosine to the peak, for a lobe with mean cosine `a` = 1 − `rest` in [0, 1): the inverse of the
    /// share of energy within, rearranged so that nothing is divided by `a` and no difference loses digits.
    pub fn hg_below(a: f32, rest: f32, u: f32) -> f32 {
        let q = rest / (rest + 2.0 * a * (1.0 - u));
        q * u * ((1.0 + a) * q + rest)
    }

    /// The direction that lies `below` (1 less the cosine) beside `peak`, at the azimuth 2π `turn`.
    pub fn phase_direction(peak: Vec3f, below: f32, turn: f32) -> Vec3f {
        let r = sqrt(max(below * (2.0 - below), 0.0));
        let sc = math_sincos(2.0 * PI * turn);
        let frame = frame_from_normal(peak);
        normalize_or(frame_from_local(frame, vec3f(r * sc.y, r * sc.x, 1.0 - below)), peak)
    }

    /// A direction with the density of `hg_eval`.
    pub fn hg_sample(g: f32, rest: f32, wo: Vec3f, u: Vec2f) -> Vec3f {
        phase_direction(wo * select(1.0, -1.0, g >= 0.0), hg_below(abs(g), rest, u.y), u.x)
    }

    /// Draine's phase function, sr⁻¹ ("Scattering by Interstellar Dust Grains", 2003): that of Henyey and
    /// Greenstein times 1 + α cos² θ, normalised.
    pub fn draine_eval(g: f32, alpha: f32, wo: Vec3f, wi: Vec3f) -> f32 {
        let c = dot(wo, wi);
        hg_eval(g, 1.0 - abs(g), wo, wi) * (1.0 + alpha * c * c)
            / (1.0 + alpha * (1.0 + 2.0 * g * g) * (1.0 / 3.0))
    }

    /// A direction with the density of `draine_eval`.
    ///
    /// Let x be the number that a lobe of Henyey and Greenstein would turn into a direction, x = 0 away from the
    /// peak. Then cos θ = E (2 − e) − 1, and the integral of 1 + α cos² θ from 0 to x is
    /// x (1 + α (1 − 2E + E² (4 − e)/3)), with e = 2ax/((1 − a) + 2ax) and E = (1 + a)² x/((1 − a) + 2ax). It
    /// rises with a slope between 1 and 1 + α, so Newton's steps, kept between bounds, find its inverse.
    pub fn draine_sample(g: f32, alpha: f32, wo: Vec3f, u: Vec2f) -> Vec3f {
        let a = abs(g);
        let goal = u.y * (1.0 + alpha * (1.0 + 2.0 * a * a) * (1.0 / 3.0));
        let mut low: f32 = 0.0;
        let mut high: f32 = 1.0;
        let mut x: f32 = u.y;
        let mut step: u32 = 0;
        while step < 24 {
            let y = (1.0 - a) + 2.0 * a * x;
            let part = 2.0 * a * x / y;
            let whole = (1.0 + a) * (1.0 + a) * x / y;
            let square = 1.0 - 2.0 * whole + whole * whole * (4.0 - part) * (1.0 / 3.0);
            let miss = x * (1.0 + alpha * square) - goal;
            let c = whole * (2.0 - part) - 1.0;
            low = select(low, x, miss <= 0.0);
            high = select(x, high, miss <= 0.0);
            let newton = x - miss / (1.0 + alpha * c * c);
            let next = select(0.5 * (low + high), newton, newton > low && newton < high);
            step = select(step + 1, 24, abs(next - x) < 5e-8);
            x = next;
        }
        phase_direction(wo * select(1.0, -1.0, g >= 0.0), hg_below(a, 1.0 - a, 1.0 - x), u.x)
    }

    /// Droplets of water: a mix of both phase functions.
    #[derive(Clone, Copy, Debug)]
    pub struct Fog {
        /// Mean cosine of the lobe of Henyey and Greenstein.
        pub g_hg: f32,
        /// 1 less that.
        pub rest: f32,
        /// Mean cosine within the lobe of Draine.
        pub g_draine: f32,
        /// Draine's α.
        pub alpha: f32,
        /// Share of Draine's lobe.
        pub share: f32,
    }

    /// The fit to Mie's theory for droplets of a diameter in µm (J. Jendersie, E. d'Eon, "An Approximate Mie
    /// Scattering Function for Fog and Cloud Rendering", SIGGRAPH 2023 Talks, equations 4 to 7, and 11 to 22 of
    /// its supplement for droplets below 5 µm). Towards 0 it becomes the phase function of Rayleigh.
    pub fn fog_new(diameter: f32) -> Fog {
        let d = min(nonnegative(diameter), DROPLET_MOST);
        if d <= 0.1 {
            let g_hg = 13.8 * d * d;
            return Fog {
                g_hg,
                rest: 1.0 - g_hg,
                g_draine: 1.1456 * d * math_sin(9.29044 * d),
                alpha: 250.0,
                share: 0.252977 - 312.983 * math_pow(d, 4.3),
            };
        }
        let l = math_log(d);
        if d < 1.5 {
            let inner = math_cos((l - 0.238604) * (l + 1.00667) / (0.507522 - 0.15677 * l));
            let outer = math_cos(1.19692 * inner + 1.37932 * l + 0.0625835);
            let g_hg = 0.862 - 0.143 * l * l;
            return Fog {
                g_hg,
                rest: 1.0 - g_hg,
                g_draine: 0.379685 * outer + 0.344213,
                alpha: 250.0,
                share: 0.146209 * math_cos(3.38707 * l + 2.11193) + 0.316072 + 0.0778917 * l,
            };
        }
        if d < 5.0 {
            let ll = math_log(l);
            let g_hg = 0.0604931 * ll + 0.940256;
            return Fog {
                g_hg,
                rest: 1.0 - g_hg,
                g_draine: 0.500411 - 0.081287 / (-2.0 * l + math_tan(l) + 1.27551),
                alpha: 7.30354 * l + 6.31675,
                share: 0.026914 * (l - math_cos(5.68947 * (ll - 0.0292149))) + 0.376475,
            };
        }
        let narrow = 0.0990567 / (d - 1.67154);
        Fog {
            g_hg: math_exp(-narrow),
            // 1 − e^(−x) = 2 e^(−x/2) sinh(x/2)
            rest: 2.0 * math_exp(-0.5 * narrow) * math_sinh(0.5 * narrow),
            g_draine: math_exp(-2.20679 / (d + 3.91029) - 0.428934),
            alpha: math_exp(3.62489 - 8.29288 / (d + 5.52825)),
            share: math_exp(-0.599085 / (d - 0.641583) - 0.665888),
        }
    }

    /// The phase function of droplets, sr⁻¹.
    pub fn fog_eval(fog: Fog, wo: Vec3f, wi: Vec3f) -> f32 {
        let draine = draine_eval(fog.g_draine, fog.alpha, wo, wi);
        (1.0 - fog.share) * hg_eval(fog.g_hg, fog.rest, wo, wi) + fog.share * draine
    }

    /// A direction with the density of `fog_eval`; `u.z` chooses the lobe.
    pub fn fog_sample(fog: Fog, wo: Vec3f, u: Vec3f) -> Vec3f {
        if u.z < fog.share {
            return draine_sample(fog.g_draine, fog.alpha, wo, u.xy());
        }
        hg_sample(fog.g_hg, fog.rest, wo, u.xy())
    }
}
pub use code::*;
