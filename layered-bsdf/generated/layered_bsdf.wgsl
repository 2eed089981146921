// Generated from the Rust of this crate, as one file because WGSL has no modules.

const PI: f32 = 3.1415927;
const FRAC_1_PI: f32 = 0.31830987;

struct Frame {
    x: vec3f,
    y: vec3f,
    z: vec3f
}

fn normalize_or(v: vec3f, fallback: vec3f) -> vec3f {
    let d = dot(v, v);
    if ((d > 1e-37) && (d < 1e37)) {
        return (v * (1.0 / sqrt(d)));
    }
    return fallback;
}

fn frame_from_normal(n: vec3f) -> Frame {
    let s = select(-1.0, 1.0, (n.z >= 0.0));
    let a = (-1.0 / (s + n.z));
    let b = ((n.x * n.y) * a);
    return Frame(vec3f((1.0 + (((s * n.x) * n.x) * a)), (s * b), (-s * n.x)), vec3f(b, (s + ((n.y * n.y) * a)), -n.y), n);
}

fn frame_from_normal_tangent(n: vec3f, tangent: vec3f) -> Frame {
    let other = frame_from_normal(n);
    let x = normalize_or((tangent - (n * dot(n, tangent))), other.x);
    return Frame(x, cross(n, x), n);
}

fn frame_to_local(f: Frame, v: vec3f) -> vec3f {
    return vec3f(dot(f.x, v), dot(f.y, v), dot(f.z, v));
}

fn frame_from_local(f: Frame, v: vec3f) -> vec3f {
    return (((f.x * v.x) + (f.y * v.y)) + (f.z * v.z));
}

fn limit(x: f32, low: f32, high: f32) -> f32 {
    return min(max(x, low), high);
}

fn unit(x: f32) -> f32 {
    return limit(x, 0.0, 1.0);
}

fn unit3(v: vec3f) -> vec3f {
    return vec3f(unit(v.x), unit(v.y), unit(v.z));
}

fn nonnegative(x: f32) -> f32 {
    return limit(x, 0.0, 3.4028234e38);
}

fn max3(v: vec3f) -> f32 {
    return max(v.x, max(v.y, v.z));
}

fn mean3(v: vec3f) -> f32 {
    return (((v.x + v.y) + v.z) * (1.0 / 3.0));
}

fn splat3(x: f32) -> vec3f {
    return vec3f(x, x, x);
}
const MATH_ROUND: f32 = 12582912.0;
const MATH_ROUND_BITS: u32 = 1262485504u;
const MATH_TWO_OVER_PI: f32 = 0.63661975;
const MATH_HALF_PI: f32 = 1.5707964;
const MATH_HALF_PI_REST: f32 = -4.371139e-8;

struct MathTurn {
    rest: f32,
    quarter: u32
}

fn math_from_bits(u: u32) -> f32 {
    return bitcast<f32>(u);
}

fn math_reduce_large(a: f32) -> MathTurn {
    let bits = bitcast<u32>(a);
    let mantissa = ((bits & 8388607u) | 8388608u);
    let first = ((bits >> 23u) - 120u);
    let word = (first >> 5u);
    let shift = (first & 31u);
    let w0 = math_two_over_pi_word(word);
    let w1 = math_two_over_pi_word((word + 1u));
    let w2 = math_two_over_pi_word((word + 2u));
    let high = ((w0 << shift) | ((w1 >> 1u) >> (31u - shift)));
    let low = ((w1 << shift) | ((w2 >> 1u) >> (31u - shift)));
    let turns = ((((mantissa * high) + ((mantissa * (low >> 24u)) >> 8u)) + ((mantissa * ((low >> 16u) & 255u)) >> 16u)) + ((mantissa * ((low >> 8u) & 255u)) >> 24u));
    let fraction = bitcast<i32>((turns << 2u));
    return MathTurn(((f32(fraction) * 3.6572953e-10) + (a - a)), ((turns + 536870912u) >> 30u));
}

fn math_two_over_pi_word(i: u32) -> u32 {
    let w01 = select(0u, 2734261102u, (i == 1u));
    let w23 = select(1313084713u, 4230436817u, (i == 3u));
    let w45 = select(4113882560u, 3680671129u, (i == 5u));
    let w03 = select(w01, w23, (i > 1u));
    let w05 = select(w03, w45, (i > 3u));
    return select(w05, 1011060801u, (i > 5u));
}

fn math_reduce(a: f32) -> MathTurn {
    let quarter = (bitcast<u32>(((a * MATH_TWO_OVER_PI) + MATH_ROUND)) - MATH_ROUND_BITS);
    let n = f32(bitcast<i32>(quarter));
    let rest = ((((a - (n * 1.5703125)) - (n * 0.00045776367)) - (n * 2.5987625e-5)) - (n * 7.54979e-8));
    var turn: MathTurn = MathTurn(rest, quarter);
    if (a > 100000.0) {
        turn = math_reduce_large(a);
    }
    return turn;
}

fn math_sincos(x: f32) -> vec2f {
    let turn = math_reduce(abs(x));
    let r = turn.rest;
    let z = (r * r);
    let s = (r + (r * (z * (-0.16666655 + (z * (0.008332189 - (z * 0.00019518286)))))));
    let c = ((1.0 - (0.5 * z)) + (z * (z * (0.041666646 + (z * (-0.0013887314 + (z * 2.4433171e-5)))))));
    let swap = ((turn.quarter & 1u) != 0u);
    let sin_sign = ((bitcast<u32>(x) & 2147483648u) ^ ((turn.quarter & 2u) << 30u));
    let cos_sign = (((turn.quarter + 1u) & 2u) << 30u);
    return vec2f(bitcast<f32>((bitcast<u32>(select(s, c, swap)) ^ sin_sign)), bitcast<f32>((bitcast<u32>(select(c, s, swap)) ^ cos_sign)));
}

fn math_sin(x: f32) -> f32 {
    return math_sincos(x).x;
}

fn math_cos(x: f32) -> f32 {
    return math_sincos(x).y;
}

fn math_tan(x: f32) -> f32 {
    let t = math_sincos(x);
    return (t.x / t.y);
}

fn math_copysign(x: f32, s: f32) -> f32 {
    return bitcast<f32>(((bitcast<u32>(x) & 2147483647u) | (bitcast<u32>(s) & 2147483648u)));
}

fn math_asin_core(s: f32, z: f32) -> f32 {
    let p = (0.16666752 + (z * (0.0749531 + (z * (0.04546902 + (z * (0.024185503 + (z * 0.042157013))))))));
    return (s + (s * (z * p)));
}

fn math_asin(x: f32) -> f32 {
    let a = abs(x);
    let outer = (a > 0.5);
    let z = select((a * a), ((1.0 - a) * 0.5), outer);
    let p = math_asin_core(select(a, sqrt(z), outer), z);
    return math_copysign(select(p, (MATH_HALF_PI - ((2.0 * p) - MATH_HALF_PI_REST)), outer), x);
}

fn math_acos(x: f32) -> f32 {
    let a = abs(x);
    let outer = (a > 0.5);
    let z = select((a * a), ((1.0 - a) * 0.5), outer);
    let p = math_asin_core(select(a, sqrt(z), outer), z);
    let signed = math_copysign(p, x);
    let inner = (MATH_HALF_PI - (signed - MATH_HALF_PI_REST));
    let left = ((2.0 * MATH_HALF_PI) - ((2.0 * p) - (2.0 * MATH_HALF_PI_REST)));
    let tail = select((2.0 * p), left, (x < 0.0));
    return select(inner, tail, outer);
}

fn math_atan_core(t: f32) -> f32 {
    let z = (t * t);
    let p = (0.04320876 + (z * (-0.016366003 + (z * 0.0029202034))));
    let q = (0.19993769 + (z * (-0.14211023 + (z * (0.1066588 + (z * (-0.07551952 + (z * p))))))));
    return (t + (t * (z * (-0.33333153 + (z * q)))));
}

fn math_atan(x: f32) -> f32 {
    let a = abs(x);
    let outer = (a > 1.0);
    let r = math_atan_core(select(a, (1.0 / a), outer));
    return math_copysign(select(r, (MATH_HALF_PI - (r - MATH_HALF_PI_REST)), outer), x);
}

fn math_atan2(y: f32, x: f32) -> f32 {
    let a = abs(x);
    let b = abs(y);
    let steep = (b > a);
    let wide = select(a, b, steep);
    let narrow = select(b, a, steep);
    let ratio = select((narrow / wide), narrow, (wide == 0.0));
    let r = math_atan_core(select(ratio, 1.0, ((narrow == wide) && (wide > 0.0))));
    let octant = select(r, (MATH_HALF_PI - (r - MATH_HALF_PI_REST)), steep);
    let left = ((2.0 * MATH_HALF_PI) - (octant - (2.0 * MATH_HALF_PI_REST)));
    let behind = ((bitcast<u32>(x) & 2147483648u) != 0u);
    return math_copysign(select(octant, left, behind), y);
}
const MATH_LOG2_E: f32 = 1.442695;
const MATH_LN_2: f32 = 0.69314575;
const MATH_LN_2_REST: f32 = 1.4286068e-6;
const MATH_SQRT_HALF_BITS: u32 = 1060439283u;
const MATH_MIN_NORMAL: f32 = 1.1754944e-38;

fn math_power_of_two(n: i32) -> f32 {
    return bitcast<f32>(((n + 127i) << 23u));
}

fn math_scale(p: f32, n: i32) -> f32 {
    let half = (n >> 1u);
    return ((p * math_power_of_two(half)) * math_power_of_two((n - half)));
}

fn math_exp_scaled(x: f32, k: i32) -> f32 {
    let above = select(x, 90.0, (x > 90.0));
    let c = select(above, -105.0, (above < -105.0));
    let n = (bitcast<i32>(((c * MATH_LOG2_E) + MATH_ROUND)) - bitcast<i32>(MATH_ROUND_BITS));
    let m = f32(n);
    let r = ((c - (m * MATH_LN_2)) - (m * MATH_LN_2_REST));
    let q = (0.4999999 + (r * (0.16666521 + (r * (0.041668963 + (r * (0.008368671 + (r * 0.0013782479))))))));
    return math_scale((1.0 + (r + ((r * r) * q))), (n + k));
}

fn math_exp(x: f32) -> f32 {
    return math_exp_scaled(x, 0i);
}

fn math_exp2_core(r: f32) -> f32 {
    let q = (0.055503584 + (r * (0.009618829 + (r * (0.0013391473 + (r * 0.00015243396))))));
    return (1.0 + (r * (0.6931472 + (r * (0.24022645 + (r * q))))));
}

fn math_exp2(x: f32) -> f32 {
    let above = select(x, 129.0, (x > 129.0));
    let c = select(above, -151.0, (above < -151.0));
    let n = (bitcast<i32>((c + MATH_ROUND)) - bitcast<i32>(MATH_ROUND_BITS));
    return math_scale(math_exp2_core((c - f32(n))), n);
}

struct MathSplit {
    exponent: f32,
    f: f32
}

fn math_split(bits: u32) -> MathSplit {
    let shifted = (bits - MATH_SQRT_HALF_BITS);
    let m = bitcast<f32>(((shifted & 8388607u) + MATH_SQRT_HALF_BITS));
    return MathSplit(f32((bitcast<i32>(shifted) >> 23u)), (m - 1.0));
}

fn math_log1p_core(f: f32) -> f32 {
    let p = (0.14238907 + (f * (-0.13212356 + (f * (0.1256589 - (f * 0.07286021))))));
    let q = (0.33333373 + (f * (-0.2500084 + (f * (0.1999899 + (f * (-0.16621207 + (f * p))))))));
    return ((f * f) * ((f * q) - 0.5));
}

fn math_log_edges(x: f32, r: f32) -> f32 {
    let zero = select(r, math_from_bits(4286578688u), (x < MATH_MIN_NORMAL));
    let negative = select(zero, math_from_bits(2143289344u), (x <= -MATH_MIN_NORMAL));
    let bits = bitcast<u32>(x);
    return select(negative, x, (((bits & 2147483647u) >= 2139095040u) && (bits != 4286578688u)));
}

fn math_log(x: f32) -> f32 {
    let s = math_split(bitcast<u32>(x));
    let low = (math_log1p_core(s.f) + (s.exponent * MATH_LN_2_REST));
    return math_log_edges(x, ((s.exponent * MATH_LN_2) + (s.f + low)));
}

fn math_log2(x: f32) -> f32 {
    let s = math_split(bitcast<u32>(x));
    let low = math_log1p_core(s.f);
    let rest = ((low + ((low + s.f) * 0.44269505)) + s.f);
    return math_log_edges(x, (s.exponent + rest));
}

fn math_log10(x: f32) -> f32 {
    let s = math_split(bitcast<u32>(x));
    let ln = (s.f + math_log1p_core(s.f));
    let low = ((s.exponent * 4.605039e-6) + (ln * 0.4342945));
    return math_log_edges(x, ((s.exponent * 0.3010254) + low));
}

fn math_log1p(u: f32) -> f32 {
    return select(math_log((1.0 + u)), (u + math_log1p_core(u)), ((u > -0.29) && (u < 0.41)));
}

fn math_head(x: f32) -> f32 {
    return bitcast<f32>((bitcast<u32>(x) & 4294963200u));
}

fn math_log2_pair(bits: u32) -> vec2f {
    let s = math_split(bits);
    let m = (1.0 + s.f);
    let mh = math_head(m);
    let inverse = (1.0 / (m + 1.0));
    let zh = bitcast<f32>((bitcast<u32>((s.f * inverse)) & 4294959104u));
    let zl = (((s.f - (zh * (mh + 1.0))) - (zh * (m - mh))) * inverse);
    let z = (zh + zl);
    let w = (z * z);
    let p = (0.3333333 + (w * (0.20000423 + (w * (0.14255202 + (w * 0.12011814))))));
    let high = (zh * 2.8847656);
    let low = ((zl * 2.8847656) + ((z * 0.0006244568) + ((z * 2.88539) * (w * p))));
    let head = math_head((s.exponent + (high + low)));
    return vec2f(head, (((s.exponent - head) + high) + low));
}

fn math_pow(x: f32, y: f32) -> f32 {
    let a = abs(x);
    let pair = math_log2_pair(bitcast<u32>(a));
    let log = (pair.x + pair.y);
    let below = select(y, 1.0e30, (y > 1.0e30));
    let e = select(below, -1.0e30, (below < -1.0e30));
    let t = (e * log);
    let low = select(t, 200.0, (t > 200.0));
    let c = select(low, -200.0, (low < -200.0));
    let n = (bitcast<i32>((c + MATH_ROUND)) - bitcast<i32>(MATH_ROUND_BITS));
    let eh = math_head(e);
    let f = (((eh * pair.x) - f32(n)) + ((eh * pair.y) + ((e - eh) * log)));
    let f1 = select(f, 1.0, (f > 1.0));
    let f2 = select(f1, -1.0, (f1 < -1.0));
    let finite = math_scale(math_exp2_core(f2), n);
    let infinity = math_from_bits(2139095040u);
    let grows = ((y > 0.0) == (a > 1.0));
    let edge = select(finite, select(0.0, infinity, grows), ((a < MATH_MIN_NORMAL) || (a == infinity)));
    let known = select(edge, (x + y), ((x != x) || (y != y)));
    let positive = select(known, 1.0, ((a == 1.0) || (y == 0.0)));
    var result: f32 = positive;
    if ((bitcast<u32>(x) & 2147483648u) != 0u) {
        result = math_pow_negative(x, y, positive);
    }
    return result;
}

fn math_pow_negative(x: f32, y: f32, r: f32) -> f32 {
    let whole = i32(y);
    let integer = ((f32(whole) == y) || (abs(y) >= 8388608.0));
    let odd = ((integer && ((whole & 1i) != 0i)) && (abs(y) < 16777216.0));
    let signed = bitcast<f32>((bitcast<u32>(r) ^ select(0u, 2147483648u, odd)));
    let finite = ((bitcast<u32>(x) & 2147483647u) < 2139095040u);
    let root = ((((x <= -MATH_MIN_NORMAL) && finite) && !integer) && (y != 0.0));
    return select(signed, math_from_bits(2143289344u), root);
}

fn math_rsqrt(x: f32) -> f32 {
    return (1.0 / sqrt(x));
}
fn math_round_half_even(x: f32) -> f32 {
    let a = abs(x);
    let k = (bitcast<i32>((a + 8388608.0)) - 1258291200i);
    return math_copysign(select(a, f32(k), (a < 8388608.0)), x);
}

fn math_fmod(x: f32, y: f32) -> f32 {
    let a = abs(x);
    let b = abs(y);
    let q = trunc((a / b));
    let far = (q >= 4194304.0);
    let qh = math_head(q);
    let ql = (q - qh);
    let bh = math_head(b);
    let bl = (b - bh);
    let r = ((((a - (qh * bh)) - (ql * bh)) - (qh * bl)) - (ql * bl));
    let low = select(r, (r + b), (r < 0.0));
    let high = select(low, (low - b), (low >= b));
    let bounded = select(high, 0.0, ((far && (b > 0.0)) && (a < math_from_bits(2139095040u))));
    let kept = select(bounded, a, ((b >= math_from_bits(2139095040u)) && (a < b)));
    return math_copysign(kept, x);
}

fn math_cbrt(x: f32) -> f32 {
    let a = abs(x);
    let large = (a > 1.0e30);
    let s = select(a, (a * 9.313226e-10), large);
    let guess = bitcast<f32>(bitcast<u32>((i32((f32(bitcast<i32>(s)) * 0.33333334)) + 709958130i)));
    let g = ((guess * guess) * guess);
    let better = (guess * ((g + (2.0 * s)) / ((2.0 * g) + s)));
    let c = ((better * better) * better);
    let root = ((better + (better * ((s - c) / ((2.0 * c) + s)))) * select(1.0, 1024.0, large));
    let nonzero = select(root, 0.0, (a < MATH_MIN_NORMAL));
    return math_copysign(select(nonzero, a, (bitcast<u32>(a) >= 2139095040u)), x);
}
fn math_erf_near(x: f32) -> f32 {
    let z = (x * x);
    let q = (0.005221127 + (z * (-0.00084867736 + (z * (0.00011293234 - (z * 9.763227e-6))))));
    return (x * (0.12837917 + (z * (-0.37612638 + (z * (0.112837814 + (z * (-0.026865425 + (z * q)))))))));
}

fn math_erf(x: f32) -> f32 {
    let a = abs(x);
    let near = (x + math_erf_near(x));
    return select(near, math_copysign((1.0 - math_erfc_far(a)), x), (a > 0.9));
}

fn math_erfc_far(a: f32) -> f32 {
    let x = select(a, 10.5, (a > 10.5));
    let t = (1.0 / (1.0 + (0.4 * x)));
    let p = (0.16597901 + (t * (-0.05555832 + (t * (0.22819413 + (t * (-0.22048645 + (t * 0.060180113))))))));
    let q = (t * (0.22567883 + (t * (0.22557396 + (t * (0.2090002 + (t * (0.16145052 + (t * p)))))))));
    let head = math_head(x);
    return ((math_exp((-head * head)) * math_exp((-(x - head) * (x + head)))) * q);
}

fn math_erfc(x: f32) -> f32 {
    let near = (1.0 - (x + math_erf_near(x)));
    let far = math_erfc_far(abs(x));
    return select(near, select(far, (2.0 - far), (x < 0.0)), (abs(x) > 0.5));
}

fn math_erf_inverse_factor(w: f32) -> f32 {
    let v = (min(w, 5.0) - 2.5);
    let p = (0.00021834444 + (v * (-4.9633454e-6 + (v * (-3.4627044e-6 + (v * (4.661701e-7 + (v * 2.3232623e-8))))))));
    let near = (1.5014094 + (v * (0.24664028 + (v * (-0.004177387 + (v * (-0.0012527419 + (v * p))))))));
    let s = (sqrt(clamp(w, 5.0, 17.64)) - 3.0);
    let q = (-0.007694381 + (s * (0.0060099047 + (s * (-0.0035019182 + (s * 0.000928124))))));
    let far = (2.8329787 + (s * (1.0016805 + (s * (0.009382151 + (s * q))))));
    return select(near, far, (w > 5.0));
}

fn math_erf_inverse(x: f32) -> f32 {
    return (x * math_erf_inverse_factor(-math_log(max(((1.0 - x) * (1.0 + x)), 1e-30))));
}

fn math_erfc_inverse(q: f32) -> f32 {
    return ((1.0 - q) * math_erf_inverse_factor(-math_log(max((q * (2.0 - q)), 1e-30))));
}
fn hash_u32(v: u32) -> u32 {
    let a = ((v ^ (v >> 16u)) * 2146121005u);
    let b = ((a ^ (a >> 15u)) * 2221713035u);
    return (b ^ (b >> 16u));
}

fn hash_combine(seed: u32, v: u32) -> u32 {
    return hash_u32((v ^ hash_u32((seed + 2654435769u))));
}

fn hash_pcg(v: u32) -> u32 {
    let state = ((v * 747796405u) + 2891336453u);
    let word = (((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u);
    return ((word >> 22u) ^ word);
}

fn hash_pcg3(p: vec3u) -> vec3u {
    let x0 = ((p.x * 1664525u) + 1013904223u);
    let y0 = ((p.y * 1664525u) + 1013904223u);
    let z0 = ((p.z * 1664525u) + 1013904223u);
    let x1 = (x0 + (y0 * z0));
    let y1 = (y0 + (z0 * x1));
    let z1 = (z0 + (x1 * y1));
    let x2 = (x1 ^ (x1 >> 16u));
    let y2 = (y1 ^ (y1 >> 16u));
    let z2 = (z1 ^ (z1 >> 16u));
    let x3 = (x2 + (y2 * z2));
    let y3 = (y2 + (z2 * x3));
    return vec3u(x3, y3, (z2 + (x3 * y3)));
}

fn hash_unit(h: u32) -> f32 {
    return (f32(bitcast<i32>((h >> 8u))) * 5.9604645e-8);
}
fn math_sinh(x: f32) -> f32 {
    let a = abs(x);
    let z = (a * a);
    let p = (0.16666667 + (z * (0.008333315 + (z * (0.00019841666 + (z * 2.789984e-6))))));
    let half = math_exp_scaled(a, -1i);
    return math_copysign(select((half - (0.25 / half)), (a + (a * (z * p))), (a < 1.0)), x);
}

fn math_cosh(x: f32) -> f32 {
    let half = math_exp_scaled(abs(x), -1i);
    return (half + (0.25 / half));
}

fn math_tanh(x: f32) -> f32 {
    let a = abs(x);
    let z = (a * a);
    let p = (0.13331416 + (z * (-0.05373794 + (z * (0.020634118 - (z * 0.005700092))))));
    let near = (a + (a * (z * (-0.3333328 + (z * p)))));
    let far = (1.0 - (2.0 / (math_exp((2.0 * a)) + 1.0)));
    return math_copysign(select(far, near, (a < 0.625)), x);
}

fn math_asinh(x: f32) -> f32 {
    let a = abs(x);
    let z = (a * a);
    let p = (0.074986435 + (z * (-0.04438358 + (z * (0.028164992 - (z * 0.013231114))))));
    let near = (a + (a * (z * (-0.16666643 + (z * p)))));
    let huge = (a > 1048576.0);
    let far = (math_log(select((a + sqrt((z + 1.0))), a, huge)) + select(0.0, 0.6931472, huge));
    return math_copysign(select(far, near, (a < 0.5)), x);
}

fn math_acosh(x: f32) -> f32 {
    let u = (x - 1.0);
    let huge = (x > 1048576.0);
    let w = select((u + sqrt((u * (u + 2.0)))), u, huge);
    return (math_log1p(w) + select(0.0, 0.6931472, huge));
}

fn math_atanh(x: f32) -> f32 {
    let a = abs(x);
    let z = (a * a);
    let p = (0.14223826 + (z * (0.11816006 + (z * (0.05161949 + (z * 0.17635684))))));
    let near = (a + (a * (z * (0.33333302 + (z * (0.20002452 + (z * p)))))));
    let far = (0.5 * math_log(((1.0 + a) / (1.0 - a))));
    return math_copysign(select(far, near, (a < 0.5)), x);
}
fn noise_within(x: f32, low: f32, high: f32) -> f32 {
    let above = select(low, x, (x > low));
    return select(high, above, (above < high));
}

fn noise_line(x: f32) -> f32 {
    return noise_within(floor(x), -2147483520.0, 2147483520.0);
}

fn noise_mix(sum: u32) -> u32 {
    let a = ((sum ^ (sum >> 15u)) * 739982445u);
    let b = ((a ^ (a >> 12u)) * 695872825u);
    return (b ^ (b >> 15u));
}

fn noise_slope(h: u32, x: f32, y: f32, z: f32) -> f32 {
    let a = select(y, x, ((h & 8u) == 0u));
    let b = select(select(z, x, ((h & 13u) == 12u)), y, ((h & 12u) == 0u));
    return (bitcast<f32>((bitcast<u32>(a) ^ (h << 31u))) + bitcast<f32>((bitcast<u32>(b) ^ ((h & 2u) << 30u))));
}

fn noise_fade(t: f32) -> f32 {
    return (((t * t) * t) * ((t * ((t * 6.0) - 15.0)) + 10.0));
}

fn noise_lerp(a: f32, b: f32, t: f32) -> f32 {
    return ((a * (1.0 - t)) + (b * t));
}

fn noise_gradient(p: vec3f, seed: i32) -> f32 {
    let cx = noise_line(p.x);
    let cy = noise_line(p.y);
    let cz = noise_line(p.z);
    let x = noise_within((p.x - cx), 0.0, 1.0);
    let y = noise_within((p.y - cy), 0.0, 1.0);
    let z = noise_within((p.z - cz), 0.0, 1.0);
    let hx = ((bitcast<u32>(i32(cx)) * 374761393u) + (bitcast<u32>(seed) * 1274126177u));
    let hy = (bitcast<u32>(i32(cy)) * 668265263u);
    let hz = (bitcast<u32>(i32(cz)) * 1440662683u);
    let h00 = ((hx + hy) + hz);
    let h10 = (h00 + 668265263u);
    let h01 = (h00 + 1440662683u);
    let h11 = (h10 + 1440662683u);
    let u = noise_fade(x);
    let v = noise_fade(y);
    let w = noise_fade(z);
    let x1 = (x - 1.0);
    let y1 = (y - 1.0);
    let z1 = (z - 1.0);
    let a = noise_lerp(noise_slope(noise_mix(h00), x, y, z), noise_slope(noise_mix((h00 + 374761393u)), x1, y, z), u);
    let b = noise_lerp(noise_slope(noise_mix(h10), x, y1, z), noise_slope(noise_mix((h10 + 374761393u)), x1, y1, z), u);
    let c = noise_lerp(noise_slope(noise_mix(h01), x, y, z1), noise_slope(noise_mix((h01 + 374761393u)), x1, y, z1), u);
    let d = noise_lerp(noise_slope(noise_mix(h11), x, y1, z1), noise_slope(noise_mix((h11 + 374761393u)), x1, y1, z1), u);
    return noise_within(noise_lerp(noise_lerp(a, b, v), noise_lerp(c, d, v), w), -1.0, 1.0);
}
fn fresnel_dielectric(c: f32, eta: f32) -> f32 {
    let k = ((eta - 1.0) * (eta + 1.0));
    let g2 = (k + (c * c));
    if (g2 <= 0.0) {
        return select(1.0, 0.0, (k == 0.0));
    }
    let g = sqrt(g2);
    let eta2 = (eta * eta);
    let s = (c + g);
    let p = ((eta2 * c) + g);
    let rs = (k / (s * s));
    let rp = ((k * (((c * c) * (eta2 + 1.0)) - 1.0)) / (p * p));
    return min((0.5 * ((rs * rs) + (rp * rp))), 1.0);
}

fn sane_eta(eta: f32) -> f32 {
    return select(1.0, limit(eta, 1e-3, 1e3), (eta > 0.0));
}

fn schlick_weight(c: f32, exponent: f32) -> f32 {
    let m = unit((1.0 - c));
    let m2 = (m * m);
    if (exponent == 5.0) {
        return ((m2 * m2) * m);
    }
    if !(exponent > 0.0) {
        return 1.0;
    }
    return math_pow(m, exponent);
}

fn half_cosine(no: f32, ni: f32, oi: f32) -> f32 {
    let product = (oi - min(((2.0 * no) * ni), 0.0));
    return sqrt(unit((0.5 + (0.5 * product))));
}
const FILM_FIRST: f32 = 1.53215;
const FILM_STEP: f32 = 0.10255;
const FILM_WIDTH: f32 = 0.10137;
const FILM_LONGEST: f32 = 1e3;
const FILM_THINNEST: f32 = 1e-6;

struct Film {
    thickness: f32,
    ior: vec3f
}

struct FilmSide {
    r: vec2f,
    t: f32
}

fn complex_mul(a: vec2f, b: vec2f) -> vec2f {
    return vec2f(((a.x * b.x) - (a.y * b.y)), ((a.x * b.y) + (a.y * b.x)));
}

fn complex_div(a: vec2f, b: vec2f) -> vec2f {
    let inverse = (1.0 / max(dot(b, b), 1e-30));
    return vec2f((((a.x * b.x) + (a.y * b.y)) * inverse), (((a.y * b.x) - (a.x * b.y)) * inverse));
}

fn sane_ior(ior: f32, fallback: f32) -> f32 {
    return select(fallback, limit(ior, 1e-3, 1e3), (ior > 0.0));
}

fn film_wave(n: f32, k: f32, n1: f32, c: f32) -> vec2f {
    let w1 = (n1 * c);
    let re = ((((n - n1) * (n + n1)) + (w1 * w1)) - (k * k));
    let im = (n * k);
    let root = sqrt((0.5 * (sqrt(((re * re) + ((4.0 * im) * im))) + abs(re))));
    let other = select(0.0, (im / root), (root > 0.0));
    return vec2f(select(other, root, (re >= 0.0)), select(root, other, (re >= 0.0)));
}

fn fresnel_complex(c: f32, n: f32, k: f32) -> f32 {
    if (k <= 0.0) {
        return fresnel_dielectric(c, n);
    }
    let w = film_wave(n, k, 1.0, c);
    let s2 = ((1.0 - c) * (1.0 + c));
    let near = (c - w.x);
    let far = (c + w.x);
    let rs = (((near * near) + (w.y * w.y)) / ((far * far) + (w.y * w.y)));
    let cv = (c * w.y);
    let less = ((c * w.x) - s2);
    let more = ((c * w.x) + s2);
    let ratio = (((less * less) + (cv * cv)) / max(((more * more) + (cv * cv)), 1e-30));
    return unit(((0.5 * rs) * (1.0 + ratio)));
}

fn film_fringe(q: vec2f, z: vec2f, re: vec3f, im: vec3f) -> vec3f {
    let x = complex_mul(q, z);
    let g = complex_div((x * 2.0), vec2f((1.0 + x.x), x.y));
    return ((re * g.x) - (im * g.y));
}

fn film_fringes(q: vec2f, z: vec2f, step: vec2f) -> vec3f {
    let z1 = complex_mul(z, step);
    let z2 = complex_mul(z1, step);
    let z3 = complex_mul(z2, step);
    let z4 = complex_mul(z3, step);
    let z5 = complex_mul(z4, step);
    let z6 = complex_mul(z5, step);
    let z7 = complex_mul(z6, step);
    let z8 = complex_mul(z7, step);
    let z9 = complex_mul(z8, step);
    return (((((((((film_fringe(q, z, vec3f(-0.368173, 0.059456, -0.006477), vec3f(0.491939, -0.083598, 0.004682)) + film_fringe(q, z1, vec3f(1.808573, -0.361625, -0.014957), vec3f(0.276871, 0.163977, -0.047033))) + film_fringe(q, z2, vec3f(0.135000, 0.515271, -0.052282), vec3f(-0.781187, 0.454635, -0.062597))) + film_fringe(q, z3, vec3f(-0.220073, 0.469988, -0.027583), vec3f(-0.219700, 0.001364, 0.022400))) + film_fringe(q, z4, vec3f(-0.419125, 0.374233, -0.048044), vec3f(0.234705, -0.528901, 0.149401))) + film_fringe(q, z5, vec3f(-0.067614, 0.103057, -0.035667), vec3f(-0.053512, -0.003730, 0.061418))) + film_fringe(q, z6, vec3f(0.037568, -0.068846, 0.747110), vec3f(0.072834, -0.056635, 0.336914))) + film_fringe(q, z7, vec3f(0.055015, -0.047835, 0.257886), vec3f(0.030116, -0.019390, 0.151089))) + film_fringe(q, z8, vec3f(0.041462, -0.040667, 0.153883), vec3f(-0.065011, 0.085519, -0.662458))) + film_fringe(q, z9, vec3f(-0.002633, -0.003032, 0.026131), vec3f(0.012945, -0.013241, 0.046184)));
}

fn film_side(a: vec2f, b: vec2f, flow: f32) -> FilmSide {
    let sum = (a + b);
    return FilmSide(complex_div((a - b), sum), unit(((4.0 * flow) / max(dot(sum, sum), 1e-30))));
}

fn film_polarised(first: FilmSide, second: FilmSide, z: vec2f, step: vec2f) -> vec3f {
    let rest = ((first.t + second.t) - (first.t * second.t));
    if !(rest > 1e-12) {
        return splat3(1.0);
    }
    let a = (first.r.x * first.r.x);
    let b = dot(second.r, second.r);
    let mean = (((a * second.t) + (b * first.t)) / rest);
    let swing = ((first.t * second.t) / rest);
    return (splat3(mean) + (film_fringes((second.r * first.r.x), z, step) * swing));
}

fn film_tunnel(r12: vec2f, r23: vec2f, z: f32) -> f32 {
    let q = (complex_mul(r12, r23) * z);
    let above = (r12 + (r23 * z));
    let below = vec2f((1.0 + q.x), q.y);
    return min((dot(above, above) / max(dot(below, below), 1e-30)), 1.0);
}

fn film_channels(
    d: f32,
    n1: f32,
    n2: f32,
    n: f32,
    k: f32,
    c: f32,
) -> vec3f {
    let w1 = vec2f((n1 * c), 0.0);
    let w3 = film_wave(n, k, n1, c);
    let w2 = film_wave(n2, 0.0, n1, c);
    let e1 = (n1 * n1);
    let e2 = (n2 * n2);
    let e3 = vec2f(((n - k) * (n + k)), ((2.0 * n) * k));
    let s2 = ((e1 * (1.0 - c)) * (1.0 + c));
    let flow3 = (w3.x * (dot(w3, w3) + s2));
    let s12 = film_side(w1, w2, (w1.x * w2.x));
    let s23 = film_side(w2, w3, (w2.x * w3.x));
    let p12 = film_side((w1 * e2), (w2 * e1), (((w1.x * w2.x) * e1) * e2));
    let p23 = film_side(complex_mul(e3, w2), (w3 * e2), ((w2.x * e2) * flow3));
    if (w2.x > 0.0) {
        let path = min(((2e-3 * d) * w2.x), FILM_LONGEST);
        let turn = math_sincos((((2.0 * PI) * FILM_FIRST) * path));
        let next = math_sincos((((2.0 * PI) * FILM_STEP) * path));
        let fade = math_exp((((-2.0 * PI) * FILM_WIDTH) * path));
        let z = vec2f((fade * turn.y), (fade * turn.x));
        let step = vec2f(next.y, next.x);
        return ((film_polarised(s12, s23, z, step) + film_polarised(p12, p23, z, step)) * 0.5);
    }
    let path = min(((2e-3 * d) * w2.y), FILM_LONGEST);
    let red = math_exp((((-2.0 * PI) * 1.6217) * path));
    let green = math_exp((((-2.0 * PI) * 1.8649) * path));
    let blue = math_exp((((-2.0 * PI) * 2.2565) * path));
    let at_red = (film_tunnel(s12.r, s23.r, red) + film_tunnel(p12.r, p23.r, red));
    let at_green = (film_tunnel(s12.r, s23.r, green) + film_tunnel(p12.r, p23.r, green));
    let at_blue = (film_tunnel(s12.r, s23.r, blue) + film_tunnel(p12.r, p23.r, blue));
    return (((vec3f(0.627607, 0.007800, -0.031718) * at_red) + (vec3f(-0.138104, 0.525818, 0.028389) * at_green)) + (vec3f(0.010497, -0.033618, 0.503329) * at_blue));
}

fn film_reflectance(
    film: Film,
    near: vec3f,
    n: vec3f,
    k: vec3f,
    c: f32,
) -> vec3f {
    if !(film.thickness > FILM_THINNEST) {
        return vec3f(fresnel_complex(c, (n.x / near.x), (k.x / near.x)), fresnel_complex(c, (n.y / near.y), (k.y / near.y)), fresnel_complex(c, (n.z / near.z), (k.z / near.z)));
    }
    let d = min(film.thickness, 1e9);
    let n2 = vec3f(sane_ior(film.ior.x, near.x), sane_ior(film.ior.y, near.y), sane_ior(film.ior.z, near.z));
    let red = film_channels(d, near.x, n2.x, n.x, k.x, c);
    let flat = ((((near.x == near.y) && (near.y == near.z)) && (n2.x == n2.y)) && (n2.y == n2.z));
    if ((((flat && (n.x == n.y)) && (n.y == n.z)) && (k.x == k.y)) && (k.y == k.z)) {
        return red;
    }
    let green = film_channels(d, near.y, n2.y, n.y, k.y, c);
    let blue = film_channels(d, near.z, n2.z, n.z, k.z, c);
    return vec3f(red.x, green.y, blue.z);
}
const EVENT_ABSORB: u32 = 0u;
const EVENT_DIFFUSE: u32 = 1u;
const EVENT_GLOSSY: u32 = 2u;
const EVENT_SPECULAR: u32 = 4u;
const EVENT_REFLECTION: u32 = 8u;
const EVENT_TRANSMISSION: u32 = 16u;
const MODE_REFLECT: u32 = 0u;
const MODE_TRANSMIT: u32 = 1u;
const MODE_REFLECT_TRANSMIT: u32 = 2u;

struct LobeValue {
    f: f32,
    pdf: f32
}

struct LobeSample {
    wi: vec3f,
    event: u32
}

fn lobe_absorb() -> LobeSample {
    return LobeSample(vec3f(0.0, 0.0, 1.0), EVENT_ABSORB);
}

fn lobe_zero() -> LobeValue {
    return LobeValue(0.0, 0.0);
}
fn sample_concentric_disc(u: vec2f) -> vec2f {
    let a = ((2.0 * u.x) - 1.0);
    let b = ((2.0 * u.y) - 1.0);
    if ((a == 0.0) && (b == 0.0)) {
        return vec2f(0.0, 0.0);
    }
    let wide = (abs(a) > abs(b));
    let r = select(b, a, wide);
    let ratio = (select(a, b, wide) / r);
    let angle = select(((0.5 * PI) - ((0.25 * PI) * ratio)), ((0.25 * PI) * ratio), wide);
    let sc = math_sincos(angle);
    return vec2f((r * sc.y), (r * sc.x));
}

fn sample_cosine_hemisphere(u: vec2f) -> vec3f {
    let d = sample_concentric_disc(u);
    return vec3f(d.x, d.y, sqrt(max((1.0 - ((d.x * d.x) + (d.y * d.y))), 0.0)));
}

fn reuse_random(u: f32, prob: f32, chosen: bool) -> f32 {
    let rest = select(((u - prob) / (1.0 - prob)), (u / prob), chosen);
    return limit(rest, 0.0, 0.99999994);
}
const MICROFLAKE_MIN: f32 = 0.01;
const FRAC_1_SQRT_TWO_PI: f32 = 0.39894228;

struct Microflake {
    axis: vec2f,
    a: f32,
    b: f32,
    albedo: f32
}

fn sane_sheen(roughness: f32) -> f32 {
    return select(MICROFLAKE_MIN, min(roughness, 1.0), (roughness > MICROFLAKE_MIN));
}

fn microflake_albedo(roughness: f32, mu: f32) -> f32 {
    let y = sane_sheen(roughness);
    let s = ((y * (0.0206607 + (1.58491 * y))) / (0.0379424 + (y * (1.32227 + y))));
    let m = ((y * (-0.193854 + (y * (-1.14885 + (y * (1.7932 - ((0.95943 * y) * y))))))) / (0.046391 + y));
    let o = ((y * (0.000654023 + (y * (-0.0207818 + (0.119681 * y))))) / (1.26264 + (y * (-1.92021 + y))));
    let t = ((mu - m) / s);
    return unit((((math_exp(((-0.5 * t) * t)) * FRAC_1_SQRT_TWO_PI) / s) + o));
}

fn microflake_new(roughness: f32, wo: vec3f) -> Microflake {
    let y = sane_sheen(roughness);
    let x = unit(wo.z);
    let flat = normalize_or(vec3f(wo.x, wo.y, 0.0), vec3f(1.0, 0.0, 0.0));
    let b = (((((y - 1.0) * y) * y) * y) / (((0.0000254053 + (1.71228 * x)) - ((1.71506 * x) * y)) + ((1.34174 * y) * y)));
    return Microflake(flat.xy, ((((2.58126 * x) + (0.813703 * y)) * y) / ((1.0 + ((0.310327 * x) * x)) + ((2.60994 * x) * y))), (sqrt((1.0 - x)) * b), microflake_albedo(y, x));
}

fn microflake_eval(lobe: Microflake, wo: vec3f, wi: vec3f) -> LobeValue {
    if ((wo.z <= 0.0) || (wi.z <= 0.0)) {
        return lobe_zero();
    }
    let along = ((lobe.axis.x * wi.x) + (lobe.axis.y * wi.y));
    let across = ((lobe.axis.x * wi.y) - (lobe.axis.y * wi.x));
    let x = ((lobe.a * along) + (lobe.b * wi.z));
    let y = (lobe.a * across);
    let scale = (lobe.a / (((x * x) + (y * y)) + (wi.z * wi.z)));
    let pdf = ((wi.z * FRAC_1_PI) * (scale * scale));
    return LobeValue((lobe.albedo * pdf), pdf);
}

fn microflake_sample(lobe: Microflake, u: vec2f) -> LobeSample {
    let w = sample_cosine_hemisphere(u);
    let along = (w.x - (lobe.b * w.z));
    let x = ((lobe.axis.x * along) - (lobe.axis.y * w.y));
    let y = ((lobe.axis.y * along) + (lobe.axis.x * w.y));
    let wi = normalize_or(vec3f(x, y, (lobe.a * w.z)), vec3f(0.0, 0.0, 0.0));
    if (wi.z <= 0.0) {
        return lobe_absorb();
    }
    return LobeSample(wi, (EVENT_GLOSSY | EVENT_REFLECTION));
}
fn specular_reflectance(mode: u32, c: f32, eta: f32) -> f32 {
    if (mode == MODE_REFLECT) {
        return 1.0;
    }
    let r = fresnel_dielectric(c, eta);
    if (mode == MODE_TRANSMIT) {
        return select(0.0, 1.0, (r >= 1.0));
    }
    return r;
}

fn refract_at(wo: vec3f, wm: vec3f, c: f32, eta: f32) -> vec3f {
    let inverse = (1.0 / eta);
    let cos_t = (sqrt(max((((eta - 1.0) * (eta + 1.0)) + (c * c)), 0.0)) * inverse);
    return ((wm * ((c * inverse) - cos_t)) - (wo * inverse));
}

fn specular_sample(
    reflected: f32,
    thin_walled: bool,
    eta: f32,
    wo: vec3f,
    u: f32,
) -> LobeSample {
    if (wo.z <= 0.0) {
        return lobe_absorb();
    }
    if (u < reflected) {
        return LobeSample(vec3f(-wo.x, -wo.y, wo.z), (EVENT_SPECULAR | EVENT_REFLECTION));
    }
    let straight = vec3f(-wo.x, -wo.y, -wo.z);
    let bent = refract_at(wo, vec3f(0.0, 0.0, 1.0), wo.z, eta);
    return LobeSample(select(bent, straight, thin_walled), (EVENT_SPECULAR | EVENT_TRANSMISSION));
}
const ALPHA_MIN: f32 = 1e-4;
const ETA_MATCH: f32 = 1e-4;

struct Ggx {
    alpha: vec2f,
    mode: u32,
    thin_walled: bool,
    eta: f32,
    reflected: f32,
    correlated: bool
}

fn sane_alpha(alpha: f32) -> f32 {
    return limit(alpha, ALPHA_MIN, 1.0);
}

fn ggx_new(
    alpha_x: f32,
    alpha_y: f32,
    mode: u32,
    thin_walled: bool,
    eta: f32,
) -> Ggx {
    let alpha = vec2f(sane_alpha(alpha_x), sane_alpha(alpha_y));
    return Ggx(alpha, mode, thin_walled, eta, -1.0, false);
}

fn ggx_stretch(alpha: vec2f, w: vec3f) -> f32 {
    let x = (alpha.x * w.x);
    let y = (alpha.y * w.y);
    return sqrt((((w.z * w.z) + (x * x)) + (y * y)));
}

fn ggx_g1(alpha: vec2f, w: vec3f) -> f32 {
    let z = abs(w.z);
    return ((2.0 * z) / (z + ggx_stretch(alpha, w)));
}

fn ggx_shadowing(lobe: Ggx, wo: vec3f, stretch: f32, wi: vec3f) -> f32 {
    if !lobe.correlated {
        return ggx_g1(lobe.alpha, wi);
    }
    let z = abs(wi.z);
    return ((z * (wo.z + stretch)) / ((z * stretch) + (wo.z * ggx_stretch(lobe.alpha, wi))));
}

fn ggx_d(alpha: vec2f, h: vec3f, h2: f32) -> f32 {
    let x = (h.x / alpha.x);
    let y = (h.y / alpha.y);
    let k = (h2 / (((x * x) + (y * y)) + (h.z * h.z)));
    return ((FRAC_1_PI / (alpha.x * alpha.y)) * (k * k));
}

fn ggx_cap_bound(lobe: Ggx, wo: vec3f) -> f32 {
    if (lobe.mode != MODE_REFLECT) {
        return 1.0;
    }
    let a = min(lobe.alpha.x, lobe.alpha.y);
    let s = (1.0 + sqrt(((wo.x * wo.x) + (wo.y * wo.y))));
    let s2 = (s * s);
    return (((1.0 - (a * a)) * s2) / (s2 + (((a * a) * wo.z) * wo.z)));
}

fn ggx_eval(lobe: Ggx, wo: vec3f, wi: vec3f) -> LobeValue {
    if ((wo.z <= 0.0) || (wi.z == 0.0)) {
        return lobe_zero();
    }
    if ((wi.z < 0.0) && !lobe.thin_walled) {
        return ggx_eval_refraction(lobe, wo, wi);
    }
    if ((wi.z < 0.0) && (lobe.mode == MODE_REFLECT)) {
        return lobe_zero();
    }
    let mirrored = vec3f(wi.x, wi.y, abs(wi.z));
    let h = (wo + mirrored);
    let h2 = dot(h, h);
    if (h2 < 1e-30) {
        return lobe_zero();
    }
    let reflected = ggx_reflectance(lobe, min((0.5 * sqrt(h2)), 1.0));
    let share = select((1.0 - reflected), reflected, (wi.z > 0.0));
    let stretch = ggx_stretch(lobe.alpha, wo);
    let d = (share * ggx_d(lobe.alpha, h, h2));
    return LobeValue((((0.5 * d) * ggx_shadowing(lobe, wo, stretch, wi)) / (wo.z + stretch)), ((0.5 * d) / ((ggx_cap_bound(lobe, wo) * wo.z) + stretch)));
}

fn ggx_reflectance(lobe: Ggx, c: f32) -> f32 {
    if (lobe.reflected >= 0.0) {
        return lobe.reflected;
    }
    if (lobe.thin_walled && (lobe.mode == MODE_TRANSMIT)) {
        return 0.0;
    }
    return specular_reflectance(lobe.mode, c, lobe.eta);
}

fn ggx_facet_cosine(lobe: Ggx, wo: vec3f, wi: vec3f) -> f32 {
    if ((wi.z < 0.0) && !lobe.thin_walled) {
        let h = (wo + (wi * lobe.eta));
        return min((abs(dot(wo, h)) / sqrt(max(dot(h, h), 1e-30))), 1.0);
    }
    let h = (wo + vec3f(wi.x, wi.y, abs(wi.z)));
    return min((0.5 * sqrt(dot(h, h))), 1.0);
}

fn ggx_eval_refraction(lobe: Ggx, wo: vec3f, wi: vec3f) -> LobeValue {
    if ((lobe.mode == MODE_REFLECT) || (abs((lobe.eta - 1.0)) < ETA_MATCH)) {
        return lobe_zero();
    }
    let sum = (wo + (wi * lobe.eta));
    let h = (sum * select(-1.0, 1.0, (sum.z >= 0.0)));
    let h2 = dot(h, h);
    let oh = dot(wo, h);
    let ih = dot(wi, h);
    if (((oh <= 0.0) || (ih >= 0.0)) || (h2 < 1e-30)) {
        return lobe_zero();
    }
    let c = min((oh / sqrt(h2)), 1.0);
    let transmitted = (1.0 - ggx_reflectance(lobe, c));
    let d = (transmitted * ggx_d(lobe.alpha, h, h2));
    let jacobian = (((lobe.eta * lobe.eta) * (oh / h2)) * (-ih / h2));
    let stretch = ggx_stretch(lobe.alpha, wo);
    let pdf = (((2.0 * d) * jacobian) / (wo.z + stretch));
    return LobeValue((pdf * ggx_shadowing(lobe, wo, stretch, wi)), pdf);
}

fn ggx_sample_normal(alpha: vec2f, wo: vec3f, bound: f32, u: vec2f) -> vec3f {
    let up = vec3f(0.0, 0.0, 1.0);
    let stretched = normalize_or(vec3f((wo.x * alpha.x), (wo.y * alpha.y), wo.z), up);
    let sc = math_sincos(((2.0 * PI) * u.x));
    let lowest = (bound * stretched.z);
    let z = (((1.0 - u.y) * (1.0 + lowest)) - lowest);
    let r = sqrt(max(((1.0 - z) * (1.0 + z)), 0.0));
    let sum = vec3f(((r * sc.y) + stretched.x), ((r * sc.x) + stretched.y), (z + stretched.z));
    return normalize_or(vec3f((sum.x * alpha.x), (sum.y * alpha.y), max(sum.z, 0.0)), up);
}

fn ggx_sample(lobe: Ggx, wo: vec3f, u: vec2f, uc: f32) -> LobeSample {
    if (wo.z <= 0.0) {
        return lobe_absorb();
    }
    if (((lobe.mode != MODE_REFLECT) && !lobe.thin_walled) && (abs((lobe.eta - 1.0)) < ETA_MATCH)) {
        return LobeSample(vec3f(-wo.x, -wo.y, -wo.z), (EVENT_SPECULAR | EVENT_TRANSMISSION));
    }
    let wm = ggx_sample_normal(lobe.alpha, wo, ggx_cap_bound(lobe, wo), u);
    let c = min(dot(wo, wm), 1.0);
    if (c <= 0.0) {
        return lobe_absorb();
    }
    let mirror = ((wm * (2.0 * c)) - wo);
    let reflects = (uc < ggx_reflectance(lobe, c));
    if (reflects || lobe.thin_walled) {
        if (mirror.z <= 0.0) {
            return lobe_absorb();
        }
        let side = select(EVENT_TRANSMISSION, EVENT_REFLECTION, reflects);
        return LobeSample(vec3f(mirror.x, mirror.y, select(-mirror.z, mirror.z, reflects)), (EVENT_GLOSSY | side));
    }
    let wi = normalize_or(refract_at(wo, wm, c, lobe.eta), vec3f(0.0, 0.0, -1.0));
    if (wi.z >= 0.0) {
        return lobe_absorb();
    }
    return LobeSample(wi, (EVENT_GLOSSY | EVENT_TRANSMISSION));
}
const ALBEDO_CELLS: u32 = 12u;

fn cubic(c: vec4f, x: f32) -> f32 {
    return (c.x + (x * (c.y + (x * (c.z + (x * c.w))))));
}

fn ggx_albedo_reflection(alpha: f32, mu: f32) -> f32 {
    let t = (mu / (mu + alpha));
    let p0 = cubic(vec4f(0.063108, 0.042415, 0.648377, -0.239965), alpha);
    let p1 = cubic(vec4f(0.013712, -0.221854, 0.127135, 0.129219), alpha);
    let p2 = cubic(vec4f(0.122677, 0.723070, -0.965951, -1.096269), alpha);
    let p3 = cubic(vec4f(-0.368986, -1.808482, -0.927123, 3.219062), alpha);
    let p4 = cubic(vec4f(0.166463, 1.352936, 2.680698, -4.121448), alpha);
    let p = (p0 + (t * (p1 + (t * (p2 + (t * (p3 + (t * p4))))))));
    let q1 = (-2.161096 - (1.171106 * alpha));
    let q2 = (1.413042 + (0.650708 * alpha));
    let q = ((1.0 + (0.332965 * alpha)) + (t * (q1 + (t * q2))));
    return unit((1.0 - (((1.0 - t) * p) / q)));
}

fn ggx_albedo(lobe: Ggx, wo: vec3f) -> f32 {
    if (wo.z <= 0.0) {
        return 0.0;
    }
    if (((lobe.mode == MODE_REFLECT) && (lobe.alpha.x == lobe.alpha.y)) && !lobe.correlated) {
        return ggx_albedo_reflection(lobe.alpha.x, wo.z);
    }
    let step = (1.0 / f32(ALBEDO_CELLS));
    var sum: f32 = 0.0;
    for (var i = 0u; i < ALBEDO_CELLS; i++) {
        for (var j = 0u; j < ALBEDO_CELLS; j++) {
            let rest = (1.0 - ((f32(j) + 0.5) * step));
            let turn = (0.25 + (0.5 * f32((j % 2u))));
            let u = vec2f(((f32(i) + turn) * step), (1.0 - (rest * rest)));
            let normal = ggx_sample_normal(lobe.alpha, wo, 1.0, u);
            sum += ((2.0 * rest) * ggx_normal_albedo(lobe, wo, normal));
        }
    }
    return unit(((sum * step) * step));
}

fn ggx_normal_albedo(lobe: Ggx, wo: vec3f, wm: vec3f) -> f32 {
    let c = clamp(dot(wo, wm), 1e-7, 1.0);
    let mirror = ((wm * (2.0 * c)) - wo);
    let r = ggx_reflectance(lobe, c);
    let stretch = ggx_stretch(lobe.alpha, wo);
    let above = select(0.0, ggx_shadowing(lobe, wo, stretch, mirror), (mirror.z > 0.0));
    if lobe.thin_walled {
        return select(above, (r * above), (lobe.mode == MODE_REFLECT));
    }
    if (r >= 1.0) {
        return above;
    }
    let wt = refract_at(wo, wm, c, lobe.eta);
    let below = select(0.0, ggx_shadowing(lobe, wo, stretch, wt), (wt.z < 0.0));
    return ((r * above) + ((1.0 - r) * below));
}
const FACETS_GGX: u32 = 0u;
const FACETS_BECKMANN: u32 = 1u;
const FACETS_PHONG: u32 = 2u;
const FACETS_SHEEN: u32 = 3u;

fn facets_d(facets: u32, alpha: vec2f, h: vec3f, h2: f32) -> f32 {
    let area = (alpha.x * alpha.y);
    let x = (h.x / alpha.x);
    let y = (h.y / alpha.y);
    let z2 = (h.z * h.z);
    let slope2 = ((x * x) + (y * y));
    if (facets == FACETS_GGX) {
        let k = (h2 / (slope2 + z2));
        return ((FRAC_1_PI / area) * (k * k));
    }
    if (facets == FACETS_BECKMANN) {
        if !(slope2 < (80.0 * z2)) {
            return 0.0;
        }
        let k = (h2 / z2);
        return (((FRAC_1_PI / area) * math_exp((-slope2 / z2))) * (k * k));
    }
    let flat2 = ((h.x * h.x) + (h.y * h.y));
    if (facets == FACETS_PHONG) {
        let s2 = min((flat2 / h2), 1.0);
        let near = ((-slope2 / h2) * phong_log_ratio(s2));
        let power = select(near, ((slope2 / flat2) * math_log(max((z2 / h2), 1e-37))), (s2 > 0.25));
        let u = (2.0 + (alpha.x * alpha.x));
        let v = (2.0 + (alpha.y * alpha.y));
        let root = sqrt(((u * v) / max((z2 / h2), 1e-37)));
        return ((((0.5 * FRAC_1_PI) * root) / area) * math_exp(power));
    }
    let inverse = (1.0 / alpha.x);
    return (((0.5 * FRAC_1_PI) * (2.0 + inverse)) * math_pow(min((flat2 / h2), 1.0), (0.5 * inverse)));
}

fn phong_log_ratio(x: f32) -> f32 {
    return select(1.0, (-math_log1p(-x) / x), (x > 1e-6));
}

fn facets_sample(facets: u32, alpha: vec2f, u: vec2f) -> vec3f {
    let sc = math_sincos(((2.0 * PI) * u.x));
    let v = max((1.0 - u.y), 5.9604645e-8);
    if ((facets == FACETS_GGX) || (facets == FACETS_BECKMANN)) {
        let slope2 = select(-math_log(v), ((1.0 - v) / v), (facets == FACETS_GGX));
        let r = sqrt(slope2);
        return normalize_or(vec3f(((alpha.x * r) * sc.y), ((alpha.y * r) * sc.x), 1.0), vec3f(0.0, 0.0, 1.0));
    }
    if (facets == FACETS_PHONG) {
        let wide = normalize_or(vec3f(((sc.y * alpha.x) * sqrt((2.0 + (alpha.y * alpha.y)))), ((sc.x * alpha.y) * sqrt((2.0 + (alpha.x * alpha.x)))), 0.0), vec3f(1.0, 0.0, 0.0));
        let x = (wide.x / alpha.x);
        let y = (wide.y / alpha.y);
        let log = (math_log(v) / ((2.0 * ((x * x) + (y * y))) + 1.0));
        let z = math_exp(log);
        let s = sqrt(max(((-2.0 * z) * math_sinh(log)), 0.0));
        return vec3f((wide.x * s), (wide.y * s), z);
    }
    let log = (math_log(v) / (2.0 + (1.0 / alpha.x)));
    let s = math_exp(log);
    return vec3f((s * sc.y), (s * sc.x), sqrt(max(((-2.0 * s) * math_sinh(log)), 0.0)));
}
struct Program {
    count: u32,
    nodes: array<vec4u, 64>
}

fn table_record_at(table: u32, index: u32) -> vec4f {
    return vec4f(0.0, 0.0, 0.0, 0.0);
}

fn table_record(program: ptr<function, Program>, table: u32, index: u32) -> vec4f {
    return table_record_at(table, index);
}
const MAX_NODES: u32 = 64u;
const MAX_PARAMS: u32 = 384u;
const MAX_STACK: u32 = 6u;
const OP_MASK: u32 = 255u;
const OP_BLACK: u32 = 0u;
const OP_DIFFUSE_REFLECTION: u32 = 1u;
const OP_DIFFUSE_TRANSMISSION: u32 = 2u;
const OP_SPECULAR: u32 = 3u;
const OP_GGX_SMITH: u32 = 4u;
const OP_BECKMANN_SMITH: u32 = 5u;
const OP_GGX_VCAVITIES: u32 = 6u;
const OP_BECKMANN_VCAVITIES: u32 = 7u;
const OP_SIMPLE_GLOSSY: u32 = 8u;
const OP_WARD: u32 = 9u;
const OP_BACKSCATTERING: u32 = 10u;
const OP_SHEEN: u32 = 11u;
const OP_DUSTY_DIFFUSE: u32 = 12u;
const OP_MICROFLAKE: u32 = 13u;
const OP_MEASURED_BSDF: u32 = 15u;
const OP_TINT: u32 = 16u;
const OP_SCALE: u32 = 17u;
const OP_DIRECTIONAL_FACTOR: u32 = 18u;
const OP_FRESNEL_FACTOR: u32 = 19u;
const OP_MEASURED_FACTOR: u32 = 20u;
const OP_COAT_ABSORPTION: u32 = 21u;
const OP_MEASURED_PICTURE: u32 = 24u;
const OP_WEIGHTED_LAYER: u32 = 32u;
const OP_FRESNEL_LAYER: u32 = 33u;
const OP_COLOR_FRESNEL_LAYER: u32 = 34u;
const OP_CUSTOM_CURVE_LAYER: u32 = 35u;
const OP_SHEEN_LAYER: u32 = 36u;
const OP_MEASURED_LAYER: u32 = 37u;
const OP_MICROFLAKE_LAYER: u32 = 38u;
const OP_DIFFUSE_EDF: u32 = 64u;
const OP_SPOT_EDF: u32 = 65u;
const OP_ANISOTROPIC_VDF: u32 = 66u;
const OP_FOG_VDF: u32 = 67u;
const FLAG_VECTOR: u32 = 256u;
const FLAG_COLOR: u32 = 512u;
const FLAG_BASE_FIRST: u32 = 1024u;
const FLAG_FILM: u32 = 2048u;
const FLAG_CORRELATED: u32 = 4096u;
const FLAG_CONSERVING: u32 = 4096u;
const SLOT_TINT: u32 = 0u;
const SLOT_DIFFUSE_ROUGHNESS: u32 = 3u;
const SLOT_DIFFUSE_MULTIPLE: u32 = 4u;
const SLOT_GLOSSY_ALPHA: u32 = 3u;
const SLOT_GLOSSY_TANGENT: u32 = 5u;
const SLOT_GLOSSY_MULTIPLE: u32 = 5u;
const SLOT_GLOSSY_MULTIPLE_TURNED: u32 = 8u;
const SLOT_MEASURED_TABLE: u32 = 3u;
const SLOT_TINT_TRANSMISSION: u32 = 3u;
const SLOT_FACTOR_GRAZING: u32 = 3u;
const SLOT_FACTOR_EXTINCTION: u32 = 3u;
const SLOT_FACTOR_EXPONENT: u32 = 6u;
const SLOT_FACTOR_F82: u32 = 7u;
const SLOT_COAT_ABSORPTION: u32 = 3u;
const SLOT_COAT_THICKNESS: u32 = 6u;
const SLOT_SPOT_AXIS: u32 = 2u;
const SLOT_LAYER_IMPORTANCE: u32 = 0u;
const SLOT_LAYER_WEIGHT: u32 = 2u;
const SLOT_LAYER_CURVE: u32 = 5u;

struct Params {
    v: array<f32, 384>
}

fn param(p: ptr<function, Params>, slot: u32) -> f32 {
    return p.v[u32(select(383u, slot, (slot < 384u)))];
}

fn param3(p: ptr<function, Params>, slot: u32) -> vec3f {
    let first = select(381u, slot, (slot < 382u));
    return vec3f(p.v[u32(first)], p.v[u32((first + 1u))], p.v[u32((first + 2u))]);
}
const FRAC_1_SQRT_PI: f32 = 0.56418958;
const HALF_SQRT_PI: f32 = 0.88622693;

struct Glossy {
    op: u32,
    facets: u32,
    ggx: Ggx
}

fn glossy_new(op: u32, ggx: Ggx) -> Glossy {
    let beckmann = (((op == OP_BECKMANN_SMITH) || (op == OP_BECKMANN_VCAVITIES)) || (op == OP_WARD));
    let phong = ((op == OP_SIMPLE_GLOSSY) || (op == OP_BACKSCATTERING));
    let other = select(FACETS_GGX, FACETS_SHEEN, (op == OP_SHEEN));
    let facets = select(select(other, FACETS_PHONG, phong), FACETS_BECKMANN, beckmann);
    return Glossy(op, facets, ggx);
}

fn beckmann_area(alpha: vec2f, w: vec3f) -> f32 {
    let z = abs(w.z);
    let x = (alpha.x * w.x);
    let y = (alpha.y * w.y);
    let s = sqrt(((x * x) + (y * y)));
    let a = (z / max(s, 1e-30));
    if (a > 5.0) {
        return z;
    }
    return (0.5 * ((z * (1.0 + math_erf(a))) + ((s * math_exp((-a * a))) * FRAC_1_SQRT_PI)));
}

fn glossy_visible(lobe: Glossy, wo: vec3f, mz: f32, om: f32) -> f32 {
    if (lobe.op == OP_BECKMANN_SMITH) {
        return (1.0 / max(beckmann_area(lobe.ggx.alpha, wo), 1e-37));
    }
    return min((1.0 / max(wo.z, 1e-37)), ((2.0 * mz) / max(om, 1e-37)));
}

fn glossy_shadowing(
    lobe: Glossy,
    wo: vec3f,
    wi: vec3f,
    mz: f32,
    om: f32,
    im: f32,
    visible: f32,
) -> f32 {
    let iz = abs(wi.z);
    if (lobe.op == OP_BECKMANN_SMITH) {
        let area = max(beckmann_area(lobe.ggx.alpha, wi), 1e-37);
        if lobe.ggx.correlated {
            let seen = max(beckmann_area(lobe.ggx.alpha, wo), 1e-37);
            return ((seen * iz) / max(((seen * iz) + ((area - iz) * wo.z)), 1e-37));
        }
        return (iz / area);
    }
    if (lobe.op == OP_WARD) {
        return (iz / max(((visible * om) * om), 1e-37));
    }
    let seen = max((visible * wo.z), 1e-37);
    let lit = min(1.0, (((2.0 * mz) * iz) / max(im, 1e-37)));
    let through = ((wi.z < 0.0) && !lobe.ggx.thin_walled);
    return select(min((lit / seen), 1.0), (max(((seen + lit) - 1.0), 0.0) / seen), through);
}

fn glossy_eval(lobe: Glossy, wo: vec3f, wi: vec3f) -> LobeValue {
    if (lobe.op == OP_GGX_SMITH) {
        return ggx_eval(lobe.ggx, wo, wi);
    }
    return facet_eval(lobe, wo, wi);
}

fn facet_eval(lobe: Glossy, wo: vec3f, wi: vec3f) -> LobeValue {
    if ((wo.z <= 0.0) || (wi.z == 0.0)) {
        return lobe_zero();
    }
    if ((wi.z < 0.0) && (lobe.ggx.mode == MODE_REFLECT)) {
        return lobe_zero();
    }
    if ((wi.z < 0.0) && !lobe.ggx.thin_walled) {
        return glossy_eval_refraction(lobe, wo, wi);
    }
    let turn = select(1.0, -1.0, (lobe.op == OP_BACKSCATTERING));
    let mirrored = vec3f((turn * wi.x), (turn * wi.y), abs(wi.z));
    let h = (wo + mirrored);
    let h2 = dot(h, h);
    if (h2 < 1e-30) {
        return lobe_zero();
    }
    let length = sqrt(h2);
    let om = min((0.5 * length), 1.0);
    let mz = (h.z / length);
    let reflected = ggx_reflectance(lobe.ggx, om);
    let share = select((1.0 - reflected), reflected, (wi.z > 0.0));
    let visible = glossy_visible(lobe, wo, mz, om);
    let pdf = (((0.25 * share) * facets_d(lobe.facets, lobe.ggx.alpha, h, h2)) * visible);
    if !(pdf > 0.0) {
        return lobe_zero();
    }
    return LobeValue((pdf * glossy_shadowing(lobe, wo, mirrored, mz, om, om, visible)), pdf);
}

fn glossy_eval_refraction(lobe: Glossy, wo: vec3f, wi: vec3f) -> LobeValue {
    let eta = lobe.ggx.eta;
    if (abs((eta - 1.0)) < ETA_MATCH) {
        return lobe_zero();
    }
    let sum = (wo + (wi * eta));
    let h = (sum * select(-1.0, 1.0, (sum.z >= 0.0)));
    let h2 = dot(h, h);
    let oh = dot(wo, h);
    let ih = dot(wi, h);
    if (((oh <= 0.0) || (ih >= 0.0)) || (h2 < 1e-30)) {
        return lobe_zero();
    }
    let length = sqrt(h2);
    let om = min((oh / length), 1.0);
    let mz = (h.z / length);
    let transmitted = (1.0 - ggx_reflectance(lobe.ggx, om));
    let visible = glossy_visible(lobe, wo, mz, om);
    let jacobian = (((eta * eta) * (oh / h2)) * (-ih / h2));
    let pdf = (((transmitted * facets_d(lobe.facets, lobe.ggx.alpha, h, h2)) * visible) * jacobian);
    if !(pdf > 0.0) {
        return lobe_zero();
    }
    return LobeValue((pdf * glossy_shadowing(lobe, wo, wi, mz, om, (-ih / length), visible)), pdf);
}

fn beckmann_sample_normal(alpha: vec2f, wo: vec3f, u: vec2f) -> vec3f {
    let x = (alpha.x * wo.x);
    let y = (alpha.y * wo.y);
    let s = sqrt(((x * x) + (y * y)));
    let axis = normalize_or(vec3f(x, y, 0.0), vec3f(1.0, 0.0, 0.0));
    let c = min((wo.z / max(s, 1e-30)), 1e6);
    let t = beckmann_slope(c, u.y);
    let towards = min((0.5 + ((0.5 * t) / max(c, 1e-30))), 1.0);
    let positive = (u.x < towards);
    let ux = select(((u.x - towards) / (1.0 - towards)), (u.x / towards), positive);
    let along = select(-t, t, positive);
    let across = math_erf_inverse(clamp(((2.0 * ux) - 1.0), -0.99999994, 0.99999994));
    let mx = ((axis.x * along) - (axis.y * across));
    let my = ((axis.y * along) + (axis.x * across));
    return normalize_or(vec3f((alpha.x * mx), (alpha.y * my), 1.0), vec3f(0.0, 0.0, 1.0));
}

fn beckmann_slope(c: f32, u: f32) -> f32 {
    let near = (c < 5.0);
    let e = select(0.0, math_erfc(c), near);
    let body = (((2.0 * HALF_SQRT_PI) * c) * (1.0 - e));
    let ring = select(0.0, (0.5 * math_exp((-c * c))), near);
    let tail = ((HALF_SQRT_PI * c) * e);
    let v = (u * ((body + ring) + tail));
    if (v < body) {
        return min(math_erf_inverse(min(((v / body) * (1.0 - e)), 0.99999994)), c);
    }
    if (v < (body + ring)) {
        return sqrt(((c * c) - math_log(clamp(((v - body) / ring), 5.9604645e-8, 1.0))));
    }
    let w = clamp((((v - body) - ring) / max(tail, 1e-37)), 5.9604645e-8, 1.0);
    return max(math_erfc_inverse((w * e)), c);
}

fn glossy_keep(wo: vec3f, m: vec3f) -> f32 {
    let flat = ((wo.x * m.x) + (wo.y * m.y));
    let own = max(((wo.z * m.z) + flat), 0.0);
    let sum = (own + max(((wo.z * m.z) - flat), 0.0));
    return select(1.0, (own / sum), (sum > 0.0));
}

struct FacetSample {
    m: vec3f,
    rest: f32
}

fn glossy_sample_facet(lobe: Glossy, wo: vec3f, u: vec2f, uc: f32) -> FacetSample {
    if (lobe.op == OP_GGX_SMITH) {
        let bound = ggx_cap_bound(lobe.ggx, wo);
        return FacetSample(ggx_sample_normal(lobe.ggx.alpha, wo, bound, u), uc);
    }
    if (lobe.op == OP_BECKMANN_SMITH) {
        return FacetSample(beckmann_sample_normal(lobe.ggx.alpha, wo, u), uc);
    }
    let m = facets_sample(lobe.facets, lobe.ggx.alpha, u);
    let keep = glossy_keep(wo, m);
    let kept = (uc < keep);
    let turn = select(-1.0, 1.0, kept);
    let rest = select(((uc - keep) / (1.0 - keep)), (uc / keep), kept);
    return FacetSample(vec3f((turn * m.x), (turn * m.y), m.z), rest);
}

fn glossy_sample(lobe: Glossy, wo: vec3f, u: vec2f, uc: f32) -> LobeSample {
    if (lobe.op == OP_GGX_SMITH) {
        return ggx_sample(lobe.ggx, wo, u, uc);
    }
    return facet_sample(lobe, wo, u, uc);
}

fn facet_sample(lobe: Glossy, wo: vec3f, u: vec2f, uc: f32) -> LobeSample {
    if (wo.z <= 0.0) {
        return lobe_absorb();
    }
    let solid = !lobe.ggx.thin_walled;
    if (((lobe.ggx.mode != MODE_REFLECT) && solid) && (abs((lobe.ggx.eta - 1.0)) < ETA_MATCH)) {
        return LobeSample(vec3f(-wo.x, -wo.y, -wo.z), (EVENT_SPECULAR | EVENT_TRANSMISSION));
    }
    let facet = glossy_sample_facet(lobe, wo, u, uc);
    let wm = facet.m;
    let c = min(dot(wo, wm), 1.0);
    if (c <= 0.0) {
        return lobe_absorb();
    }
    let mirror = ((wm * (2.0 * c)) - wo);
    let reflects = (facet.rest < ggx_reflectance(lobe.ggx, c));
    if (reflects || lobe.ggx.thin_walled) {
        if (mirror.z <= 0.0) {
            return lobe_absorb();
        }
        let turn = select(1.0, -1.0, (lobe.op == OP_BACKSCATTERING));
        let side = select(EVENT_TRANSMISSION, EVENT_REFLECTION, reflects);
        let wi = vec3f((turn * mirror.x), (turn * mirror.y), select(-mirror.z, mirror.z, reflects));
        return LobeSample(normalize_or(wi, vec3f(0.0, 0.0, 1.0)), (EVENT_GLOSSY | side));
    }
    let wi = normalize_or(refract_at(wo, wm, c, lobe.ggx.eta), vec3f(0.0, 0.0, -1.0));
    if (wi.z >= 0.0) {
        return lobe_absorb();
    }
    return LobeSample(wi, (EVENT_GLOSSY | EVENT_TRANSMISSION));
}
const GLOSSY_CELLS: u32 = 16u;

fn glossy_albedo(lobe: Glossy, wo: vec3f) -> f32 {
    if (lobe.op == OP_GGX_SMITH) {
        return ggx_albedo(lobe.ggx, wo);
    }
    if (wo.z <= 0.0) {
        return 0.0;
    }
    let step = (1.0 / f32(GLOSSY_CELLS));
    var sum: f32 = 0.0;
    for (var i = 0u; i < GLOSSY_CELLS; i++) {
        for (var j = 0u; j < GLOSSY_CELLS; j++) {
            let turn = (0.25 + (0.5 * f32((j % 2u))));
            let u = vec2f(((f32(i) + turn) * step), ((f32(j) + 0.5) * step));
            if (lobe.op == OP_BECKMANN_SMITH) {
                sum += glossy_normal_albedo(lobe, wo, beckmann_sample_normal(lobe.ggx.alpha, wo, u));
            } else {
                let m = facets_sample(lobe.facets, lobe.ggx.alpha, u);
                let keep = glossy_keep(wo, m);
                let twin = vec3f(-m.x, -m.y, m.z);
                sum += (keep * glossy_normal_albedo(lobe, wo, m));
                sum += ((1.0 - keep) * glossy_normal_albedo(lobe, wo, twin));
            }
        }
    }
    return unit(((sum * step) * step));
}

fn glossy_normal_albedo(lobe: Glossy, wo: vec3f, wm: vec3f) -> f32 {
    let c = clamp(dot(wo, wm), 1e-7, 1.0);
    let mirror = ((wm * (2.0 * c)) - wo);
    let r = ggx_reflectance(lobe.ggx, c);
    let visible = glossy_visible(lobe, wo, wm.z, c);
    let leaves = glossy_shadowing(lobe, wo, mirror, wm.z, c, c, visible);
    let above = select(0.0, leaves, (mirror.z > 0.0));
    if lobe.ggx.thin_walled {
        return select(above, (r * above), (lobe.ggx.mode == MODE_REFLECT));
    }
    if (r >= 1.0) {
        return above;
    }
    let wt = refract_at(wo, wm, c, lobe.ggx.eta);
    let im = max(-dot(wt, wm), 1e-7);
    let below = select(0.0, glossy_shadowing(lobe, wo, wt, wm.z, c, im, visible), (wt.z < 0.0));
    return ((r * above) + ((1.0 - r) * below));
}
const ANISOTROPIC_SHARE: f32 = 0.33;

fn quintic(
    x: f32,
    c0: f32,
    c1: f32,
    c2: f32,
    c3: f32,
    c4: f32,
    c5: f32,
) -> f32 {
    return (c0 + (x * (c1 + (x * (c2 + (x * (c3 + (x * (c4 + (x * c5))))))))));
}

fn septic(a: vec4f, b: vec4f, x: f32) -> f32 {
    let x2 = (x * x);
    return (x * (cubic(a, x) + ((x2 * x2) * cubic(b, x))));
}

fn loss_kind(lobe: Glossy) -> u32 {
    return (lobe.op | select(0u, FLAG_CORRELATED, lobe.ggx.correlated));
}

fn glossy_loss(op: u32, alpha: f32, mu: f32) -> f32 {
    if (op == OP_GGX_SMITH) {
        return (1.0 - ggx_albedo_reflection(alpha, mu));
    }
    return unit(glossy_loss_fit(op, alpha, (mu / (mu + alpha))));
}

fn glossy_loss_fit(op: u32, alpha: f32, t: f32) -> f32 {
    if (op == OP_BECKMANN_SMITH) {
        return ((quintic(t, cubic(vec4f(0.021866, 0.036548, -0.116330, 0.141893), alpha), cubic(vec4f(0.986037, -1.638502, 6.016981, -6.246905), alpha), cubic(vec4f(-9.069356, 12.080729, -46.312368, 62.466531), alpha), cubic(vec4f(34.629537, -29.873240, 121.822790, -221.238919), alpha), cubic(vec4f(-50.580212, 33.783996, -129.002715, 343.954927), alpha), cubic(vec4f(24.213737, -8.550887, 9.255230, -149.277097), alpha)) * (1.0 - t)) - 0.0119);
    }
    if (op == (OP_BECKMANN_SMITH | FLAG_CORRELATED)) {
        return ((quintic(t, cubic(vec4f(-0.012070, 0.033214, -0.119957, 0.110431), alpha), cubic(vec4f(1.078240, -1.714757, 6.277661, -6.328772), alpha), cubic(vec4f(-9.050296, 12.552000, -47.616779, 63.009265), alpha), cubic(vec4f(34.399414, -30.570156, 123.712075, -220.821026), alpha), cubic(vec4f(-50.402222, 33.792275, -129.260595, 341.172655), alpha), cubic(vec4f(24.192633, -8.218997, 8.715681, -147.494675), alpha)) * (1.0 - t)) - 0.0119);
    }
    if (op == (OP_GGX_SMITH | FLAG_CORRELATED)) {
        return ((quintic(t, cubic(vec4f(-0.002193, -0.003929, 0.019700, -0.009909), alpha), cubic(vec4f(0.389514, 0.276278, 3.602155, -0.153941), alpha), cubic(vec4f(-1.884535, 0.799644, -8.848353, -10.377415), alpha), cubic(vec4f(9.441536, -15.514724, 46.543361, 51.055802), alpha), cubic(vec4f(-13.996536, 36.710452, -59.939266, -145.717144), alpha), cubic(vec4f(6.043220, -22.636623, 10.802714, 146.711971), alpha)) * (1.0 - t)) - 0.0039);
    }
    if (op == OP_GGX_VCAVITIES) {
        return ((quintic(t, cubic(vec4f(0.004576, 0.041367, -0.112244, 0.057583), alpha), cubic(vec4f(-0.210112, -2.435367, 5.088588, -0.941911), alpha), cubic(vec4f(2.703446, 27.413009, -42.366882, 2.242607), alpha), cubic(vec4f(-7.317091, -99.204317, 109.273817, 52.875048), alpha), cubic(vec4f(10.293373, 122.091267, -13.652756, -213.643385), alpha), cubic(vec4f(-5.817452, -44.807848, -69.977269, 184.795958), alpha)) * (1.0 - t)) - 0.0091);
    }
    if (op == OP_BECKMANN_VCAVITIES) {
        return ((quintic(t, cubic(vec4f(-0.010304, 0.026959, -0.098387, 0.091693), alpha), cubic(vec4f(0.890890, -3.064467, 6.620376, -4.568157), alpha), cubic(vec4f(-8.662196, 36.733745, -55.631454, 31.933835), alpha), cubic(vec4f(33.213867, -132.826896, 111.506443, -23.793283), alpha), cubic(vec4f(-47.370721, 174.350391, 30.974288, -131.846028), alpha), cubic(vec4f(22.025890, -68.265414, -160.801484, 204.672060), alpha)) * (1.0 - t)) - 0.0102);
    }
    if (op == OP_WARD) {
        return ((quintic(t, cubic(vec4f(0.001529, 0.002360, 0.000942, -0.000811), alpha), cubic(vec4f(1.880037, -0.201461, 1.570437, -0.017933), alpha), cubic(vec4f(-8.388028, 2.587254, -3.034493, -4.328010), alpha), cubic(vec4f(25.278350, -11.149513, 6.221193, 30.245513), alpha), cubic(vec4f(-33.826014, 16.184907, 25.545393, -95.085965), alpha), cubic(vec4f(15.051414, -4.966080, -48.585016, 104.673753), alpha)) * (1.0 - t)) - 0.0042);
    }
    return ((quintic(t, cubic(vec4f(-0.013516, 0.076712, -0.188384, 0.116670), alpha), cubic(vec4f(1.115230, -9.128073, 20.113239, -10.726370), alpha), cubic(vec4f(-10.869623, 110.646688, -223.222328, 109.119772), alpha), cubic(vec4f(40.455348, -411.078839, 726.252177, -273.870593), alpha), cubic(vec4f(-56.712615, 575.451629, -797.921680, 116.722843), alpha), cubic(vec4f(26.116329, -263.050487, 201.867514, 158.453524), alpha)) * (1.0 - t)) - 0.0132);
}

fn glossy_mean_loss(op: u32, alpha: f32) -> f32 {
    if (op == OP_GGX_SMITH) {
        let root = sqrt(alpha);
        let low = septic(vec4f(0.001421, -0.066154, 0.656688, 3.604301), vec4f(-12.275078, 25.129295, -32.551043, 22.004815), root);
        let square = (alpha * alpha);
        let fit = (low - (((5.881026 * square) * square) * root));
        return select(1.5e-3, fit, (alpha > 0.0158));
    }
    let low = select(select(0.08, 0.055, (op == OP_GGX_VCAVITIES)), 0.035, (op == OP_WARD));
    return select(4e-3, glossy_mean_fit(op, alpha), (alpha > low));
}

fn glossy_mean_fit(op: u32, alpha: f32) -> f32 {
    if (op == OP_BECKMANN_SMITH) {
        return (1.034 * septic(vec4f(0.769377, -9.761946, 48.764537, -121.692648), vec4f(161.355696, -107.091346, 27.982531, 0.000000), sqrt(alpha)));
    }
    if (op == (OP_BECKMANN_SMITH | FLAG_CORRELATED)) {
        return (1.019 * septic(vec4f(0.769040, -9.758975, 48.757141, -121.697163), vec4f(161.374213, -107.100001, 27.974245, 0.000000), sqrt(alpha)));
    }
    if (op == (OP_GGX_SMITH | FLAG_CORRELATED)) {
        return (1.010 * septic(vec4f(0.047996, -0.535666, 1.214514, 6.285924), vec4f(-16.741533, 15.685147, -5.375737, 0.000000), sqrt(alpha)));
    }
    if (op == OP_GGX_VCAVITIES) {
        return (1.050 * septic(vec4f(0.430624, -4.851440, 18.641040, -26.925715), vec4f(12.082475, 6.714142, -5.665598, 0.000000), sqrt(alpha)));
    }
    if (op == OP_BECKMANN_VCAVITIES) {
        return (1.037 * septic(vec4f(0.751290, -10.484129, 57.828211, -160.067098), vec4f(235.237994, -172.937206, 50.003273, 0.000000), sqrt(alpha)));
    }
    if (op == OP_WARD) {
        return (1.028 * septic(vec4f(0.163873, -2.384024, 12.207345, -25.057892), vec4f(28.838545, -17.351150, 4.086057, 0.000000), sqrt(alpha)));
    }
    return (1.037 * septic(vec4f(0.725637, -10.199080, 56.687442, -158.425591), vec4f(235.608495, -175.338975, 51.278755, 0.000000), sqrt(alpha)));
}

fn sheen_albedo(roughness: f32, mu: f32) -> f32 {
    let s = sqrt(sane_alpha(roughness));
    let x = (mu / (mu + s));
    let high = quintic(x, cubic(vec4f(0.182386, -1.750024, 8.450559, -6.139677), s), cubic(vec4f(6.360615, 25.636229, -118.253925, 88.956734), s), cubic(vec4f(-29.597860, -124.794808, 602.452339, -456.201103), s), cubic(vec4f(72.266909, 261.505770, -1370.659008, 1053.828265), s), cubic(vec4f(-76.794117, -252.693863, 1472.390364, -1139.899303), s), cubic(vec4f(28.570965, 93.408071, -607.751661, 459.298155), s));
    return unit(((1.0 - (cubic(vec4f(0.004206, 0.029186, -0.141438, 0.113149), s) + (x * high))) + 0.0061));
}

struct Multiscatter {
    loss: f32,
    inverse_mean: f32,
    reflected: f32,
    transmitted: f32
}

fn lobe_loss(lobe: Glossy, mu: f32) -> f32 {
    let loss = glossy_loss(loss_kind(lobe), lobe.ggx.alpha.x, mu);
    if (lobe.ggx.alpha.x == lobe.ggx.alpha.y) {
        return loss;
    }
    return (ANISOTROPIC_SHARE * min(loss, glossy_loss(loss_kind(lobe), lobe.ggx.alpha.y, mu)));
}

fn multiscatter_new(lobe: Glossy, wo: vec3f) -> Multiscatter {
    let alpha = lobe.ggx.alpha;
    let mode = lobe.ggx.mode;
    var reflected: f32 = 1.0;
    var transmitted: f32 = 0.0;
    if (mode != MODE_REFLECT) {
        reflected = select(0.0, fresnel_dielectric(1.0, lobe.ggx.eta), (mode == MODE_REFLECT_TRANSMIT));
        if lobe.ggx.thin_walled {
            transmitted = (1.0 - reflected);
        }
    }
    var mean_loss: f32 = glossy_mean_loss(loss_kind(lobe), alpha.x);
    if (alpha.x != alpha.y) {
        mean_loss = (ANISOTROPIC_SHARE * min(mean_loss, glossy_mean_loss(loss_kind(lobe), alpha.y)));
    }
    return Multiscatter(lobe_loss(lobe, unit(wo.z)), (1.0 / mean_loss), reflected, transmitted);
}

fn multiscatter_eval(m: Multiscatter, lobe: Glossy, wi: vec3f) -> LobeValue {
    let mu = abs(wi.z);
    let share = select(m.reflected, m.transmitted, (wi.z < 0.0));
    let lambert = (mu * FRAC_1_PI);
    return LobeValue(((((share * m.loss) * lobe_loss(lobe, min(mu, 1.0))) * m.inverse_mean) * lambert), select(0.0, ((share / (m.reflected + m.transmitted)) * lambert), (share > 0.0)));
}

fn multiscatter_single(m: Multiscatter, single: vec3f, multiple: vec3f) -> f32 {
    let a = (max3(single) * (1.0 - m.loss));
    let sum = (a + ((max3(multiple) * m.loss) * (m.reflected + m.transmitted)));
    return select(1.0, (a / sum), (sum > 0.0));
}
struct ShadingPoint {
    geometry_normal: vec3f,
    ior_near: vec3f,
    ior_far: vec3f,
    near: f32,
    far: f32,
    eta: f32,
    flags: u32
}
const POINT_THIN_WALLED: u32 = 1u;
const POINT_INSIDE: u32 = 2u;

fn shading_point(geometry_normal: vec3f, ior_near: vec3f, ior_far: vec3f, flags: u32) -> ShadingPoint {
    let near = mean3(ior_near);
    let far = mean3(ior_far);
    return ShadingPoint(geometry_normal, ior_near, ior_far, near, far, sane_eta((far / near)), flags);
}

fn coating_eta(ior: f32, near: f32, far: f32, flags: u32) -> f32 {
    let inside = ((flags & POINT_INSIDE) != 0u);
    return sane_eta((select(ior, far, inside) / select(near, ior, inside)));
}

fn schlick_curve(normal: vec3f, grazing: vec3f, exponent: f32, c: f32) -> vec3f {
    return unit3((normal + ((grazing - normal) * schlick_weight(c, exponent))));
}

fn f82_curve(
    normal: vec3f,
    grazing: vec3f,
    f82: vec3f,
    exponent: f32,
    c: f32,
) -> vec3f {
    let plain = (normal + ((grazing - normal) * schlick_weight(c, exponent)));
    let at_82 = (normal + ((grazing - normal) * schlick_weight((1.0 / 7.0), exponent)));
    let m = (1.0 - c);
    let m2 = (m * m);
    let bump = ((((17.651384 * c) * m2) * m2) * m2);
    return unit3((plain - ((at_82 * (splat3(1.0) - unit3(f82))) * bump)));
}

fn node_film(n: vec4u, p: ptr<function, Params>) -> Film {
    let slot = film_slot(n);
    return Film(param(p, slot), param3(p, (slot + 1u)));
}

fn film_slot(n: vec4u) -> u32 {
    let op = (n.x & OP_MASK);
    let vector = select(0u, 3u, ((n.x & FLAG_VECTOR) != 0u));
    let color = select(0u, 3u, ((n.x & FLAG_COLOR) != 0u));
    if (op >= OP_WEIGHTED_LAYER) {
        return (layer_normal_slot(n) + vector);
    }
    if (op == OP_FRESNEL_FACTOR) {
        return (n.y + 6u);
    }
    if (op == OP_DIRECTIONAL_FACTOR) {
        return ((n.y + SLOT_FACTOR_F82) + color);
    }
    if (op == OP_SPECULAR) {
        return (n.y + 3u);
    }
    return (((n.y + SLOT_GLOSSY_TANGENT) + vector) + color);
}

fn coating_film(film: Film, ior: vec3f, point: ShadingPoint, c: f32) -> vec3f {
    let inside = ((point.flags & POINT_INSIDE) != 0u);
    let coat = vec3f(sane_ior(ior.x, point.ior_near.x), sane_ior(ior.y, point.ior_near.y), sane_ior(ior.z, point.ior_near.z));
    let near = select(point.ior_near, coat, inside);
    let far = select(coat, point.ior_far, inside);
    return unit3(film_reflectance(film, near, far, splat3(0.0), c));
}

fn mirror_index(r: f32) -> vec2f {
    let root = sqrt(min(r, 0.2));
    let dielectric = ((1.0 + root) / (1.0 - root));
    if (r <= 0.2) {
        return vec2f(dielectric, 0.0);
    }
    let most = min(r, 0.999);
    let n = (dielectric + ((1.0 - dielectric) * unit(((most - 0.2) / 0.3))));
    let k2 = (((((n + 1.0) * (n + 1.0)) * most) - ((n - 1.0) * (n - 1.0))) / (1.0 - most));
    return vec2f(n, sqrt(max(k2, 0.0)));
}

fn filmed_curve(
    film: Film,
    plain: vec3f,
    front: vec3f,
    near: vec3f,
    c: f32,
) -> vec3f {
    let x = mirror_index(front.x);
    let y = mirror_index(front.y);
    let z = mirror_index(front.z);
    let n = (vec3f(x.x, y.x, z.x) * near);
    let k = (vec3f(x.y, y.y, z.y) * near);
    let bare = film_reflectance(Film(0.0, film.ior), near, n, k, c);
    return unit3(((plain + film_reflectance(film, near, n, k, c)) - bare));
}

fn measured_curve(p: ptr<function, Params>, slot: u32, count: u32, c: f32) -> vec3f {
    if (count == 0u) {
        return splat3(0.0);
    }
    let x = ((math_acos(unit(c)) * (2.0 * FRAC_1_PI)) * f32((count - 1u)));
    let first = min(u32(x), (count - 1u));
    let second = min((first + 1u), (count - 1u));
    let t = (x - f32(first));
    return ((unit3(param3(p, (slot + (3u * first)))) * (1.0 - t)) + (unit3(param3(p, (slot + (3u * second)))) * t));
}

fn measured_most(p: ptr<function, Params>, slot: u32, count: u32, c: f32) -> vec3f {
    var most: vec3f = measured_curve(p, slot, count, c);
    let x = ((math_acos(unit(c)) * (2.0 * FRAC_1_PI)) * f32((max(count, 1u) - 1u)));
    for (var i = 0u; i < count; i++) {
        if (f32(i) <= x) {
            most = max(most, unit3(param3(p, (slot + (3u * i)))));
        }
    }
    return most;
}

struct LayerCurve {
    seen: vec3f,
    half: vec3f,
    most: vec3f
}

fn color_coating_eta(ior: vec3f, point: ShadingPoint) -> vec3f {
    return vec3f(coating_eta(ior.x, point.ior_near.x, point.ior_far.x, point.flags), coating_eta(ior.y, point.ior_near.y, point.ior_far.y, point.flags), coating_eta(ior.z, point.ior_near.z, point.ior_far.z, point.flags));
}

fn color_fresnel(c: f32, eta: vec3f) -> vec3f {
    return vec3f(fresnel_dielectric(c, eta.x), fresnel_dielectric(c, eta.y), fresnel_dielectric(c, eta.z));
}

fn node_schlick(
    n: vec4u,
    p: ptr<function, Params>,
    near: vec3f,
    slot: u32,
    c: f32,
) -> vec3f {
    let plain = node_schlick_bare(n, p, slot, c);
    if ((n.x & FLAG_FILM) != 0u) {
        return filmed_curve(node_film(n, p), plain, unit3(param3(p, slot)), near, c);
    }
    return plain;
}

fn node_schlick_bare(n: vec4u, p: ptr<function, Params>, slot: u32, c: f32) -> vec3f {
    let normal = param3(p, slot);
    let grazing = param3(p, (slot + 3u));
    let exponent = param(p, (slot + 6u));
    if ((n.x & FLAG_COLOR) != 0u) {
        return f82_curve(normal, grazing, param3(p, (slot + 7u)), exponent, c);
    }
    return schlick_curve(normal, grazing, exponent, c);
}

fn layer_value(n: vec4u, p: ptr<function, Params>, point: ShadingPoint, c: f32) -> vec3f {
    let op = (n.x & OP_MASK);
    let slot = (n.y + SLOT_LAYER_CURVE);
    if (op == OP_FRESNEL_LAYER) {
        return splat3(fresnel_dielectric(c, coating_eta(param(p, slot), point.near, point.far, point.flags)));
    }
    if (op == OP_COLOR_FRESNEL_LAYER) {
        if ((n.x & FLAG_FILM) != 0u) {
            return coating_film(node_film(n, p), param3(p, slot), point, c);
        }
        return color_fresnel(c, color_coating_eta(param3(p, slot), point));
    }
    if (op == OP_CUSTOM_CURVE_LAYER) {
        return node_schlick(n, p, point.ior_near, slot, c);
    }
    if (op == OP_MEASURED_LAYER) {
        return measured_curve(p, slot, n.w, c);
    }
    if (op == OP_SHEEN_LAYER) {
        return splat3(sheen_albedo(param(p, slot), c));
    }
    if (op == OP_MICROFLAKE_LAYER) {
        return splat3(microflake_albedo(param(p, slot), c));
    }
    return splat3(1.0);
}

fn layer_seen(n: vec4u, p: ptr<function, Params>, point: ShadingPoint, c: f32) -> vec3f {
    return (unit3(param3(p, (n.y + SLOT_LAYER_WEIGHT))) * layer_value(n, p, point, c));
}

fn layer_curve(
    n: vec4u,
    p: ptr<function, Params>,
    point: ShadingPoint,
    seen: f32,
    lit: f32,
    half: f32,
) -> LayerCurve {
    let op = (n.x & OP_MASK);
    let weight = unit3(param3(p, (n.y + SLOT_LAYER_WEIGHT)));
    let slot = (n.y + SLOT_LAYER_CURVE);
    if (op == OP_FRESNEL_LAYER) {
        let eta = coating_eta(param(p, slot), point.near, point.far, point.flags);
        let at_seen = fresnel_dielectric(seen, eta);
        return LayerCurve((weight * at_seen), (weight * fresnel_dielectric(half, eta)), (weight * max(at_seen, fresnel_dielectric(lit, eta))));
    }
    let at_seen = (weight * layer_value(n, p, point, seen));
    let most = max(at_seen, (weight * layer_value(n, p, point, lit)));
    if ((op == OP_SHEEN_LAYER) || (op == OP_MICROFLAKE_LAYER)) {
        return LayerCurve(at_seen, weight, most);
    }
    let at_half = (weight * layer_value(n, p, point, half));
    var front: vec3f = splat3(0.0);
    if ((n.x & FLAG_FILM) != 0u) {
        front = max(at_half, (weight * layer_value(n, p, point, 1.0)));
    } else if (op == OP_CUSTOM_CURVE_LAYER) {
        front = (weight * unit3(param3(p, slot)));
    } else if (op == OP_MEASURED_LAYER) {
        front = (weight * measured_most(p, slot, n.w, min(seen, lit)));
    }
    return LayerCurve(at_seen, at_half, max(most, front));
}

fn layer_normal_slot(n: vec4u) -> u32 {
    let op = (n.x & OP_MASK);
    let slot = (n.y + SLOT_LAYER_CURVE);
    if (((op == OP_FRESNEL_LAYER) || (op == OP_SHEEN_LAYER)) || (op == OP_MICROFLAKE_LAYER)) {
        return (slot + 1u);
    }
    if (op == OP_COLOR_FRESNEL_LAYER) {
        return (slot + 3u);
    }
    if (op == OP_MEASURED_LAYER) {
        return (slot + (3u * n.w));
    }
    if (op == OP_CUSTOM_CURVE_LAYER) {
        return (slot + select(7u, 10u, ((n.x & FLAG_COLOR) != 0u)));
    }
    return slot;
}
const CONSERVE_ENTRIES: u32 = 17u;

fn conserve_slot(n: vec4u) -> u32 {
    return (film_slot(n) + select(0u, 4u, ((n.x & FLAG_FILM) != 0u)));
}

fn layer_conserves(n: vec4u, p: ptr<function, Params>, point: ShadingPoint) -> bool {
    if ((((n.x & FLAG_CONSERVING) == 0u) || ((point.flags & POINT_INSIDE) != 0u)) || (point.near != 1.0)) {
        return false;
    }
    return (param(p, conserve_slot(n)) >= 0.0);
}

fn layer_albedo(n: vec4u, p: ptr<function, Params>, c: f32) -> vec3f {
    let x = (sqrt(c) * f32((CONSERVE_ENTRIES - 1u)));
    let first = min(u32(x), (CONSERVE_ENTRIES - 2u));
    let t = (x - f32(first));
    let table = conserve_slot(n);
    let a = param3(p, (table + (3u * select((max(first, 1u) - 1u), 1u, (first == 0u)))));
    let b = param3(p, (table + (3u * first)));
    let after = param3(p, ((table + (3u * first)) + 3u));
    var last: vec3f = ((after * 2.0) - b);
    if ((first + 2u) < CONSERVE_ENTRIES) {
        last = param3(p, ((table + (3u * first)) + 6u));
    }
    let curve = ((((last - a) + ((b - after) * 3.0)) * t) + ((((a * 2.0) - (b * 5.0)) + (after * 4.0)) - last));
    return unit3((b + ((((curve * t) + after) - a) * (0.5 * t))));
}
const NO_SLOT: u32 = 4294967295u;
const OPAQUE: f32 = 80.0;

fn normal_at(p: ptr<function, Params>, slot: u32) -> vec3f {
    let up = vec3f(0.0, 0.0, 1.0);
    if (slot == NO_SLOT) {
        return up;
    }
    let own = normalize_or(param3(p, slot), up);
    return (own * select(-1.0, 1.0, (own.z >= 0.0)));
}

fn modifier_factor(
    n: vec4u,
    p: ptr<function, Params>,
    point: ShadingPoint,
    normal: u32,
    wo: vec3f,
    wi: vec3f,
    transmits: bool,
) -> vec3f {
    let op = (n.x & OP_MASK);
    if (op == OP_TINT) {
        let second = (transmits && ((n.x & FLAG_COLOR) != 0u));
        return unit3(param3(p, (n.y + select(SLOT_TINT, SLOT_TINT_TRANSMISSION, second))));
    }
    if (op == OP_SCALE) {
        let s = param3(p, (n.y + SLOT_TINT));
        return vec3f(nonnegative(s.x), nonnegative(s.y), nonnegative(s.z));
    }
    let z = normal_at(p, normal);
    let no = dot(z, wo);
    let ni = dot(z, wi);
    if (op == OP_COAT_ABSORPTION) {
        return node_coat_absorption(n, p, point, unit(abs(no)), unit(abs(ni)), transmits);
    }
    let c = half_cosine(no, ni, dot(wo, wi));
    if (op == OP_MEASURED_FACTOR) {
        return measured_curve(p, n.y, n.w, c);
    }
    if (op == OP_FRESNEL_FACTOR) {
        return node_fresnel_factor(n, p, point, c);
    }
    return node_schlick(n, p, point.ior_near, (n.y + SLOT_TINT), c);
}

fn node_fresnel_factor(n: vec4u, p: ptr<function, Params>, point: ShadingPoint, c: f32) -> vec3f {
    let near = select(point.ior_near, point.ior_far, ((point.flags & POINT_INSIDE) != 0u));
    let ior = param3(p, n.y);
    let k = param3(p, (n.y + SLOT_FACTOR_EXTINCTION));
    let real = vec3f(sane_ior(ior.x, near.x), sane_ior(ior.y, near.y), sane_ior(ior.z, near.z));
    let imaginary = vec3f(sane_ior(k.x, 0.0), sane_ior(k.y, 0.0), sane_ior(k.z, 0.0));
    if ((n.x & FLAG_FILM) != 0u) {
        return unit3(film_reflectance(node_film(n, p), near, real, imaginary, c));
    }
    return film_reflectance(Film(0.0, near), near, real, imaginary, c);
}

fn coat_path(ior: f32, side: f32, c: f32) -> f32 {
    let ratio = (side / ior);
    return (1.0 / sqrt(max((1.0 - (((1.0 - c) * (1.0 + c)) * (ratio * ratio))), 1e-12)));
}

fn node_coat_absorption(
    n: vec4u,
    p: ptr<function, Params>,
    point: ShadingPoint,
    co: f32,
    ci: f32,
    transmits: bool,
) -> vec3f {
    let ior = param3(p, n.y);
    let coefficient = param3(p, (n.y + SLOT_COAT_ABSORPTION));
    let depth = (nonnegative(param(p, (n.y + SLOT_COAT_THICKNESS))) * select(1.0, 0.5, transmits));
    let near = point.ior_near;
    let far = select(point.ior_near, point.ior_far, transmits);
    let rx = sane_ior(ior.x, near.x);
    let ry = sane_ior(ior.y, near.y);
    let rz = sane_ior(ior.z, near.z);
    return vec3f(coat_transmittance(coefficient.x, depth, (coat_path(rx, near.x, co) + coat_path(rx, far.x, ci))), coat_transmittance(coefficient.y, depth, (coat_path(ry, near.y, co) + coat_path(ry, far.y, ci))), coat_transmittance(coefficient.z, depth, (coat_path(rz, near.z, co) + coat_path(rz, far.z, ci))));
}

fn coat_transmittance(coefficient: f32, depth: f32, slant: f32) -> f32 {
    return math_exp(-min(((nonnegative(coefficient) * depth) * slant), OPAQUE));
}
const FUJII_LOSS: f32 = 0.2877934;
const FUJII_MEAN: f32 = 0.07248821;

struct DiffuseReflection {
    roughness: f32,
    a: f32,
    b: f32
}

struct DiffuseValue {
    single: f32,
    multiple: f32,
    pdf: f32
}

fn diffuse_reflection_new(roughness: f32) -> DiffuseReflection {
    let r = unit(roughness);
    let a = (1.0 / (1.0 + (FUJII_LOSS * r)));
    return DiffuseReflection(r, a, (a * r));
}

fn diffuse_reflection_eval(lobe: DiffuseReflection, wo: vec3f, wi: vec3f) -> DiffuseValue {
    if ((wo.z <= 0.0) || (wi.z <= 0.0)) {
        return DiffuseValue(0.0, 0.0, 0.0);
    }
    let lambert = (wi.z * FRAC_1_PI);
    if (lobe.roughness == 0.0) {
        return DiffuseValue(lambert, 0.0, lambert);
    }
    let s = (dot(wo, wi) - (wo.z * wi.z));
    let t = select(1.0, max(wo.z, wi.z), (s > 0.0));
    return DiffuseValue(((lobe.a + ((lobe.b * s) / t)) * lambert), ((((lobe.b * fujii_missing(wo.z)) * fujii_missing(wi.z)) / (FUJII_LOSS - FUJII_MEAN)) * lambert), lambert);
}

fn diffuse_reflection_sample(u: vec2f) -> LobeSample {
    let wi = sample_cosine_hemisphere(u);
    if (wi.z <= 0.0) {
        return lobe_absorb();
    }
    return LobeSample(wi, (EVENT_DIFFUSE | EVENT_REFLECTION));
}

fn fujii_missing(mu: f32) -> f32 {
    let c = unit(mu);
    let s = sqrt(((1.0 - c) * (1.0 + c)));
    let theta = math_acos(c);
    let g = ((s * (theta - (s * c))) + ((2.0 / 3.0) * ((((s * c) * ((1.0 + s) + (s * s))) / (1.0 + s)) - s)));
    return max((FUJII_LOSS - (g * FRAC_1_PI)), 0.0);
}

fn diffuse_reflection_albedo(lobe: DiffuseReflection, mu: f32) -> f32 {
    return (1.0 - (lobe.b * fujii_missing(mu)));
}
fn diffuse_transmission_eval(wo: vec3f, wi: vec3f) -> LobeValue {
    if ((wo.z <= 0.0) || (wi.z >= 0.0)) {
        return lobe_zero();
    }
    let lambert = (-wi.z * FRAC_1_PI);
    return LobeValue(lambert, lambert);
}

fn diffuse_transmission_sample(u: vec2f) -> LobeSample {
    let wi = sample_cosine_hemisphere(u);
    if (wi.z <= 0.0) {
        return lobe_absorb();
    }
    return LobeSample(vec3f(wi.x, wi.y, -wi.z), (EVENT_DIFFUSE | EVENT_TRANSMISSION));
}
const DUST_BACKWARD: f32 = 0.44444445;
const DUST_RISE: f32 = 0.7222222;
const DUST_FIRST_MEAN: f32 = 0.32550111;
const DUST_SINGLE_MEAN: f32 = 0.30981506;

struct Dust {
    c: f32,
    gamma: f32,
    inverse_mean: f32
}

fn dust_new(k: f32) -> Dust {
    let rest = (1.0 - unit(k));
    let c = unit(((1.0 - math_pow(rest, 2.73556)) / (1.0 - (0.184096 * math_pow(rest, 2.48423)))));
    let gamma = sqrt(((1.0 - c) / (1.0 + (DUST_BACKWARD * c))));
    let low = (0.11270167 / (1.0 + (0.22540333 * gamma)));
    let middle = (0.5 / (1.0 + gamma));
    let high = (0.88729833 / (1.0 + (1.7745967 * gamma)));
    let whole = (((1.0 - gamma) * ((10.0 * (low + high)) + (16.0 * middle))) * (1.0 / 18.0));
    let mean = (whole - (c * (DUST_FIRST_MEAN + (c * (DUST_SINGLE_MEAN - DUST_FIRST_MEAN)))));
    return Dust(c, gamma, select(0.0, (1.0 / mean), (mean > 1e-7)));
}

fn dust_single(mu: f32) -> f32 {
    let m = max(mu, 1e-7);
    let isotropic = (0.5 * (1.0 - (m * math_log((1.0 + (1.0 / m))))));
    let fit = (0.999174 + (m * (0.571997 + (m * (0.769161 + (m * ((0.33139 * m) - 0.772553)))))));
    return (isotropic * fit);
}

fn dust_multiple(dust: Dust, mu: f32, single: f32) -> f32 {
    let first = (DUST_RISE / (1.0 + (2.0 * mu)));
    let whole = ((1.0 - dust.gamma) / (1.0 + ((2.0 * dust.gamma) * mu)));
    return max((whole - (dust.c * (first + (dust.c * (single - first))))), 0.0);
}

fn dust_phase(u: f32) -> f32 {
    let c = clamp(u, -1.0, 1.0);
    let s = sqrt(((1.0 - c) * (1.0 + c)));
    return ((((2.0 / 3.0) * FRAC_1_PI) * FRAC_1_PI) * (s - (c * math_acos(c))));
}

fn dust_value(
    dust: Dust,
    once: f32,
    zo: f32,
    zi: f32,
    so: f32,
    si: f32,
) -> f32 {
    let multiple = ((dust_multiple(dust, zo, so) * dust_multiple(dust, zi, si)) * dust.inverse_mean);
    return (((dust.c * once) + (multiple * FRAC_1_PI)) * zi);
}

fn dusty_diffuse_eval(k: vec3f, wo: vec3f, wi: vec3f) -> vec3f {
    if ((wo.z <= 0.0) || (wi.z <= 0.0)) {
        return splat3(0.0);
    }
    let once = (dust_phase(-dot(wo, wi)) / (wo.z + wi.z));
    let so = dust_single(wo.z);
    let si = dust_single(wi.z);
    return vec3f(dust_value(dust_new(k.x), once, wo.z, wi.z, so, si), dust_value(dust_new(k.y), once, wo.z, wi.z, so, si), dust_value(dust_new(k.z), once, wo.z, wi.z, so, si));
}

fn dust_albedo(k: f32, mu: f32) -> f32 {
    let dust = dust_new(k);
    let single = dust_single(mu);
    return unit(((dust.c * single) + select(0.0, dust_multiple(dust, mu, single), (dust.inverse_mean > 0.0))));
}

fn dusty_diffuse_albedo(k: vec3f, mu: f32) -> vec3f {
    return vec3f(dust_albedo(k.x, mu), dust_albedo(k.y, mu), dust_albedo(k.z, mu));
}
const MEASURED_REFLECTION: u32 = 0u;
const MEASURED_TRANSMISSION: u32 = 1u;
const MEASURED_STEPS: f32 = 16777216.0;

struct Measured {
    table: u32,
    first: u32,
    theta: u32,
    phi: u32,
    below: u32,
    above: u32,
    between: f32,
    axis: vec2f,
    albedo: vec3f,
    even: f32
}

struct MeasuredValue {
    f: vec3f,
    density: f32
}

struct MeasuredCell {
    i0: u32,
    i1: u32,
    k0: u32,
    k1: u32
}

fn measured_scale(program: ptr<function, Program>, table: u32, mode: u32, multiplier: f32) -> f32 {
    let most = table_record(program, table, 0u);
    let bound = select(select(most.z, most.y, (mode == MODE_TRANSMIT)), most.x, (mode == MODE_REFLECT));
    if (bound <= 0.0) {
        return 0.0;
    }
    return min(nonnegative(multiplier), (1.0 / bound));
}

fn measured_angle(w: vec3f, theta: u32) -> f32 {
    return ((math_atan2(sqrt(((w.x * w.x) + (w.y * w.y))), abs(w.z)) * (2.0 * FRAC_1_PI)) * f32(theta));
}

fn measured_new(program: ptr<function, Program>, table: u32, side: u32, wo: vec3f) -> Measured {
    let part = table_record(program, table, (1u + side));
    let theta = u32(part.y);
    let axis = normalize_or(vec3f(wo.x, wo.y, 0.0), vec3f(1.0, 0.0, 0.0));
    var m: Measured = Measured(table, u32(part.x), theta, u32(part.z), 0u, 0u, 0.0, axis.xy, splat3(0.0), 1.0);
    if (theta == 0) {
        return m;
    }
    let x = clamp((measured_angle(wo, theta) - 0.5), 0.0, f32((theta - 1)));
    m.below = min(u32(x), (theta - 1u));
    m.above = min((m.below + 1u), (theta - 1u));
    m.between = (x - f32(m.below));
    let a = table_record(program, table, measured_bucket(m, m.below));
    let b = table_record(program, table, measured_bucket(m, m.above));
    let mixed = ((a * (1.0 - m.between)) + (b * m.between));
    m.albedo = mixed.xyz;
    m.even = mixed.w;
    return m;
}

fn measured_bucket(m: Measured, o: u32) -> u32 {
    return (((m.first + m.theta) + 1u) + o);
}

fn measured_texel(m: Measured, o: u32, i: u32, k: u32) -> u32 {
    return ((((m.first + (2u * m.theta)) + 1u) + (((o * m.theta) + i) * m.phi)) + k);
}

fn measured_alias(m: Measured, o: u32, cell: u32) -> u32 {
    let cells = ((m.theta + 1u) * (m.phi + 1u));
    return (((((m.first + (2u * m.theta)) + 1u) + ((m.theta * m.theta) * m.phi)) + (o * ((cells + 1u) / 2u))) + (cell / 2u));
}

fn measured_cell(m: Measured, row: u32, column: u32) -> MeasuredCell {
    return MeasuredCell((max(row, 1u) - 1u), min(row, (m.theta - 1u)), (max(column, 1u) - 1u), min(column, (m.phi - 1u)));
}

fn measured_eval(program: ptr<function, Program>, m: Measured, wi: vec3f) -> MeasuredValue {
    let x = (measured_angle(wi, m.theta) + 0.5);
    let row = min(u32(x), m.theta);
    let bounds = table_record(program, m.table, (m.first + row));
    let by_angle = unit((x - f32(row)));
    let by_square = unit(((((wi.x * wi.x) + (wi.y * wi.y)) - bounds.x) * bounds.z));
    let along = ((m.axis.x * wi.x) + (m.axis.y * wi.y));
    let across = abs(((m.axis.x * wi.y) - (m.axis.y * wi.x)));
    let y = ((math_atan2(across, along) * (FRAC_1_PI * f32(m.phi))) + 0.5);
    let column = min(u32(y), m.phi);
    let by_turn = unit((y - f32(column)));
    let cell = measured_cell(m, row, column);
    let a = measured_pair(program, m, cell.i0, cell.k0, cell.k1, by_turn);
    let b = measured_pair(program, m, cell.i1, cell.k0, cell.k1, by_turn);
    let f = ((a.xyz * (1.0 - by_angle)) + (b.xyz * by_angle));
    let peaked = ((a.w * (1.0 - by_square)) + (b.w * by_square));
    return MeasuredValue(f, ((m.even * FRAC_1_PI) + peaked));
}

fn measured_pair(
    program: ptr<function, Program>,
    m: Measured,
    i: u32,
    k0: u32,
    k1: u32,
    t: f32,
) -> vec4f {
    let a = table_record(program, m.table, measured_texel(m, m.below, i, k0));
    let b = table_record(program, m.table, measured_texel(m, m.below, i, k1));
    let c = table_record(program, m.table, measured_texel(m, m.above, i, k0));
    let d = table_record(program, m.table, measured_texel(m, m.above, i, k1));
    return ((((a * (1.0 - t)) + (b * t)) * (1.0 - m.between)) + (((c * (1.0 - t)) + (d * t)) * m.between));
}

fn measured_column(x: u32, n: u32) -> u32 {
    return ((((x >> 12u) * n) + (((x & 4095u) * n) >> 12u)) >> 12u);
}

fn measured_rest(x: u32, n: u32) -> f32 {
    return ((f32(((x * n) & 16777215u)) + 0.5) * (1.0 / MEASURED_STEPS));
}

fn measured_integer(u: f32) -> u32 {
    return min(u32((u * MEASURED_STEPS)), 16777215u);
}

fn measured_slope(u: f32, a: f32, b: f32) -> f32 {
    let root = (a + sqrt((((a * a) * (1.0 - u)) + ((b * b) * u))));
    if (root <= 0.0) {
        return u;
    }
    return min(((u * (a + b)) / root), 1.0);
}

fn measured_sample(program: ptr<function, Program>, m: Measured, u: vec3f) -> vec3f {
    var uz: f32 = u.z;
    let upper = (uz < m.between);
    uz = reuse_random(uz, m.between, upper);
    let o = select(m.below, m.above, upper);
    let bucket = table_record(program, m.table, measured_bucket(m, o));
    let even = (uz < bucket.w);
    uz = reuse_random(uz, bucket.w, even);
    if even {
        return sample_cosine_hemisphere(u.xy);
    }
    return measured_sample_peak(program, m, o, vec3f(u.x, u.y, uz));
}

fn measured_sample_peak(program: ptr<function, Program>, m: Measured, o: u32, u: vec3f) -> vec3f {
    let columns = (m.phi + 1u);
    let x = measured_integer(u.x);
    let whole = measured_integer(u.y);
    let y = ((whole << 1u) & 16777215u);
    let chosen = ((measured_column(x, (m.theta + 1u)) * columns) + measured_column(y, columns));
    let pair = table_record(program, m.table, measured_alias(m, o, chosen));
    let odd = ((chosen & 1u) != 0u);
    let keep = (u.z < select(pair.x, pair.z, odd));
    let other = u32(select(pair.y, pair.w, odd));
    let index = select(other, chosen, keep);
    let row = (index / columns);
    let column = (index - (row * columns));
    let cell = measured_cell(m, row, column);
    let a = table_record(program, m.table, measured_texel(m, o, cell.i0, cell.k0)).w;
    let b = table_record(program, m.table, measured_texel(m, o, cell.i0, cell.k1)).w;
    let c = table_record(program, m.table, measured_texel(m, o, cell.i1, cell.k0)).w;
    let d = table_record(program, m.table, measured_texel(m, o, cell.i1, cell.k1)).w;
    let s = measured_slope(measured_rest(x, (m.theta + 1u)), (a + b), (c + d));
    let t = measured_slope(measured_rest(y, columns), ((a * (1.0 - s)) + (c * s)), ((b * (1.0 - s)) + (d * s)));
    let bounds = table_record(program, m.table, (m.first + row));
    let square = (bounds.x + (bounds.y * s));
    let low = max((f32(column) - 0.5), 0.0);
    let high = min((f32(column) + 0.5), f32(m.phi));
    let turn = math_sincos(((low + ((high - low) * t)) * (PI / f32(m.phi))));
    let along = (turn.y * sqrt(square));
    let across = ((turn.x * sqrt(square)) * select(-1.0, 1.0, (whole >= 8388608u)));
    return vec3f(((m.axis.x * along) - (m.axis.y * across)), ((m.axis.y * along) + (m.axis.x * across)), sqrt(max((1.0 - square), 0.0)));
}

fn measured_reflects(reflection: Measured, transmission: Measured, mode: u32) -> f32 {
    let r = select(mean3(reflection.albedo), 0.0, (mode == MODE_TRANSMIT));
    let t = select(mean3(transmission.albedo), 0.0, (mode == MODE_REFLECT));
    if ((r + t) <= 0.0) {
        return 1.0;
    }
    return (r / (r + t));
}

fn node_measured_eval(
    program: ptr<function, Program>,
    n: vec4u,
    p: ptr<function, Params>,
    wo: vec3f,
    wi: vec3f,
) -> MeasuredValue {
    let nothing = MeasuredValue(splat3(0.0), 0.0);
    let table = node_measured_table(n, p);
    let side = select(MEASURED_REFLECTION, MEASURED_TRANSMISSION, (wi.z < 0.0));
    let other = (MEASURED_TRANSMISSION - side);
    if ((wo.z <= 0.0) || (n.w == select(MODE_REFLECT, MODE_TRANSMIT, (wi.z >= 0.0)))) {
        return nothing;
    }
    let m = measured_new(program, table, side, wo);
    if (m.theta == 0u) {
        return nothing;
    }
    var share: f32 = 1.0;
    if (n.w == MODE_REFLECT_TRANSMIT) {
        let back = measured_new(program, table, other, wo);
        let own = mean3(m.albedo);
        let sum = (own + mean3(back.albedo));
        share = select(select(0.0, 1.0, (side == MEASURED_REFLECTION)), (own / sum), (sum > 0.0));
    }
    let v = measured_eval(program, m, wi);
    let scale = measured_scale(program, table, n.w, param(p, (n.y + SLOT_TINT)));
    let cosine = abs(wi.z);
    return MeasuredValue((v.f * (scale * cosine)), ((share * v.density) * cosine));
}

fn node_measured_sample(
    program: ptr<function, Program>,
    n: vec4u,
    p: ptr<function, Params>,
    wo: vec3f,
    u: vec3f,
) -> LobeSample {
    let table = node_measured_table(n, p);
    let reflection = measured_new(program, table, MEASURED_REFLECTION, wo);
    let transmission = measured_new(program, table, MEASURED_TRANSMISSION, wo);
    let prob = measured_reflects(reflection, transmission, n.w);
    let reflects = (u.z < prob);
    let uz = reuse_random(u.z, prob, reflects);
    var m: Measured = reflection;
    if !reflects {
        m = transmission;
    }
    if ((m.theta == 0u) || (reflects && (n.w == MODE_TRANSMIT))) {
        return lobe_absorb();
    }
    let w = measured_sample(program, m, vec3f(u.x, u.y, uz));
    if (w.z <= 0.0) {
        return lobe_absorb();
    }
    let side = select(EVENT_TRANSMISSION, EVENT_REFLECTION, reflects);
    return LobeSample(vec3f(w.x, w.y, select(-w.z, w.z, reflects)), (EVENT_GLOSSY | side));
}

fn node_measured_albedo(program: ptr<function, Program>, n: vec4u, p: ptr<function, Params>, wo: vec3f) -> vec3f {
    let table = node_measured_table(n, p);
    var sum: vec3f = splat3(0.0);
    if (n.w != MODE_TRANSMIT) {
        sum += measured_new(program, table, MEASURED_REFLECTION, wo).albedo;
    }
    if (n.w != MODE_REFLECT) {
        sum += measured_new(program, table, MEASURED_TRANSMISSION, wo).albedo;
    }
    return unit3((sum * measured_scale(program, table, n.w, param(p, (n.y + SLOT_TINT)))));
}

fn node_measured_table(n: vec4u, p: ptr<function, Params>) -> u32 {
    return table_number(param(p, (n.y + SLOT_MEASURED_TABLE)));
}

fn table_number(x: f32) -> u32 {
    if ((x >= 0.0) && (x < MEASURED_STEPS)) {
        return u32(x);
    }
    return 4294967295u;
}
fn facet_cosine(no: f32, ni: f32, c: f32) -> f32 {
    return unit(((0.5 * (abs(no) + abs(ni))) / max(c, 1e-20)));
}

fn picture_place(c: f32, count: u32) -> vec3f {
    let x = clamp((((math_acos(unit(c)) * (2.0 * FRAC_1_PI)) * f32(count)) - 0.5), 0.0, f32((count - 1u)));
    let first = floor(x);
    return vec3f(first, min((first + 1.0), f32((count - 1u))), (x - first));
}

fn node_picture_factor(
    program: ptr<function, Program>,
    n: vec4u,
    p: ptr<function, Params>,
    normal: u32,
    wo: vec3f,
    wi: vec3f,
) -> vec3f {
    let z = normal_at(p, normal);
    let no = dot(z, wo);
    let ni = dot(z, wi);
    let difference = half_cosine(no, ni, dot(wo, wi));
    let half = facet_cosine(no, ni, difference);
    let table = table_number(param(p, n.y));
    let size = table_record(program, table, 0u);
    let columns = u32(size.x);
    if (columns == 0) {
        return splat3(0.0);
    }
    let x = picture_place(half, columns);
    let y = picture_place(difference, u32(size.y));
    let low = (1 + (u32(y.x) * columns));
    let high = (1 + (u32(y.y) * columns));
    let a = table_record(program, table, (low + u32(x.x))).xyz;
    let b = table_record(program, table, (low + u32(x.y))).xyz;
    let c = table_record(program, table, (high + u32(x.x))).xyz;
    let d = table_record(program, table, (high + u32(x.y))).xyz;
    let near = ((a * (1.0 - x.z)) + (b * x.z));
    let far = ((c * (1.0 - x.z)) + (d * x.z));
    return unit3(((near * (1.0 - y.z)) + (far * y.z)));
}
struct BsdfValue {
    diffuse: vec3f,
    glossy: vec3f,
    pdf: f32,
    specular: vec3f
}

struct LeafValue {
    f: vec3f,
    pdf: f32
}

struct BsdfSample {
    wi: vec3f,
    pdf: f32,
    weight: vec3f,
    event: u32
}

struct BsdfScatter {
    sample: BsdfSample,
    value: BsdfValue
}

struct Visit {
    node: u32,
    weight: vec3f,
    prob: f32,
    normal: u32
}

struct LayerSplit {
    layer: vec3f,
    base: vec3f,
    prob: f32
}
const NO_NODE: u32 = 4294967295u;
const LAYER_FLOOR: f32 = 0.04;

fn layer_child(n: vec4u, index: u32) -> u32 {
    return select((index + 1u), n.z, ((n.x & FLAG_BASE_FIRST) != 0u));
}

fn base_child(n: vec4u, index: u32) -> u32 {
    return select(n.z, (index + 1u), ((n.x & FLAG_BASE_FIRST) != 0u));
}

fn visit_root() -> Visit {
    return Visit(0u, splat3(1.0), 1.0, NO_SLOT);
}

struct Fork {
    now: Visit,
    later: Visit
}

fn visit_fork(n: vec4u, visit: Visit, own: u32, split: LayerSplit) -> Fork {
    let layer = Visit(layer_child(n, visit.node), (visit.weight * split.layer), (visit.prob * split.prob), own);
    let base = Visit(base_child(n, visit.node), (visit.weight * split.base), (visit.prob * (1.0 - split.prob)), visit.normal);
    if ((n.x & FLAG_BASE_FIRST) != 0u) {
        return Fork(base, layer);
    }
    return Fork(layer, base);
}

fn layer_normal(n: vec4u, inherited: u32) -> u32 {
    if ((n.x & FLAG_VECTOR) == 0u) {
        return inherited;
    }
    return layer_normal_slot(n);
}

fn layer_probability(n: vec4u, p: ptr<function, Params>, curve: vec3f) -> f32 {
    let weight = mean3(unit3(param3(p, (n.y + SLOT_LAYER_WEIGHT))));
    let m = max(mean3(curve), (LAYER_FLOOR * weight));
    let layer = (m * param(p, (n.y + SLOT_LAYER_IMPORTANCE)));
    let base = ((1.0 - m) * param(p, ((n.y + SLOT_LAYER_IMPORTANCE) + 1u)));
    let sum = (layer + base);
    if (sum > 0.0) {
        return (layer / sum);
    }
    return select(0.0, 1.0, (m > 0.5));
}

fn layer_split(
    n: vec4u,
    p: ptr<function, Params>,
    point: ShadingPoint,
    normal: u32,
    wo: vec3f,
    wi: vec3f,
) -> LayerSplit {
    if ((n.x & OP_MASK) == OP_WEIGHTED_LAYER) {
        let weight = unit3(param3(p, (n.y + SLOT_LAYER_WEIGHT)));
        let prob = layer_probability(n, p, weight);
        return LayerSplit(weight, (splat3(1.0) - weight), prob);
    }
    let z = normal_at(p, normal);
    let no = dot(z, wo);
    let ni = dot(z, wi);
    let half = half_cosine(no, ni, dot(wo, wi));
    let curve = layer_curve(n, p, point, unit(abs(no)), unit(abs(ni)), half);
    if layer_conserves(n, p, point) {
        let albedo = layer_albedo(n, p, unit(abs(no)));
        let prob = layer_probability(n, p, albedo);
        return LayerSplit(curve.half, (splat3(1.0) - albedo), prob);
    }
    let prob = layer_probability(n, p, curve.seen);
    return LayerSplit(curve.half, (splat3(1.0) - curve.most), prob);
}
const FILM_ETA: f32 = 1e-3;

fn node_ggx(n: vec4u, p: ptr<function, Params>, point: ShadingPoint) -> Ggx {
    let matched = (((n.x & FLAG_FILM) != 0u) && (abs((point.eta - 1.0)) < FILM_ETA));
    var lobe: Ggx = ggx_new(param(p, (n.y + SLOT_GLOSSY_ALPHA)), param(p, ((n.y + SLOT_GLOSSY_ALPHA) + 1u)), n.w, ((point.flags & POINT_THIN_WALLED) != 0u), select(point.eta, (1.0 + FILM_ETA), matched));
    lobe.correlated = ((n.x & FLAG_CORRELATED) != 0u);
    return lobe;
}

fn node_film_reflectance(n: vec4u, p: ptr<function, Params>, point: ShadingPoint, c: f32) -> vec3f {
    return unit3(film_reflectance(node_film(n, p), splat3(point.near), splat3(point.far), splat3(0.0), c));
}

fn film_tone(film: vec3f, reflects: bool) -> vec3f {
    let tone = select((splat3(1.0) - film), film, reflects);
    let mean = mean3(tone);
    return select(splat3(1.0), (tone * (1.0 / max(mean, 1e-30))), (mean > 0.0));
}

fn node_glossy(n: vec4u, p: ptr<function, Params>, point: ShadingPoint) -> Glossy {
    return glossy_new((n.x & OP_MASK), node_ggx(n, p, point));
}

fn node_multiple(n: vec4u, p: ptr<function, Params>) -> vec3f {
    let turned = ((n.x & FLAG_VECTOR) != 0u);
    return unit3(param3(p, (n.y + select(SLOT_GLOSSY_MULTIPLE, SLOT_GLOSSY_MULTIPLE_TURNED, turned))));
}

fn node_glossy_eval(
    n: vec4u,
    p: ptr<function, Params>,
    point: ShadingPoint,
    o: vec3f,
    i: vec3f,
) -> LeafValue {
    var tint: vec3f = unit3(param3(p, (n.y + SLOT_TINT)));
    var lobe: Glossy = node_glossy(n, p, point);
    if ((n.x & FLAG_FILM) != 0u) {
        let film = node_film_reflectance(n, p, point, ggx_facet_cosine(lobe.ggx, o, i));
        lobe.ggx.reflected = mean3(film);
        tint *= film_tone(film, (i.z > 0.0));
    }
    let v = glossy_eval(lobe, o, i);
    if (((n.x & FLAG_COLOR) == 0u) || (o.z <= 0.0)) {
        return LeafValue((tint * v.f), v.pdf);
    }
    let multiple = node_multiple(n, p);
    let m = multiscatter_new(lobe, o);
    let more = multiscatter_eval(m, lobe, i);
    let q = multiscatter_single(m, tint, multiple);
    let pdf = ((q * v.pdf) + ((1.0 - q) * more.pdf));
    return LeafValue(((tint * v.f) + (multiple * more.f)), pdf);
}

fn node_glossy_sample(
    n: vec4u,
    p: ptr<function, Params>,
    point: ShadingPoint,
    o: vec3f,
    u: vec3f,
) -> LobeSample {
    var lobe: Glossy = node_glossy(n, p, point);
    var uz: f32 = u.z;
    if ((n.x & FLAG_COLOR) != 0u) {
        let m = multiscatter_new(lobe, o);
        let q = multiscatter_single(m, unit3(param3(p, (n.y + SLOT_TINT))), node_multiple(n, p));
        let single = (uz < q);
        uz = reuse_random(uz, q, single);
        if !single {
            let wi = sample_cosine_hemisphere(u.xy);
            let up = ((uz * (m.reflected + m.transmitted)) < m.reflected);
            let side = select(EVENT_TRANSMISSION, EVENT_REFLECTION, up);
            return LobeSample(vec3f(wi.x, wi.y, select(-wi.z, wi.z, up)), select(EVENT_ABSORB, (EVENT_GLOSSY | side), (wi.z > 0.0)));
        }
    }
    if ((n.x & FLAG_FILM) != 0u) {
        let facet = glossy_sample_facet(lobe, o, u.xy, uz);
        let c = clamp(dot(o, facet.m), 0.0, 1.0);
        lobe.ggx.reflected = mean3(node_film_reflectance(n, p, point, c));
    }
    return glossy_sample(lobe, o, u.xy, uz);
}

fn node_specular_reflectance(n: vec4u, p: ptr<function, Params>, point: ShadingPoint, c: f32) -> vec3f {
    if ((n.x & FLAG_FILM) != 0u) {
        return node_film_reflectance(n, p, point, c);
    }
    if (((point.flags & POINT_THIN_WALLED) != 0u) && (n.w == MODE_TRANSMIT)) {
        return splat3(0.0);
    }
    return splat3(specular_reflectance(n.w, c, point.eta));
}

fn op_is_diffuse(op: u32) -> bool {
    return (((op == OP_DIFFUSE_REFLECTION) || (op == OP_DIFFUSE_TRANSMISSION)) || (op == OP_DUSTY_DIFFUSE));
}

fn node_is_turned(n: vec4u, normal: u32) -> bool {
    return ((normal != NO_SLOT) || ((n.x & FLAG_VECTOR) != 0u));
}

fn node_frame(n: vec4u, p: ptr<function, Params>, normal: u32) -> Frame {
    let z = normal_at(p, normal);
    if ((n.x & FLAG_VECTOR) != 0u) {
        return frame_from_normal_tangent(z, param3(p, (n.y + SLOT_GLOSSY_TANGENT)));
    }
    return frame_from_normal(z);
}

struct Directions {
    wo: vec3f,
    wi: vec3f
}

fn node_local(
    n: vec4u,
    p: ptr<function, Params>,
    normal: u32,
    wo: vec3f,
    wi: vec3f,
) -> Directions {
    let frame = node_frame(n, p, normal);
    return Directions(frame_to_local(frame, wo), frame_to_local(frame, wi));
}

fn bsdf_node(program: ptr<function, Program>, index: u32) -> vec4u {
    return program.nodes[u32(index)];
}

fn bsdf_visit(
    program: ptr<function, Program>,
    p: ptr<function, Params>,
    point: ShadingPoint,
    wo: vec3f,
    wi: vec3f,
    specular_node: u32,
) -> BsdfValue {
    var diffuse: vec3f = splat3(0.0);
    var glossy: vec3f = splat3(0.0);
    var pdf: f32 = 0.0;
    var specular: vec3f = splat3(0.0);
    var visit: Visit = visit_root();
    var stack: array<Visit, 6> = array(visit, visit, visit, visit, visit, visit);
    var depth: u32 = 0u;
    let transmits = (dot(point.geometry_normal, wi) < 0.0);
    var running: bool = true;
    while running {
        let n = bsdf_node(program, visit.node);
        let op = (n.x & OP_MASK);
        if (op >= OP_WEIGHTED_LAYER) {
            let own = layer_normal(n, visit.normal);
            let fork = visit_fork(n, visit, own, layer_split(n, p, point, own, wo, wi));
            stack[u32(depth)] = fork.later;
            visit = fork.now;
            depth += 1u;
        } else if (op == OP_MEASURED_PICTURE) {
            visit.weight *= node_picture_factor(program, n, p, visit.normal, wo, wi);
            visit.node += 1u;
        } else if (op >= OP_TINT) {
            visit.weight *= modifier_factor(n, p, point, visit.normal, wo, wi, transmits);
            visit.node += 1u;
        } else {
            if (visit.node == specular_node) {
                specular = visit.weight;
            }
            let leaf = leaf_eval(program, n, p, point, visit.normal, wo, wi, transmits);
            let f = (visit.weight * leaf.f);
            if op_is_diffuse(op) {
                diffuse += f;
            } else {
                glossy += f;
            }
            pdf += (visit.prob * leaf.pdf);
            running = (depth > 0u);
            if running {
                depth -= 1u;
                visit = stack[u32(depth)];
            }
        }
    }
    return BsdfValue(diffuse, glossy, pdf, specular);
}

fn leaf_eval(
    program: ptr<function, Program>,
    n: vec4u,
    p: ptr<function, Params>,
    point: ShadingPoint,
    normal: u32,
    wo: vec3f,
    wi: vec3f,
    transmits: bool,
) -> LeafValue {
    let op = (n.x & OP_MASK);
    var result: LeafValue = LeafValue(splat3(0.0), 0.0);
    if ((op == OP_BLACK) || (op == OP_SPECULAR)) {
        return result;
    }
    var o: vec3f = wo;
    var i: vec3f = wi;
    if node_is_turned(n, normal) {
        let local = node_local(n, p, normal, wo, wi);
        o = local.wo;
        i = local.wi;
    }
    if ((i.z < 0.0) != transmits) {
        return result;
    }
    let tint = unit3(param3(p, (n.y + SLOT_TINT)));
    if (op == OP_DIFFUSE_REFLECTION) {
        let lobe = diffuse_reflection_new(param(p, (n.y + SLOT_DIFFUSE_ROUGHNESS)));
        let v = diffuse_reflection_eval(lobe, o, i);
        result.f = (tint * v.single);
        if ((n.x & FLAG_COLOR) != 0u) {
            result.f += (unit3(param3(p, (n.y + SLOT_DIFFUSE_MULTIPLE))) * v.multiple);
        }
        result.pdf = v.pdf;
    } else if (op == OP_DIFFUSE_TRANSMISSION) {
        let v = diffuse_transmission_eval(o, i);
        result.f = (tint * v.f);
        result.pdf = v.pdf;
    } else if (op == OP_DUSTY_DIFFUSE) {
        result.f = dusty_diffuse_eval(tint, o, i);
        result.pdf = select(0.0, (max(i.z, 0.0) * FRAC_1_PI), (o.z > 0.0));
    } else if (op == OP_MICROFLAKE) {
        let v = microflake_eval(microflake_new(param(p, (n.y + SLOT_GLOSSY_ALPHA)), o), o, i);
        result.f = (tint * v.f);
        result.pdf = v.pdf;
    } else if ((op == OP_GGX_SMITH) && ((n.x & (FLAG_COLOR | FLAG_FILM)) == 0u)) {
        let v = ggx_eval(node_ggx(n, p, point), o, i);
        result.f = (tint * v.f);
        result.pdf = v.pdf;
    } else if (op == OP_MEASURED_BSDF) {
        let v = node_measured_eval(program, n, p, o, i);
        result.f = v.f;
        result.pdf = v.density;
    } else {
        let v = node_glossy_eval(n, p, point, o, i);
        result.f = v.f;
        result.pdf = v.pdf;
    }
    return result;
}

fn leaf_sample(
    program: ptr<function, Program>,
    n: vec4u,
    p: ptr<function, Params>,
    point: ShadingPoint,
    normal: u32,
    wo: vec3f,
    u: vec3f,
) -> LobeSample {
    let op = (n.x & OP_MASK);
    var frame: Frame = Frame(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), vec3f(0.0, 0.0, 1.0));
    var o: vec3f = wo;
    let turned = node_is_turned(n, normal);
    if turned {
        frame = node_frame(n, p, normal);
        o = frame_to_local(frame, wo);
    }
    var s: LobeSample = lobe_absorb();
    if (o.z <= 0.0) {
        return s;
    }
    if ((op == OP_DIFFUSE_REFLECTION) || (op == OP_DUSTY_DIFFUSE)) {
        s = diffuse_reflection_sample(u.xy);
    } else if (op == OP_DIFFUSE_TRANSMISSION) {
        s = diffuse_transmission_sample(u.xy);
    } else if (op == OP_MICROFLAKE) {
        s = microflake_sample(microflake_new(param(p, (n.y + SLOT_GLOSSY_ALPHA)), o), u.xy);
    } else if (op == OP_SPECULAR) {
        let thin = ((point.flags & POINT_THIN_WALLED) != 0u);
        let reflected = node_specular_reflectance(n, p, point, o.z);
        s = specular_sample(mean3(reflected), thin, point.eta, o, u.z);
    } else if ((op == OP_GGX_SMITH) && ((n.x & (FLAG_COLOR | FLAG_FILM)) == 0u)) {
        s = ggx_sample(node_ggx(n, p, point), o, u.xy, u.z);
    } else if (op == OP_MEASURED_BSDF) {
        s = node_measured_sample(program, n, p, o, u);
    } else if (op >= OP_GGX_SMITH) {
        s = node_glossy_sample(n, p, point, o, u);
    }
    if turned {
        s.wi = normalize_or(frame_from_local(frame, s.wi), s.wi);
    }
    return s;
}

fn bsdf_eval(
    program: ptr<function, Program>,
    p: ptr<function, Params>,
    point: ShadingPoint,
    wo: vec3f,
    wi: vec3f,
) -> BsdfValue {
    return bsdf_visit(program, p, point, wo, wi, NO_NODE);
}

fn bsdf_sample(
    program: ptr<function, Program>,
    p: ptr<function, Params>,
    point: ShadingPoint,
    wo: vec3f,
    u: vec3f,
) -> BsdfSample {
    return bsdf_scatter(program, p, point, wo, u).sample;
}

fn bsdf_scatter(
    program: ptr<function, Program>,
    p: ptr<function, Params>,
    point: ShadingPoint,
    wo: vec3f,
    u: vec3f,
) -> BsdfScatter {
    let zero = splat3(0.0);
    var result: BsdfSample = BsdfSample(vec3f(0.0, 0.0, 1.0), 0.0, zero, EVENT_ABSORB);
    let nothing = BsdfValue(zero, zero, 0.0, zero);
    var node: u32 = 0u;
    var normal: u32 = NO_SLOT;
    var prob: f32 = 1.0;
    var uz: f32 = u.z;
    var n: vec4u = bsdf_node(program, node);
    while ((n.x & OP_MASK) >= OP_TINT) {
        if ((n.x & OP_MASK) >= OP_WEIGHTED_LAYER) {
            let own = layer_normal(n, normal);
            let z = normal_at(p, own);
            let c = unit(abs(dot(z, wo)));
            var seen: vec3f = layer_seen(n, p, point, c);
            if layer_conserves(n, p, point) {
                seen = layer_albedo(n, p, c);
            }
            let q = layer_probability(n, p, seen);
            let layer = (uz < q);
            uz = reuse_random(uz, q, layer);
            prob *= select((1.0 - q), q, layer);
            node = select(base_child(n, node), layer_child(n, node), layer);
            normal = select(normal, own, layer);
        } else {
            node += 1u;
        }
        n = bsdf_node(program, node);
    }
    let s = leaf_sample(program, n, p, point, normal, wo, vec3f(u.x, u.y, uz));
    let transmits = ((s.event & EVENT_TRANSMISSION) != 0u);
    let crosses = (dot(point.geometry_normal, s.wi) < 0.0);
    if ((s.event == EVENT_ABSORB) || (transmits != crosses)) {
        return BsdfScatter(result, nothing);
    }
    let specular = ((s.event & EVENT_SPECULAR) != 0u);
    let v = bsdf_visit(program, p, point, wo, s.wi, select(NO_NODE, node, specular));
    if specular {
        result.weight = ((v.specular * unit3(param3(p, (n.y + SLOT_TINT)))) * (1.0 / prob));
        if ((n.x & FLAG_FILM) != 0u) {
            let c = unit(dot(normal_at(p, normal), wo));
            let film = node_film_reflectance(n, p, point, c);
            result.weight *= film_tone(film, !transmits);
        }
        result.wi = s.wi;
        result.event = s.event;
    } else if (v.pdf > 0.0) {
        result.weight = ((v.diffuse + v.glossy) * (1.0 / v.pdf));
        result.wi = s.wi;
        result.pdf = v.pdf;
        result.event = s.event;
    }
    return BsdfScatter(result, v);
}
struct BsdfAlbedo {
    diffuse: vec3f,
    glossy: vec3f
}
const ALBEDO_POINTS: u32 = 64u;

fn node_is_angular(n: vec4u) -> bool {
    let op = (n.x & OP_MASK);
    let splits = ((op == OP_TINT) && ((n.x & FLAG_COLOR) != 0u));
    let factor = ((op >= OP_DIRECTIONAL_FACTOR) && (op != OP_WEIGHTED_LAYER));
    return ((factor || splits) || ((n.x & FLAG_FILM) != 0u));
}

fn bsdf_albedo(program: ptr<function, Program>, p: ptr<function, Params>, point: ShadingPoint, wo: vec3f) -> BsdfAlbedo {
    var angular: bool = false;
    let count = program.count;
    for (var i = 0u; i < count; i++) {
        angular = (angular || node_is_angular(bsdf_node(program, i)));
    }
    if angular {
        return bsdf_albedo_sampled(program, p, point, wo);
    }
    return bsdf_albedo_closed(program, p, point, wo);
}

fn bsdf_albedo_sampled(program: ptr<function, Program>, p: ptr<function, Params>, point: ShadingPoint, wo: vec3f) -> BsdfAlbedo {
    var result: BsdfAlbedo = BsdfAlbedo(splat3(0.0), splat3(0.0));
    let share = (1.0 / f32(ALBEDO_POINTS));
    for (var i = 0u; i < ALBEDO_POINTS; i++) {
        let k = (f32(i) + 0.5);
        let u = vec3f((k * 0.8191725), (k * 0.6710436), (k * 0.5497005));
        let s = bsdf_scatter(program, p, point, wo, (u - floor(u)));
        if ((s.sample.event & EVENT_SPECULAR) != 0u) {
            result.glossy += (s.sample.weight * share);
        } else if (s.sample.event != EVENT_ABSORB) {
            result.diffuse += (s.value.diffuse * (share / s.value.pdf));
            result.glossy += (s.value.glossy * (share / s.value.pdf));
        }
    }
    return BsdfAlbedo(unit3(result.diffuse), unit3(result.glossy));
}

fn bsdf_albedo_closed(program: ptr<function, Program>, p: ptr<function, Params>, point: ShadingPoint, wo: vec3f) -> BsdfAlbedo {
    var result: BsdfAlbedo = BsdfAlbedo(splat3(0.0), splat3(0.0));
    var visit: Visit = visit_root();
    var stack: array<Visit, 6> = array(visit, visit, visit, visit, visit, visit);
    var depth: u32 = 0u;
    var running: bool = true;
    while running {
        let n = bsdf_node(program, visit.node);
        let op = (n.x & OP_MASK);
        if (op >= OP_WEIGHTED_LAYER) {
            let own = layer_normal(n, visit.normal);
            let share = unit3(param3(p, (n.y + SLOT_LAYER_WEIGHT)));
            let split = LayerSplit(share, (splat3(1.0) - share), 1.0);
            let fork = visit_fork(n, visit, own, split);
            stack[u32(depth)] = fork.later;
            visit = fork.now;
            depth += 1u;
        } else if (op >= OP_TINT) {
            visit.weight *= modifier_factor(n, p, point, visit.normal, wo, wo, false);
            visit.node += 1u;
        } else {
            let leaf = leaf_albedo(program, n, p, point, visit.normal, wo);
            result.diffuse += (visit.weight * leaf.diffuse);
            result.glossy += (visit.weight * leaf.glossy);
            running = (depth > 0u);
            if running {
                depth -= 1u;
                visit = stack[u32(depth)];
            }
        }
    }
    return result;
}

fn leaf_albedo(
    program: ptr<function, Program>,
    n: vec4u,
    p: ptr<function, Params>,
    point: ShadingPoint,
    normal: u32,
    wo: vec3f,
) -> BsdfAlbedo {
    var result: BsdfAlbedo = BsdfAlbedo(splat3(0.0), splat3(0.0));
    let op = (n.x & OP_MASK);
    let o = frame_to_local(node_frame(n, p, normal), wo);
    if ((op == OP_BLACK) || (o.z <= 0.0)) {
        return result;
    }
    let tint = unit3(param3(p, (n.y + SLOT_TINT)));
    if (op == OP_DIFFUSE_REFLECTION) {
        let lobe = diffuse_reflection_new(param(p, (n.y + SLOT_DIFFUSE_ROUGHNESS)));
        let single = diffuse_reflection_albedo(lobe, o.z);
        result.diffuse = (tint * single);
        if ((n.x & FLAG_COLOR) != 0u) {
            let multiple = unit3(param3(p, (n.y + SLOT_DIFFUSE_MULTIPLE)));
            result.diffuse += (multiple * (1.0 - single));
        }
    } else if (op == OP_DIFFUSE_TRANSMISSION) {
        result.diffuse = tint;
    } else if (op == OP_DUSTY_DIFFUSE) {
        result.diffuse = dusty_diffuse_albedo(tint, o.z);
    } else if (op == OP_MICROFLAKE) {
        result.glossy = (tint * microflake_albedo(param(p, (n.y + SLOT_GLOSSY_ALPHA)), unit(o.z)));
    } else if (op == OP_SPECULAR) {
        result.glossy = tint;
    } else if (op == OP_MEASURED_BSDF) {
        result.glossy = node_measured_albedo(program, n, p, o);
    } else {
        result.glossy = node_glossy_albedo(n, p, point, o);
    }
    return result;
}

fn node_glossy_albedo(n: vec4u, p: ptr<function, Params>, point: ShadingPoint, o: vec3f) -> vec3f {
    let lobe = node_glossy(n, p, point);
    var result: vec3f = (unit3(param3(p, (n.y + SLOT_TINT))) * glossy_albedo(lobe, o));
    if ((n.x & FLAG_COLOR) != 0u) {
        let m = multiscatter_new(lobe, o);
        result += (node_multiple(n, p) * (m.loss * (m.reflected + m.transmitted)));
    }
    return unit3(result);
}
struct BsdfAuxiliary {
    diffuse: vec3f,
    glossy: vec3f,
    normal: vec3f,
    roughness: vec2f
}

fn leaf_roughness(n: vec4u, p: ptr<function, Params>) -> vec2f {
    let op = (n.x & OP_MASK);
    if (op == OP_SPECULAR) {
        return vec2f(0.0, 0.0);
    }
    if (op == OP_MICROFLAKE) {
        let alpha = unit(param(p, (n.y + SLOT_GLOSSY_ALPHA)));
        return vec2f(alpha, alpha);
    }
    if ((op >= OP_GGX_SMITH) && (op <= OP_SHEEN)) {
        return vec2f(sane_alpha(param(p, (n.y + SLOT_GLOSSY_ALPHA))), sane_alpha(param(p, ((n.y + SLOT_GLOSSY_ALPHA) + 1u))));
    }
    return vec2f(1.0, 1.0);
}

fn bsdf_auxiliary(program: ptr<function, Program>, p: ptr<function, Params>, point: ShadingPoint, wo: vec3f) -> BsdfAuxiliary {
    let albedo = bsdf_albedo(program, p, point, wo);
    var normal: vec3f = splat3(0.0);
    var roughness: vec2f = vec2f(0.0, 0.0);
    var total: f32 = 0.0;
    var visit: Visit = visit_root();
    var stack: array<Visit, 6> = array(visit, visit, visit, visit, visit, visit);
    var depth: u32 = 0u;
    var running: bool = true;
    while running {
        let n = bsdf_node(program, visit.node);
        let op = (n.x & OP_MASK);
        if (op >= OP_WEIGHTED_LAYER) {
            let own = layer_normal(n, visit.normal);
            let c = unit(abs(dot(normal_at(p, own), wo)));
            var seen: vec3f = layer_seen(n, p, point, c);
            if layer_conserves(n, p, point) {
                seen = layer_albedo(n, p, c);
            }
            let split = LayerSplit(seen, (splat3(1.0) - seen), 1.0);
            let fork = visit_fork(n, visit, own, split);
            stack[u32(depth)] = fork.later;
            visit = fork.now;
            depth += 1u;
        } else if (op == OP_MEASURED_PICTURE) {
            visit.weight *= node_picture_factor(program, n, p, visit.normal, wo, wo);
            visit.node += 1u;
        } else if (op >= OP_TINT) {
            visit.weight *= modifier_factor(n, p, point, visit.normal, wo, wo, false);
            visit.node += 1u;
        } else {
            let leaf = leaf_albedo(program, n, p, point, visit.normal, wo);
            let share = nonnegative(mean3((visit.weight * (leaf.diffuse + leaf.glossy))));
            normal += (normal_at(p, visit.normal) * share);
            roughness += (leaf_roughness(n, p) * share);
            total += share;
            running = (depth > 0u);
            if running {
                depth -= 1u;
                visit = stack[u32(depth)];
            }
        }
    }
    if !(total > 1e-20) {
        roughness = vec2f(1.0, 1.0);
        total = 1.0;
    }
    return BsdfAuxiliary(albedo.diffuse, albedo.glossy, normalize_or(normal, vec3f(0.0, 0.0, 1.0)), (roughness * (1.0 / total)));
}
const SPREAD_MIN: f32 = 1e-3;
const SPOT_MOST: f32 = 1e6;

struct Spot {
    exponent: f32,
    depth: f32,
    axis: vec3f
}

fn spot_new(exponent: f32, spread: f32, axis: vec3f) -> Spot {
    let quarter = (0.25 * clamp(nonnegative(spread), SPREAD_MIN, PI));
    let s = math_sin(quarter);
    return Spot(min(nonnegative(exponent), SPOT_MOST), ((2.0 * s) * s), axis);
}

fn spot_eval(spot: Spot, w: vec3f) -> LobeValue {
    let apart = (w - spot.axis);
    let below = (0.5 * dot(apart, apart));
    let t = (1.0 - (below / spot.depth));
    if (t <= 0.0) {
        return lobe_zero();
    }
    let k = spot.exponent;
    let norm = (((((k + 1.0) * (k + 2.0)) * 0.5) * FRAC_1_PI) / (spot.depth * ((k + 2.0) - spot.depth)));
    let f = (norm * math_pow(t, k));
    return LobeValue(f, (f * max((1.0 - below), 0.0)));
}

fn spot_sample(spot: Spot, u: vec3f) -> vec3f {
    let k = spot.exponent;
    let plain = ((1.0 - spot.depth) / (k + 1.0));
    let steeper = (spot.depth / (k + 2.0));
    let power = select((k + 2.0), (k + 1.0), ((u.z * (plain + steeper)) < plain));
    let half = ((0.5 * math_log(max((1.0 - u.y), 5.9604645e-8))) / power);
    let below = (spot.depth * min(((-2.0 * math_exp(half)) * math_sinh(half)), 1.0));
    let r = sqrt(max((below * (2.0 - below)), 0.0));
    let turn = math_sincos(((2.0 * PI) * u.x));
    let frame = frame_from_normal(spot.axis);
    let w = frame_from_local(frame, vec3f((r * turn.y), (r * turn.x), (1.0 - below)));
    return normalize_or(w, spot.axis);
}
fn weighted_fork(n: vec4u, p: ptr<function, Params>, visit: Visit) -> Fork {
    let weight = unit3(param3(p, (n.y + SLOT_LAYER_WEIGHT)));
    let prob = layer_probability(n, p, weight);
    return visit_fork(n, visit, visit.normal, LayerSplit(weight, (splat3(1.0) - weight), prob));
}

struct Chosen {
    n: vec4u,
    rest: f32
}

fn weighted_leaf(program: ptr<function, Program>, p: ptr<function, Params>, u: f32) -> Chosen {
    var node: u32 = 0u;
    var rest: f32 = u;
    var n: vec4u = bsdf_node(program, node);
    while (((n.x & OP_MASK) >= OP_TINT) && ((n.x & OP_MASK) < OP_DIFFUSE_EDF)) {
        if ((n.x & OP_MASK) >= OP_WEIGHTED_LAYER) {
            let weight = unit3(param3(p, (n.y + SLOT_LAYER_WEIGHT)));
            let q = layer_probability(n, p, weight);
            let layer = (rest < q);
            rest = reuse_random(rest, q, layer);
            node = select(base_child(n, node), layer_child(n, node), layer);
        } else {
            node += 1u;
        }
        n = bsdf_node(program, node);
    }
    return Chosen(n, rest);
}
struct EdfValue {
    value: vec3f,
    pdf: f32
}

fn edf_eval(program: ptr<function, Program>, p: ptr<function, Params>, w: vec3f) -> EdfValue {
    var result: EdfValue = EdfValue(splat3(0.0), 0.0);
    if (w.z <= 0.0) {
        return result;
    }
    let point = shading_point(vec3f(0.0, 0.0, 1.0), splat3(1.0), splat3(1.0), 0u);
    var visit: Visit = visit_root();
    var stack: array<Visit, 6> = array(visit, visit, visit, visit, visit, visit);
    var depth: u32 = 0u;
    var running: bool = true;
    while running {
        let n = bsdf_node(program, visit.node);
        let op = (n.x & OP_MASK);
        if (op == OP_WEIGHTED_LAYER) {
            let fork = weighted_fork(n, p, visit);
            stack[u32(depth)] = fork.later;
            visit = fork.now;
            depth += 1u;
        } else if ((op >= OP_TINT) && (op < OP_WEIGHTED_LAYER)) {
            let mirrored = vec3f(-w.x, -w.y, w.z);
            visit.weight *= modifier_factor(n, p, point, visit.normal, w, mirrored, false);
            visit.node += 1u;
        } else {
            if (op == OP_DIFFUSE_EDF) {
                result.value += (visit.weight * FRAC_1_PI);
                result.pdf += ((visit.prob * w.z) * FRAC_1_PI);
            } else if (op == OP_SPOT_EDF) {
                let v = spot_eval(node_spot(n, p), w);
                result.value += (visit.weight * v.f);
                result.pdf += (visit.prob * v.pdf);
            }
            running = (depth > 0u);
            if running {
                depth -= 1u;
                visit = stack[u32(depth)];
            }
        }
    }
    return result;
}

fn node_spot(n: vec4u, p: ptr<function, Params>) -> Spot {
    let up = vec3f(0.0, 0.0, 1.0);
    let exponent = param(p, n.y);
    let spread = param(p, (n.y + 1u));
    if ((n.x & FLAG_VECTOR) == 0u) {
        return spot_new(exponent, spread, up);
    }
    return spot_new(exponent, spread, normalize_or(param3(p, (n.y + SLOT_SPOT_AXIS)), up));
}

fn edf_sample(program: ptr<function, Program>, p: ptr<function, Params>, u: vec3f) -> LobeSample {
    let chosen = weighted_leaf(program, p, u.z);
    let n = chosen.n;
    let op = (n.x & OP_MASK);
    var wi: vec3f = sample_cosine_hemisphere(u.xy);
    if (op == OP_SPOT_EDF) {
        wi = spot_sample(node_spot(n, p), vec3f(u.x, u.y, chosen.rest));
    }
    if ((op < OP_DIFFUSE_EDF) || (wi.z <= 0.0)) {
        return lobe_absorb();
    }
    return LobeSample(wi, select(EVENT_GLOSSY, EVENT_DIFFUSE, (op == OP_DIFFUSE_EDF)));
}
const SLOT_HAIR_TINT: u32 = 0u;
const SLOT_HAIR_DIFFUSE: u32 = 3u;
const SLOT_HAIR_DIFFUSE_TINT: u32 = 4u;
const SLOT_HAIR_ROUGHNESS: u32 = 7u;
const SLOT_HAIR_CUTICLE: u32 = 13u;
const SLOT_HAIR_ABSORPTION: u32 = 14u;
const SLOT_HAIR_IOR: u32 = 17u;
const HAIR_SLOTS: u32 = 18u;
const HAIR_V_MIN: f32 = 1e-6;
const HAIR_S_MIN: f32 = 1e-3;
const SQRT_PI_8: f32 = 0.62665707;

struct HairValue {
    value: vec3f,
    pdf: f32
}

struct HairSample {
    wi: vec3f,
    pdf: f32,
    weight: vec3f
}

struct Fiber {
    a0: vec3f,
    a1: vec3f,
    a2: vec3f,
    a3: vec3f,
    gamma_o: f32,
    gamma_t: f32,
    diffuse: f32
}

fn bessel_i0_scaled(x: f32) -> f32 {
    if (x < 3.75) {
        let t = (x * (1.0 / 3.75));
        let z = (t * t);
        let p = (0.2659732 + (z * (0.0360768 + (z * 0.0045813))));
        return ((1.0 + (z * (3.5156229 + (z * (3.0899424 + (z * (1.2067492 + (z * p)))))))) * math_exp(-x));
    }
    let r = (3.75 / x);
    let p = (0.00916281 + (r * (-0.02057706 + (r * (0.02635537 + (r * (-0.01647633 + (r * 0.00392377))))))));
    return ((0.3989423 + (r * (0.01328592 + (r * (0.00225319 + (r * (-0.00157565 + (r * p)))))))) / sqrt(x));
}

fn hair_longitudinal(to: vec2f, ti: vec2f, v: f32) -> f32 {
    let across = (ti.x - to.x);
    let along = (ti.y + to.y);
    let exponent = ((-0.5 * ((across * across) + (along * along))) / v);
    let wide = (((2.0 * v) * math_exp((-1.0 / max(v, 0.1)))) * math_sinh((1.0 / max(v, 0.1))));
    let norm = select(wide, v, (v < 0.1));
    return ((math_exp(exponent) * bessel_i0_scaled(((to.x * ti.x) / v))) / norm);
}

fn hair_logistic(x: f32, s: f32) -> f32 {
    let e = math_exp((-abs(x) / s));
    return (e / (((s * (1.0 + e)) * (1.0 + e)) * math_tanh(((0.5 * PI) / s))));
}

fn hair_logistic_sample(u: f32, s: f32) -> f32 {
    let x = ((2.0 * s) * math_atanh((clamp(((2.0 * u) - 1.0), -0.9999999, 0.9999999) * math_tanh(((0.5 * PI) / s)))));
    return clamp(x, -PI, PI);
}

fn hair_turn(fiber: Fiber, p: f32) -> f32 {
    return ((((2.0 * p) * fiber.gamma_t) - (2.0 * fiber.gamma_o)) + (p * PI));
}

fn hair_azimuthal(fiber: Fiber, p: f32, s: f32, dphi: f32) -> f32 {
    let x = (dphi - hair_turn(fiber, p));
    return hair_logistic((x - ((2.0 * PI) * math_round_half_even((x * (0.5 * FRAC_1_PI))))), s);
}

fn hair_roughness(h: ptr<function, Params>, p: u32) -> vec2f {
    let v = param(h, (SLOT_HAIR_ROUGHNESS + (2u * p)));
    let beta = param(h, ((SLOT_HAIR_ROUGHNESS + (2u * p)) + 1u));
    let s = (nonnegative(beta) * SQRT_PI_8);
    return vec2f(clamp(nonnegative(v), HAIR_V_MIN, 1e4), clamp(s, HAIR_S_MIN, 1e4));
}

fn hair_tilted(h: ptr<function, Params>, p: u32, wo: vec3f) -> vec2f {
    let plain = vec2f(sqrt(((wo.y * wo.y) + (wo.z * wo.z))), wo.x);
    let angle = param(h, SLOT_HAIR_CUTICLE);
    if ((p > 2u) || !(abs(angle) < 100.0)) {
        return plain;
    }
    let sc = math_sincos(((2.0 - (3.0 * f32(p))) * angle));
    return vec2f(abs(((plain.x * sc.y) - (plain.y * sc.x))), ((plain.y * sc.y) + (plain.x * sc.x)));
}

fn fiber_new(h: ptr<function, Params>, wo: vec3f) -> Fiber {
    let eta = sane_eta(param(h, SLOT_HAIR_IOR));
    let cos_o = max(sqrt(((wo.y * wo.y) + (wo.z * wo.z))), 1e-18);
    let offset = clamp((-wo.y / cos_o), -1.0, 1.0);
    let sin_t = (wo.x / eta);
    let cos_t = sqrt(max(((1.0 - sin_t) * (1.0 + sin_t)), 1e-12));
    let inner = (sqrt(max(((eta - wo.x) * (eta + wo.x)), 1e-12)) / cos_o);
    let bent = clamp((offset / inner), -1.0, 1.0);
    let cos_bent = sqrt(((1.0 - bent) * (1.0 + bent)));
    let fresnel = fresnel_dielectric(unit(abs(wo.z)), eta);
    let rest = (1.0 - fresnel);
    let depth = ((2.0 * cos_bent) / cos_t);
    let sigma = param3(h, SLOT_HAIR_ABSORPTION);
    let t = vec3f(math_exp(-min((nonnegative(sigma.x) * depth), 80.0)), math_exp(-min((nonnegative(sigma.y) * depth), 80.0)), math_exp(-min((nonnegative(sigma.z) * depth), 80.0)));
    let a1 = (t * (rest * rest));
    let a2 = ((a1 * t) * fresnel);
    let lost = vec3f(max((1.0 - (t.x * fresnel)), 1e-20), max((1.0 - (t.y * fresnel)), 1e-20), max((1.0 - (t.z * fresnel)), 1e-20));
    let weight = unit(param(h, SLOT_HAIR_DIFFUSE));
    return Fiber(splat3(fresnel), a1, a2, (((a2 * t) * fresnel) / lost), math_atan2(-wo.y, max(abs(wo.z), 1e-30)), math_asin(bent), select(0.0, weight, (wo.z > 0.0)));
}

fn hair_eval(h: ptr<function, Params>, wo: vec3f, wi: vec3f) -> HairValue {
    let fiber = fiber_new(h, wo);
    return hair_eval_fiber(h, fiber, wo, wi);
}

fn hair_eval_fiber(h: ptr<function, Params>, fiber: Fiber, wo: vec3f, wi: vec3f) -> HairValue {
    let ti = vec2f(sqrt(((wi.y * wi.y) + (wi.z * wi.z))), wi.x);
    let dphi = math_atan2(((wi.z * wo.y) - (wi.y * wo.z)), ((wi.y * wo.y) + (wi.z * wo.z)));
    let r0 = hair_roughness(h, 0u);
    let r1 = hair_roughness(h, 1u);
    let r2 = hair_roughness(h, 2u);
    let n0 = (hair_longitudinal(hair_tilted(h, 0u, wo), ti, r0.x) * hair_azimuthal(fiber, 0.0, r0.y, dphi));
    let n1 = (hair_longitudinal(hair_tilted(h, 1u, wo), ti, r1.x) * hair_azimuthal(fiber, 1.0, r1.y, dphi));
    let n2 = (hair_longitudinal(hair_tilted(h, 2u, wo), ti, r2.x) * hair_azimuthal(fiber, 2.0, r2.y, dphi));
    let n3 = (hair_longitudinal(hair_tilted(h, 3u, wo), ti, r2.x) * (0.5 * FRAC_1_PI));
    let lobes = ((((fiber.a0 * n0) + (fiber.a1 * n1)) + (fiber.a2 * n2)) + (fiber.a3 * n3));
    let m = vec4f(mean3(fiber.a0), mean3(fiber.a1), mean3(fiber.a2), mean3(fiber.a3));
    let pdf = (((((m.x * n0) + (m.y * n1)) + (m.z * n2)) + (m.w * n3)) / (((m.x + m.y) + m.z) + m.w));
    let cosine = (max(wi.z, 0.0) * FRAC_1_PI);
    let diffuse = (unit3(param3(h, SLOT_HAIR_DIFFUSE_TINT)) * (cosine * fiber.diffuse));
    let weight = unit(param(h, SLOT_HAIR_DIFFUSE));
    return HairValue((unit3(param3(h, SLOT_HAIR_TINT)) * ((lobes * (1.0 - weight)) + diffuse)), ((pdf * (1.0 - fiber.diffuse)) + (cosine * fiber.diffuse)));
}

fn hair_sample(h: ptr<function, Params>, wo: vec3f, u: vec3f) -> HairSample {
    let fiber = fiber_new(h, wo);
    let wi = hair_direction(h, fiber, wo, u);
    let v = hair_eval_fiber(h, fiber, wo, wi);
    if !(v.pdf > 0.0) {
        return HairSample(wi, 0.0, splat3(0.0));
    }
    return HairSample(wi, v.pdf, (v.value * (1.0 / max(v.pdf, 1e-37))));
}

fn hair_direction(h: ptr<function, Params>, fiber: Fiber, wo: vec3f, u: vec3f) -> vec3f {
    if (u.z < fiber.diffuse) {
        return sample_cosine_hemisphere(u.xy);
    }
    let m = vec4f(mean3(fiber.a0), mean3(fiber.a1), mean3(fiber.a2), mean3(fiber.a3));
    let sum = (((m.x + m.y) + m.z) + m.w);
    let choice = (((u.z - fiber.diffuse) / (1.0 - fiber.diffuse)) * sum);
    let after0 = (m.x + m.y);
    let after1 = (after0 + m.z);
    let p = select(select(select(3u, 2u, (choice < after1)), 1u, (choice < after0)), 0u, (choice < m.x));
    let before = select(select(select(after1, after0, (p == 2u)), m.x, (p == 1u)), 0.0, (p == 0u));
    let own = select(select(select(m.w, m.z, (p == 2u)), m.y, (p == 1u)), m.x, (p == 0u));
    let rest = clamp(((choice - before) / max(own, 1e-30)), 0.0, 1.0);
    let r = hair_roughness(h, min(p, 2u));
    let to = hair_tilted(h, p, wo);
    let spread = (u.y + ((1.0 - u.y) * math_exp((-2.0 / r.x))));
    let below = min((-r.x * math_log(max(spread, 1e-37))), 2.0);
    let radius = sqrt(max((below * (2.0 - below)), 0.0));
    let sc = math_sincos(((2.0 * PI) * rest));
    let sin_i = (((radius * sc.y) * to.x) - (to.y * (1.0 - below)));
    let up = ((to.x * (1.0 - below)) + ((radius * sc.y) * to.y));
    let side = (radius * sc.x);
    let cos_i = sqrt(((up * up) + (side * side)));
    let uniform = (PI * ((2.0 * u.x) - 1.0));
    let turned = (hair_turn(fiber, f32(p)) + hair_logistic_sample(u.x, r.y));
    let phi = (math_atan2(wo.z, wo.y) + select(turned, uniform, (p == 3u)));
    let around = math_sincos(phi);
    return normalize_or(vec3f(sin_i, (cos_i * around.y), (cos_i * around.x)), vec3f(0.0, 0.0, 1.0));
}
const FRAC_1_4PI: f32 = 0.07957747;
const BIAS_MOST: f32 = 0.999999;
const DROPLET_MOST: f32 = 50.0;

fn sane_bias(g: f32) -> f32 {
    return select(0.0, clamp(g, -BIAS_MOST, BIAS_MOST), (abs(g) >= 0.0));
}

fn hg_eval(g: f32, rest: f32, wo: vec3f, wi: vec3f) -> f32 {
    let a = abs(g);
    let apart = (wi + (wo * select(-1.0, 1.0, (g >= 0.0))));
    let d = ((rest * rest) + (a * dot(apart, apart)));
    return (((FRAC_1_4PI * rest) * (1.0 + a)) / (d * sqrt(d)));
}

fn hg_below(a: f32, rest: f32, u: f32) -> f32 {
    let q = (rest / (rest + ((2.0 * a) * (1.0 - u))));
    return ((q * u) * (((1.0 + a) * q) + rest));
}

fn phase_direction(peak: vec3f, below: f32, turn: f32) -> vec3f {
    let r = sqrt(max((below * (2.0 - below)), 0.0));
    let sc = math_sincos(((2.0 * PI) * turn));
    let frame = frame_from_normal(peak);
    return normalize_or(frame_from_local(frame, vec3f((r * sc.y), (r * sc.x), (1.0 - below))), peak);
}

fn hg_sample(g: f32, rest: f32, wo: vec3f, u: vec2f) -> vec3f {
    return phase_direction((wo * select(1.0, -1.0, (g >= 0.0))), hg_below(abs(g), rest, u.y), u.x);
}

fn draine_eval(g: f32, alpha: f32, wo: vec3f, wi: vec3f) -> f32 {
    let c = dot(wo, wi);
    return ((hg_eval(g, (1.0 - abs(g)), wo, wi) * (1.0 + ((alpha * c) * c))) / (1.0 + ((alpha * (1.0 + ((2.0 * g) * g))) * (1.0 / 3.0))));
}

fn draine_sample(g: f32, alpha: f32, wo: vec3f, u: vec2f) -> vec3f {
    let a = abs(g);
    let goal = (u.y * (1.0 + ((alpha * (1.0 + ((2.0 * a) * a))) * (1.0 / 3.0))));
    var low: f32 = 0.0;
    var high: f32 = 1.0;
    var x: f32 = u.y;
    var step: u32 = 0u;
    while (step < 24u) {
        let y = ((1.0 - a) + ((2.0 * a) * x));
        let part = (((2.0 * a) * x) / y);
        let whole = ((((1.0 + a) * (1.0 + a)) * x) / y);
        let square = ((1.0 - (2.0 * whole)) + (((whole * whole) * (4.0 - part)) * (1.0 / 3.0)));
        let miss = ((x * (1.0 + (alpha * square))) - goal);
        let c = ((whole * (2.0 - part)) - 1.0);
        low = select(low, x, (miss <= 0.0));
        high = select(x, high, (miss <= 0.0));
        let newton = (x - (miss / (1.0 + ((alpha * c) * c))));
        let next = select((0.5 * (low + high)), newton, ((newton > low) && (newton < high)));
        step = select((step + 1u), 24u, (abs((next - x)) < 5e-8));
        x = next;
    }
    return phase_direction((wo * select(1.0, -1.0, (g >= 0.0))), hg_below(a, (1.0 - a), (1.0 - x)), u.x);
}

struct Fog {
    g_hg: f32,
    rest: f32,
    g_draine: f32,
    alpha: f32,
    share: f32
}

fn fog_new(diameter: f32) -> Fog {
    let d = min(nonnegative(diameter), DROPLET_MOST);
    if (d <= 0.1) {
        let g_hg = ((13.8 * d) * d);
        return Fog(g_hg, (1.0 - g_hg), ((1.1456 * d) * math_sin((9.29044 * d))), 250.0, (0.252977 - (312.983 * math_pow(d, 4.3))));
    }
    let l = math_log(d);
    if (d < 1.5) {
        let inner = math_cos((((l - 0.238604) * (l + 1.00667)) / (0.507522 - (0.15677 * l))));
        let outer = math_cos((((1.19692 * inner) + (1.37932 * l)) + 0.0625835));
        let g_hg = (0.862 - ((0.143 * l) * l));
        return Fog(g_hg, (1.0 - g_hg), ((0.379685 * outer) + 0.344213), 250.0, (((0.146209 * math_cos(((3.38707 * l) + 2.11193))) + 0.316072) + (0.0778917 * l)));
    }
    if (d < 5.0) {
        let ll = math_log(l);
        let g_hg = ((0.0604931 * ll) + 0.940256);
        return Fog(g_hg, (1.0 - g_hg), (0.500411 - (0.081287 / (((-2.0 * l) + math_tan(l)) + 1.27551))), ((7.30354 * l) + 6.31675), ((0.026914 * (l - math_cos((5.68947 * (ll - 0.0292149))))) + 0.376475));
    }
    let narrow = (0.0990567 / (d - 1.67154));
    return Fog(math_exp(-narrow), ((2.0 * math_exp((-0.5 * narrow))) * math_sinh((0.5 * narrow))), math_exp(((-2.20679 / (d + 3.91029)) - 0.428934)), math_exp((3.62489 - (8.29288 / (d + 5.52825)))), math_exp(((-0.599085 / (d - 0.641583)) - 0.665888)));
}

fn fog_eval(fog: Fog, wo: vec3f, wi: vec3f) -> f32 {
    let draine = draine_eval(fog.g_draine, fog.alpha, wo, wi);
    return (((1.0 - fog.share) * hg_eval(fog.g_hg, fog.rest, wo, wi)) + (fog.share * draine));
}

fn fog_sample(fog: Fog, wo: vec3f, u: vec3f) -> vec3f {
    if (u.z < fog.share) {
        return draine_sample(fog.g_draine, fog.alpha, wo, u.xy);
    }
    return hg_sample(fog.g_hg, fog.rest, wo, u.xy);
}
struct VdfValue {
    value: vec3f,
    pdf: f32
}

struct VdfSample {
    wi: vec3f,
    pdf: f32,
    weight: vec3f
}

fn vdf_leaf_eval(n: vec4u, p: ptr<function, Params>, wo: vec3f, wi: vec3f) -> f32 {
    let op = (n.x & OP_MASK);
    if (op == OP_ANISOTROPIC_VDF) {
        let g = sane_bias(param(p, n.y));
        return hg_eval(g, (1.0 - abs(g)), wo, wi);
    }
    if (op == OP_FOG_VDF) {
        return fog_eval(fog_new(param(p, n.y)), wo, wi);
    }
    return 0.0;
}

fn vdf_eval(program: ptr<function, Program>, p: ptr<function, Params>, wo: vec3f, wi: vec3f) -> VdfValue {
    var result: VdfValue = VdfValue(splat3(0.0), 0.0);
    let point = shading_point(vec3f(0.0, 0.0, 1.0), splat3(1.0), splat3(1.0), 0u);
    var visit: Visit = visit_root();
    var stack: array<Visit, 6> = array(visit, visit, visit, visit, visit, visit);
    var depth: u32 = 0u;
    var running: bool = true;
    while running {
        let n = bsdf_node(program, visit.node);
        let op = (n.x & OP_MASK);
        if (op == OP_WEIGHTED_LAYER) {
            let fork = weighted_fork(n, p, visit);
            stack[u32(depth)] = fork.later;
            visit = fork.now;
            depth += 1u;
        } else if ((op == OP_TINT) || (op == OP_SCALE)) {
            visit.weight *= modifier_factor(n, p, point, visit.normal, wo, wi, false);
            visit.node += 1u;
        } else {
            let phase = vdf_leaf_eval(n, p, wo, wi);
            result.value += (visit.weight * phase);
            result.pdf += (visit.prob * phase);
            running = (depth > 0u);
            if running {
                depth -= 1u;
                visit = stack[u32(depth)];
            }
        }
    }
    return result;
}

fn vdf_sample(program: ptr<function, Program>, p: ptr<function, Params>, wo: vec3f, u: vec3f) -> VdfSample {
    let chosen = weighted_leaf(program, p, u.z);
    let n = chosen.n;
    let op = (n.x & OP_MASK);
    var wi: vec3f = vec3f(-wo.x, -wo.y, -wo.z);
    if (op == OP_ANISOTROPIC_VDF) {
        let g = sane_bias(param(p, n.y));
        wi = hg_sample(g, (1.0 - abs(g)), wo, u.xy);
    } else if (op == OP_FOG_VDF) {
        wi = fog_sample(fog_new(param(p, n.y)), wo, vec3f(u.x, u.y, chosen.rest));
    } else {
        return VdfSample(wi, 0.0, splat3(0.0));
    }
    let v = vdf_eval(program, p, wo, wi);
    return VdfSample(wi, v.pdf, (v.value * (1.0 / max(v.pdf, 1e-37))));
}
const LAYERED_BSDF_VERSION: u32 = 1u;
