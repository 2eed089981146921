//! Stages *setup* and *inputs*: points, frames, media, and the values that materials compute.
//!
//! Order, as MDL has it: cutout (decided by then), normal, then everything else with that normal.

use super::Job;
use super::media::Medium;
use super::pool::Paths;
use crate::convert::to_bsdf;
use crate::scene::Surface;
use crate::scene::surface::unit_or;
use crate::shading::normal::adapt;
use crate::shading::state::{fill, fill_frame, fill_normal};
use crate::shading::{Shader, ShadingFrame};
use glam::Vec3;
use layered_bsdf::prelude::{POINT_INSIDE, POINT_THIN_WALLED, ShadingPoint, shading_point};
use mdl_jit::material::{InputFault, Part};
use mdl_jit::state::{StateBatch, StateFields};

/// A point that is shaded.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Whose it is.
    pub path: u32,
    /// Where it is.
    pub surface: Surface,
    /// Unit vector to where the path came from.
    pub wo: Vec3,
    /// Whether the back is seen.
    pub back: bool,
    /// Local frame.
    pub frame: ShadingFrame,
    /// What the evaluator is told.
    pub bsdf: ShadingPoint,
    /// The medium on the side of `wo`.
    pub near: Medium,
    /// The medium on the other side.
    pub far: Medium,
}

impl Point {
    /// The geometric normal on the side of `wo`.
    #[inline(always)]
    pub fn side(&self) -> Vec3 {
        if self.back { -self.surface.geometry_normal } else { self.surface.geometry_normal }
    }
}

/// Points of a chunk and what their material computed.
#[derive(Default)]
pub struct SetupStage {
    /// The points.
    pub points: Vec<Point>,
    /// Outputs of the part that feeds the BSDF.
    pub columns: Vec<Vec<f32>>,
    /// Points that show the front, and those that show the back where that is another face.
    rows: [Vec<u32>; 2],
    /// Material normals of the outer side.
    normals: Vec<Vec3>,
    state: StateBatch,
    normal_columns: Vec<Vec<f32>>,
    volume_columns: Vec<Vec<f32>>,
    inner_columns: Vec<Vec<f32>>,
}

impl SetupStage {
    /// Rows of the points that show a face.
    pub fn rows(&self, back: bool) -> &[u32] {
        &self.rows[usize::from(back)]
    }

    /// Computes surfaces of what paths met.
    pub fn load(&mut self, job: &Job<'_>, paths: &Paths, members: &[u32]) {
        self.points.clear();
        self.points.extend(members.iter().map(|&path| {
            let p = path as usize;
            let surface = job.shading.scene.surface(&paths.hits.get(p));
            let wo = -paths.rays.direction.get(p);
            let (zero, one) = (to_bsdf(Vec3::ZERO), to_bsdf(Vec3::ONE));
            Point {
                path,
                surface,
                wo,
                back: surface.geometry_normal.dot(wo) < 0.0,
                frame: ShadingFrame { x: Vec3::X, y: Vec3::Y, z: Vec3::Z },
                bsdf: shading_point(zero, one, one, 0),
                near: Medium::VACUUM,
                far: Medium::VACUUM,
            }
        }));
    }

    /// Forgets the points of paths that are to end.
    pub fn keep(&mut self, goes_on: impl Fn(u32) -> bool) {
        self.points.retain(|point| goes_on(point.path));
    }

    /// Normals and frames of all points.
    pub fn run(&mut self, job: &Job<'_>, slot: u32, paths: &Paths) -> Result<(), InputFault> {
        let scene = job.shading.scene;
        let shader = &job.shading.shaders[slot as usize];
        self.sort_sides(shader);
        let stateful = shader.fields != StateFields::NONE;
        if stateful {
            self.state.reset(self.points.len(), shader.fields);
            for (row, point) in self.points.iter().enumerate() {
                fill(&mut self.state, row, scene, &point.surface, point.surface.normal);
            }
        }
        self.material_normals(job, shader)?;
        for (row, point) in self.points.iter_mut().enumerate() {
            let normal = self.normals.get(row).copied().unwrap_or(point.surface.normal);
            let z = adapt(if point.back { -normal } else { normal }, point.side(), point.wo);
            point.frame = if shader.face(point.back).has_tangents {
                ShadingFrame::with_tangent(z, scene.tangents(&point.surface, 0, z).0)
            } else {
                ShadingFrame::around(z)
            };
            if stateful {
                if shader.has_normal {
                    fill_normal(&mut self.state, row, scene, &point.surface, normal);
                }
                fill_frame(&mut self.state, row, &point.frame);
            }
        }
        let _ = paths;
        Ok(())
    }

    fn sort_sides(&mut self, shader: &Shader) {
        let distinct = shader.has_back();
        self.rows.iter_mut().for_each(Vec::clear);
        for (row, point) in self.points.iter().enumerate() {
            self.rows[usize::from(distinct && point.back)].push(row as u32);
        }
    }

    /// Fills `normals`, or leaves it empty if the material has none of its own.
    fn material_normals(&mut self, job: &Job<'_>, shader: &Shader) -> Result<(), InputFault> {
        self.normals.clear();
        if !shader.has_normal {
            return Ok(());
        }
        let inputs = shader.material.inputs(Part::Normal);
        inputs.run(&self.state, job.shading.runtime, &mut self.normal_columns)?;
        let columns = &self.normal_columns;
        self.normals.extend(self.points.iter().enumerate().map(|(row, point)| {
            let outer = point.surface.geometry_normal;
            let normal = unit_or(Vec3::from(inputs.value3(columns, 0, row)), point.surface.normal);
            // As for vertex normals: what faces inwards is mirrored to the outside.
            normal - outer * (2.0 * normal.dot(outer).min(0.0))
        }));
        Ok(())
    }

    /// Runs what feeds the BSDF of one face, and sets what the evaluator is told of its points.
    pub fn inputs(&mut self, job: &Job<'_>, slot: u32, back: bool, paths: &Paths) -> Result<(), InputFault> {
        let shader = &job.shading.shaders[slot as usize];
        let inputs = shader.material.inputs(shader.face(back).part);
        inputs.run(&self.state, job.shading.runtime, &mut self.columns)?;
        let volume = shader.material.inputs(Part::Volume);
        let inner = shader.material.inputs(Part::VolumeScattering);
        let has_inner = shader.scattering.is_some() || shader.glows;
        if shader.has_interior {
            volume.run(&self.state, job.shading.runtime, &mut self.volume_columns)?;
        }
        if has_inner {
            inner.run(&self.state, job.shading.runtime, &mut self.inner_columns)?;
        }
        let meters = job.shading.runtime.meters_per_unit;
        let thin = shader.material.thin_walled;
        for &row in &self.rows[usize::from(back)] {
            let row = row as usize;
            let point = &mut self.points[row];
            let mut coefficients = [[0.0; 3]; 3];
            if shader.has_interior {
                coefficients[0] = volume.value3(&self.volume_columns, 0, row);
            }
            if has_inner {
                coefficients[1] = volume.value3(&self.volume_columns, 3, row);
                coefficients[2] = inner.value3(&self.inner_columns, 0, row);
            }
            let own = Medium::new(inputs.value3(&self.columns, 0, row), coefficients, slot, meters);
            (point.near, point.far) = sides(paths, point, own, thin);
            let flags = match (thin, point.back) {
                (true, _) => POINT_THIN_WALLED,
                (false, true) => POINT_INSIDE,
                (false, false) => 0,
            };
            let geometry_normal = to_bsdf(point.frame.to_local(point.side()));
            point.bsdf =
                shading_point(geometry_normal, to_bsdf(point.near.ior), to_bsdf(point.far.ior), flags);
        }
        Ok(())
    }
}

/// The media on the side of the viewer and on the other side. `own` is what the material encloses.
#[inline]
fn sides(paths: &Paths, point: &Point, own: Medium, thin: bool) -> (Medium, Medium) {
    let path = point.path as usize;
    let instance = point.surface.instance;
    let current = paths.media.as_ref().map_or(Medium::VACUUM, |media| media.current(path));
    if thin {
        // Behind it is the same space; its own index decides what it reflects.
        return (current, Medium { ior: own.ior, ..current });
    }
    if !point.back {
        return (current, own);
    }
    match &paths.media {
        Some(media) if media.contains(path, instance) => (current, media.without(path, instance)),
        // The path began inside, or the surface is not closed.
        _ => (own, current),
    }
}
