//! Emissive triangles, chosen in proportion to their flux.
//!
//! The flux of a triangle is its area times the luminance of its exitance; where a material's emission
//! varies, the exitance is averaged over a few points, and no triangle is left without a chance.

use super::alias::AliasTable;
use super::luminance;
use crate::scene::Scene;
use crate::shading::state::fill;
use crate::shading::{Shader, Shading};
use glam::Vec3;
use mdl_jit::material::{InputFault, Part};
use mdl_jit::state::StateBatch;
use std::collections::BTreeMap;

/// Points per triangle at which varying emission is looked at: barycentric weights.
const POINTS: [(f32, f32); 4] = [(1.0 / 3.0, 1.0 / 3.0), (0.6, 0.2), (0.2, 0.6), (0.2, 0.2)];
/// Least flux of a triangle with varying emission, in parts of the mean of its material.
const LEAST_SHARE: f64 = 0.05;
/// No light.
pub const NO_LIGHT: u32 = u32::MAX;

/// A triangle that emits.
#[derive(Clone, Copy, Debug)]
pub struct LightTriangle {
    /// Instance.
    pub instance: u32,
    /// Triangle of its mesh.
    pub primitive: u32,
    /// In world space.
    pub area: f32,
    /// Factor from intensity to exitance: 1, or the inverse of the area that a power is spread over.
    pub scale: f32,
    /// Material slot.
    pub slot: u32,
}

/// A point of a light.
#[derive(Clone, Copy, Debug)]
pub struct LightPoint {
    /// Index of the light.
    pub light: u32,
    /// Barycentric weights of the second and third vertex.
    pub b: [f32; 2],
    /// Density per area.
    pub pdf_area: f32,
}

/// All emissive triangles of a scene.
#[derive(Clone, Debug)]
pub struct TriangleLights {
    lights: Vec<LightTriangle>,
    table: AliasTable,
    /// By instance, where its triangles begin in `ids`; [`NO_LIGHT`] if it does not emit.
    starts: Vec<u32>,
    /// Light of each triangle of an emissive instance.
    ids: Vec<u32>,
    /// Sum of all flux, by luminance.
    pub flux: f64,
}

impl TriangleLights {
    /// Collects the lights of a scene; none if there are none.
    pub fn new(shading: &Shading<'_>) -> Result<Option<Self>, InputFault> {
        let scene = shading.scene;
        let mut lights: Vec<LightTriangle> = Vec::new();
        let mut starts = vec![NO_LIGHT; scene.places.len()];
        let mut ids = Vec::new();
        for (instance, place) in scene.places.iter().enumerate() {
            let geometry = &scene.geometries[place.geometry as usize];
            let instance = instance as u32;
            let slots = (0..geometry.triangles.len() as u32).map(|p| scene.slot(instance, p));
            if !slots.clone().any(|slot| shading.shaders[slot as usize].emits()) {
                continue;
            }
            starts[instance as usize] = ids.len() as u32;
            let first = lights.len();
            for (primitive, slot) in slots.enumerate() {
                let shader = &shading.shaders[slot as usize];
                let area = world_area(scene, instance, primitive as u32);
                let is_light = shader.emits() && area > 0.0;
                ids.push(if is_light { lights.len() as u32 } else { NO_LIGHT });
                if is_light {
                    lights.push(LightTriangle {
                        instance,
                        primitive: primitive as u32,
                        area,
                        scale: 1.0,
                        slot,
                    });
                }
            }
            spread_powers(shading.shaders, &mut lights[first..]);
        }
        let flux = fluxes(shading, &lights)?;
        let Some(table) = AliasTable::new(&flux) else { return Ok(None) };
        Ok(Some(Self { lights, table, starts, ids, flux: flux.iter().sum() }))
    }

    /// Number of lights.
    pub fn len(&self) -> usize {
        self.lights.len()
    }

    /// Whether there is no light.
    pub fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }

    /// A light.
    #[inline]
    pub fn light(&self, index: u32) -> &LightTriangle {
        &self.lights[index as usize]
    }

    /// The light that a triangle is, or [`NO_LIGHT`].
    #[inline]
    pub fn find(&self, instance: u32, primitive: u32) -> u32 {
        match self.starts[instance as usize] {
            NO_LIGHT => NO_LIGHT,
            start => self.ids[(start + primitive) as usize],
        }
    }

    /// Density per area of sampling a light's points.
    #[inline]
    pub fn pdf_area(&self, light: u32) -> f32 {
        self.table.probability(light) / self.lights[light as usize].area
    }

    /// A point: `choice` in [0, 1) chooses the light, `u` in [0, 1)² places it.
    ///
    /// The square is folded to the triangle with little distortion (E. Heitz, "A Low-Distortion Map Between
    /// Triangle and Square", 2019).
    #[inline]
    pub fn sample(&self, choice: f64, u: [f32; 2]) -> LightPoint {
        let (light, probability) = self.table.sample(choice);
        let [s, t] = u;
        let b = if t > s { [0.5 * s, t - 0.5 * s] } else { [s - 0.5 * t, 0.5 * t] };
        LightPoint { light, b, pdf_area: probability / self.lights[light as usize].area }
    }
}

fn world_area(scene: &Scene, instance: u32, primitive: u32) -> f32 {
    let place = &scene.places[instance as usize];
    let mut corners = scene.geometries[place.geometry as usize].corners(primitive).map(|v| v.as_dvec3());
    if let Some(t) = &place.transforms {
        let (m, shift) = (&t.to_world.matrix3, t.to_world.translation.as_dvec3());
        corners = corners.map(|v| {
            m.x_axis.as_dvec3() * v.x + m.y_axis.as_dvec3() * v.y + m.z_axis.as_dvec3() * v.z + shift
        });
    }
    let [a, b, c] = corners;
    ((b - a).cross(c - a).length() * 0.5) as f32
}

/// Divides powers by the area of each material on the instance that `lights` belong to.
fn spread_powers(shaders: &[Shader], lights: &mut [LightTriangle]) {
    let mut areas: BTreeMap<u32, f64> = BTreeMap::new();
    for light in lights.iter() {
        *areas.entry(light.slot).or_default() += f64::from(light.area);
    }
    for light in lights {
        let shader = &shaders[light.slot as usize];
        let is_power = [false, true].into_iter().any(|b| shader.emitter(b).is_some_and(|e| e.is_power));
        if is_power {
            light.scale = (1.0 / areas[&light.slot]) as f32;
        }
    }
}

/// Flux of each light by luminance, for both sides together.
fn fluxes(shading: &Shading<'_>, lights: &[LightTriangle]) -> Result<Vec<f64>, InputFault> {
    let mut by_slot: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (index, light) in lights.iter().enumerate() {
        by_slot.entry(light.slot).or_default().push(index);
    }
    let mut flux = vec![0.0; lights.len()];
    for (slot, members) in by_slot {
        let shader = &shading.shaders[slot as usize];
        let mut varies = false;
        for back in [false, true] {
            let Some(emitter) = shader.emitter(back) else { continue };
            let inputs = shader.material.inputs(emitter.part);
            if inputs.is_uniform() {
                let intensity = Vec3::new(inputs.uniform[0], inputs.uniform[1], inputs.uniform[2]);
                let value = f64::from(luminance(intensity.max(Vec3::ZERO)));
                for &m in &members {
                    flux[m] += value * f64::from(lights[m].area * lights[m].scale);
                }
            } else {
                varies = true;
                add_varying(shading, shader, emitter.part, lights, &members, &mut flux)?;
            }
        }
        if varies {
            let (sum, area) = members
                .iter()
                .fold((0.0, 0.0), |(sum, area), &m| (sum + flux[m], area + f64::from(lights[m].area)));
            // Where all that was looked at is dark there may still be light.
            let mean = if sum > 0.0 { sum / area } else { 1.0 };
            for &m in &members {
                flux[m] = flux[m].max(LEAST_SHARE * mean * f64::from(lights[m].area));
            }
        }
    }
    Ok(flux)
}

/// Triangles evaluated at a time.
const BATCH: usize = 1024;

fn add_varying(
    shading: &Shading<'_>,
    shader: &Shader,
    part: Part,
    lights: &[LightTriangle],
    members: &[usize],
    flux: &mut [f64],
) -> Result<(), InputFault> {
    let inputs = shader.material.inputs(part);
    let mut state = StateBatch::default();
    let mut columns = Vec::new();
    for members in members.chunks(BATCH) {
        state.reset(members.len() * POINTS.len(), inputs.state);
        for (i, &m) in members.iter().enumerate() {
            for (j, &(b1, b2)) in POINTS.iter().enumerate() {
                let surface = shading.scene.surface_at(lights[m].instance, lights[m].primitive, b1, b2);
                fill(&mut state, i * POINTS.len() + j, shading.scene, &surface, surface.normal);
            }
        }
        inputs.run(&state, shading.runtime, &mut columns)?;
        for (i, &m) in members.iter().enumerate() {
            for j in 0..POINTS.len() {
                let intensity = Vec3::from(inputs.value3(&columns, 0, i * POINTS.len() + j));
                let value = f64::from(luminance(intensity.max(Vec3::ZERO))) / POINTS.len() as f64;
                if value.is_finite() {
                    flux[m] += value * f64::from(lights[m].area * lights[m].scale);
                }
            }
        }
    }
    Ok(())
}
