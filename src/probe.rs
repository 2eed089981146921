//! A material at one point: what its BSDF does there, without a renderer.

use crate::error::Error;
use crate::material::Material;
use layered_bsdf::prelude::*;
use mdl_jit::material::{PROGRAM_OFFSET, Part, Runtime};
use mdl_jit::state::{StateBatch, StateField};
use mdl_jit::{Executor, Scatterer};
use std::f64::consts::{PI, TAU};

/// A point of a surface in its own frame: x and y are the texture tangents, z the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Position in metres.
    pub position: [f32; 3],
    /// Texture coordinates.
    pub uvw: [f32; 3],
    /// Index of refraction of the surrounding medium.
    pub surrounding_ior: f32,
    /// Seen from inside the volume that the surface bounds.
    pub inside: bool,
}

impl Default for SurfacePoint {
    fn default() -> Self {
        Self { position: [0.0; 3], uvw: [0.5, 0.5, 0.0], surrounding_ior: 1.0, inside: false }
    }
}

/// Value and density for a pair of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evaluation {
    /// f·|cos θi|, sr⁻¹.
    pub value: [f32; 3],
    /// Density of `sample`, sr⁻¹.
    pub pdf: f32,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The direction; without meaning if the event is 0.
    pub wi: [f32; 3],
    /// Density, sr⁻¹; 0 for specular events.
    pub pdf: f32,
    /// f·|cos θi|/pdf, or the share of energy for specular events.
    pub weight: [f32; 3],
    /// Bits of [`layered_bsdf::lobes`]`::EVENT_*`.
    pub event: u32,
}

/// Albedo, normal and roughness, seen from one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Auxiliary {
    /// Share of energy that diffuse lobes scatter.
    pub diffuse: [f32; 3],
    /// Share of energy that glossy and specular lobes scatter.
    pub glossy: [f32; 3],
    /// Mean of the lobes' normals in the frame of the point, unit length.
    pub normal: [f32; 3],
    /// Mean of the lobes' roughness along the tangents: 0 of a mirror, 1 of a diffuse lobe.
    pub roughness: [f32; 2],
}

/// A material's BSDF at one point. Directions are in the frame of the point and have unit length.
#[derive(Clone)]
pub struct Probe {
    layers: LayerProgram,
    program: Program,
    params: Params,
    point: ShadingPoint,
}

impl Probe {
    pub(crate) fn new(material: &Material, at: &SurfacePoint) -> Result<Self, Error> {
        let textures = material.textures()?;
        let shaded = material.with_textures(&textures, &textures.numbers[0])?;
        let (face, part, _) = shaded.face(at.inside);
        let outputs = evaluate_inputs(material, part, at)?;
        let mut params = Params { v: [0.0; MAX_PARAMS as usize] };
        let slots = &outputs[PROGRAM_OFFSET..];
        params.v[..slots.len()].copy_from_slice(slots);
        let own = vec3f(outputs[0], outputs[1], outputs[2]);
        let air = vec3f(at.surrounding_ior, at.surrounding_ior, at.surrounding_ior);
        let (near, far) = if at.inside { (own, air) } else { (air, own) };
        let flags =
            if shaded.thin_walled { POINT_THIN_WALLED } else { 0 } | if at.inside { POINT_INSIDE } else { 0 };
        let point = shading_point(vec3f(0.0, 0.0, 1.0), near, far, flags);
        let layers = face.bsdf.clone();
        Ok(Self { program: layers.with_tables(&shaded.tables), layers, params, point })
    }

    /// Value and density. Specular lobes have neither.
    pub fn eval(&mut self, wo: [f32; 3], wi: [f32; 3]) -> Evaluation {
        let v = bsdf_eval(&mut self.program, &mut self.params, self.point, vector(wo), vector(wi));
        Evaluation { value: array(v.diffuse + v.glossy), pdf: v.pdf }
    }

    /// Value and density by the library's shader code: in the `f64` interpreter, which is the measure of
    /// accuracy, or as a compute kernel.
    pub fn eval_on(
        &self,
        executor: Executor<'_>,
        wo: [f32; 3],
        wi: [f32; 3],
    ) -> Result<([f64; 3], f64), Error> {
        let failed = |e: &dyn std::fmt::Display| Error::Setting(e.to_string());
        if self.program.tables.words().is_none() {
            return Err(failed(&"its measurements are too large for a buffer"));
        }
        let code = mdl_jit::evaluator(&self.layers, &["bsdf_eval"]).map_err(|e| failed(&e))?;
        let scatterer =
            Scatterer { program: Some(&self.program), params: &self.params, point: Some(&self.point) };
        let columns = scatterer.run(&code, "bsdf_eval", executor, &[&[wo], &[wi]]).map_err(|e| failed(&e))?;
        // Diffuse, glossy, density, specular.
        let leaf = |i: usize| columns[i][0];
        Ok(([0, 1, 2].map(|i| leaf(i) + leaf(i + 3)), leaf(6)))
    }

    /// A direction from three random numbers in [0, 1).
    pub fn sample(&mut self, wo: [f32; 3], u: [f32; 3]) -> Sample {
        let s = bsdf_sample(&mut self.program, &mut self.params, self.point, vector(wo), vector(u));
        Sample { wi: array(s.wi), pdf: s.pdf, weight: array(s.weight), event: s.event }
    }

    /// The share of energy that is scattered.
    pub fn albedo(&mut self, wo: [f32; 3]) -> [f32; 3] {
        let a = bsdf_albedo(&mut self.program, &mut self.params, self.point, vector(wo));
        array(a.diffuse + a.glossy)
    }

    /// What a denoiser asks for.
    pub fn auxiliary(&mut self, wo: [f32; 3]) -> Auxiliary {
        let a = bsdf_auxiliary(&mut self.program, &mut self.params, self.point, vector(wo));
        Auxiliary {
            diffuse: array(a.diffuse),
            glossy: array(a.glossy),
            normal: array(a.normal),
            roughness: [a.roughness.x, a.roughness.y],
        }
    }

    /// The share of energy that is scattered, by samples: the mean weight of `count` of them.
    pub fn furnace_by_sample(&mut self, wo: [f32; 3], count: u32) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for i in 0..count {
            let weight = self.sample(wo, quasi_random(i)).weight;
            sum.iter_mut().zip(weight).for_each(|(sum, weight)| *sum += f64::from(weight));
        }
        sum.map(|sum| sum / f64::from(count))
    }

    /// The same by quadrature of `eval`, with the share of specular lobes added: rings on a logarithmic
    /// scale around the mirrored and the refracted direction resolve narrow lobes.
    pub fn furnace_by_eval(&mut self, wo: [f32; 3]) -> [f64; 3] {
        let thin = self.point.flags & POINT_THIN_WALLED != 0;
        let eta = if thin { 1.0 } else { f64::from(self.point.eta) };
        let [x, y, z] = wo.map(f64::from);
        let scale = if (1.0 - z * z) < eta * eta { 1.0 / eta } else { 0.0 };
        let below = (1.0 - (x * x + y * y) * scale * scale).max(0.0).sqrt();
        let mut sum = [0.0; 3];
        for (centre, side) in [([-x, -y, z], 1.0), ([-x * scale, -y * scale, -below], -1.0)] {
            for (wi, weight) in rings(centre) {
                if wi[2] * side > 0.0 {
                    let value = self.eval(wo, wi.map(|c| c as f32)).value;
                    sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += weight * f64::from(value));
                }
            }
        }
        // The weights of specular events depend on the third random number alone.
        const CHOICES: u32 = 4096;
        for i in 0..CHOICES {
            let sample = self.sample(wo, [0.5, 0.5, (i as f32 + 0.5) / CHOICES as f32]);
            if sample.event & EVENT_SPECULAR != 0 {
                let add = |(sum, weight): (&mut f64, f32)| *sum += f64::from(weight) / f64::from(CHOICES);
                sum.iter_mut().zip(sample.weight).for_each(add);
            }
        }
        sum
    }

    /// The flat program.
    pub fn program(&self) -> &Program {
        &self.program
    }

    /// The parameters at the point.
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// Media and sides.
    pub fn point(&self) -> &ShadingPoint {
        &self.point
    }
}

/// The transforms of an object that lies where the world has it: to the world and back.
pub(crate) const IDENTITY: [[f32; 4]; 6] = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
];

/// Sets a field of a point of a flat surface whose normal is z and whose tangents are x and y.
pub(crate) fn set_flat(
    state: &mut StateBatch,
    field: StateField,
    index: usize,
    position: [f32; 3],
    uvw: [f32; 3],
) {
    use StateField::*;
    match field {
        Position => state.set(field, index, position),
        Normal | GeometryNormal | FrameZ | Toward => state.set(field, index, [0.0, 0.0, 1.0]),
        TextureCoordinate0 | TextureCoordinate1 | TextureCoordinate2 | TextureCoordinate3 => {
            state.set(field, index, uvw);
        }
        TextureTangentU0 | TextureTangentU1 | TextureTangentU2 | TextureTangentU3 | FrameX => {
            state.set(field, index, [1.0, 0.0, 0.0]);
        }
        TextureTangentV0 | TextureTangentV1 | TextureTangentV2 | TextureTangentV3 | FrameY => {
            state.set(field, index, [0.0, 1.0, 0.0]);
        }
        Motion | Direction => state.set(field, index, [0.0; 3]),
        ObjectId | Instance => state.set(field, index, [f32::from_bits(0)]),
    }
}

/// All outputs of a part of a material at a point.
pub fn evaluate_inputs(material: &Material, part: Part, at: &SurfacePoint) -> Result<Vec<f32>, Error> {
    let inputs = material.shaded().inputs(part);
    let mut state = StateBatch::default();
    state.reset(1, inputs.state);
    for field in inputs.state.iter() {
        set_flat(&mut state, field, 0, at.position, at.uvw);
    }
    let textures = material.textures()?;
    let shaded = material.with_textures(&textures, &textures.numbers[0])?;
    let inputs = shaded.inputs(part);
    let runtime = Runtime {
        textures: &textures.table,
        transforms: &IDENTITY,
        animation_time: 0.0,
        meters_per_unit: 1.0,
    };
    let mut columns = Vec::new();
    inputs.run(&state, &runtime, &mut columns)?;
    Ok((0..inputs.uniform.len()).map(|output| inputs.value(&columns, output, 0)).collect())
}

fn vector(v: [f32; 3]) -> Vec3f {
    vec3f(v[0], v[1], v[2])
}

fn array(v: Vec3f) -> [f32; 3] {
    [v.x, v.y, v.z]
}

/// A point of a sequence that fills the unit cube evenly (M. Roberts, 2018).
pub(crate) fn quasi_random(index: u32) -> [f32; 3] {
    const STEPS: [f64; 3] = [0.819_172_513_396_164_5, 0.671_043_606_703_789_2, 0.549_700_477_901_970_2];
    STEPS.map(|step| ((0.5 + f64::from(index + 1) * step).fract() as f32).min(1.0 - f32::EPSILON / 2.0))
}

/// Directions around a centre with their solid angles: sectors of rings of logarithmic width, each by
/// Gauss-Legendre points.
fn rings(centre: [f64; 3]) -> impl Iterator<Item = ([f64; 3], f64)> {
    const RINGS: usize = 160;
    const SECTORS: usize = 96;
    const CORE: f64 = 1e-6;
    const GAUSS: [(f64, f64); 2] = [(-0.577_350_269_189_625_8, 1.0), (0.577_350_269_189_625_8, 1.0)];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let unit = |a: [f64; 3]| a.map(|c| c / dot(a, a).sqrt());
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let z = unit(centre);
    let x = unit(cross(if z[0].abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] }, z));
    let y = cross(z, x);
    let span = (PI / CORE).ln() / RINGS as f64;
    let width = TAU / SECTORS as f64;
    (0..RINGS).flat_map(move |ring| {
        GAUSS.into_iter().flat_map(move |(t, wt)| {
            let angle = CORE * (span * (ring as f64 + 0.5 + 0.5 * t)).exp();
            (0..SECTORS).flat_map(move |sector| {
                GAUSS.into_iter().map(move |(p, wp)| {
                    let phi = width * (sector as f64 + 0.5 + 0.5 * p);
                    let (sin, cos) = angle.sin_cos();
                    let (sp, cp) = phi.sin_cos();
                    let w = [0, 1, 2].map(|i| sin * (cp * x[i] + sp * y[i]) + cos * z[i]);
                    (w, 0.25 * wt * wp * span * width * angle * sin)
                })
            })
        })
    })
}
