// Lookups in textures over one buffer of words.
//
// The twin of `texture/*.rs`: same functions, same order, same results. Where texels lie is computed in
// integers, so that no rounding of a product, fused or not, can pick another texel.
//
// Words 0 to 255: what the codes of sRGB mean, as floats. Word 256: number of textures. From word 257 on
// eight words per texture: width, height, first word of its texels, format, depth, and of a set of tiles
// columns, rows, and the first word of the numbers of its textures. Row 0 is the bottom row, v = 0.

@group(0) @binding(0) var<storage, read> tex_words: array<u32>;

fn tex_header(texture: u32) -> u32 {
    return 257u + texture * 8u;
}

// The texture of a tile; one that does not exist has a number that does not exist. A texture that is no set
// has one tile.
fn tex_tile(texture: u32, tile: vec2<i32>) -> u32 {
    if texture >= tex_words[256] {
        return texture;
    }
    let header = tex_header(texture);
    let columns = i32(tex_words[header + 5u]);
    let rows = i32(tex_words[header + 6u]);
    if tile.x < 0i || tile.y < 0i || tile.x >= max(columns, 1i) || tile.y >= max(rows, 1i) {
        return 0xffffffffu;
    }
    if columns == 0i {
        return texture;
    }
    return tex_words[tex_words[header + 7u] + u32(tile.y * columns + tile.x)];
}

fn tex_size_2d(texture: u32, tile: vec2<i32>) -> vec2<u32> {
    return tex_size_3d(tex_tile(texture, tile)).xy;
}

fn tex_size_3d(texture: u32) -> vec3<u32> {
    if texture >= tex_words[256] {
        return vec3<u32>(0u, 0u, 0u);
    }
    let header = tex_header(texture);
    return vec3<u32>(tex_words[header], tex_words[header + 1u], tex_words[header + 4u]);
}

// Texel number `texel` of a texture that has as many.
fn tex_fetch(texture: u32, texel: u32) -> vec4<f32> {
    let header = tex_header(texture);
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
    if format == 4u {
        let value = bitcast<f32>(word);
        return vec4<f32>(value, value, value, 1.0);
    }
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

fn tex_texel_2d(texture: u32, coord: vec2<i32>, tile: vec2<i32>) -> vec4<f32> {
    return tex_texel_3d(tex_tile(texture, tile), vec3<i32>(coord, 0i));
}

fn tex_texel_3d(texture: u32, coord: vec3<i32>) -> vec4<f32> {
    let size = vec3<i32>(tex_size_3d(texture));
    if any(coord < vec3<i32>(0i, 0i, 0i)) || any(coord >= size) {
        return vec4<f32>(0.0, 0.0, 0.0, 0.0);
    }
    return tex_fetch(texture, u32((coord.z * size.y + coord.y) * size.x + coord.x));
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

// The texels of one axis that a lookup blends, and the weight of the second.
struct TexAxis {
    a: u32,
    b: u32,
    f: f32,
}

fn tex_axis(u: f32, wrap: u32, crop: vec2<f32>, size: u32) -> TexAxis {
    let region = tex_region(crop, size);
    let p = tex_scale(tex_fixed(u, wrap), u32(region.y));
    // Texel centres are at halves.
    let i = (i32(p.x) - 2048i) >> 12u;
    let f = (f32(i32((p.x + 2048u) & 4095u)) + f32(i32(p.y)) * 0.00024414063) * 0.00024414063;
    let a = u32(region.x + tex_wrap(i, region.y, wrap));
    let b = u32(region.x + tex_wrap(i + 1i, region.y, wrap));
    return TexAxis(a, b, f);
}

// The blend of four texels of a slice that begins at texel `slice`.
fn tex_bilinear(texture: u32, slice: u32, width: u32, x: TexAxis, y: TexAxis) -> vec4<f32> {
    let a = tex_fetch(texture, slice + y.a * width + x.a);
    let b = tex_fetch(texture, slice + y.a * width + x.b);
    let c = tex_fetch(texture, slice + y.b * width + x.a);
    let d = tex_fetch(texture, slice + y.b * width + x.b);
    let low = a + (b - a) * x.f;
    let high = c + (d - c) * x.f;
    return low + (high - low) * y.f;
}

// A set of tiles is looked up in the tile that holds the coordinate: its edges end, and it has no crop.
fn tex_lookup_2d(texture: u32, coord: vec2<f32>, wrap: vec2<u32>, crop: vec4<f32>) -> vec4<f32> {
    if texture >= tex_words[256] {
        return vec4<f32>(0.0, 0.0, 0.0, 0.0);
    }
    if tex_words[tex_header(texture) + 5u] == 0u {
        return tex_lookup_tile(texture, coord, wrap, crop);
    }
    // Beyond 2^16 there are no tiles; NaN is there, too.
    let near = abs(coord) < vec2<f32>(65536.0, 65536.0);
    let whole = floor(select(vec2<f32>(-1.0, -1.0), coord, near));
    let tile = tex_tile(texture, vec2<i32>(whole));
    let ends = vec2<u32>(0u, 0u);
    return tex_lookup_tile(tile, coord - whole, ends, vec4<f32>(0.0, 1.0, 0.0, 1.0));
}

fn tex_lookup_tile(texture: u32, coord: vec2<f32>, wrap: vec2<u32>, crop: vec4<f32>) -> vec4<f32> {
    let size = tex_size_3d(texture);
    if size.x == 0u || tex_clipped(coord.x, wrap.x) || tex_clipped(coord.y, wrap.y) {
        return vec4<f32>(0.0, 0.0, 0.0, 0.0);
    }
    let x = tex_axis(coord.x, wrap.x, crop.xy, size.x);
    let y = tex_axis(coord.y, wrap.y, crop.zw, size.y);
    return tex_bilinear(texture, 0u, size.x, x, y);
}

fn tex_lookup_3d(
    texture: u32,
    coord: vec3<f32>,
    wrap: vec3<u32>,
    crop: vec4<f32>,
    crop_w: vec2<f32>,
) -> vec4<f32> {
    let size = tex_size_3d(texture);
    if size.x == 0u
        || tex_clipped(coord.x, wrap.x) || tex_clipped(coord.y, wrap.y) || tex_clipped(coord.z, wrap.z) {
        return vec4<f32>(0.0, 0.0, 0.0, 0.0);
    }
    let x = tex_axis(coord.x, wrap.x, crop.xy, size.x);
    let y = tex_axis(coord.y, wrap.y, crop.zw, size.y);
    let z = tex_axis(coord.z, wrap.z, crop_w, size.z);
    let slice = size.x * size.y;
    let near = tex_bilinear(texture, z.a * slice, size.x, x, y);
    let far = tex_bilinear(texture, z.b * slice, size.x, x, y);
    return near + (far - near) * z.f;
}
