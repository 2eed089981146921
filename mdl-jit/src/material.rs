//! A compiled material, ready to shade batches of points.
//!
//! A material is data: a [`LayerProgram`] per side and, per [`Part`], the values of its outputs. Outputs
//! that depend on arguments alone are computed once per edit and stand in [`Inputs::uniform`]; those that
//! vary are computed for a batch of points by a kernel, into columns. A part without varying outputs runs
//! nothing.
//!
//! Order of evaluation, as MDL has it: cutout, then normal, then everything else with that normal.

use crate::state::{StateBatch, StateFields};
use layered_bsdf::prelude::*;
use std::sync::Arc;

/// What is computed together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Part {
    /// One output: the cutout opacity.
    Cutout,
    /// Three outputs: the shading normal in world space, any length. None where it is the geometry's.
    Normal,
    /// Index of refraction (three), then the slots of the front's BSDF.
    Surface,
    /// Index of refraction (three), then the slots of the back's BSDF.
    Backface,
    /// Intensity (three), then the slots of the front's EDF.
    SurfaceEmission,
    /// Intensity (three), then the slots of the back's EDF.
    BackfaceEmission,
    /// Absorption, then scattering coefficient (three each), per metre.
    Volume,
    /// Emission of the volume (three, W·m⁻³·sr⁻¹), then the slots of its VDF. None if it does neither scatter nor
    /// emit.
    VolumeScattering,
    /// The slots of the hair lobe ([`layered_bsdf::lobes::hair`]). None if there is no hair.
    Hair,
}

impl Part {
    /// All parts in order.
    pub const ALL: [Part; 9] = [
        Part::Cutout,
        Part::Normal,
        Part::Surface,
        Part::Backface,
        Part::SurfaceEmission,
        Part::BackfaceEmission,
        Part::Volume,
        Part::VolumeScattering,
        Part::Hair,
    ];
}

/// Outputs before the slots of a program: the index of refraction, the intensity, or the emission of a volume.
pub const PROGRAM_OFFSET: usize = 3;

/// Why inputs could not be computed: the message names the material and the place in its source.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{message}")]
pub struct InputFault {
    /// One sentence with cause and place.
    pub message: String,
}

/// What the inputs of all materials share while they run.
pub struct Runtime<'a> {
    /// Textures by index.
    pub textures: &'a dyn crate::texture::Textures,
    /// Six rows of four floats per instance: object to world, then world to object.
    pub transforms: &'a [[f32; 4]],
    /// `state::animation_time()`
    pub animation_time: f32,
    /// `state::meters_per_scene_unit()`
    pub meters_per_unit: f32,
}

/// The varying outputs of one part, as code.
pub trait InputKernel: Send + Sync {
    /// Computes every varying output for every point of `state`; `columns` are as many, each as long.
    fn run(
        &self,
        state: &StateBatch,
        runtime: &Runtime<'_>,
        columns: &mut [Vec<f32>],
    ) -> Result<(), InputFault>;
}

/// The outputs of one part.
#[derive(Clone, Default)]
pub struct Inputs {
    /// All outputs; where `varying` names one, a typical value.
    pub uniform: Vec<f32>,
    /// Outputs that the kernel computes, in the order of its columns.
    pub varying: Vec<u32>,
    /// What the kernel asks of the state.
    pub state: StateFields,
    /// The kernel, if anything varies.
    pub kernel: Option<Arc<dyn InputKernel>>,
}

impl Inputs {
    /// Outputs that never vary.
    pub fn constant(values: impl Into<Vec<f32>>) -> Self {
        Self { uniform: values.into(), ..Self::default() }
    }

    /// Fills what `program`, whose slots these are, derives where its layers conserve energy: for light from air.
    pub fn conserve(&mut self, program: &LayerProgram, thin_walled: bool) {
        let mut params = Params { v: [0.0; MAX_PARAMS as usize] };
        self.load(&mut params);
        let air = vec3f(1.0, 1.0, 1.0);
        let ior = vec3f(self.uniform[0], self.uniform[1], self.uniform[2]);
        let flags = if thin_walled { POINT_THIN_WALLED } else { 0 };
        let point = shading_point(vec3f(0.0, 0.0, 1.0), air, ior, flags);
        // Where the index of refraction varies, nothing is known of any layer.
        let known = !self.varying.iter().any(|&output| (output as usize) < PROGRAM_OFFSET);
        program.conserve(&mut params, point, |slot| {
            !known || self.varying.contains(&((slot + PROGRAM_OFFSET) as u32))
        });
        let slots = self.uniform.len() - PROGRAM_OFFSET;
        self.uniform[PROGRAM_OFFSET..].copy_from_slice(&params.v[..slots]);
    }

    /// Whether no output varies.
    pub fn is_uniform(&self) -> bool {
        self.kernel.is_none()
    }

    /// Runs the kernel, if there is one, over all points of `state`.
    pub fn run(
        &self,
        state: &StateBatch,
        runtime: &Runtime<'_>,
        columns: &mut Vec<Vec<f32>>,
    ) -> Result<(), InputFault> {
        let Some(kernel) = &self.kernel else { return Ok(()) };
        if columns.len() < self.varying.len() {
            columns.resize_with(self.varying.len(), Vec::new);
        }
        let columns = &mut columns[..self.varying.len()];
        columns.iter_mut().for_each(|column| column.resize(state.len(), 0.0));
        kernel.run(state, runtime, columns)
    }

    /// Output `output` of point `index` after [`Inputs::run`].
    pub fn value(&self, columns: &[Vec<f32>], output: usize, index: usize) -> f32 {
        match self.varying.iter().position(|&varying| varying as usize == output) {
            Some(column) => columns[column][index],
            None => self.uniform[output],
        }
    }

    /// Outputs `output..output + 3` of point `index` after [`Inputs::run`].
    pub fn value3(&self, columns: &[Vec<f32>], output: usize, index: usize) -> [f32; 3] {
        [0, 1, 2].map(|i| self.value(columns, output + i, index))
    }

    /// The parameters of the program behind [`PROGRAM_OFFSET`], as far as they are uniform. Take them once
    /// per run of points with one material, then [`Inputs::gather`] for each point.
    pub fn load(&self, params: &mut Params) {
        if let Some(slots) = self.uniform.get(PROGRAM_OFFSET..) {
            params.v[..slots.len()].copy_from_slice(slots);
        }
    }

    /// Overwrites the varying parameters with those of point `index`.
    #[inline]
    pub fn gather(&self, columns: &[Vec<f32>], index: usize, params: &mut Params) {
        for (&output, column) in self.varying.iter().zip(columns) {
            if let Some(slot) = (output as usize).checked_sub(PROGRAM_OFFSET) {
                params.v[slot] = column[index];
            }
        }
    }
}

/// How the intensity of an emission is meant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum IntensityMode {
    /// Radiant exitance, W·m⁻² (`intensity_radiant_exitance`).
    #[default]
    RadiantExitance,
    /// Power over the whole surface, W (`intensity_power`).
    Power,
}

/// Emission of one side.
#[derive(Clone)]
pub struct Emission {
    /// Directional distribution.
    pub edf: LayerProgram,
    /// Meaning of the intensity.
    pub mode: IntensityMode,
}

/// One side of a surface.
#[derive(Clone)]
pub struct Face {
    /// Scattering.
    pub bsdf: LayerProgram,
    /// Emission, if there is any.
    pub emission: Option<Emission>,
}

/// A material with its current arguments.
#[derive(Clone)]
pub struct Material {
    /// Qualified name.
    pub name: String,
    /// The surface bounds no volume.
    pub thin_walled: bool,
    /// The front.
    pub surface: Face,
    /// The back of a thin-walled surface where it differs from the front.
    pub backface: Option<Face>,
    /// Measured data by the number of a resource, to be loaded: see [`Material::table_numbers`].
    pub tables: Tables,
    /// How the volume scatters; none if its scattering coefficient is zero.
    pub vdf: Option<LayerProgram>,
    /// By part, in the order of [`Part::ALL`].
    pub inputs: [Inputs; 9],
}

impl Material {
    /// The outputs of a part.
    pub fn inputs(&self, part: Part) -> &Inputs {
        &self.inputs[part as usize]
    }

    /// What is seen from one side: the face, and the parts that feed its BSDF and EDF.
    pub fn face(&self, back: bool) -> (&Face, Part, Part) {
        match &self.backface {
            Some(face) if back => (face, Part::Backface, Part::BackfaceEmission),
            _ => (&self.surface, Part::Surface, Part::SurfaceEmission),
        }
    }

    /// Its programs with the parts that hold their slots.
    pub fn programs(&self) -> Vec<(Part, &LayerProgram)> {
        let mut programs = Vec::new();
        for back in [false, true] {
            let (face, part, emission) = self.face(back);
            if back && part == Part::Surface {
                continue;
            }
            programs.push((part, &face.bsdf));
            programs.extend(face.emission.as_ref().map(|e| (emission, &e.edf)));
        }
        programs.extend(self.vdf.as_ref().map(|vdf| (Part::VolumeScattering, vdf)));
        programs
    }

    /// The resources that programs read as tables of a kind: by `OP_MEASURED_BSDF` measurements, by
    /// `OP_MEASURED_PICTURE` pictures.
    pub fn table_numbers(&self, op: u32) -> Vec<usize> {
        let mut numbers = Vec::new();
        for (part, program) in self.programs() {
            let uniform = &self.inputs(part).uniform;
            let used = program.table_slots(op).map(|slot| uniform[PROGRAM_OFFSET + slot]);
            numbers.extend(used.filter(|&x| x >= 0.0).map(|x| x as usize));
        }
        numbers.sort_unstable();
        numbers.dedup();
        numbers
    }

    /// Whether some of the surface may be cut out.
    pub fn has_cutout(&self) -> bool {
        let inputs = self.inputs(Part::Cutout);
        !inputs.is_uniform() || inputs.uniform[0] < 1.0
    }

    /// Whether the material changes the shading normal.
    pub fn has_normal(&self) -> bool {
        !self.inputs(Part::Normal).uniform.is_empty()
    }

    /// Whether either side emits.
    pub fn emits(&self) -> bool {
        let face = |face: &Face| face.emission.is_some();
        face(&self.surface) || self.backface.as_ref().is_some_and(face)
    }

    /// Whether light can pass the surface by scattering.
    pub fn transmits(&self) -> bool {
        self.surface.bsdf.transmits() || self.backface.as_ref().is_some_and(|face| face.bsdf.transmits())
    }
}

/// A material whose values are all known, for scenes made in code.
#[derive(Clone, Debug)]
pub struct ConstantMaterial {
    /// Name.
    pub name: String,
    /// The surface bounds no volume.
    pub thin_walled: bool,
    /// Scattering of both sides.
    pub scattering: Tree<f32>,
    /// Emission of the front: directional distribution and intensity.
    pub emission: Option<(Tree<f32>, [f32; 3])>,
    /// Index of refraction of the volume.
    pub ior: [f32; 3],
    /// Share of the surface that exists.
    pub cutout_opacity: f32,
    /// Absorption coefficient of the volume, per metre.
    pub absorption: [f32; 3],
    /// How the volume scatters, and its scattering coefficient, per metre.
    pub volume_scattering: Option<(Tree<f32>, [f32; 3])>,
    /// Emission of the volume, W·m⁻³·sr⁻¹.
    pub volume_emission: [f32; 3],
}

impl Default for ConstantMaterial {
    fn default() -> Self {
        Self {
            name: "constant".to_string(),
            thin_walled: false,
            scattering: Tree::Black,
            emission: None,
            ior: [1.0; 3],
            cutout_opacity: 1.0,
            absorption: [0.0; 3],
            volume_scattering: None,
            volume_emission: [0.0; 3],
        }
    }
}

impl ConstantMaterial {
    /// Lays out the programs.
    pub fn build(&self) -> Result<Material, ProgramError> {
        let (bsdf, slots) = program_outputs(&self.scattering, self.ior)?;
        let (emission, emission_outputs) = match &self.emission {
            Some((tree, intensity)) => {
                let (edf, outputs) = program_outputs(tree, *intensity)?;
                (Some(Emission { edf, mode: IntensityMode::RadiantExitance }), outputs)
            }
            None => (None, vec![0.0; PROGRAM_OFFSET]),
        };
        let (vdf, coefficient, volume_outputs) = match &self.volume_scattering {
            Some((tree, coefficient)) => {
                let (vdf, outputs) = program_outputs(tree, self.volume_emission)?;
                (Some(vdf), *coefficient, outputs)
            }
            None if self.volume_emission == [0.0; 3] => (None, [0.0; 3], Vec::new()),
            None => (None, [0.0; 3], self.volume_emission.to_vec()),
        };
        Ok(Material {
            name: self.name.clone(),
            thin_walled: self.thin_walled,
            surface: Face { bsdf, emission },
            backface: None,
            tables: Tables::default(),
            vdf,
            inputs: [
                Inputs::constant([self.cutout_opacity]),
                Inputs::constant([]),
                Inputs::constant(slots),
                Inputs::constant([]),
                Inputs::constant(emission_outputs),
                Inputs::constant([]),
                Inputs::constant([self.absorption, coefficient].concat()),
                Inputs::constant(volume_outputs),
                Inputs::constant([]),
            ],
        })
    }
}

/// A program and its outputs behind three leading values.
fn program_outputs(tree: &Tree<f32>, leading: [f32; 3]) -> Result<(LayerProgram, Vec<f32>), ProgramError> {
    let (program, params) = LayerProgram::with_values(tree)?;
    let outputs = leading.iter().chain(&params.v[..program.slots()]).copied().collect();
    Ok((program, outputs))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constant_material_has_its_values_in_order() {
        let tree = Tree::DiffuseReflection { tint: [0.1, 0.2, 0.3], roughness: 0.4, multiscatter_tint: None };
        let material = ConstantMaterial { scattering: tree, ior: [1.5; 3], ..Default::default() };
        let material = material.build().expect("one node");
        let inputs = material.inputs(Part::Surface);
        assert_eq!(inputs.uniform, [1.5, 1.5, 1.5, 0.1, 0.2, 0.3, 0.4]);
        assert!(inputs.is_uniform() && !material.has_cutout() && !material.emits());
        let mut params = Params { v: [0.0; 384] };
        inputs.load(&mut params);
        assert_eq!(params.v[3], 0.4);
    }
}
