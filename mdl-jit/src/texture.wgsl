// Lookups in two-dimensional textures over one buffer of words.
//
// The twin of `texture.rs`: same functions, same order, same results. Where texels lie is computed in
// integers, so that no rounding of a product, fused or not, can pick another texel.
//
// Words 0 to 255: what the codes of sRGB mean, as floats. Word 256: number of textures. From word 257 on
// eight words per texture: width, height, first word of its texels, format, and four unused. Row 0 is
// the bottom row, v = 0.

@group(0) @binding(0) var<storage, read> tex_words: array<u32>;

fn tex_size_2d(texture: u32) -> vec2<u32> {
    if texture >= tex_words[256] {
        return vec2<u32>(0u, 0u);
    }
    let header = 257u + texture * 8u;
    return vec2<u32>(tex_words[header], tex_words[header + 1u]);
}

// The texel at a place within the texture.
fn tex_fetch(texture: u32, x: u32, y: u32) -> vec4<f32> {
    let header = 257u + texture * 8u;
    let texel = y * tex_words[header] + x;
    let first = tex_words[header + 2u];
    let format = tex_words[header + 3u];
    if format == 0u {
        let at = first + texel * 4u;
        return vec4<f32>(
            bitcast<f32>(tex_words[at]),
            bitcast<f32>(tex_words[at + 1u]),
            bitcast<f32>(tex_words[at + 2u]),
            bitcast<f32>(tex_words[at + 3u]),
        );
    }
    if format == 3u {
        let at = first + texel * 2u;
        return vec4<f32>(unpack2x16float(tex_words[at]), unpack2x16float(tex_words[at + 1u]));
    }
    let word = tex_words[first + texel];
    if format == 2u {
        return vec4<f32>(
            bitcast<f32>(tex_words[word & 255u]),
            bitcast<f32>(tex_words[(word >> 8u) & 255u]),
            bitcast<f32>(tex_words[(word >> 16u) & 255u]),
            f32(word >> 24u) / 255.0,
        );
    }
    return vec4<f32>(
        f32(word & 255u) / 255.0,
        f32((word >> 8u) & 255u) / 255.0,
        f32((word >> 16u) & 255u) / 255.0,
        f32(word >> 24u) / 255.0,
    );
}

fn tex_texel_2d(texture: u32, coord: vec2<i32>) -> vec4<f32> {
    let size = vec2<i32>(tex_size_2d(texture));
    if coord.x < 0i || coord.y < 0i || coord.x >= size.x || coord.y >= size.y {
        return vec4<f32>(0.0, 0.0, 0.0, 0.0);
    }
    return tex_fetch(texture, u32(coord.x), u32(coord.y));
}

// A coordinate brought to one period, in units of 2^-24. NaN and infinities count as 0.
fn tex_fixed(u: f32, wrap: u32) -> u32 {
    let x = select(0.0, u, abs(u) < 1e30);
    let repeated = x - floor(x);
    let mirrored = x - 2.0 * floor(x * 0.5);
    let clamped = min(max(x, 0.0), 1.0);
    let bounded = select(select(clamped, mirrored, wrap == 2u), repeated, wrap == 1u);
    return u32(bounded * 16777216.0);
}

// t * n in units of 2^-12 of what n counts, and the rest in units of 2^-24.
fn tex_scale(t: u32, n: u32) -> vec2<u32> {
    let low = (t & 4095u) * n;
    return vec2<u32>((t >> 12u) * n + (low >> 12u), low & 4095u);
}

// First texel and number of texels of a crop.
fn tex_region(crop: vec2<f32>, size: u32) -> vec2<i32> {
    let from_ = (tex_scale(tex_fixed(crop.x, 0u), size).x + 2048u) >> 12u;
    let to = (tex_scale(tex_fixed(crop.y, 0u), size).x + 2048u) >> 12u;
    let first = min(from_, size - 1u);
    return vec2<i32>(i32(first), max(i32(to) - i32(first), 1i));
}

// A texel index, one beyond the region at most, brought into it.
fn tex_wrap(i: i32, n: i32, wrap: u32) -> i32 {
    let up = select(i, i + n, i < 0i);
    let repeated = select(up, up - n, up >= n);
    let folded = select(i, -1i - i, i < 0i);
    let mirrored = min(folded, 2i * n - 1i - folded);
    let bounded = select(i, mirrored, wrap == 2u);
    return select(min(max(bounded, 0i), n - 1i), repeated, wrap == 1u);
}

fn tex_clipped(u: f32, wrap: u32) -> bool {
    return wrap == 3u && !(u >= 0.0 && u <= 1.0);
}

fn tex_lookup_2d(texture: u32, coord: vec2<f32>, wrap: vec2<u32>, crop: vec4<f32>) -> vec4<f32> {
    let size = tex_size_2d(texture);
    if size.x == 0u || tex_clipped(coord.x, wrap.x) || tex_clipped(coord.y, wrap.y) {
        return vec4<f32>(0.0, 0.0, 0.0, 0.0);
    }
    let across = tex_region(crop.xy, size.x);
    let along = tex_region(crop.zw, size.y);
    let px = tex_scale(tex_fixed(coord.x, wrap.x), u32(across.y));
    let py = tex_scale(tex_fixed(coord.y, wrap.y), u32(along.y));
    // Texel centres are at halves.
    let ix = (i32(px.x) - 2048i) >> 12u;
    let iy = (i32(py.x) - 2048i) >> 12u;
    let fx = (f32(i32((px.x + 2048u) & 4095u)) + f32(i32(px.y)) * 0.00024414063) * 0.00024414063;
    let fy = (f32(i32((py.x + 2048u) & 4095u)) + f32(i32(py.y)) * 0.00024414063) * 0.00024414063;
    let x0 = u32(across.x + tex_wrap(ix, across.y, wrap.x));
    let x1 = u32(across.x + tex_wrap(ix + 1i, across.y, wrap.x));
    let y0 = u32(along.x + tex_wrap(iy, along.y, wrap.y));
    let y1 = u32(along.x + tex_wrap(iy + 1i, along.y, wrap.y));
    let a = tex_fetch(texture, x0, y0);
    let b = tex_fetch(texture, x1, y0);
    let c = tex_fetch(texture, x0, y1);
    let d = tex_fetch(texture, x1, y1);
    let low = a + (b - a) * fx;
    let high = c + (d - c) * fx;
    return low + (high - low) * fy;
}
