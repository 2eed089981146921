//! Measured isotropic scattering (MDL `df::measured_bsdf`).
//!
//! The table ([`crate::measured`]) has values of f at equal angles: of `wo` and `wi` to the normal, and between
//! their azimuths. Between them f is linear in each angle, beyond the first and last it is constant.
//!
//! Sampling: for each angle of `wo` there is a density over the cells of a grid whose corners are the angles
//! of the table, even in sin²θ and φ. It is an even part, cos θ/π, plus a peaked part that is bilinear within
//! cells; a cell is drawn by the alias method (A. Walker 1974, M. Vose, "A Linear Algorithm for Generating
//! Random Numbers with a Given Distribution", 1991) with the integer parts of the random numbers as row
//! and column. Between the angles of `wo` densities are mixed linearly, as values are. With sin²θ as
//! coordinate the density per solid angle has the factor cos θ that the value has too.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    use crate::frame::code::*;
    use crate::lobes::code::*;
    use crate::math::code::*;
    use crate::nodes::code::*;
    use crate::sampling::code::*;
    use wgsl_rs::std::*;

    /// The side of a table that holds reflection.
    pub const MEASURED_REFLECTION: u32 = 0;
    /// The side of a table that holds transmission.
    pub const MEASURED_TRANSMISSION: u32 = 1;
    /// 2²⁴: what the random numbers are multiples of the inverse of.
    pub const MEASURED_STEPS: f32 = 16777216.0;

    /// One side of a measurement, seen from a direction.
    #[derive(Clone, Copy, Debug)]
    pub struct Measured {
        /// Number of the table.
        pub table: u32,
        /// First record of the side.
        pub first: u32,
        /// Number of angles to the normal; 0 if the side was not measured.
        pub theta: u32,
        /// Number of angles between azimuths.
        pub phi: u32,
        /// The measured angle of `wo` below its own, and the one above.
        pub below: u32,
        /// See `below`.
        pub above: u32,
        /// Where between them, 0 to 1.
        pub between: f32,
        /// Unit vector of `wo` along the surface.
        pub axis: Vec2f,
        /// Albedo.
        pub albedo: Vec3f,
        /// Probability of the even part.
        pub even: f32,
    }

    /// f and the density over cos θ.
    #[derive(Clone, Copy, Debug)]
    pub struct MeasuredValue {
        /// f, sr⁻¹.
        pub f: Vec3f,
        /// Density per solid angle over cos θ, sr⁻¹.
        pub density: f32,
    }

    /// A cell of the grid by its corners: angle i of `wi` from `i0` to `i1`, azimuth from `k0` to `k1`.
    #[derive(Clone, Copy, Debug)]
    pub struct MeasuredCell {
        /// Measured angle of `wi` at the near side.
        pub i0: u32,
        /// At the far side.
        pub i1: u32,
        /// Measured azimuth at the near side.
        pub k0: u32,
        /// At the far side.
        pub k1: u32,
    }

    /// The factor of a measurement: the author's multiplier, as far as no energy is gained.
    pub fn measured_scale(program: ptr!(function, Program), table: u32, mode: u32, multiplier: f32) -> f32 {
        let most = table_record(program, table, 0);
        let bound = select(select(most.z, most.y, mode == MODE_TRANSMIT), most.x, mode == MODE_REFLECT);
        if bound <= 0.0 {
            return 0.0;
        }
        min(nonnegative(multiplier), 1.0 / bound)
    }

    /// The angle of a direction to the normal, or to its back, over what lies between two measured angles.
    pub fn measured_angle(w: Vec3f, theta: u32) -> f32 {
        math_atan2(sqrt(w.x * w.x + w.y * w.y), abs(w.z)) * (2.0 * FRAC_1_PI) * f32(theta)
    }

    /// One side of a table, seen from `wo`.
    pub fn measured_new(program: ptr!(function, Program), table: u32, side: u32, wo: Vec3f) -> Measured {
        let part = table_record(program, table, 1 + side);
        let theta = u32(part.y);
        let axis = normalize_or(vec3f(wo.x, wo.y, 0.0), vec3f(1.0, 0.0, 0.0));
        let mut m: Measured = Measured {
            table,
            first: u32(part.x),
            theta,
            phi: u32(part.z),
            below: 0,
            above: 0,
            between: 0.0,
            axis: axis.xy(),
            albedo: splat3(0.0),
            even: 1.0,
        };
        if theta == 0 {
            return m;
        }
        let x = clamp(measured_angle(wo, theta) - 0.5, 0.0, f32(theta - 1));
        m.below = min(u32(x), theta - 1);
        m.above = min(m.below + 1, theta - 1);
        m.between = x - f32(m.below);
        let a = table_record(program, table, measured_bucket(m, m.below));
        let b = table_record(program, table, measured_bucket(m, m.above));
        let mixed = a * (1.0 - m.between) + b * m.between;
        m.albedo = mixed.xyz();
        m.even = mixed.w;
        m
    }

    /// The record of a measured angle of `wo`: its albedo and the probability of its even part.
    pub fn measured_bucket(m: Measured, o: u32) -> u32 {
        m.first + m.theta + 1 + o
    }

    /// The record of a value: f per channel and the density of the peaked part over cos θ.
    pub fn measured_texel(m: Measured, o: u32, i: u32, k: u32) -> u32 {
        m.first + 2 * m.theta + 1 + (o * m.theta + i) * m.phi + k
    }

    /// The record that holds a cell of the alias map of a measured angle of `wo`; two cells share one.
    pub fn measured_alias(m: Measured, o: u32, cell: u32) -> u32 {
        let cells = (m.theta + 1) * (m.phi + 1);
        m.first + 2 * m.theta + 1 + m.theta * m.theta * m.phi + o * ((cells + 1) / 2) + cell / 2
    }

    /// The cell in a row and column.
    pub fn measured_cell(m: Measured, row: u32, column: u32) -> MeasuredCell {
        MeasuredCell {
            i0: max(row, 1) - 1,
            i1: min(row, m.theta - 1),
            k0: max(column, 1) - 1,
            k1: min(column, m.phi - 1),
        }
    }

    /// f and density for a direction of this side. Asked only of a side that was measured.
    pub fn measured_eval(program: ptr!(function, Program), m: Measured, wi: Vec3f) -> MeasuredValue {
        let x = measured_angle(wi, m.theta) + 0.5;
        let row = min(u32(x), m.theta);
        let bounds = table_record(program, m.table, m.first + row);
        // Where in the cell: by the angle for f, by sin²θ for the density.
        let by_angle = unit(x - f32(row));
        let by_square = unit((wi.x * wi.x + wi.y * wi.y - bounds.x) * bounds.z);
        let along = m.axis.x * wi.x + m.axis.y * wi.y;
        let across = abs(m.axis.x * wi.y - m.axis.y * wi.x);
        let y = math_atan2(across, along) * (FRAC_1_PI * f32(m.phi)) + 0.5;
        let column = min(u32(y), m.phi);
        let by_turn = unit(y - f32(column));
        let cell = measured_cell(m, row, column);
        let a = measured_pair(program, m, cell.i0, cell.k0, cell.k1, by_turn);
        let b = measured_pair(program, m, cell.i1, cell.k0, cell.k1, by_turn);
        let f = a.xyz() * (1.0 - by_angle) + b.xyz() * by_angle;
        let peaked = a.w * (1.0 - by_square) + b.w * by_square;
        MeasuredValue { f, density: m.even * FRAC_1_PI + peaked }
    }

    /// The record between azimuths `k0` and `k1`, and between the two angles of `wo`.
    pub fn measured_pair(
        program: ptr!(function, Program),
        m: Measured,
        i: u32,
        k0: u32,
        k1: u32,
        t: f32,
    ) -> Vec4f {
        let a = table_record(program, m.table, measured_texel(m, m.below, i, k0));
        let b = table_record(program, m.table, measured_texel(m, m.below, i, k1));
        let c = table_record(program, m.table, measured_texel(m, m.above, i, k0));
        let d = table_record(program, m.table, measured_texel(m, m.above, i, k1));
        (a * (1.0 - t) + b * t) * (1.0 - m.between) + (c * (1.0 - t) + d * t) * m.between
    }

    /// floor(x·n/2²⁴) for x below 2²⁴ and n up to 2¹²: a column, without floats.
    pub fn measured_column(x: u32, n: u32) -> u32 {
        ((x >> 12) * n + (((x & 0xfff) * n) >> 12)) >> 12
    }

    /// What x·n/2²⁴ has behind the point, at the centre of what is not known.
    pub fn measured_rest(x: u32, n: u32) -> f32 {
        (f32((x * n) & 0xffffff) + 0.5) * (1.0 / MEASURED_STEPS)
    }

    /// A random number as a multiple of 2⁻²⁴.
    pub fn measured_integer(u: f32) -> u32 {
        min(u32(u * MEASURED_STEPS), 0xffffff)
    }

    /// x in [0, 1] with a density that goes straight from a to b, for uniform u.
    pub fn measured_slope(u: f32, a: f32, b: f32) -> f32 {
        let root = a + sqrt(a * a * (1.0 - u) + b * b * u);
        if root <= 0.0 {
            return u;
        }
        min(u * (a + b) / root, 1.0)
    }

    /// A direction on the upper side; `u.z` chooses the angle, the part and the alias.
    pub fn measured_sample(program: ptr!(function, Program), m: Measured, u: Vec3f) -> Vec3f {
        let mut uz: f32 = u.z;
        let upper = uz < m.between;
        uz = reuse_random(uz, m.between, upper);
        let o = select(m.below, m.above, upper);
        let bucket = table_record(program, m.table, measured_bucket(m, o));
        let even = uz < bucket.w;
        uz = reuse_random(uz, bucket.w, even);
        if even {
            return sample_cosine_hemisphere(u.xy());
        }
        measured_sample_peak(program, m, o, vec3f(u.x, u.y, uz))
    }

    /// A direction of the peaked part of a measured angle of `wo`.
    pub fn measured_sample_peak(program: ptr!(function, Program), m: Measured, o: u32, u: Vec3f) -> Vec3f {
        let columns = m.phi + 1;
        let x = measured_integer(u.x);
        let whole = measured_integer(u.y);
        // The first bit says on which side of the plane of `wo`.
        let y = (whole << 1) & 0xffffff;
        let chosen = measured_column(x, m.theta + 1) * columns + measured_column(y, columns);
        let pair = table_record(program, m.table, measured_alias(m, o, chosen));
        let odd = (chosen & 1) != 0;
        let keep = u.z < select(pair.x, pair.z, odd);
        let other = u32(select(pair.y, pair.w, odd));
        let index = select(other, chosen, keep);
        let row = index / columns;
        let column = index - row * columns;
        let cell = measured_cell(m, row, column);
        let a = table_record(program, m.table, measured_texel(m, o, cell.i0, cell.k0)).w;
        let b = table_record(program, m.table, measured_texel(m, o, cell.i0, cell.k1)).w;
        let c = table_record(program, m.table, measured_texel(m, o, cell.i1, cell.k0)).w;
        let d = table_record(program, m.table, measured_texel(m, o, cell.i1, cell.k1)).w;
        let s = measured_slope(measured_rest(x, m.theta + 1), a + b, c + d);
        let t = measured_slope(measured_rest(y, columns), a * (1.0 - s) + c * s, b * (1.0 - s) + d * s);
        let bounds = table_record(program, m.table, m.first + row);
        let square = bounds.x + bounds.y * s;
        // The cells at the ends are half as wide.
        let low = max(f32(column) - 0.5, 0.0);
        let high = min(f32(column) + 0.5, f32(m.phi));
        let turn = math_sincos((low + (high - low) * t) * (PI / f32(m.phi)));
        let along = turn.y * sqrt(square);
        let across = turn.x * sqrt(square) * select(-1.0, 1.0, whole >= 0x800000);
        vec3f(
            m.axis.x * along - m.axis.y * across,
            m.axis.y * along + m.axis.x * across,
            sqrt(max(1.0 - square, 0.0)),
        )
    }

    /// Probability of reflection, of a lobe with this mode.
    pub fn measured_reflects(reflection: Measured, transmission: Measured, mode: u32) -> f32 {
        let r = select(mean3(reflection.albedo), 0.0, mode == MODE_TRANSMIT);
        let t = select(mean3(transmission.albedo), 0.0, mode == MODE_REFLECT);
        if r + t <= 0.0 {
            return 1.0;
        }
        r / (r + t)
    }

    /// f·|cos θi| and density of the lobe of node `n` in its frame.
    pub fn node_measured_eval(
        program: ptr!(function, Program),
        n: Vec4u,
        p: ptr!(function, Params),
        wo: Vec3f,
        wi: Vec3f,
    ) -> MeasuredValue {
        let nothing = MeasuredValue { f: splat3(0.0), density: 0.0 };
        let table = node_measured_table(n, p);
        let side = select(MEASURED_REFLECTION, MEASURED_TRANSMISSION, wi.z < 0.0);
        let other = MEASURED_TRANSMISSION - side;
        if wo.z <= 0.0 || n.w == select(MODE_REFLECT, MODE_TRANSMIT, wi.z >= 0.0) {
            return nothing;
        }
        let m = measured_new(program, table, side, wo);
        if m.theta == 0 {
            return nothing;
        }
        let mut share: f32 = 1.0;
        if n.w == MODE_REFLECT_TRANSMIT {
            let back = measured_new(program, table, other, wo);
            // Of the side asked for; where nothing scatters, all goes to reflection.
            let own = mean3(m.albedo);
            let sum = own + mean3(back.albedo);
            share = select(select(0.0, 1.0, side == MEASURED_REFLECTION), own / sum, sum > 0.0);
        }
        let v = measured_eval(program, m, wi);
        let scale = measured_scale(program, table, n.w, param(p, n.y + SLOT_TINT));
        let cosine = abs(wi.z);
        MeasuredValue { f: v.f * (scale * cosine), density: share * v.density * cosine }
    }

    /// A direction of the lobe of node `n` in its frame.
    pub fn node_measured_sample(
        program: ptr!(function, Program),
        n: Vec4u,
        p: ptr!(function, Params),
        wo: Vec3f,
        u: Vec3f,
    ) -> LobeSample {
        let table = node_measured_table(n, p);
        let reflection = measured_new(program, table, MEASURED_REFLECTION, wo);
        let transmission = measured_new(program, table, MEASURED_TRANSMISSION, wo);
        let prob = measured_reflects(reflection, transmission, n.w);
        let reflects = u.z < prob;
        let uz = reuse_random(u.z, prob, reflects);
        let mut m: Measured = reflection;
        if !reflects {
            m = transmission;
        }
        if m.theta == 0 || reflects && n.w == MODE_TRANSMIT {
            return lobe_absorb();
        }
        let w = measured_sample(program, m, vec3f(u.x, u.y, uz));
        if w.z <= 0.0 {
            return lobe_absorb();
        }
        let side = select(EVENT_TRANSMISSION, EVENT_REFLECTION, reflects);
        LobeSample { wi: vec3f(w.x, w.y, select(-w.z, w.z, reflects)), event: EVENT_GLOSSY | side }
    }

    /// Albedo of the lobe of node `n` in its frame.
    pub fn node_measured_albedo(
        program: ptr!(function, Program),
        n: Vec4u,
        p: ptr!(function, Params),
        wo: Vec3f,
    ) -> Vec3f {
        let table = node_measured_table(n, p);
        let mut sum: Vec3f = splat3(0.0);
        if n.w != MODE_TRANSMIT {
            sum += measured_new(program, table, MEASURED_REFLECTION, wo).albedo;
        }
        if n.w != MODE_REFLECT {
            sum += measured_new(program, table, MEASURED_TRANSMISSION, wo).albedo;
        }
        unit3(sum * measured_scale(program, table, n.w, param(p, n.y + SLOT_TINT)))
    }

    /// The table that the lobe of node `n` refers to.
    pub fn node_measured_table(n: Vec4u, p: ptr!(function, Params)) -> u32 {
        table_number(param(p, n.y + SLOT_MEASURED_TABLE))
    }

    /// A number in a slot; of none where it is negative or no number.
    pub fn table_number(x: f32) -> u32 {
        if x >= 0.0 && x < MEASURED_STEPS {
            return u32(x);
        }
        0xffffffff
    }
}
pub use code::*;
