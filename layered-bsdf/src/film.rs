//! Reflectance of absorbing media and of thin films, in RGB (MDL `df::fresnel_factor`, `df::thin_film`).
//!
//! One film between two media reflects, per polarisation and wavenumber σ,
//! |r₁₂ + r₂₃ z|²/|1 + r₁₂ r₂₃ z|² with z = e^(2πiσL) and the path L = 2 n₂ d cos θ₂ (M. Born, E. Wolf, "Principles
//! of Optics", §7.6, eq. 11, all orders). Where r₁₂ is real, and with q = r₁₂ r₂₃, this is
//!
//! mean + swing · Re(2qz/(1 + qz)), mean = (|r₁₂|² t₂₃ + |r₂₃|² t₁₂)/m, swing = t₁₂ t₂₃/m, m = 1 − |q|², t = 1 − |r|²
//!
//! and analytic in z. So its average over a sensitivity that is a rational function of σ with poles ζ in the
//! upper half plane is a sum of its values at the poles (the residue theorem), exactly, for every thickness:
//! Σ w_k f(e^(2πiζ_k L)). Thick films lose their fringes as |z| falls, a film of no thickness has z = 1 and is
//! none. The sensitivities are those of the sRGB primaries (CIE 1931, 2°) under light of equal energy, each with
//! the integral 1, by ten poles in a row; `examples/fit_film_colors.rs` finds the weights. Their Fourier
//! transforms, and so every order of fringes, are met within 2.5e-3.
//!
//! A colour as index means: this channel's light sees that index. Indices do not vary within a channel.
//! Colours outside of sRGB come out below 0 or above 1; whoever uses them as weights limits them.
//! Where the film is passed by evanescent waves alone, the average over σ is smooth, and three wavenumbers are
//! enough (6e-6).

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
    use crate::math::code::*;
    use wgsl_rs::std::*;

    /// The first pole: its real part, µm⁻¹.
    pub const FILM_FIRST: f32 = 1.53215;
    /// Distance of poles, µm⁻¹.
    pub const FILM_STEP: f32 = 0.10255;
    /// Imaginary part of all poles, µm⁻¹.
    pub const FILM_WIDTH: f32 = 0.10137;
    /// Longest path that is told from an infinite one, µm: there, fringes are weaker than 1e-250.
    pub const FILM_LONGEST: f32 = 1e3;
    /// Films thinner than this are none, nm.
    pub const FILM_THINNEST: f32 = 1e-6;

    /// A film on an interface.
    #[derive(Clone, Copy, Debug)]
    pub struct Film {
        /// Thickness, nm; no film below `FILM_THINNEST`.
        pub thickness: f32,
        /// Index of refraction per channel.
        pub ior: Vec3f,
    }

    /// An interface of a film for one polarisation.
    #[derive(Clone, Copy, Debug)]
    pub struct FilmSide {
        /// Amplitude of the reflected wave, complex.
        pub r: Vec2f,
        /// 1 − |r|², without cancellation.
        pub t: f32,
    }

    /// a·b
    pub fn complex_mul(a: Vec2f, b: Vec2f) -> Vec2f {
        vec2f(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x)
    }

    /// a/b
    pub fn complex_div(a: Vec2f, b: Vec2f) -> Vec2f {
        let inverse = 1.0 / max(dot(b, b), 1e-30);
        vec2f((a.x * b.x + a.y * b.y) * inverse, (a.y * b.x - a.x * b.y) * inverse)
    }

    /// An index of refraction limited to what the formulas are made for; one that is no number, or not
    /// positive, is `fallback`.
    pub fn sane_ior(ior: f32, fallback: f32) -> f32 {
        select(fallback, limit(ior, 1e-3, 1e3), ior > 0.0)
    }

    /// √(N² − n₁² sin²θ) of a medium N = n + ik, for light at cosine `c` in a medium of index `n1`; both parts
    /// are not negative.
    pub fn film_wave(n: f32, k: f32, n1: f32, c: f32) -> Vec2f {
        let w1 = n1 * c;
        let re = (n - n1) * (n + n1) + w1 * w1 - k * k;
        let im = n * k;
        let root = sqrt(0.5 * (sqrt(re * re + 4.0 * im * im) + abs(re)));
        let other = select(0.0, im / root, root > 0.0);
        vec2f(select(other, root, re >= 0.0), select(root, other, re >= 0.0))
    }

    /// Unpolarised reflectance of a medium of index n + ik, relative to the near side, at cosine `c` (Born and
    /// Wolf, §14.2; r_p/r_s = (c w − s²)/(c w + s²) with w = √(N² − s²): R. Azzam, JOSA 69, 1979).
    pub fn fresnel_complex(c: f32, n: f32, k: f32) -> f32 {
        if k <= 0.0 {
            return fresnel_dielectric(c, n);
        }
        let w = film_wave(n, k, 1.0, c);
        let s2 = (1.0 - c) * (1.0 + c);
        let near = c - w.x;
        let far = c + w.x;
        let rs = (near * near + w.y * w.y) / (far * far + w.y * w.y);
        let cv = c * w.y;
        let less = c * w.x - s2;
        let more = c * w.x + s2;
        let ratio = (less * less + cv * cv) / max(more * more + cv * cv, 1e-30);
        unit(0.5 * rs * (1.0 + ratio))
    }

    /// A pole's part of the fringes: the real part of weight · 2qz/(1 + qz).
    pub fn film_fringe(q: Vec2f, z: Vec2f, re: Vec3f, im: Vec3f) -> Vec3f {
        let x = complex_mul(q, z);
        let g = complex_div(x * 2.0, vec2f(1.0 + x.x, x.y));
        re * g.x - im * g.y
    }

    /// The fringes seen by the three channels: `z` at the first pole, `step` from one to the next.
    pub fn film_fringes(q: Vec2f, z: Vec2f, step: Vec2f) -> Vec3f {
        let z1 = complex_mul(z, step);
        let z2 = complex_mul(z1, step);
        let z3 = complex_mul(z2, step);
        let z4 = complex_mul(z3, step);
        let z5 = complex_mul(z4, step);
        let z6 = complex_mul(z5, step);
        let z7 = complex_mul(z6, step);
        let z8 = complex_mul(z7, step);
        let z9 = complex_mul(z8, step);
        film_fringe(q, z, vec3f(-0.368173, 0.059456, -0.006477), vec3f(0.491939, -0.083598, 0.004682))
            + film_fringe(q, z1, vec3f(1.808573, -0.361625, -0.014957), vec3f(0.276871, 0.163977, -0.047033))
            + film_fringe(q, z2, vec3f(0.135000, 0.515271, -0.052282), vec3f(-0.781187, 0.454635, -0.062597))
            + film_fringe(q, z3, vec3f(-0.220073, 0.469988, -0.027583), vec3f(-0.219700, 0.001364, 0.022400))
            + film_fringe(q, z4, vec3f(-0.419125, 0.374233, -0.048044), vec3f(0.234705, -0.528901, 0.149401))
            + film_fringe(q, z5, vec3f(-0.067614, 0.103057, -0.035667), vec3f(-0.053512, -0.003730, 0.061418))
            + film_fringe(q, z6, vec3f(0.037568, -0.068846, 0.747110), vec3f(0.072834, -0.056635, 0.336914))
            + film_fringe(q, z7, vec3f(0.055015, -0.047835, 0.257886), vec3f(0.030116, -0.019390, 0.151089))
            + film_fringe(q, z8, vec3f(0.041462, -0.040667, 0.153883), vec3f(-0.065011, 0.085519, -0.662458))
            + film_fringe(q, z9, vec3f(-0.002633, -0.003032, 0.026131), vec3f(0.012945, -0.013241, 0.046184))
    }

    /// The interface between waves `wa` and `wb` whose media weigh them with `fa` and `fb`: 1 for light polarised
    /// across the plane of incidence, the squared index of the other medium within it. `flow` is Re(fb wa · (fa wb)*).
    pub fn film_side(a: Vec2f, b: Vec2f, flow: f32) -> FilmSide {
        let sum = a + b;
        FilmSide { r: complex_div(a - b, sum), t: unit(4.0 * flow / max(dot(sum, sum), 1e-30)) }
    }

    /// Reflectance of a film for one polarisation, where waves travel in it: `r12` is real.
    pub fn film_polarised(first: FilmSide, second: FilmSide, z: Vec2f, step: Vec2f) -> Vec3f {
        let rest = first.t + second.t - first.t * second.t;
        if !(rest > 1e-12) {
            return splat3(1.0);
        }
        let a = first.r.x * first.r.x;
        let b = dot(second.r, second.r);
        let mean = (a * second.t + b * first.t) / rest;
        let swing = first.t * second.t / rest;
        splat3(mean) + film_fringes(second.r * first.r.x, z, step) * swing
    }

    /// Reflectance of a film for one polarisation at one attenuation `z` of its evanescent wave.
    pub fn film_tunnel(r12: Vec2f, r23: Vec2f, z: f32) -> f32 {
        let q = complex_mul(r12, r23) * z;
        let above = r12 + r23 * z;
        let below = vec2f(1.0 + q.x, q.y);
        min(dot(above, above) / max(dot(below, below), 1e-30), 1.0)
    }

    /// Unpolarised reflectance of a film of thickness `d` nm and index `n2` between the index `n1` and n + ik,
    /// at cosine `c` in the near medium, as the three channels see it.
    pub fn film_channels(d: f32, n1: f32, n2: f32, n: f32, k: f32, c: f32) -> Vec3f {
        let w1 = vec2f(n1 * c, 0.0);
        let w3 = film_wave(n, k, n1, c);
        let w2 = film_wave(n2, 0.0, n1, c);
        let e1 = n1 * n1;
        let e2 = n2 * n2;
        let e3 = vec2f((n - k) * (n + k), 2.0 * n * k);
        // N² w* has the real part u(|w|² + n₁² sin²θ).
        let s2 = e1 * (1.0 - c) * (1.0 + c);
        let flow3 = w3.x * (dot(w3, w3) + s2);
        let s12 = film_side(w1, w2, w1.x * w2.x);
        let s23 = film_side(w2, w3, w2.x * w3.x);
        let p12 = film_side(w1 * e2, w2 * e1, w1.x * w2.x * e1 * e2);
        let p23 = film_side(complex_mul(e3, w2), w3 * e2, w2.x * e2 * flow3);
        if w2.x > 0.0 {
            let path = min(2e-3 * d * w2.x, FILM_LONGEST);
            let turn = math_sincos(2.0 * PI * FILM_FIRST * path);
            let next = math_sincos(2.0 * PI * FILM_STEP * path);
            let fade = math_exp(-2.0 * PI * FILM_WIDTH * path);
            let z = vec2f(fade * turn.y, fade * turn.x);
            let step = vec2f(next.y, next.x);
            return (film_polarised(s12, s23, z, step) + film_polarised(p12, p23, z, step)) * 0.5;
        }
        let path = min(2e-3 * d * w2.y, FILM_LONGEST);
        let red = math_exp(-2.0 * PI * 1.6217 * path);
        let green = math_exp(-2.0 * PI * 1.8649 * path);
        let blue = math_exp(-2.0 * PI * 2.2565 * path);
        let at_red = film_tunnel(s12.r, s23.r, red) + film_tunnel(p12.r, p23.r, red);
        let at_green = film_tunnel(s12.r, s23.r, green) + film_tunnel(p12.r, p23.r, green);
        let at_blue = film_tunnel(s12.r, s23.r, blue) + film_tunnel(p12.r, p23.r, blue);
        vec3f(0.627607, 0.007800, -0.031718) * at_red
            + vec3f(-0.138104, 0.525818, 0.028389) * at_green
            + vec3f(0.010497, -0.033618, 0.503329) * at_blue
    }

    /// Reflectance per channel of an interface with the index `near` on this side and n + ik on the other, under
    /// a film, at cosine `c`. Not limited to [0, 1]: the film's colours may lie outside of sRGB.
    pub fn film_reflectance(film: Film, near: Vec3f, n: Vec3f, k: Vec3f, c: f32) -> Vec3f {
        if !(film.thickness > FILM_THINNEST) {
            return vec3f(
                fresnel_complex(c, n.x / near.x, k.x / near.x),
                fresnel_complex(c, n.y / near.y, k.y / near.y),
                fresnel_complex(c, n.z / near.z, k.z / near.z),
            );
        }
        let d = min(film.thickness, 1e9);
        let n2 =
            vec3f(sane_ior(film.ior.x, near.x), sane_ior(film.ior.y, near.y), sane_ior(film.ior.z, near.z));
        let red = film_channels(d, near.x, n2.x, n.x, k.x, c);
        let flat = near.x == near.y && near.y == near.z && n2.x == n2.y && n2.y == n2.z;
        if flat && n.x == n.y && n.y == n.z && k.x == k.y && k.y == k.z {
            return red;
        }
        let green = film_channels(d, near.y, n2.y, n.y, k.y, c);
        let blue = film_channels(d, near.z, n2.z, n.z, k.z, c);
        vec3f(red.x, green.y, blue.z)
    }
}
pub use code::*;
