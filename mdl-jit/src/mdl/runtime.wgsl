// What generated code calls besides the math library and texture access.

/// Rows of transforms, six per instance: three of object to world, then three of world to object.
@group(0) @binding(0) var<storage, read> transforms: array<vec4<f32>>;

/// First row of the transform of an instance: `direction` 1 is into object space, -1 out of it.
fn mdl_transform_rows(instance: u32, direction: i32) -> u32 {
    return instance * 6u + select(0u, 3u, direction > 0);
}

fn mdl_transform_vector(instance: u32, direction: i32, v: vec3<f32>) -> vec3<f32> {
    if direction == 0 {
        return v;
    }
    let row = mdl_transform_rows(instance, direction);
    return vec3<f32>(
        dot(transforms[row].xyz, v),
        dot(transforms[row + 1u].xyz, v),
        dot(transforms[row + 2u].xyz, v),
    );
}

fn mdl_transform_point(instance: u32, direction: i32, p: vec3<f32>) -> vec3<f32> {
    if direction == 0 {
        return p;
    }
    let row = mdl_transform_rows(instance, direction);
    let shift = vec3<f32>(transforms[row].w, transforms[row + 1u].w, transforms[row + 2u].w);
    return mdl_transform_vector(instance, direction, p) + shift;
}

/// By the transposed inverse, which is the transpose of the opposite transform.
fn mdl_transform_normal(instance: u32, direction: i32, n: vec3<f32>) -> vec3<f32> {
    if direction == 0 {
        return n;
    }
    let row = mdl_transform_rows(instance, -direction);
    return n.x * transforms[row].xyz + n.y * transforms[row + 1u].xyz + n.z * transforms[row + 2u].xyz;
}

/// By the mean length of the images of the axes.
fn mdl_transform_scale(instance: u32, direction: i32, scale: f32) -> f32 {
    let x = mdl_transform_vector(instance, direction, vec3<f32>(1.0, 0.0, 0.0));
    let y = mdl_transform_vector(instance, direction, vec3<f32>(0.0, 1.0, 0.0));
    let z = mdl_transform_vector(instance, direction, vec3<f32>(0.0, 0.0, 1.0));
    return scale * (length(x) + length(y) + length(z)) * 0.33333334;
}

fn mdl_transform(instance: u32, direction: i32) -> mat4x4<f32> {
    let last = vec4<f32>(0.0, 0.0, 0.0, 1.0);
    if direction == 0 {
        return mat4x4<f32>(
            vec4<f32>(1.0, 0.0, 0.0, 0.0),
            vec4<f32>(0.0, 1.0, 0.0, 0.0),
            vec4<f32>(0.0, 0.0, 1.0, 0.0),
            last,
        );
    }
    let row = mdl_transform_rows(instance, direction);
    return transpose(mat4x4<f32>(transforms[row], transforms[row + 1u], transforms[row + 2u], last));
}

/// x to the power of n by squaring, in wrapping arithmetic. A negative power is 1/x^-n, rounded to zero.
fn mdl_pow_int(x: i32, n: i32) -> i32 {
    if n < 0 {
        let sign = select(-1, 1, (n & 1) == 0);
        return select(0, select(sign, 1, x == 1), x == 1 || x == -1);
    }
    var result = 1;
    var base = x;
    var rest = n;
    while rest != 0 {
        if (rest & 1) != 0 {
            result = result * base;
        }
        base = base * base;
        rest = rest >> 1u;
    }
    return result;
}

/// The colour of a black body at a temperature in kelvin, linear sRGB of luminance 1.
/// Chromaticity after M. Krystek, "An algorithm to calculate correlated colour temperature", Color
/// Research and Application 10(1), 1985; fitted for 1000 K to 15000 K, to which the argument is limited.
fn mdl_blackbody(temperature: f32) -> vec3<f32> {
    let t = clamp(temperature, 1000.0, 15000.0);
    let u = (0.860117757 + t * (1.54118254e-4 + t * 1.28641212e-7))
        / (1.0 + t * (8.42420235e-4 + t * 7.08145163e-7));
    let v = (0.317398726 + t * (4.22806245e-5 + t * 4.20481691e-8))
        / (1.0 + t * (-2.89741816e-5 + t * 1.61456053e-7));
    // x = 3u/d and y = 2v/d with d = 2u - 8v + 4, so X/Y = 3u/2v and Z/Y = (d - 3u - 2v)/2v.
    let xr = 1.5 * u / v;
    let zr = (2.0 - 0.5 * u - 5.0 * v) / v;
    return max(
        vec3<f32>(
            3.2404542 * xr - 1.5371385 - 0.4985314 * zr,
            -0.969266 * xr + 1.8760108 + 0.041556 * zr,
            0.0556434 * xr - 0.2040259 + 1.0572252 * zr,
        ),
        vec3<f32>(0.0),
    );
}

/// Intensity over power of a light profile, sr^-1, in a direction of its frame; the texture is laid out by
/// `renderer/src/images/profile.rs`.
fn mdl_profile(profile: u32, w: vec3<f32>) -> f32 {
    let size = tex_size_3d(profile);
    let square = dot(w, w);
    if size.x == 0u || !(square > 0.0) {
        return 0.0;
    }
    let d = w / sqrt(square);
    let theta = math_acos(clamp(d.z, -1.0, 1.0)) * 0.31830987;
    let u = math_atan2(d.y, d.x) * 0.15915494 + 0.5 / f32(size.x);
    let v = (theta * f32(size.y - 1u) + 0.5) / f32(size.y);
    return tex_lookup_2d(profile, vec2<f32>(u, v), vec2<u32>(1u, 0u), vec4<f32>(0.0, 1.0, 0.0, 1.0)).x;
}

/// With the angle 0 along the normal z: what a small surface sends has the intensities of the profile, so
/// its radiance is them over the cosine, which has a least value.
fn mdl_profile_local(profile: u32, toward: vec3<f32>, tangent: vec3<f32>, side: vec3<f32>, z: vec3<f32>) -> f32 {
    let flat_ = tangent - z * dot(tangent, z);
    let square = dot(flat_, flat_);
    let x = select(side, flat_ / sqrt(max(square, 1e-20)), square > 1e-12);
    let y = cross(z, x);
    let cosine = dot(toward, z);
    return 3.1415927 * mdl_profile(profile, vec3<f32>(dot(toward, x), dot(toward, y), cosine)) / max(cosine, 1e-3);
}

/// For a body as a whole: radiance is the same all over it, in proportion to the profile. A convex body shows
/// a quarter of its area on average (A. Cauchy), which makes up for the 4.
fn mdl_profile_global(profile: u32, toward: vec3<f32>, instance: u32, frame: mat3x3<f32>) -> f32 {
    let d = mdl_transform_vector(instance, 1, toward);
    let w = vec3<f32>(dot(frame[0], d), dot(frame[1], d), dot(frame[2], d));
    return 12.566371 * mdl_profile(profile, w);
}
