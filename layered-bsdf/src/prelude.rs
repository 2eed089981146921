//! What a user of the library imports: the evaluator, its data, and the vector types they use.

pub use crate::albedo::{BsdfAlbedo, bsdf_albedo};
pub use crate::auxiliary::{BsdfAuxiliary, bsdf_auxiliary};
pub use crate::curves::{POINT_INSIDE, POINT_THIN_WALLED, ShadingPoint, shading_point};
pub use crate::edf::{EdfValue, edf_eval, edf_sample};
pub use crate::evaluator::{BsdfSample, BsdfValue, bsdf_eval, bsdf_sample};
pub use crate::lobes::hair::{HAIR_SLOTS, HairSample, HairValue, hair_eval, hair_sample};
pub use crate::lobes::{
    EVENT_ABSORB, EVENT_DIFFUSE, EVENT_GLOSSY, EVENT_REFLECTION, EVENT_SPECULAR, EVENT_TRANSMISSION,
    LobeSample,
};
pub use crate::nodes::{MAX_NODES, MAX_PARAMS, Params, Program};
pub use crate::options::BsdfOptions;
pub use crate::program::{Curve, GlossyModel, LayerProgram, ProgramError, ScatterMode, Slot, Tree};
pub use crate::tables::{Table, Tables};
pub use crate::vdf::{VdfSample, VdfValue, vdf_eval, vdf_sample};
pub use wgsl_rs::std::{Vec2f, Vec3f, vec2f, vec3f};
