//! What of the library a program never calls.
//!
//! Executors that compile the evaluator need not compile what no node asks for: a film's interference, the
//! facets of other lobes. A function whose rows all say no may be left out. A function without a row stays.

use crate::albedo::node_is_angular;
use crate::lobes::MODE_REFLECT;
use crate::nodes::*;
use crate::program::LayerProgram;
use wgsl_rs::std::Vec4u;

/// A function and whether a node calls it.
type Row = (&'static str, fn(Vec4u) -> bool);

const ROWS: &[Row] = &[
    ("bsdf_albedo_sampled", node_is_angular),
    ("film_channels", filmed),
    ("node_film_reflectance", |n| filmed(n) && op(n) < OP_TINT),
    ("coating_film", |n| filmed(n) && op(n) == OP_COLOR_FRESNEL_LAYER),
    ("filmed_curve", |n| filmed(n) && matches!(op(n), OP_CUSTOM_CURVE_LAYER | OP_DIRECTIONAL_FACTOR)),
    ("node_schlick", |n| matches!(op(n), OP_CUSTOM_CURVE_LAYER | OP_DIRECTIONAL_FACTOR)),
    ("color_fresnel", |n| op(n) == OP_COLOR_FRESNEL_LAYER),
    ("measured_curve", |n| matches!(op(n), OP_MEASURED_FACTOR | OP_MEASURED_LAYER)),
    ("measured_most", |n| op(n) == OP_MEASURED_LAYER),
    ("sheen_albedo", |n| matches!(op(n), OP_SHEEN | OP_SHEEN_LAYER)),
    ("modifier_factor", |n| (OP_TINT..OP_WEIGHTED_LAYER).contains(&op(n))),
    ("node_coat_absorption", |n| op(n) == OP_COAT_ABSORPTION),
    ("node_fresnel_factor", |n| op(n) == OP_FRESNEL_FACTOR),
    ("node_measured_eval", |n| op(n) == OP_MEASURED_BSDF),
    ("node_measured_sample", |n| op(n) == OP_MEASURED_BSDF),
    ("node_measured_albedo", |n| op(n) == OP_MEASURED_BSDF),
    ("node_picture_factor", |n| op(n) == OP_MEASURED_PICTURE),
    ("layer_split", |n| op(n) >= OP_WEIGHTED_LAYER),
    ("layer_seen", |n| op(n) >= OP_WEIGHTED_LAYER),
    ("layer_curve", |n| op(n) > OP_WEIGHTED_LAYER),
    ("layer_conserves", |n| op(n) > OP_WEIGHTED_LAYER && n.x & FLAG_CONSERVING != 0),
    ("layer_albedo", |n| op(n) > OP_WEIGHTED_LAYER && n.x & FLAG_CONSERVING != 0),
    ("diffuse_reflection_eval", |n| op(n) == OP_DIFFUSE_REFLECTION),
    ("diffuse_reflection_albedo", |n| op(n) == OP_DIFFUSE_REFLECTION),
    ("diffuse_transmission_eval", |n| op(n) == OP_DIFFUSE_TRANSMISSION),
    ("diffuse_transmission_sample", |n| op(n) == OP_DIFFUSE_TRANSMISSION),
    ("dusty_diffuse_eval", |n| op(n) == OP_DUSTY_DIFFUSE),
    ("dusty_diffuse_albedo", |n| op(n) == OP_DUSTY_DIFFUSE),
    ("microflake_new", |n| op(n) == OP_MICROFLAKE),
    ("microflake_eval", |n| op(n) == OP_MICROFLAKE),
    ("microflake_sample", |n| op(n) == OP_MICROFLAKE),
    ("microflake_albedo", |n| matches!(op(n), OP_MICROFLAKE | OP_MICROFLAKE_LAYER)),
    ("specular_sample", |n| op(n) == OP_SPECULAR),
    ("node_specular_reflectance", |n| op(n) == OP_SPECULAR),
    ("node_glossy_eval", |n| glossy(n) && !plain_ggx(n)),
    ("node_glossy_sample", |n| glossy(n) && !plain_ggx(n)),
    ("node_glossy_albedo", glossy),
    ("ggx_eval", |n| op(n) == OP_GGX_SMITH),
    ("ggx_sample", |n| op(n) == OP_GGX_SMITH),
    ("ggx_eval_refraction", |n| op(n) == OP_GGX_SMITH && n.w != MODE_REFLECT),
    ("facet_eval", other_glossy),
    ("facet_sample", other_glossy),
    ("glossy_eval_refraction", |n| other_glossy(n) && n.w != MODE_REFLECT),
    ("beckmann_area", |n| op(n) == OP_BECKMANN_SMITH),
    ("beckmann_sample_normal", |n| op(n) == OP_BECKMANN_SMITH),
    ("facets_sample", |n| other_glossy(n) && op(n) != OP_BECKMANN_SMITH),
    ("multiscatter_new", |n| glossy(n) && colored(n)),
    ("multiscatter_eval", |n| glossy(n) && colored(n)),
    ("frame_from_normal_tangent", |n| glossy(n) && n.x & FLAG_VECTOR != 0),
];

fn op(n: Vec4u) -> u32 {
    n.x & OP_MASK
}

fn filmed(n: Vec4u) -> bool {
    n.x & FLAG_FILM != 0
}

fn colored(n: Vec4u) -> bool {
    n.x & FLAG_COLOR != 0
}

fn glossy(n: Vec4u) -> bool {
    (OP_GGX_SMITH..=OP_SHEEN).contains(&op(n))
}

fn other_glossy(n: Vec4u) -> bool {
    glossy(n) && op(n) != OP_GGX_SMITH
}

fn plain_ggx(n: Vec4u) -> bool {
    op(n) == OP_GGX_SMITH && !colored(n) && !filmed(n)
}

impl LayerProgram {
    /// Names of functions of the library that evaluating this program never calls. Their results are not
    /// used, whatever they are.
    pub fn unreached(&self) -> impl Iterator<Item = &'static str> + '_ {
        let called = |used: fn(Vec4u) -> bool| self.nodes().iter().any(|&n| used(n));
        let sampled = called(node_is_angular).then_some("bsdf_albedo_closed");
        ROWS.iter().filter(move |(_, used)| !called(*used)).map(|(name, _)| *name).chain(sampled)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::Tree;

    #[test]
    fn every_row_names_a_function() {
        let text = crate::wgsl::source();
        let missing: Vec<&str> =
            ROWS.iter().map(|row| row.0).filter(|name| !text.contains(&format!("fn {name}("))).collect();
        assert!(missing.is_empty(), "{missing:?}");
        assert!(text.contains("fn bsdf_albedo_closed("));
    }

    #[test]
    fn glass_needs_no_film() {
        let glass = Tree::Specular { tint: [1.0f32; 3], mode: crate::program::ScatterMode::ReflectTransmit };
        let (program, _) = LayerProgram::new(&glass).expect("one node");
        let plain: Vec<&str> = program.unreached().collect();
        assert!(plain.contains(&"film_channels") && !plain.contains(&"specular_sample"));
        let filmed = Tree::ThinFilm { thickness: 300.0, ior: [1.3; 3], base: Box::new(glass) };
        let (program, _) = LayerProgram::new(&filmed).expect("one node");
        assert!(program.unreached().all(|name| name != "film_channels"));
    }
}
