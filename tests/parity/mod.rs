//! What the tests share that hold executors against one another.

mod gpu;

pub use gpu::gpu;

/// Points per run.
pub const POINTS: usize = 259;

/// Results: a row of leaves per point.
pub type Rows = Vec<Vec<f64>>;

/// A fixed sequence of numbers from 0 to below 1.
pub fn numbers() -> impl FnMut() -> f32 {
    let mut state = 1u32;
    move || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        ((((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737)) >> 8) as f32
            / (1u32 << 24) as f32
    }
}

/// A unit vector, even among those with z from `low` to 1.
pub fn direction(low: f32, unit: &mut impl FnMut() -> f32) -> [f32; 3] {
    let z = low + (1.0 - low) * unit();
    let (r, phi) = ((1.0 - z * z).max(0.0).sqrt(), std::f32::consts::TAU * unit());
    [r * phi.cos(), r * phi.sin(), z]
}

/// A row per point from a column per leaf.
pub fn rows(columns: &[Vec<f64>]) -> Rows {
    (0..columns[0].len()).map(|i| columns.iter().map(|column| column[i]).collect()).collect()
}

/// Fails where leaves differ most, if that is by more than `tolerance`, relative to the larger. Of what a function
/// samples, the first three leaves are a unit vector: they differ relative to 1.
pub fn check(function: &str, name: &str, a: &Rows, b: &Rows, tolerance: f64) -> Result<(), String> {
    assert_eq!(a.len(), b.len(), "{function}, {name}");
    let unit = if function.ends_with("sample") { 3 } else { 0 };
    let mut worst = (0.0, String::new());
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        assert_eq!(a.len(), b.len(), "{function}, {name}");
        for (l, (a, b)) in a.iter().zip(b).enumerate() {
            let scale = if l < unit { 1.0 } else { a.abs().max(b.abs()).max(1e-6) };
            let relative = (a - b).abs() / scale;
            if relative > worst.0 || relative.is_nan() {
                worst = (relative, format!("{function}, {name}: leaf {l} of point {i}: {a} and {b}"));
            }
        }
    }
    if worst.0 <= tolerance { Ok(()) } else { Err(worst.1) }
}
