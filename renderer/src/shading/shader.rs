//! A material with its programs in the form that the evaluator takes.

use crate::integrator::media::Medium;
use glam::Vec3;
use layered_bsdf::prelude::{MAX_PARAMS, Params, Program};
use mdl_jit::material::{Emission, IntensityMode, Material, Part};
use mdl_jit::state::{StateField, StateFields};
use std::sync::Arc;

/// Emission of one side.
#[derive(Clone)]
pub struct Emitter {
    /// Directional distribution.
    pub program: Program,
    /// Its parameters as far as they are uniform.
    pub params: Params,
    /// What feeds it.
    pub part: Part,
    /// Whether the intensity is a power, to be divided by the area.
    pub is_power: bool,
}

/// One side of a material.
#[derive(Clone)]
pub struct Face {
    /// Scattering.
    pub program: Program,
    /// Its parameters as far as they are uniform.
    pub params: Params,
    /// What feeds it.
    pub part: Part,
    /// Emission, if there is any.
    pub emitter: Option<Emitter>,
    /// Nothing is scattered.
    pub is_black: bool,
    /// Lights cannot be sampled: every lobe is specular.
    pub is_specular: bool,
    /// Light can pass.
    pub transmits: bool,
    /// A lobe has a direction in the surface, so the frame follows the texture.
    pub has_tangents: bool,
}

/// A boundary that light crosses without a turn wherever the index of refraction does not change.
#[derive(Clone, Copy, Debug)]
pub struct StraightBoundary {
    /// Share of light that passes.
    pub tint: Vec3,
    /// What it encloses.
    pub inside: Medium,
}

/// How a volume scatters.
#[derive(Clone)]
pub struct VolumeScattering {
    /// The phase function.
    pub program: Program,
    /// Its parameters.
    pub params: Params,
}

/// A material ready to shade.
#[derive(Clone)]
pub struct Shader {
    /// The material.
    pub material: Arc<Material>,
    front: Box<Face>,
    back: Option<Box<Face>>,
    /// Some of the surface may be cut out.
    pub has_cutout: bool,
    /// The material changes the normal.
    pub has_normal: bool,
    /// The surface bounds a volume that light can enter.
    pub has_interior: bool,
    /// The boundary does nothing but enclose a volume that is the same everywhere.
    pub straight: Option<StraightBoundary>,
    /// How the volume scatters, if it does.
    pub scattering: Option<Box<VolumeScattering>>,
    /// The volume emits.
    pub glows: bool,
    /// What scattering, normal and volume ask of the state.
    pub fields: StateFields,
    /// What emission, cutout included, asks of the state.
    pub emission_fields: StateFields,
}

impl Shader {
    /// For the material in slot `slot`, in a scene with units of `meters`.
    pub fn new(material: Arc<Material>, slot: u32, meters: f32) -> Self {
        let front = Box::new(face(&material, false));
        let back = material.backface.as_ref().map(|_| Box::new(face(&material, true)));
        let fields = |parts: &[Part]| {
            parts.iter().fold(StateFields::NONE, |all, &part| all.union(material.inputs(part).state))
        };
        let transmits = front.transmits || back.as_ref().is_some_and(|face| face.transmits);
        let has_interior = !material.thin_walled && transmits;
        let scattering =
            material.vdf.as_ref().filter(|_| has_interior && may_exceed_zero(&material, Part::Volume, 3));
        Self {
            straight: straight(&material, slot, meters),
            scattering: scattering.map(|vdf| Box::new(volume_scattering(&material, vdf))),
            glows: has_interior && may_exceed_zero(&material, Part::VolumeScattering, 0),
            has_cutout: material.has_cutout(),
            has_normal: material.has_normal(),
            has_interior,
            fields: fields(&[
                Part::Normal,
                Part::Surface,
                Part::Backface,
                Part::Volume,
                Part::VolumeScattering,
            ]),
            emission_fields: fields(&[Part::SurfaceEmission, Part::BackfaceEmission, Part::Cutout]),
            front,
            back,
            material,
        }
    }

    /// The side that is seen.
    #[inline]
    pub fn face(&self, back: bool) -> &Face {
        match &self.back {
            Some(face) if back => face,
            _ => &self.front,
        }
    }

    /// Whether the back is another face than the front.
    #[inline]
    pub fn has_back(&self) -> bool {
        self.back.is_some()
    }

    /// What emits on a side: the back of a solid does not.
    #[inline]
    pub fn emitter(&self, back: bool) -> Option<&Emitter> {
        if back && !self.material.thin_walled { None } else { self.face(back).emitter.as_ref() }
    }

    /// Whether either side emits anything.
    pub fn emits(&self) -> bool {
        [false, true].into_iter().any(|back| self.emitter(back).is_some())
    }

    /// Whether the state's tangents are asked for in a texture space.
    pub fn needs_tangents(&self, set: usize) -> bool {
        let all = self.fields.union(self.emission_fields);
        let asked =
            [StateField::TextureTangentU0 as u8 + set as u8, StateField::TextureTangentV0 as u8 + set as u8]
                .iter()
                .any(|&field| all.contains(StateField::ALL[field as usize]));
        let framed = [false, true].into_iter().any(|back| self.face(back).has_tangents);
        asked || set == 0 && framed
    }
}

fn face(material: &Material, back: bool) -> Face {
    use layered_bsdf::nodes::{FLAG_VECTOR, OP_GGX_SMITH, OP_MASK, OP_TINT};
    let (face, part, emission_part) = material.face(back);
    let inputs = material.inputs(part);
    let mut params = Params { v: [0.0; MAX_PARAMS as usize] };
    inputs.load(&mut params);
    let framed = |n: u32| (OP_GGX_SMITH..OP_TINT).contains(&(n & OP_MASK)) && n & FLAG_VECTOR != 0;
    let asks_for_frame = [StateField::FrameX, StateField::FrameY].iter().any(|&f| inputs.state.contains(f));
    Face {
        program: face.bsdf.with_tables(&material.tables),
        params,
        part,
        emitter: face.emission.as_ref().and_then(|e| emitter(material, e, emission_part)),
        is_black: face.bsdf.is_black(),
        is_specular: face.bsdf.is_specular(),
        transmits: face.bsdf.transmits(),
        has_tangents: asks_for_frame || face.bsdf.nodes().iter().any(|n| framed(n.x)),
    }
}

/// None if nothing is emitted, whatever the point.
fn emitter(material: &Material, emission: &Emission, part: Part) -> Option<Emitter> {
    let inputs = material.inputs(part);
    let varies = inputs.varying.iter().any(|&output| output < 3);
    let dark = inputs.uniform.iter().take(3).all(|&i| i <= 0.0);
    if emission.edf.is_black() || !varies && dark {
        return None;
    }
    let mut params = Params { v: [0.0; MAX_PARAMS as usize] };
    inputs.load(&mut params);
    Some(Emitter {
        program: emission.edf.to_program(),
        params,
        part,
        is_power: emission.mode == IntensityMode::Power,
    })
}

/// Whether any of the three outputs from `first` on can be positive.
fn may_exceed_zero(material: &Material, part: Part, first: usize) -> bool {
    let inputs = material.inputs(part);
    let outputs = first..(first + 3).min(inputs.uniform.len());
    outputs.clone().any(|output| inputs.uniform[output] > 0.0)
        || inputs.varying.iter().any(|&output| outputs.contains(&(output as usize)))
}

fn volume_scattering(material: &Material, vdf: &layered_bsdf::prelude::LayerProgram) -> VolumeScattering {
    let mut params = Params { v: [0.0; MAX_PARAMS as usize] };
    material.inputs(Part::VolumeScattering).load(&mut params);
    VolumeScattering { program: vdf.to_program(), params }
}

/// The boundary of a material that is nothing but a specular lobe which transmits.
fn straight(material: &Material, slot: u32, meters: f32) -> Option<StraightBoundary> {
    use layered_bsdf::lobes::MODE_REFLECT;
    use layered_bsdf::nodes::{FLAG_FILM, OP_MASK, OP_SPECULAR};
    let [node] = material.surface.bsdf.nodes() else { return None };
    let transmits = node.x & OP_MASK == OP_SPECULAR && node.x & FLAG_FILM == 0 && node.w != MODE_REFLECT;
    let parts = [Part::Surface, Part::Volume, Part::VolumeScattering];
    let uniform = parts.into_iter().all(|part| material.inputs(part).is_uniform());
    let plain = !material.thin_walled && !material.emits() && !material.has_cutout();
    let surface = &material.inputs(Part::Surface).uniform;
    let tint = Vec3::from_slice(surface.get(3..6)?);
    let inside = Medium::uniform(material, slot, meters);
    // Another index turns light nearly everywhere, so such boundaries would only cost time.
    (transmits && uniform && plain && inside.ior == Vec3::ONE).then(|| StraightBoundary {
        // A NaN counts as 0, as for the evaluator.
        tint: tint.max(Vec3::ZERO).min(Vec3::ONE),
        inside,
    })
}
