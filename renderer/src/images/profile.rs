//! Light profiles: intensities by direction, as a texture.
//!
//! Rows are even in θ from 0° to 180°, both ends included, columns in φ from 0°, the last before 360°.
//! Slice 0 has intensity over power, sr⁻¹; slice 1 begins with the power in lumens and the greatest
//! intensity in candela. The functions `mdl_profile…` of `mdl-jit/src/mdl/runtime.wgsl` read it.

use super::texture::TextureImage;
use mdl_jit::texture::Format;

/// A light profile.
#[derive(Clone, Debug)]
pub struct Profile {
    /// ∫ I dω in lumens.
    pub power: f64,
    /// Greatest intensity, in candela.
    pub maximum: f64,
    columns: usize,
    rows: usize,
    /// In candela, row by row.
    candela: Vec<f32>,
}

impl Profile {
    /// From intensities in candela by θ and φ in degrees, at multiples of `step`, which divides 180. Between
    /// them intensity is linear, but nothing shines outside of the range `lit` of θ.
    pub fn new(step: f64, is_axial: bool, lit: [f64; 2], intensity: impl Fn(f64, f64) -> f64) -> Self {
        let rows = (180.0 / step).round() as usize + 1;
        // Two columns have room for two numbers in slice 1.
        let columns = if is_axial { 2 } else { (360.0 / step).round() as usize };
        let turn = 360.0 / columns as f64;
        let mut candela = Vec::with_capacity(rows * columns);
        for row in 0..rows {
            candela.extend((0..columns).map(|c| intensity(row as f64 * step, c as f64 * turn) as f32));
        }
        let (mut power, mut maximum) = (0.0, 0f64);
        for column in 0..columns {
            let at = |row: usize| f64::from(candela[row * columns + column]);
            for row in 0..rows - 1 {
                let first = step * row as f64;
                maximum = maximum.max(at(row)).max(at(row + 1));
                if first > lit[0] - 1e-6 && first + step < lit[1] + 1e-6 {
                    power += cell(first, step, at(row), at(row + 1));
                }
            }
        }
        power *= turn.to_radians();
        Self { power, maximum, columns, rows, candela }
    }

    /// Intensity at the nearest sample, in candela.
    pub fn candela(&self, theta: f64, phi: f64) -> f64 {
        let row = (theta / 180.0 * (self.rows - 1) as f64).round() as usize;
        let column = (phi / 360.0 * self.columns as f64).round() as usize % self.columns;
        f64::from(self.candela[row.min(self.rows - 1) * self.columns + column])
    }

    /// As a texture.
    pub fn to_texture(&self) -> TextureImage {
        let scale = if self.power > 0.0 { 1.0 / self.power } else { 0.0 };
        let mut texels: Vec<u32> =
            self.candela.iter().map(|&c| ((f64::from(c) * scale) as f32).to_bits()).collect();
        let size = texels.len();
        texels.resize(2 * size, 0);
        texels[size] = (self.power as f32).to_bits();
        texels[size + 1] = (self.maximum as f32).to_bits();
        let (width, height) = (self.columns as u32, self.rows as u32);
        TextureImage { width, height, depth: 2, format: Format::Grey32Float, texels }
    }
}

/// ∫ I sin θ dθ over `step` degrees from `first`, where I is linear from `a` to `b`.
fn cell(first: f64, step: f64, a: f64, b: f64) -> f64 {
    let (t, h) = (first.to_radians(), step.to_radians());
    let even = t.cos() - (t + h).cos();
    let sloped = (t + h).sin() - t.sin() - h * (t + h).cos();
    a * even + (b - a) / h * sloped
}
