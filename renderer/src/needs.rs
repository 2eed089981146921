//! What a scene needs, why, and what it costs.
//!
//! A feature that is off costs nothing: no column of the paths, no work per path.

use crate::integrator::media::Media;
use crate::integrator::pool::PathFields;
use crate::lights::Lights;
use crate::scene::{Environment, Scene};
use crate::shading::Shader;
use mdl_jit::material::{Material, Part};
use mdl_jit::state::{StateField, StateFields};

/// A feature of the renderer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Feature {
    /// Light passes surfaces.
    Transmission,
    /// Paths know the volumes that they are in.
    Volumes,
    /// Volumes absorb.
    Absorption,
    /// Volumes scatter.
    Scattering,
    /// Volumes emit.
    VolumeEmission,
    /// Boundaries of volumes that light may pass without a turn.
    StraightBoundaries,
    /// Parts of surfaces are cut out.
    Cutout,
    /// Surfaces emit.
    Emission,
    /// Emission varies over surfaces.
    VaryingEmission,
    /// Light from far away.
    Environment,
    /// Surfaces without an inside.
    ThinWalled,
    /// The back of a surface differs from its front.
    Backface,
    /// Materials change normals.
    Normals,
    /// Frames follow the texture coordinates.
    Tangents,
    /// Inputs are computed per point.
    VaryingInputs,
    /// The lens has an extent.
    DepthOfField,
    /// Meshes are shared between instances.
    Instancing,
    /// Pictures have an alpha channel.
    Alpha,
    /// Coordinates are relative to the camera.
    FarOrigin,
}

impl Feature {
    /// All in order.
    pub const ALL: [Feature; 19] = [
        Feature::Transmission,
        Feature::Volumes,
        Feature::Absorption,
        Feature::Scattering,
        Feature::VolumeEmission,
        Feature::StraightBoundaries,
        Feature::Cutout,
        Feature::Emission,
        Feature::VaryingEmission,
        Feature::Environment,
        Feature::ThinWalled,
        Feature::Backface,
        Feature::Normals,
        Feature::Tangents,
        Feature::VaryingInputs,
        Feature::DepthOfField,
        Feature::Instancing,
        Feature::Alpha,
        Feature::FarOrigin,
    ];

    /// A short name for reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Transmission => "transmission",
            Self::Volumes => "volumes",
            Self::Absorption => "absorption",
            Self::Scattering => "scattering",
            Self::VolumeEmission => "volume emission",
            Self::StraightBoundaries => "straight boundary",
            Self::Cutout => "cutout",
            Self::Emission => "emission",
            Self::VaryingEmission => "varying emission",
            Self::Environment => "environment",
            Self::ThinWalled => "thin walled",
            Self::Backface => "backface",
            Self::Normals => "normals",
            Self::Tangents => "tangents",
            Self::VaryingInputs => "varying inputs",
            Self::DepthOfField => "depth of field",
            Self::Instancing => "instancing",
            Self::Alpha => "alpha",
            Self::FarOrigin => "far origin",
        }
    }
}

/// Whether a feature is on, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Need {
    /// The feature.
    pub feature: Feature,
    /// Whether it is on.
    pub on: bool,
    /// The material or setting that asks for it; empty if it is off.
    pub why: String,
    /// What it adds to the state of a path.
    pub bytes_per_path: usize,
}

/// The features of a scene with its materials.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Needs {
    /// One row per feature.
    pub rows: Vec<Need>,
    /// State of a path in total.
    pub bytes_per_path: usize,
}

impl Needs {
    /// Collects what is needed. Materials in slots that no triangle uses do not count.
    pub fn new(scene: &Scene, shaders: &[Shader], lights: &Lights) -> Self {
        let used = used_slots(scene, shaders.len());
        let named = |test: &dyn Fn(&Shader) -> bool| {
            let users = shaders.iter().zip(&used).filter(|(shader, used)| **used && test(shader));
            let names: Vec<&str> = users.map(|(shader, _)| shader.material.name.as_str()).take(3).collect();
            names.join(", ")
        };
        let setting = |on: bool, why: &str| if on { why.to_string() } else { String::new() };
        let mut inner = PathFields::INNER_BYTES;
        let mut traveled = PathFields::TRAVELED_BYTES;
        let rows = Feature::ALL.map(|feature| {
            let why = match feature {
                Feature::Transmission => named(&|s| transmits(s)),
                Feature::Volumes => named(&|s| s.has_interior),
                Feature::Absorption => named(&|s| s.has_interior && absorbs(&s.material)),
                Feature::Scattering => named(&|s| s.scattering.is_some()),
                Feature::VolumeEmission => named(&|s| s.glows),
                Feature::StraightBoundaries => named(&|s| s.straight.is_some()),
                Feature::Cutout => named(&|s| s.has_cutout),
                Feature::Emission => named(&|s| s.emits()),
                Feature::VaryingEmission => named(&varying_emission),
                Feature::Environment => match (&scene.environment, &lights.environment) {
                    (_, None) => String::new(),
                    (Environment::Constant(_), _) => "a constant environment".to_string(),
                    _ => "an environment map".to_string(),
                },
                Feature::ThinWalled => named(&|s| s.material.thin_walled && !s.face(false).is_black),
                Feature::Backface => named(&|s| s.has_back()),
                Feature::Normals => named(&|s| s.has_normal),
                Feature::Tangents => named(&|s| (0..4).any(|set| s.needs_tangents(set))),
                Feature::VaryingInputs => named(&varying_inputs),
                Feature::DepthOfField => setting(scene.camera.aperture_radius > 0.0, "the camera's aperture"),
                Feature::Instancing => {
                    setting(scene.notes.instanced_meshes > 0, "meshes with several instances")
                }
                Feature::Alpha => setting(!scene.background_visible, "the background is not visible"),
                Feature::FarOrigin => {
                    setting(scene.origin != glam::DVec3::ZERO, "the camera is far from the origin")
                }
            };
            let on = !why.is_empty();
            let bytes = match feature {
                Feature::Volumes => Media::BYTES,
                // Shared by two features: the first that is on pays.
                Feature::Scattering | Feature::VolumeEmission if on => std::mem::take(&mut inner),
                Feature::StraightBoundaries | Feature::Cutout if on => std::mem::take(&mut traveled),
                Feature::Alpha => PathFields::ALPHA_BYTES,
                _ => 0,
            };
            Need { feature, on, why, bytes_per_path: if on { bytes } else { 0 } }
        });
        let mut needs = Self { rows: rows.to_vec(), bytes_per_path: 0 };
        needs.bytes_per_path = needs.path_fields().bytes();
        needs
    }

    /// Whether a feature is on.
    pub fn on(&self, feature: Feature) -> bool {
        self.rows.iter().any(|need| need.feature == feature && need.on)
    }

    /// The columns that paths have.
    pub fn path_fields(&self) -> PathFields {
        PathFields {
            media: self.on(Feature::Volumes),
            inner: self.on(Feature::Scattering) || self.on(Feature::VolumeEmission),
            traveled: self.on(Feature::Cutout) || self.on(Feature::StraightBoundaries),
            alpha: self.on(Feature::Alpha),
        }
    }
}

fn used_slots(scene: &Scene, count: usize) -> Vec<bool> {
    let mut used = vec![false; count];
    for (instance, place) in scene.places.iter().enumerate() {
        let geometry = &scene.geometries[place.geometry as usize];
        let triangles = geometry.triangles.len() as u32;
        // One group is the rule; it needs no walk over all triangles.
        let walk = if geometry.has_groups() { triangles } else { triangles.min(1) };
        for primitive in 0..walk {
            used[scene.slot(instance as u32, primitive) as usize] = true;
        }
    }
    used
}

fn transmits(shader: &Shader) -> bool {
    [false, true].into_iter().any(|back| shader.face(back).transmits)
}

fn absorbs(material: &Material) -> bool {
    let volume = material.inputs(Part::Volume);
    !volume.is_uniform() || volume.uniform.iter().take(3).any(|&a| a > 0.0)
}

fn varying_emission(shader: &Shader) -> bool {
    let emitters = [false, true].into_iter().filter_map(|back| shader.emitter(back));
    emitters.into_iter().any(|e| !shader.material.inputs(e.part).is_uniform())
}

fn varying_inputs(shader: &Shader) -> bool {
    let parts =
        [Part::Cutout, Part::Normal, Part::Surface, Part::Backface, Part::Volume, Part::VolumeScattering];
    parts.into_iter().any(|part| !shader.material.inputs(part).is_uniform())
}

/// Fields of the state that any of `shaders` asks for.
pub fn state_fields(shaders: &[Shader]) -> Vec<StateField> {
    let all = shaders.iter().fold(StateFields::NONE, |all, s| all.union(s.fields).union(s.emission_fields));
    all.iter().collect()
}
