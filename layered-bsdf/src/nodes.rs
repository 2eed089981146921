//! The flat form of a tree of distribution functions: node words, parameter slots.
//!
//! A program is an array of nodes in preorder. A node is four words:
//!
//! | word | meaning |
//! |---|---|
//! | x | operation (`OP_*`), plus flags (`FLAG_*`) |
//! | y | first parameter slot |
//! | z | for layers: index of the second child; the first child is the next node |
//! | w | scatter mode (`MODE_*`) of lobes that have one; number of colours of measured curves |
//!
//! Parameters lie in one array of floats per shading point, [`Params`]; the slots of a node are
//! consecutive, in the order of the `SLOT_*` constants here. Optional parts stand last and are announced
//! by flags.

use wgsl_rs::wgsl;

#[wgsl]
pub mod code {
    //! Shared with the GPU.
    pub use crate::tables::code::*;
    use wgsl_rs::std::*;

    /// Most nodes of a program.
    pub const MAX_NODES: u32 = 64;
    /// Most parameter slots of a program.
    pub const MAX_PARAMS: u32 = 384;
    /// Deepest stack of pending children: the child that needs less comes first, so the depth is at most
    /// the logarithm of the number of leaves.
    pub const MAX_STACK: u32 = 6;

    /// Mask of the operation in the first word.
    pub const OP_MASK: u32 = 0xff;
    /// Absorbs everything.
    pub const OP_BLACK: u32 = 0;
    /// Diffuse reflection: tint, roughness, [multiple scattering tint].
    pub const OP_DIFFUSE_REFLECTION: u32 = 1;
    /// Diffuse transmission: tint.
    pub const OP_DIFFUSE_TRANSMISSION: u32 = 2;
    /// Specular: tint.
    pub const OP_SPECULAR: u32 = 3;
    /// GGX microfacets: tint, roughness u and v, tangent if flagged, [multiple scattering tint].
    pub const OP_GGX_SMITH: u32 = 4;
    /// Beckmann microfacets with Smith masking; this and the following have the parameters of GGX.
    pub const OP_BECKMANN_SMITH: u32 = 5;
    /// GGX microfacets in V-shaped cavities.
    pub const OP_GGX_VCAVITIES: u32 = 6;
    /// Beckmann microfacets in V-shaped cavities.
    pub const OP_BECKMANN_VCAVITIES: u32 = 7;
    /// Phong microfacets in V-shaped cavities.
    pub const OP_SIMPLE_GLOSSY: u32 = 8;
    /// Ward's lobe.
    pub const OP_WARD: u32 = 9;
    /// Phong microfacets that send light back.
    pub const OP_BACKSCATTERING: u32 = 10;
    /// Sheen: tint, roughness twice.
    pub const OP_SHEEN: u32 = 11;
    /// Dusty diffuse reflection: tint.
    pub const OP_DUSTY_DIFFUSE: u32 = 12;
    /// Sheen of microflakes: tint, roughness.
    pub const OP_MICROFLAKE: u32 = 13;
    /// Measured scattering: multiplier (three times), number of the table.
    pub const OP_MEASURED_BSDF: u32 = 15;
    /// Tint of one child: colour, [colour for transmission].
    pub const OP_TINT: u32 = 16;
    /// Uniform scale of one child, not limited to 1: factor as colour.
    pub const OP_SCALE: u32 = 17;
    /// Tint by direction: colour at normal incidence, at grazing incidence, exponent, [colour at 82°].
    pub const OP_DIRECTIONAL_FACTOR: u32 = 18;
    /// Reflectance of a medium: index of refraction (three), extinction (three), film if flagged.
    pub const OP_FRESNEL_FACTOR: u32 = 19;
    /// Tint by a measured curve: its colours, as many as the last word says.
    pub const OP_MEASURED_FACTOR: u32 = 20;
    /// Absorption of a coat: index of refraction (three), absorption coefficient (three), thickness.
    pub const OP_COAT_ABSORPTION: u32 = 21;
    /// Tint by a measured picture over the angles to the half vector: number of the table.
    pub const OP_MEASURED_PICTURE: u32 = 24;
    /// Layer by weight: importances, weight, normal if flagged.
    pub const OP_WEIGHTED_LAYER: u32 = 32;
    /// Layer by Fresnel's equations: importances, weight, index of refraction (one), normal if flagged.
    pub const OP_FRESNEL_LAYER: u32 = 33;
    /// Layer by Fresnel's equations: importances, weight, index of refraction (three), normal if flagged.
    pub const OP_COLOR_FRESNEL_LAYER: u32 = 34;
    /// Layer by Schlick's curve: importances, weight, reflectivity at normal and grazing incidence,
    /// exponent, normal if flagged, [colour at 82°].
    pub const OP_CUSTOM_CURVE_LAYER: u32 = 35;
    /// What sheen leaves to its base: importances, weight, roughness, normal if flagged.
    pub const OP_SHEEN_LAYER: u32 = 36;
    /// Layer by a measured curve: importances, weight, the colours of the curve, as many as the last word
    /// says, normal if flagged.
    pub const OP_MEASURED_LAYER: u32 = 37;
    /// What the sheen of microflakes leaves to its base: importances, weight, roughness, normal if flagged.
    pub const OP_MICROFLAKE_LAYER: u32 = 38;
    /// Diffuse emission; no parameters. This and the next are emission.
    pub const OP_DIFFUSE_EDF: u32 = 64;
    /// Emission into a cone: exponent, spread, axis if flagged.
    pub const OP_SPOT_EDF: u32 = 65;
    /// Scattering by particles with a bias forwards or backwards: mean cosine. This and all above scatter in volumes.
    pub const OP_ANISOTROPIC_VDF: u32 = 66;
    /// Scattering by droplets: diameter in µm.
    pub const OP_FOG_VDF: u32 = 67;

    /// The lobe has a tangent; the layer has a normal; the cone has an axis.
    pub const FLAG_VECTOR: u32 = 0x100;
    /// A colour for multiple scattering, for transmission, or at 82°.
    pub const FLAG_COLOR: u32 = 0x200;
    /// The first child of a layer is its base.
    pub const FLAG_BASE_FIRST: u32 = 0x400;
    /// A thin film lies on what reflects: thickness in nm, index of refraction (three), behind all else.
    pub const FLAG_FILM: u32 = 0x800;
    /// A lobe's heights of masking and shadowing are correlated.
    pub const FLAG_CORRELATED: u32 = 0x1000;
    /// The base of a layer gets what the layer leaves: a table of its albedo stands behind the film.
    pub const FLAG_CONSERVING: u32 = 0x1000;

    /// Slot of the tint of a lobe or modifier.
    pub const SLOT_TINT: u32 = 0;
    /// Slot of the roughness of diffuse reflection.
    pub const SLOT_DIFFUSE_ROUGHNESS: u32 = 3;
    /// Slot of the multiple scattering tint of diffuse reflection.
    pub const SLOT_DIFFUSE_MULTIPLE: u32 = 4;
    /// Slot of the roughness of a glossy lobe, u then v.
    pub const SLOT_GLOSSY_ALPHA: u32 = 3;
    /// Slot of the tangent of a glossy lobe.
    pub const SLOT_GLOSSY_TANGENT: u32 = 5;
    /// Slot of the multiple scattering tint of a glossy lobe without a tangent.
    pub const SLOT_GLOSSY_MULTIPLE: u32 = 5;
    /// The same of one with a tangent.
    pub const SLOT_GLOSSY_MULTIPLE_TURNED: u32 = 8;
    /// Slot of the table of a measured lobe.
    pub const SLOT_MEASURED_TABLE: u32 = 3;
    /// Slot of the second colour of a tint.
    pub const SLOT_TINT_TRANSMISSION: u32 = 3;
    /// Slot of the tint at grazing incidence.
    pub const SLOT_FACTOR_GRAZING: u32 = 3;
    /// Slot of the extinction of a Fresnel factor.
    pub const SLOT_FACTOR_EXTINCTION: u32 = 3;
    /// Slot of the exponent of a directional factor.
    pub const SLOT_FACTOR_EXPONENT: u32 = 6;
    /// Slot of the colour at 82° of a directional factor.
    pub const SLOT_FACTOR_F82: u32 = 7;
    /// Slot of the absorption coefficient of a coat.
    pub const SLOT_COAT_ABSORPTION: u32 = 3;
    /// Slot of the thickness of a coat.
    pub const SLOT_COAT_THICKNESS: u32 = 6;
    /// Slot of the axis of a cone of light.
    pub const SLOT_SPOT_AXIS: u32 = 2;
    /// Slots of the importances of layer and base: what selection probabilities are weighted by.
    pub const SLOT_LAYER_IMPORTANCE: u32 = 0;
    /// Slot of the weight of a layer, a colour.
    pub const SLOT_LAYER_WEIGHT: u32 = 2;
    /// First slot of what a kind of layer has beyond its weight.
    pub const SLOT_LAYER_CURVE: u32 = 5;

    /// The parameters of a program at a shading point.
    #[derive(Clone, Copy, Debug)]
    pub struct Params {
        /// By slot.
        pub v: [f32; 384],
    }

    /// The parameter in a slot.
    #[wgsl_inline::always]
    pub fn param(p: ptr!(function, Params), slot: u32) -> f32 {
        p.v[select(383u32, slot, slot < 384u32) as usize]
    }

    /// The three parameters from a slot on.
    #[wgsl_inline::always]
    pub fn param3(p: ptr!(function, Params), slot: u32) -> Vec3f {
        // One limit instead of three checks of bounds.
        let first = select(381u32, slot, slot < 382u32);
        vec3f(p.v[first as usize], p.v[(first + 1) as usize], p.v[(first + 2) as usize])
    }
}
pub use code::*;
