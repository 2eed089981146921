//! The hair of a material at one point of a fiber, without a renderer.
//!
//! Directions are in the frame of the fiber: x along it, z the normal where light from the eye meets it.

use crate::error::Error;
use crate::material::Material;
use crate::probe::{Evaluation, SurfacePoint, evaluate_inputs};
use layered_bsdf::prelude::*;
use mdl_jit::material::Part;
use mdl_jit::{Executor, Scatterer};
use std::f64::consts::{PI, TAU};

/// A material's hair at one point. Directions have unit length.
#[derive(Clone)]
pub struct HairProbe {
    params: Params,
}

impl HairProbe {
    /// None if the material has no hair.
    pub fn new(material: &Material, at: &SurfacePoint) -> Result<Option<Self>, Error> {
        let outputs = evaluate_inputs(material, Part::Hair, at)?;
        let mut params = Params { v: [0.0; MAX_PARAMS as usize] };
        params.v[..outputs.len()].copy_from_slice(&outputs);
        Ok((!outputs.is_empty()).then_some(Self { params }))
    }

    /// Value and density.
    pub fn eval(&mut self, wo: [f32; 3], wi: [f32; 3]) -> Evaluation {
        let v = hair_eval(&mut self.params, vector(wo), vector(wi));
        Evaluation { value: [v.value.x, v.value.y, v.value.z], pdf: v.pdf }
    }

    /// A direction from three random numbers in [0, 1): the direction, its density and weight.
    pub fn sample(&mut self, wo: [f32; 3], u: [f32; 3]) -> ([f32; 3], f32, [f32; 3]) {
        let s = hair_sample(&mut self.params, vector(wo), vector(u));
        ([s.wi.x, s.wi.y, s.wi.z], s.pdf, [s.weight.x, s.weight.y, s.weight.z])
    }

    /// Value and density by the library's shader code on an executor.
    pub fn eval_on(
        &self,
        executor: Executor<'_>,
        wo: [f32; 3],
        wi: [f32; 3],
    ) -> Result<([f64; 3], f64), Error> {
        let failed = |e: &dyn std::fmt::Display| Error::Setting(e.to_string());
        let library = mdl_jit::evaluator::library().map_err(|e| failed(&e))?;
        let scatterer = Scatterer { program: None, params: &self.params, point: None };
        let columns =
            scatterer.run(library, "hair_eval", executor, &[&[wo], &[wi]]).map_err(|e| failed(&e))?;
        let leaf = |i: usize| columns[i][0];
        Ok(([0, 1, 2].map(leaf), leaf(3)))
    }

    /// The share of energy that is scattered, by quadrature in equal steps of both angles.
    pub fn furnace_by_eval(&mut self, wo: [f32; 3]) -> [f64; 3] {
        const ROWS: usize = 1024;
        const COLUMNS: usize = 1024;
        let mut sum = [0.0; 3];
        for row in 0..ROWS {
            let (x, r) = (PI * ((row as f64 + 0.5) / ROWS as f64 - 0.5)).sin_cos();
            let area = r * PI / ROWS as f64 * TAU / COLUMNS as f64;
            for column in 0..COLUMNS {
                let (s, c) = (TAU * (column as f64 + 0.5) / COLUMNS as f64).sin_cos();
                let value = self.eval(wo, [x as f32, (r * c) as f32, (r * s) as f32]).value;
                sum.iter_mut().zip(value).for_each(|(sum, v)| *sum += f64::from(v) * area);
            }
        }
        sum
    }

    /// The same by the mean weight of `count` samples.
    pub fn furnace_by_sample(&mut self, wo: [f32; 3], count: u32) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for i in 0..count {
            let (_, _, weight) = self.sample(wo, crate::probe::quasi_random(i));
            sum.iter_mut().zip(weight).for_each(|(sum, weight)| *sum += f64::from(weight));
        }
        sum.map(|sum| sum / f64::from(count))
    }
}

fn vector(v: [f32; 3]) -> Vec3f {
    vec3f(v[0], v[1], v[2])
}
