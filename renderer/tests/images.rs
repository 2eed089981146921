//! Image files: written and read back, limits, broken files.

mod common;

use common::*;
use glam::Vec3;
use mdl_jit::texture::{Format, Lookup, TextureTable, Textures};
use renderer::film::exr::{ExrMetadata, write_exr};
use renderer::film::png::write_png;
use renderer::film::tonemap::srgb_encode;
use renderer::images::{
    FloatImage, Gamma, ImageError, ImageLimits, TextureImage, load_environment, load_texture, read_exr,
};
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).expect("a folder for test files");
    folder
}

fn film() -> renderer::film::Film {
    let mut stage = Stage::new([0.0, 0.0, 4.0], [0.0; 3], 40.0, 0.5);
    stage.add(sphere(Vec3::ZERO, 1.0, 3, true), diffuse(0.8));
    stage.render(&settings(20, 16)).film
}

#[test]
fn exr_keeps_every_bit_and_has_metadata() {
    let film = film();
    let path = folder("exr").join("film.exr");
    let metadata = ExrMetadata { software: "lacquer 0.1".to_string(), comments: "16 spp".to_string() };
    let mut bytes = Cursor::new(Vec::new());
    write_exr(&film, &metadata, &mut bytes).expect("memory takes it");
    let mut again = Cursor::new(Vec::new());
    write_exr(&film, &metadata, &mut again).expect("memory takes it");
    assert_eq!(bytes.get_ref(), again.get_ref());
    fs::write(&path, bytes.get_ref()).expect("a file");
    let read = load_environment(&path, &ImageLimits::default()).expect("our own file");
    assert_eq!((read.width, read.height), (20, 20));
    assert_eq!(read.pixels, film.rgb());
    let text = String::from_utf8_lossy(bytes.get_ref()).into_owned();
    assert!(text.contains("lacquer 0.1") && text.contains("16 spp"));
}

fn texture(path: &Path, gamma: Gamma) -> TextureImage {
    load_texture(path, gamma, &ImageLimits::default()).expect("a picture")
}

/// The texel at a column and a row from the bottom, as lookups see it.
fn texel(image: &TextureImage, x: i32, y: i32) -> [f32; 4] {
    TextureTable::new(&[image.as_image()]).expect("a small texture").texel_2d(0, [x, y], [0; 2])
}

fn exr_bytes(image: &FloatImage) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    renderer::images::write_exr(image, &mut bytes).expect("memory takes it");
    bytes.into_inner()
}

#[test]
fn png_is_tone_mapped_and_reads_back() {
    let film = film();
    let path = folder("png").join("film.png");
    write_png(&film, 1.0, fs::File::create(&path).expect("a file")).expect("a disc takes it");
    let texture = texture(&path, Gamma::Default);
    assert_eq!((texture.width, texture.height, texture.format), (20, 20, Format::Rgba8Srgb));
    let expected = renderer::film::tonemap::neutral(film.pixels[0].mean.as_vec3());
    assert!((texel(&texture, 0, 19)[0] - expected.x).abs() < 0.01);
    // Upwards is v.
    let table = TextureTable::new(&[texture.as_image()]).expect("a small texture");
    let top = Lookup { texture: 0, coord: [0.025, 0.975], wrap: [0; 2], crop: [0.0, 1.0, 0.0, 1.0] };
    assert_eq!(table.lookup_2d(&top), texel(&texture, 0, 19));
}

#[test]
fn exr_of_floats_keeps_every_bit() {
    let mut random = 1u32;
    let mut next = || {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f32::from_bits(random & 0xbfff_ffff)
    };
    let pixels = (0..7 * 5).map(|_| [next(), next(), next()]).collect();
    let image = FloatImage { width: 7, height: 5, pixels };
    let path = folder("floats").join("floats.exr");
    fs::write(&path, exr_bytes(&image)).expect("a file");
    assert_eq!(read_exr(&path).expect("our own file"), image);
    assert_eq!(exr_bytes(&image), exr_bytes(&image));
    let wrong = FloatImage { width: 8, ..image };
    assert!(renderer::images::write_exr(&wrong, Cursor::new(Vec::new())).is_err());
}

#[test]
fn exr_of_luminance_is_grey() {
    use exr::prelude::{SpecificChannels, Vec2, WritableImage};
    let path = folder("floats").join("luminance.exr");
    let channels =
        SpecificChannels::build().with_channel("Y").with_pixel_fn(|at: Vec2<usize>| (at.x() as f32 + 0.5,));
    exr::prelude::Image::from_channels((3, 2), channels).write().to_file(&path).expect("a disc takes it");
    let image = load_environment(&path, &ImageLimits::default()).expect("a picture");
    assert_eq!(image.pixels[4], [1.5; 3]);
}

#[test]
fn gamma_mode_decides_what_numbers_mean() {
    let path = folder("gamma").join("grey.png");
    image::RgbaImage::from_pixel(3, 2, image::Rgba([128; 4])).save(&path).expect("a disc takes it");
    for (gamma, expected) in [(Gamma::Default, 0.2159), (Gamma::Srgb, 0.2159), (Gamma::Linear, 0.502)] {
        let [r, _, _, a] = texel(&texture(&path, gamma), 1, 1);
        assert!((r - expected).abs() < 1e-3 && (a - 0.502).abs() < 1e-3, "{gamma:?}: {r} {a}");
    }
    let path = folder("gamma").join("half.exr");
    fs::write(&path, exr_bytes(&FloatImage { width: 1, height: 1, pixels: vec![[0.5; 3]] })).expect("a file");
    for (gamma, expected) in [(Gamma::Default, 0.5), (Gamma::Srgb, 0.214_041), (Gamma::Linear, 0.5)] {
        let [r, _, _, a] = texel(&texture(&path, gamma), 0, 0);
        assert!((r - expected).abs() < 1e-5 && a == 1.0, "{gamma:?}: {r}");
        assert!((srgb_encode(0.214_041) - 0.5).abs() < 1e-5);
    }
}

#[test]
fn sixteen_bits_keep_their_digits() {
    let path = folder("deep").join("deep.png");
    let deep = image::ImageBuffer::<image::Luma<u16>, _>::from_pixel(2, 2, image::Luma([32_769]));
    deep.save(&path).expect("a disc takes it");
    let image = texture(&path, Gamma::Linear);
    assert!((texel(&image, 0, 1)[2] - 32_769.0 / 65_535.0).abs() < 1e-6);
}

#[test]
fn floats_are_halves_only_where_nothing_is_lost() {
    let load = |name: &str, value: f32| {
        let path = folder("half").join(name);
        let image = FloatImage { width: 2, height: 1, pixels: vec![[0.25; 3], [0.5, -value, value]] };
        fs::write(&path, exr_bytes(&image)).expect("a file");
        let image = texture(&path, Gamma::Default);
        assert_eq!(texel(&image, 1, 0), [0.5, -value, value, 1.0]);
        image.format
    };
    assert_eq!(load("exact.exr", 1023.5), Format::Rgba16Float);
    assert_eq!(load("subnormal.exr", 2f32.powi(-24)), Format::Rgba16Float);
    assert_eq!(load("fine.exr", 0.1), Format::Rgba32Float);
    assert_eq!(load("large.exr", 1e5), Format::Rgba32Float);
}

/// A smooth picture of another value in every texel.
fn gradient(width: u32, height: u32) -> image::RgbImage {
    image::RgbImage::from_fn(width, height, |x, y| {
        image::Rgb([(255 * x / width) as u8, (255 * y / height) as u8, 60])
    })
}

#[test]
fn every_format_is_known_by_its_content() {
    let source = gradient(16, 8);
    for extension in ["png", "jpg", "tiff", "tga", "webp", "hdr"] {
        let named = folder("formats").join(format!("picture.{extension}"));
        if extension == "hdr" {
            image::DynamicImage::from(source.clone()).into_rgb32f().save(&named).expect("a disc takes it");
        } else {
            source.save(&named).expect("a disc takes it");
        }
        // TGA has nothing to be known by.
        let path = if extension == "tga" { named } else { folder("formats").join(format!("of {extension}")) };
        if extension != "tga" {
            fs::copy(folder("formats").join(format!("picture.{extension}")), &path).expect("a copy");
        }
        let image = texture(&path, Gamma::Linear);
        assert_eq!((image.width, image.height), (16, 8), "{extension}");
        let found = texel(&image, 4, 6);
        let tolerance = if extension == "jpg" { 0.05 } else { 0.005 };
        for (channel, &expected) in source.get_pixel(4, 1).0.iter().enumerate() {
            let difference = (found[channel] - f32::from(expected) / 255.0).abs();
            assert!(difference < tolerance, "{extension} {channel}: {difference}");
        }
    }
}

#[test]
fn size_is_checked_before_memory_is_taken() {
    let path = folder("limits").join("wide.png");
    image::GrayImage::new(300, 2).save(&path).expect("a disc takes it");
    let small = ImageLimits { side: 256, bytes: 1 << 20 };
    let error = load_texture(&path, Gamma::Default, &small).expect_err("too wide").to_string();
    assert!(error.contains("wide.png"), "{error}");
    let few = ImageLimits { side: 1000, bytes: 1000 };
    assert!(load_texture(&path, Gamma::Default, &few).is_err());
    // A header that promises 2³¹ pixels along an axis.
    let mut bytes = fs::read(&path).expect("just written");
    bytes[16..20].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff]);
    let huge = folder("limits").join("huge.png");
    fs::write(&huge, bytes).expect("a file");
    assert!(load_texture(&huge, Gamma::Default, &ImageLimits::default()).is_err());
    // The same of other kinds, in a few bytes.
    let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2000000000 +X 2000000000\n\x02\x02";
    let none = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 0 +X 0\n";
    let mut tga = [0u8; 18];
    tga[2] = 2;
    tga[12..17].copy_from_slice(&[0xff, 0xff, 0xff, 0xff, 32]);
    let mut exr = exr_bytes(&FloatImage { width: 4, height: 4, pixels: vec![[1.0; 3]; 16] });
    let at = exr.windows(10).position(|w| w == b"dataWindow").expect("an attribute") + 10 + 1 + 6 + 4;
    exr[at + 8..at + 16].copy_from_slice(&[0xff, 0xff, 0xff, 0x3f, 0xff, 0xff, 0xff, 0x3f]);
    for (name, bytes) in [("huge.hdr", &hdr[..]), ("none.hdr", none), ("huge.tga", &tga), ("huge.exr", &exr)]
    {
        let path = folder("limits").join(name);
        fs::write(&path, bytes).expect("a file");
        let error = load_texture(&path, Gamma::Default, &ImageLimits::default()).expect_err(name);
        assert!(error.to_string().contains(name), "{error}");
    }
}

#[test]
fn texels_that_are_no_numbers_are_named() {
    for (name, value, fits_texture) in
        [("nan.exr", f32::NAN, false), ("inf.exr", f32::INFINITY, false), ("negative.exr", -1.0, true)]
    {
        let mut image = FloatImage { width: 3, height: 2, pixels: vec![[1.0; 3]; 6] };
        image.pixels[5][1] = value;
        let path = folder("values").join(name);
        fs::write(&path, exr_bytes(&image)).expect("a file");
        let error = load_environment(&path, &ImageLimits::default()).expect_err(name).to_string();
        assert!(error.contains(name) && error.contains("column 2, row 1"), "{error}");
        let texture = load_texture(&path, Gamma::Default, &ImageLimits::default());
        assert_eq!(texture.is_ok(), fits_texture, "{name}");
        assert!(read_exr(&path).is_ok());
    }
}

#[test]
fn broken_files_are_errors_with_name_and_cause() {
    let folder = folder("broken");
    let load = |name: &str, bytes: &[u8]| -> Result<(), ImageError> {
        let path = folder.join(name);
        fs::write(&path, bytes).expect("a file");
        load_texture(&path, Gamma::Default, &ImageLimits::default()).map(|_| ())
    };
    let encoded = |format: image::ImageFormat| {
        let mut bytes = Cursor::new(Vec::new());
        let source = image::DynamicImage::from(gradient(24, 16));
        let source = if format == image::ImageFormat::Hdr { source.into_rgb32f().into() } else { source };
        source.write_to(&mut bytes, format).expect("memory takes it");
        bytes.into_inner()
    };
    let mut exr = Cursor::new(Vec::new());
    write_exr(&film(), &ExrMetadata::default(), &mut exr).expect("memory takes it");
    use image::ImageFormat as F;
    // What a decoder shows although the end is missing, is its own choice.
    let files = [
        ("a.exr", exr.into_inner(), true),
        ("a.png", encoded(F::Png), true),
        ("a.hdr", encoded(F::Hdr), true),
        ("a.tga", encoded(F::Tga), true),
        ("a.tiff", encoded(F::Tiff), false),
        ("a.jpg", encoded(F::Jpeg), false),
        ("a.webp", encoded(F::WebP), false),
    ];
    for (name, bytes, strict) in files {
        load(name, &bytes).expect("as written");
        // What comes last in a file may be missing without harm.
        for cut in (0..bytes.len() * 9 / 10).step_by(bytes.len() / 60 + 1) {
            let result = load(name, &bytes[..cut]);
            assert!(result.is_err() || !strict, "{name} cut at {cut}");
        }
        // Damage is an error or another picture, never a panic.
        for at in (0..bytes.len()).step_by(bytes.len() / 300 + 1) {
            for flip in [0xff, 1 << (at % 8)] {
                let mut damaged = bytes.clone();
                damaged[at] ^= flip;
                let _ = load(name, &damaged);
            }
        }
    }
    let error = load("text.hdr", b"this is no picture").expect_err("text").to_string();
    assert!(error.contains("text.hdr") && error.contains("format"), "{error}");
    let missing = load_texture(Path::new("/nowhere/at/all.png"), Gamma::Default, &ImageLimits::default());
    let error = missing.expect_err("missing").to_string();
    assert!(error.contains("all.png") && error.contains("No such file"), "{error}");
    let empty = load("empty.png", b"").expect_err("empty").to_string();
    assert!(empty.contains("empty"), "{empty}");
    let directory = load_texture(&folder, Gamma::Default, &ImageLimits::default());
    assert!(directory.expect_err("a directory").to_string().contains("directory"));
}

#[test]
fn real_environments_are_read() {
    for file in data_files("env", &["hdr", "exr"]) {
        let start = std::time::Instant::now();
        let image = load_environment(&file, &ImageLimits::default()).expect("a good file");
        let time = start.elapsed();
        assert_eq!(image.pixels.len(), image.width as usize * image.height as usize);
        let peak = image.pixels.iter().flatten().fold(0f32, |a, &b| a.max(b));
        let mean = image.pixels.iter().flatten().map(|&c| f64::from(c)).sum::<f64>()
            / (3 * image.pixels.len()) as f64;
        assert!(mean > 0.0 && f64::from(peak) > mean);
        let name = file.file_name().expect("a file").to_string_lossy();
        println!("{name}: {}×{}, mean {mean:.4}, peak {peak:.1}, {time:.1?}", image.width, image.height);
    }
}

#[test]
fn real_textures_are_read() {
    for file in data_files("textures", &["png", "jpg", "jpeg", "exr", "hdr", "tif", "tga"]) {
        let image = texture(&file, Gamma::Default);
        assert!(texel(&image, 0, 0).iter().all(|c| c.is_finite()), "{}", file.display());
    }
}
