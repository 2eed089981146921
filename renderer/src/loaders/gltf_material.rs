//! Materials of glTF as trees of constant values (glTF 2.0, §3.9 and appendix B).

use gltf::material::{AlphaMode, Material};
use layered_bsdf::math::math_log;
use layered_bsdf::prelude::{Curve, ScatterMode, Tree};
use mdl_jit::material::ConstantMaterial;
use std::f32::consts::PI;

/// Index of refraction where a file says nothing.
const IOR: f32 = 1.5;

/// A dielectric is a Fresnel-weighted GGX layer over a Lambertian base, a metal a GGX lobe of Schlick's
/// curve; partial metals are mixtures of both. Textures are left out with a note.
pub(super) fn material(m: &Material<'_>, notes: &mut Vec<String>) -> ConstantMaterial {
    let name = m.name().unwrap_or(if m.index().is_none() { "default" } else { "unnamed" }).to_string();
    let pbr = m.pbr_metallic_roughness();
    let [r, g, b, alpha] = pbr.base_color_factor();
    let mut color = [r, g, b];
    let (mut metallic, mut roughness) = (pbr.metallic_factor(), pbr.roughness_factor());
    let mut left_out = Vec::new();
    if pbr.base_color_texture().is_some() {
        // Factors beside a texture are mostly 1, which would make everything as white as can be.
        color = color.map(|c| 0.5 * c);
        left_out.push("colour (taken as half the factor)");
    }
    if pbr.metallic_roughness_texture().is_some() {
        // As above: everything would be a rough metal.
        (metallic, roughness) = (0.0, 0.5 * roughness);
        left_out.push("metallic and roughness (taken as dielectric, half as rough)");
    }
    if m.normal_texture().is_some() {
        left_out.push("normal");
    }
    let mut emissive = m.emissive_factor();
    if m.emissive_texture().is_some() && emissive.iter().any(|&e| e > 0.0) {
        emissive = [0.0; 3];
        left_out.push("emission (taken as dark)");
    }
    if let Some(old) = m.pbr_specular_glossiness() {
        roughness = 1.0 - old.glossiness_factor();
        metallic = 0.0;
        left_out.push("specular and glossiness (taken as dielectric)");
    }
    let color = m.pbr_specular_glossiness().map_or(color, |old| {
        let [r, g, b, _] = old.diffuse_factor();
        [r, g, b]
    });
    if !left_out.is_empty() {
        notes.push(format!("left out in material `{name}`: {}", left_out.join(", ")));
    }
    let ior = m.ior().unwrap_or(IOR).max(1.0);
    let transmission = m.transmission().map_or(0.0, |t| t.transmission_factor());
    let strength = m.emissive_strength().unwrap_or(1.0);
    // Radiance to the exitance of a Lambertian emitter.
    let exitance = emissive.map(|e| if e * strength > 0.0 { (e * strength).min(f32::MAX) * PI } else { 0.0 });
    ConstantMaterial {
        name,
        // Transmission is through a sheet unless there is a volume.
        thin_walled: transmission > 0.0 && m.volume().is_none_or(|v| v.thickness_factor() == 0.0),
        scattering: scattering(color, metallic, roughness * roughness, ior, transmission),
        emission: exitance.iter().any(|&e| e > 0.0).then_some((Tree::DiffuseEdf, exitance)),
        ior: [ior; 3],
        cutout_opacity: match m.alpha_mode() {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Blend => alpha.clamp(0.0, 1.0),
            AlphaMode::Mask => f32::from(alpha >= m.alpha_cutoff().unwrap_or(0.5)),
        },
        volume_scattering: None,
        volume_emission: [0.0; 3],
        absorption: m.volume().map_or([0.0; 3], absorption),
    }
}

/// Absorption coefficients with which the attenuation colour is left after the attenuation distance.
fn absorption(volume: gltf::material::Volume<'_>) -> [f32; 3] {
    let distance = volume.attenuation_distance();
    let coefficient = |c: f32| -math_log(c.clamp(1e-6, 1.0)) / distance;
    if distance > 0.0 { volume.attenuation_color().map(coefficient) } else { [0.0; 3] }
}

fn scattering(color: [f32; 3], metallic: f32, alpha: f32, ior: f32, transmission: f32) -> Tree<f32> {
    let ggx = |tint: [f32; 3], mode: ScatterMode| Tree::GgxSmith {
        tint,
        roughness_u: alpha,
        roughness_v: alpha,
        mode,
        tangent: None,
    };
    let diffuse = Tree::DiffuseReflection { tint: color, roughness: 0.0, multiscatter_tint: None };
    let mixed = |share: f32, layer: Tree<f32>, base: Tree<f32>| {
        if share <= 0.0 {
            base
        } else if share >= 1.0 {
            layer
        } else {
            let (layer, base) = (Box::new(layer), Box::new(base));
            Tree::Layer { curve: Curve::Constant, weight: [share; 3], normal: None, layer, base }
        }
    };
    let dielectric = Tree::Layer {
        curve: Curve::Fresnel { ior },
        weight: [1.0; 3],
        normal: None,
        layer: Box::new(ggx([1.0; 3], ScatterMode::Reflect)),
        base: Box::new(mixed(transmission, ggx(color, ScatterMode::Transmit), diffuse)),
    };
    let metal = Tree::DirectionalFactor {
        normal_tint: color,
        grazing_tint: [1.0; 3],
        f82_factor: None,
        exponent: 5.0,
        base: Box::new(ggx([1.0; 3], ScatterMode::Reflect)),
    };
    mixed(metallic, metal, dielectric)
}
