//! Programs in words, for people.

use crate::nodes::*;
use crate::program::LayerProgram;

/// A node in words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeText {
    /// Name of the operation, with its mode.
    pub name: String,
    /// Names of its parameters with their first slots.
    pub slots: String,
    /// Indices of its children.
    pub children: Vec<usize>,
}

/// Name of an operation and its parameters with their numbers of slots; those behind `optional` are there
/// if the flag is set.
struct Operation {
    name: &'static str,
    parameters: &'static [(&'static str, u32)],
    optional: &'static [(u32, &'static str)],
}

const LAYER: [(&str, u32); 2] = [("importance", 2), ("weight", 3)];

const GLOSSY: [(&str, u32); 2] = [("tint", 3), ("roughness", 2)];
const GLOSSY_MORE: [(u32, &str); 2] = [(FLAG_VECTOR, "tangent"), (FLAG_COLOR, "multiscatter tint")];

fn operation(op: u32) -> Operation {
    type Row = (&'static str, &'static [(&'static str, u32)], &'static [(u32, &'static str)]);
    let (name, parameters, optional): Row = match op {
        OP_BLACK => ("black", &[], &[]),
        OP_DIFFUSE_REFLECTION => {
            ("diffuse reflection", &[("tint", 3), ("roughness", 1)], &[(FLAG_COLOR, "multiscatter tint")])
        }
        OP_DIFFUSE_TRANSMISSION => ("diffuse transmission", &[("tint", 3)], &[]),
        OP_SPECULAR => ("specular", &[("tint", 3)], &[]),
        OP_GGX_SMITH => ("GGX Smith", &GLOSSY, &GLOSSY_MORE),
        OP_BECKMANN_SMITH => ("Beckmann Smith", &GLOSSY, &GLOSSY_MORE),
        OP_GGX_VCAVITIES => ("GGX V-cavities", &GLOSSY, &GLOSSY_MORE),
        OP_BECKMANN_VCAVITIES => ("Beckmann V-cavities", &GLOSSY, &GLOSSY_MORE),
        OP_SIMPLE_GLOSSY => ("simple glossy", &GLOSSY, &GLOSSY_MORE),
        OP_WARD => ("Ward", &GLOSSY, &GLOSSY_MORE),
        OP_BACKSCATTERING => ("backscattering glossy", &GLOSSY, &GLOSSY_MORE),
        OP_SHEEN => ("sheen", &GLOSSY, &[]),
        OP_DUSTY_DIFFUSE => ("dusty diffuse reflection", &[("tint", 3)], &[]),
        OP_MICROFLAKE => ("microflake sheen", &[("tint", 3), ("roughness", 1)], &[]),
        OP_MEASURED_BSDF => ("measured BSDF", &[("multiplier", 3), ("measurement", 1)], &[]),
        OP_TINT => ("tint", &[("tint", 3)], &[(FLAG_COLOR, "transmission tint")]),
        OP_SCALE => ("scale", &[("factor", 3)], &[]),
        OP_DIRECTIONAL_FACTOR => (
            "directional factor",
            &[("normal tint", 3), ("grazing tint", 3), ("exponent", 1)],
            &[(FLAG_COLOR, "f82 factor")],
        ),
        OP_FRESNEL_FACTOR => ("Fresnel factor", &[("ior", 3), ("extinction", 3)], &[]),
        OP_MEASURED_FACTOR => ("measured curve factor", &[], &[]),
        OP_MEASURED_PICTURE => ("measured factor", &[("picture", 1)], &[]),
        OP_COAT_ABSORPTION => {
            ("coat absorption", &[("ior", 3), ("absorption coefficient", 3), ("thickness", 1)], &[])
        }
        OP_WEIGHTED_LAYER => ("weighted layer", &LAYER, &[(FLAG_VECTOR, "normal")]),
        OP_FRESNEL_LAYER => ("Fresnel layer", &[LAYER[0], LAYER[1], ("ior", 1)], &[(FLAG_VECTOR, "normal")]),
        OP_COLOR_FRESNEL_LAYER => {
            ("color Fresnel layer", &[LAYER[0], LAYER[1], ("ior", 3)], &[(FLAG_VECTOR, "normal")])
        }
        OP_MEASURED_LAYER => ("measured curve layer", &LAYER, &[]),
        OP_SHEEN_LAYER => {
            ("layer of sheen", &[LAYER[0], LAYER[1], ("roughness", 1)], &[(FLAG_VECTOR, "normal")])
        }
        OP_CUSTOM_CURVE_LAYER => (
            "custom curve layer",
            &[LAYER[0], LAYER[1], ("normal reflectivity", 3), ("grazing reflectivity", 3), ("exponent", 1)],
            &[(FLAG_COLOR, "f82 factor"), (FLAG_VECTOR, "normal")],
        ),
        OP_MICROFLAKE_LAYER => {
            ("layer of microflake sheen", &[LAYER[0], LAYER[1], ("roughness", 1)], &[(FLAG_VECTOR, "normal")])
        }
        OP_DIFFUSE_EDF => ("diffuse emission", &[], &[]),
        OP_SPOT_EDF => ("spot emission", &[("exponent", 1), ("spread", 1)], &[(FLAG_VECTOR, "axis")]),
        OP_ANISOTROPIC_VDF => ("anisotropic scattering", &[("directional bias", 1)], &[]),
        OP_FOG_VDF => ("scattering by droplets", &[("particle size", 1)], &[]),
        _ => ("unknown", &[], &[]),
    };
    Operation { name, parameters, optional }
}

impl LayerProgram {
    /// The nodes in words, in order.
    pub fn describe(&self) -> Vec<NodeText> {
        self.nodes().iter().enumerate().map(|(index, n)| describe(index, n.x, n.y, n.z, n.w)).collect()
    }
}

/// Parameters of a node: names, first slots, numbers of slots.
pub(crate) fn parameters(word: u32, mut slot: u32, count_or_mode: u32) -> Vec<(&'static str, u32, u32)> {
    let op = word & OP_MASK;
    let operation = operation(op);
    let present = operation.optional.iter().filter(|(flag, _)| word & flag != 0).map(|(_, name)| (*name, 3));
    let curve = matches!(op, OP_MEASURED_FACTOR | OP_MEASURED_LAYER).then_some(("curve", 3 * count_or_mode));
    let normal = op == OP_MEASURED_LAYER && word & FLAG_VECTOR != 0;
    let film = [("film thickness", 1), ("film ior", 3)].into_iter().filter(|_| word & FLAG_FILM != 0);
    let last = curve.into_iter().chain(normal.then_some(("normal", 3))).chain(film);
    let all = operation.parameters.iter().copied().chain(present).chain(last);
    all.map(|(name, count)| {
        let first = slot;
        slot += count;
        (name, first, count)
    })
    .collect()
}

/// Name of the operation of a node.
pub(crate) fn name(word: u32) -> &'static str {
    operation(word & OP_MASK).name
}

fn describe(index: usize, word: u32, slot: u32, second: u32, count_or_mode: u32) -> NodeText {
    let op = word & OP_MASK;
    let has_mode = op == OP_SPECULAR || op == OP_MEASURED_BSDF || op >= OP_GGX_SMITH && op < OP_WARD;
    let mode = match count_or_mode {
        _ if !has_mode => "",
        crate::lobes::MODE_REFLECT => ", reflecting",
        crate::lobes::MODE_TRANSMIT => ", transmitting",
        _ => ", reflecting and transmitting",
    };
    let slots = parameters(word, slot, count_or_mode).into_iter().map(|(name, slot, count)| match count {
        1 => format!("{name} [{slot}]"),
        _ => format!("{name} [{slot}..{}]", slot + count),
    });
    let slots: Vec<String> = slots.collect();
    let children = match op {
        op if op >= OP_DIFFUSE_EDF => vec![],
        op if op >= OP_WEIGHTED_LAYER => vec![index + 1, second as usize],
        op if op >= OP_TINT => vec![index + 1],
        _ => vec![],
    };
    let beyond = match word & FLAG_CORRELATED {
        0 => "",
        _ if op < OP_TINT => ", correlated heights",
        _ => ", conserving",
    };
    NodeText { name: format!("{}{mode}{beyond}", name(word)), slots: slots.join(", "), children }
}

#[cfg(test)]
mod tests {
    use crate::program::{Curve, LayerProgram, ScatterMode, Tree};

    #[test]
    fn a_coat_is_described_with_its_children() {
        let tree = Tree::Layer {
            curve: Curve::Fresnel { ior: 1.5 },
            weight: [1.0; 3],
            normal: None,
            layer: Box::new(Tree::Specular { tint: [1.0; 3], mode: ScatterMode::Reflect }),
            base: Box::new(Tree::Black),
        };
        let (program, slots) = LayerProgram::new(&tree).expect("a small tree");
        let text = program.describe();
        assert_eq!(text[0].name, "Fresnel layer");
        assert_eq!(text[0].slots, "importance [0..2], weight [2..5], ior [5]");
        assert_eq!(text[0].children, [1, 2]);
        assert_eq!(text[1].name, "specular, reflecting");
        assert_eq!(slots.len(), 9);
    }
}
