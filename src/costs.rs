//! What a material costs, measured where it runs.

use crate::error::Error;
use crate::material::Material;
use crate::probe::{IDENTITY, SurfacePoint, set_flat};
use mdl_jit::material::{Part, Runtime};
use mdl_jit::state::StateBatch;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Points of a batch.
const BATCH: usize = 4096;
/// Directions that BSDFs are asked for.
const PAIRS: usize = 1024;
/// Time that a measurement takes at most, beside its first run.
const PATIENCE: Duration = Duration::from_millis(20);

/// Nanoseconds per point on one core: the fastest of several runs, so as free of disturbance as can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Costs {
    /// Computing the inputs of the front's BSDF; 0 if nothing varies.
    pub inputs_ns: f64,
    /// Value and density of the BSDF.
    pub eval_ns: f64,
    /// A sample of the BSDF.
    pub sample_ns: f64,
    /// Points of the batch that inputs were computed for.
    pub batch: usize,
}

impl Costs {
    pub(crate) fn measure(material: &Material) -> Result<Self, Error> {
        let textures = material.textures()?;
        let shaded = material.with_textures(&textures, &textures.numbers[0])?;
        let inputs = shaded.inputs(Part::Surface);
        let mut state = StateBatch::default();
        state.reset(BATCH, inputs.state);
        for i in 0..BATCH {
            let at = [0.013 * (i % 64) as f32, 0.017 * (i / 64) as f32, 0.3];
            for field in inputs.state.iter() {
                set_flat(&mut state, field, i, at, at);
            }
        }
        let runtime = Runtime {
            textures: &textures.table,
            transforms: &IDENTITY,
            animation_time: 0.0,
            meters_per_unit: 1.0,
        };
        let mut columns = Vec::new();
        let inputs_ns = match inputs.is_uniform() {
            true => 0.0,
            false => fastest(BATCH, || inputs.run(&state, &runtime, &mut columns).map_err(Error::from))?,
        };
        let mut probe = material.at(&SurfacePoint::default())?;
        let pairs: Vec<[[f32; 3]; 2]> = (0..PAIRS).map(|i| [hemisphere(i), hemisphere(i + PAIRS)]).collect();
        let eval_ns = fastest(PAIRS, || {
            pairs.iter().for_each(|[wo, wi]| _ = black_box(probe.eval(*wo, *wi)));
            Ok(())
        })?;
        let sample_ns = fastest(PAIRS, || {
            pairs.iter().for_each(|[wo, u]| _ = black_box(probe.sample(*wo, u.map(|x| 0.5 + 0.49 * x))));
            Ok(())
        })?;
        Ok(Self { inputs_ns, eval_ns, sample_ns, batch: BATCH })
    }
}

/// Time per point of the fastest run.
fn fastest(points: usize, mut run: impl FnMut() -> Result<(), Error>) -> Result<f64, Error> {
    // The first run warms caches and compiles what is compiled on demand.
    run()?;
    let begin = Instant::now();
    let mut best = Duration::MAX;
    while begin.elapsed() < PATIENCE {
        let start = Instant::now();
        run()?;
        best = best.min(start.elapsed());
    }
    Ok(best.as_secs_f64() * 1e9 / points as f64)
}

/// Directions all over the hemisphere.
fn hemisphere(i: usize) -> [f32; 3] {
    let z = (i as f32 * 0.618_034).fract().max(0.01);
    let phi = i as f32 * 2.399_963;
    let r = (1.0 - z * z).sqrt();
    [r * phi.cos(), r * phi.sin(), z]
}
