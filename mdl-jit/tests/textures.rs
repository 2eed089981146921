//! Texture lookups: the host's code and the shader text give the same texels.

mod common;

use common::{Case, Column, Random};
use mdl_jit::externs::{STUBS, TEXTURES};
use mdl_jit::texture::{Entry, Format, Image, Lookup, Lookup3d, NO_TEXTURE, TextureTable, Textures};
use mdl_jit::types::Kind;
use mdl_jit::{Executor, Program};

/// Textures of all formats and of awkward sizes.
fn table() -> TextureTable {
    let mut r = Random::new(5);
    let mut words = |n: usize, mut f: Box<dyn FnMut(&mut Random) -> u32>| -> Vec<u32> {
        (0..n).map(|_| f(&mut r)).collect()
    };
    let floats = words(7 * 5 * 4, Box::new(|r| (r.below(1000) as f32 / 100.0).to_bits()));
    let bytes = words(16 * 16, Box::new(Random::next));
    let codes = words(3, Box::new(Random::next));
    let halves = words(4 * 6 * 2, Box::new(|r| (r.below(0x7b00) << 16) | r.below(0x7b00)));
    let greys = words(3 * 4 * 5, Box::new(|r| (r.below(1000) as f32 / 100.0 - 2.0).to_bits()));
    let grid = words(8 * 2 * 4, Box::new(Random::next));
    let image =
        |width, height, depth, format, texels| Entry::Image(Image { width, height, depth, format, texels });
    TextureTable::with_tiles(&[
        image(7, 5, 1, Format::Rgba32Float, &floats),
        image(16, 16, 1, Format::Rgba8, &bytes),
        image(1, 3, 1, Format::Rgba8Srgb, &codes),
        image(4, 6, 1, Format::Rgba16Float, &halves),
        image(3, 4, 5, Format::Grey32Float, &greys),
        Entry::Tiles { columns: 2, rows: 3, numbers: &[0, 1, NO_TEXTURE, 3, 2, NO_TEXTURE] },
        image(8, 2, 4, Format::Rgba8, &grid),
    ])
    .expect("the textures fit")
}

const CALLER: &str = "
fn f(
    texture: u32,
    coord: vec3<f32>,
    wrap: vec3<u32>,
    crop: vec4<f32>,
    crop_w: vec2<f32>,
    at: vec3<i32>,
    tile: vec2<i32>,
) -> vec4<f32> {
    let size = tex_size_2d(texture, tile);
    let solid = tex_size_3d(texture);
    return tex_lookup_2d(texture, coord.xy, wrap.xy, crop)
        + 3.0 * tex_lookup_3d(texture, coord, wrap, crop, crop_w)
        + tex_texel_2d(texture, at.xy, tile) * f32(size.x + 2u * size.y)
        + tex_texel_3d(texture, at) * f32(solid.x + 2u * solid.y + 4u * solid.z);
}
";

/// Arguments at and around every seam.
fn argument(r: &mut Random, arg: usize, leaf: usize) -> u32 {
    match arg {
        0 => r.below(8),
        1 if r.chance(40) => {
            let edges =
                [0.0, 1.0, -1.0, 0.5, 1.5, -1e-9, 1e9, -1e9, f32::NAN, f32::INFINITY, f32::MIN, 0.999_999_94];
            r.pick(&edges).to_bits()
        }
        1 if r.chance(50) => ((r.below(64) as f32 - 16.0) / 32.0).to_bits(),
        1 => (r.next() as f32 / 4294967296.0 * 6.0 - 3.0).to_bits(),
        2 => r.below(4),
        3 | 4 if r.chance(60) => [0.0f32, 1.0][leaf % 2].to_bits(),
        3 | 4 => (r.below(17) as f32 / 16.0).to_bits(),
        5 => r.below(9).wrapping_sub(1),
        _ if r.chance(50) => 0,
        _ => r.below(5).wrapping_sub(1),
    }
}

fn case<'p>(program: &'p Program, points: usize) -> Case<'p> {
    let mut r = Random::new(9);
    Case::new(program, "f", false).fill(points, |arg, leaf, _, _| argument(&mut r, arg, leaf))
}

#[test]
fn host_functions_and_shader_text_agree_bit_for_bit() {
    let table = table();
    let stubs = Program::from_wgsl(&format!("{STUBS}{CALLER}")).expect("the stubs validate");
    let mut by_host = case(&stubs, 5003);
    by_host.textures = Some(&table);
    by_host.check().expect("all executors call the host alike");
    let want = by_host.run(Executor::Interp32).expect("the stubs run");

    let text = Program::from_wgsl(&format!("{TEXTURES}{CALLER}")).expect("the text validates");
    let mut by_text = case(&text, 5003);
    by_text.options.textures = false;
    let words = text.global("tex_words").expect("the text has a buffer");
    by_text.buffers.push((words, table.words().to_vec()));
    by_text.check().expect("all executors run the text alike");
    let got = by_text.run(Executor::Interp32).expect("the text runs");
    by_host.equal("shader text", &want, &got).expect("the same values");
}

#[cfg(feature = "gpu")]
#[test]
fn lookups_on_the_gpu_equal_those_of_the_host() {
    let Some(gpu) = common::gpu("lookups_on_the_gpu_equal_those_of_the_host") else { return };
    let table = table();
    let stubs = Program::from_wgsl(&format!("{STUBS}{CALLER}")).expect("the stubs validate");
    let mut case = case(&stubs, 20_003);
    case.textures = Some(&table);
    let want = case.run(Executor::Interp32).expect("the stubs run");
    let got = case.run(Executor::Gpu(gpu)).expect("the kernel runs");
    for (w, g) in want.iter().zip(&got) {
        let (Column::F32(w), Column::F32(g)) = (w, g) else { panic!("lookups give floats") };
        for (p, (w, g)) in w.iter().zip(g).enumerate() {
            // The division by 255 and the blends may round differently; the texels are the same.
            assert!((w - g).abs() <= 1e-5 * w.abs().max(1.0), "point {p}: {g} instead of {w}");
        }
    }
}

#[test]
fn an_unbound_host_function_is_a_fault() {
    let stubs = Program::from_wgsl(&format!("{STUBS}{CALLER}")).expect("the stubs validate");
    let case = case(&stubs, 5);
    for executor in [Executor::Interp32, Executor::Cpu] {
        let error = case.run(executor).expect_err("nothing is bound").to_string();
        assert!(error.contains("is not bound"), "{error}");
    }
}

#[test]
fn a_panicking_host_function_is_a_fault() {
    let stubs = Program::from_wgsl(&format!("{STUBS}{CALLER}")).expect("the stubs validate");
    let mut case = case(&stubs, 5);
    case.options.externs = vec!["tex_size_2d".into()];
    case.options.textures = false;
    let bad = |_: &mut mdl_jit::Call<'_>| panic!("on purpose");
    case.externs = mdl_jit::Externs::new().with("tex_size_2d", &bad);
    for executor in [Executor::Interp32, Executor::Cpu] {
        let error = case.run(executor).expect_err("the function panics").to_string();
        assert!(error.contains("tex_size_2d"), "{error}");
    }
}

fn lookup(table: &TextureTable, u: f32, v: f32, wrap: u32) -> f32 {
    let l = Lookup { texture: 0, coord: [u, v], wrap: [wrap; 2], crop: [0.0, 1.0, 0.0, 1.0] };
    table.lookup_2d(&l)[0]
}

#[test]
fn texel_centres_give_their_texels_in_every_wrap_mode() {
    let texels: Vec<u32> = (0..4 * 2 * 4).map(|i| ((i / 4) as f32).to_bits()).collect();
    let image = Image { width: 4, height: 2, depth: 1, format: Format::Rgba32Float, texels: &texels };
    let t = TextureTable::new(&[image]).expect("the texture fits");
    for x in 0..4 {
        let u = (x as f32 + 0.5) / 4.0;
        assert_eq!(lookup(&t, u, 0.25, 0), x as f32);
        assert_eq!(lookup(&t, u + 5.0, 0.75, 1), 4.0 + x as f32);
        assert_eq!(lookup(&t, u - 3.0, 0.25, 1), x as f32);
        assert_eq!(lookup(&t, -u, 0.25, 2), x as f32);
        assert_eq!(lookup(&t, 2.0 - u, 0.25, 2), x as f32);
        assert_eq!(lookup(&t, u, 0.25, 3), x as f32);
    }
    // Between the last and the first texel of a repeated texture.
    assert_eq!(lookup(&t, 1.0, 0.25, 1), 1.5);
    assert_eq!(lookup(&t, 0.0, 0.25, 1), 1.5);
    assert_eq!(lookup(&t, 1.0, 0.25, 0), 3.0);
    assert_eq!(lookup(&t, 1.5, 0.25, 3), 0.0);
    assert_eq!(lookup(&t, 0.5, -0.1, 3), 0.0);
    assert!(lookup(&t, f32::NAN, f32::NEG_INFINITY, 1).is_finite());
}

#[test]
fn a_crop_is_a_texture_of_its_own() {
    let texels: Vec<u32> = (0..8 * 4).map(|i| ((i / 4) as f32).to_bits()).collect();
    let whole = Image { width: 8, height: 1, depth: 1, format: Format::Rgba32Float, texels: &texels };
    let part = Image { width: 4, height: 1, depth: 1, format: Format::Rgba32Float, texels: &texels[2 * 4..] };
    let t = TextureTable::new(&[whole, part]).expect("the textures fit");
    for wrap in 0..4 {
        for i in -40..40 {
            let coord = [i as f32 / 13.0, 0.5];
            let of = |texture, crop| t.lookup_2d(&Lookup { texture, coord, wrap: [wrap; 2], crop });
            assert_eq!(of(0, [0.25, 0.75, 0.0, 1.0]), of(1, [0.0, 1.0, 0.0, 1.0]), "{coord:?} {wrap}");
        }
    }
}

#[test]
fn solid_textures_blend_between_slices() {
    let texels: Vec<u32> = (0..2 * 2 * 3).map(|i| (i as f32).to_bits()).collect();
    let image = Image { width: 2, height: 2, depth: 3, format: Format::Grey32Float, texels: &texels };
    let t = TextureTable::new(&[image]).expect("the texture fits");
    let at = |coord: [f32; 3], wrap: u32, crop_w: [f32; 2]| {
        let crop = [0.0, 1.0, 0.0, 1.0, crop_w[0], crop_w[1]];
        t.lookup_3d(&Lookup3d { texture: 0, coord, wrap: [wrap; 3], crop })
    };
    let third = 1.0 / 3.0;
    assert_eq!(at([0.25, 0.25, 0.5 * third], 0, [0.0, 1.0]), [0.0, 0.0, 0.0, 1.0]);
    for (coord, wrap, expected) in [
        ([0.75, 0.25, 0.5 * third], 0, 1.0),
        ([0.25, 0.75, 0.5 * third], 0, 2.0),
        ([0.25, 0.25, 0.5], 0, 4.0),
        ([0.25, 0.25, third], 0, 2.0),
        // Between the last and the first slice.
        ([0.25, 0.25, 1.0], 1, 4.0),
        ([0.25, 0.25, 1.0], 0, 8.0),
        ([0.25, 0.25, 1.0], 2, 8.0),
        ([0.25, 0.25, 1.01], 3, 0.0),
        ([0.25, 0.25, -0.5 * third], 2, 0.0),
    ] {
        let found = at(coord, wrap, [0.0, 1.0])[0];
        assert!((found - expected).abs() < 1e-5, "{coord:?} {wrap}: {found}");
    }
    // The middle slice alone.
    assert_eq!(at([0.25, 0.25, 0.0], 1, [third, 2.0 * third])[0], 4.0);
    assert_eq!(t.texel_3d(0, [1, 1, 2])[0], 11.0);
    assert_eq!(t.texel_3d(0, [1, 1, 3]), [0.0; 4]);
    assert_eq!(t.size_3d(0), [2, 2, 3]);
}

#[test]
fn tiles_are_chosen_by_the_coordinate() {
    let texel = |x: f32| [x.to_bits()];
    let (a, b) = (texel(5.0), texel(7.0));
    let image =
        |texels| Entry::Image(Image { width: 1, height: 1, depth: 1, format: Format::Grey32Float, texels });
    let tiles = Entry::Tiles { columns: 2, rows: 2, numbers: &[0, NO_TEXTURE, NO_TEXTURE, 1] };
    let t = TextureTable::with_tiles(&[image(&a[..]), image(&b[..]), tiles]).expect("they fit");
    let at = |u: f32, v: f32| {
        t.lookup_2d(&Lookup { texture: 2, coord: [u, v], wrap: [1; 2], crop: [0.0, 0.5, 0.0, 0.5] })[0]
    };
    assert_eq!([at(0.5, 0.5), at(1.5, 1.5), at(0.0, 0.0), at(1.999, 1.0)], [5.0, 7.0, 5.0, 7.0]);
    // Where no tile is.
    let outside = [at(1.5, 0.5), at(-0.1, 0.5), at(2.0, 1.5), at(0.5, 1e9), at(f32::NAN, 0.5)];
    assert_eq!(outside, [0.0; 5]);
    assert_eq!((t.size_2d(2, [1, 1]), t.size_2d(2, [1, 0]), t.size_2d(0, [0, 0])), ([1, 1], [0, 0], [1, 1]));
    assert_eq!(t.texel_2d(2, [0, 0], [1, 1])[0], 7.0);
    assert_eq!(t.texel_2d(0, [0, 0], [1, 0])[0], 0.0);
    let too_few = Entry::Tiles { columns: 2, rows: 2, numbers: &[0] };
    assert!(TextureTable::with_tiles(&[too_few]).is_err());
}

#[test]
fn textures_of_no_size_or_too_few_words_are_refused() {
    let image = Image { width: 0, height: 1, depth: 1, format: Format::Rgba8, texels: &[] };
    assert!(TextureTable::new(&[image]).is_err());
    let image = Image { width: 2, height: 2, depth: 1, format: Format::Rgba8, texels: &[0; 3] };
    assert!(TextureTable::new(&[image]).is_err());
    let column = Column::zeros(Kind::F32, 1);
    assert_eq!(column.len(), 1);
}
