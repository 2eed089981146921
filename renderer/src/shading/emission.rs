//! Emitted radiance of surface points, alike for points that rays hit and points that lights are sampled at.
//!
//! The direction is seen from the interpolated normal; a material's own normal does not change emission.
//! Emission of a cut-out point is weighted by its opacity where the cutout has not been decided.

use super::Shading;
use super::frame::ShadingFrame;
use super::state::{fill, fill_frame};
use crate::convert::{from_bsdf, to_bsdf};
use crate::scene::Surface;
use glam::Vec3;
use layered_bsdf::prelude::{Params, Program, edf_eval};
use mdl_jit::material::{InputFault, Part};
use mdl_jit::state::{StateBatch, StateField};

/// A point and where it is seen from.
#[derive(Clone, Copy, Debug)]
pub struct EmissionQuery {
    /// The point.
    pub surface: Surface,
    /// Unit vector to the viewer.
    pub toward: Vec3,
    /// 1 for intensities that are exitances, the inverse area for those that are powers.
    pub scale: f32,
}

/// A program with its parameters; none if nothing is emitted.
type OwnProgram = Option<Box<(Program, Params)>>;

/// Programs of the evaluator, which wants them for itself, and buffers.
#[derive(Default)]
pub struct Emitters {
    /// By shader and side.
    programs: Vec<[OwnProgram; 2]>,
    state: StateBatch,
    columns: Vec<Vec<f32>>,
    cutouts: Vec<Vec<f32>>,
}

impl Emitters {
    /// For the materials of a scene.
    pub fn new(shading: &Shading<'_>) -> Self {
        let program = |slot: usize, back: bool| {
            shading.shaders[slot].emitter(back).map(|e| Box::new((e.program.clone(), e.params)))
        };
        let programs = (0..shading.shaders.len()).map(|slot| [program(slot, false), program(slot, true)]);
        Self { programs: programs.collect(), ..Self::default() }
    }

    /// Radiance of a point whose emission is the same all over the surface; none if it varies.
    #[inline]
    pub fn uniform(
        &mut self,
        shading: &Shading<'_>,
        slot: u32,
        query: &EmissionQuery,
        cut: bool,
    ) -> Option<Vec3> {
        let shader = &shading.shaders[slot as usize];
        let back = query.toward.dot(query.surface.geometry_normal) < 0.0;
        let Some(emitter) = shader.emitter(back) else { return Some(Vec3::ZERO) };
        let inputs = shader.material.inputs(emitter.part);
        if !inputs.is_uniform() || cut && shader.has_cutout {
            return None;
        }
        let (program, params) = &mut **self.programs[slot as usize][usize::from(back)].as_mut()?;
        let intensity = Vec3::new(inputs.uniform[0], inputs.uniform[1], inputs.uniform[2]);
        Some(radiance(program, params, intensity, query, back))
    }

    /// Radiance of points of one material, appended to `out`. With `cut`, weighted by opacity.
    pub fn batch(
        &mut self,
        shading: &Shading<'_>,
        slot: u32,
        queries: &[EmissionQuery],
        cut: bool,
        out: &mut Vec<Vec3>,
    ) -> Result<(), InputFault> {
        let shader = &shading.shaders[slot as usize];
        let start = out.len();
        out.resize(start + queries.len(), Vec3::ZERO);
        let out = &mut out[start..];
        self.state.reset(queries.len(), shader.emission_fields);
        for (row, query) in queries.iter().enumerate() {
            fill(&mut self.state, row, shading.scene, &query.surface, query.surface.normal);
            fill_frame(&mut self.state, row, &frame(query));
            self.state.set(StateField::Toward, row, query.toward.to_array());
        }
        for back in [false, true] {
            let Some(emitter) = shader.emitter(back) else { continue };
            let inputs = shader.material.inputs(emitter.part);
            inputs.run(&self.state, shading.runtime, &mut self.columns)?;
            let Some(own) = &mut self.programs[slot as usize][usize::from(back)] else { continue };
            let (program, params) = &mut **own;
            for (row, query) in queries.iter().enumerate() {
                if (query.toward.dot(query.surface.geometry_normal) < 0.0) == back {
                    inputs.gather(&self.columns, row, params);
                    let intensity = Vec3::from(inputs.value3(&self.columns, 0, row));
                    out[row] = radiance(program, params, intensity, query, back);
                }
            }
        }
        if cut && shader.has_cutout {
            let inputs = shader.material.inputs(Part::Cutout);
            inputs.run(&self.state, shading.runtime, &mut self.cutouts)?;
            for (row, out) in out.iter_mut().enumerate() {
                *out *= inputs.value(&self.cutouts, 0, row).clamp(0.0, 1.0);
            }
        }
        Ok(())
    }
}

/// The frame of the side that is seen.
fn frame(query: &EmissionQuery) -> ShadingFrame {
    let back = query.toward.dot(query.surface.geometry_normal) < 0.0;
    ShadingFrame::around(if back { -query.surface.normal } else { query.surface.normal })
}

#[inline]
fn radiance(
    program: &mut Program,
    params: &mut Params,
    intensity: Vec3,
    query: &EmissionQuery,
    back: bool,
) -> Vec3 {
    let frame = ShadingFrame::around(if back { -query.surface.normal } else { query.surface.normal });
    let value = edf_eval(program, params, to_bsdf(frame.to_local(query.toward))).value;
    from_bsdf(value) * intensity.max(Vec3::ZERO) * query.scale
}
