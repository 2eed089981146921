//! Parameters that no material means: what they are, and what they count as.
//!
//! The evaluator gives finite results for any parameter. Whoever wrote a roughness of 2 wants to know.

use crate::describe::{name, parameters};
use crate::nodes::Params;
use crate::program::LayerProgram;

/// What values a parameter may have.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Range {
    /// 0 to 1.
    Unit,
    /// 0 and above.
    NonNegative,
    /// Above 0.
    Positive,
    /// −1 to 1.
    Signed,
    /// A direction.
    Direction,
    /// Not the author's.
    Derived,
}

/// The range of a parameter, by its name in [`crate::describe`].
fn range(name: &str) -> Range {
    match name {
        "importance" | "measurement" | "picture" => Range::Derived,
        "ior" | "film ior" => Range::Positive,
        "directional bias" => Range::Signed,
        "tangent" | "normal" | "axis" => Range::Direction,
        "factor"
        | "exponent"
        | "extinction"
        | "absorption coefficient"
        | "thickness"
        | "film thickness"
        | "spread"
        | "particle size" => Range::NonNegative,
        _ => Range::Unit,
    }
}

/// What is wrong with values, if anything.
fn complaint(range: Range, values: &[f32]) -> Option<String> {
    let wrong = |x: f32| match range {
        Range::Unit => !(0.0..=1.0).contains(&x),
        Range::NonNegative => !(x >= 0.0 && x.is_finite()),
        Range::Positive => !(x > 0.0 && x.is_finite()),
        Range::Signed => !(-1.0..=1.0).contains(&x),
        Range::Direction => !x.is_finite(),
        Range::Derived => false,
    };
    if range == Range::Direction && values.iter().all(|&x| x == 0.0) {
        return Some("is zero; directions have a length".to_string());
    }
    let x = values.iter().copied().find(|&x| wrong(x))?;
    let expected = match range {
        Range::Unit if x > 1.0 => "counts as 1",
        Range::Unit => "counts as 0",
        Range::NonNegative => "should be finite and not negative",
        Range::Positive => "should be finite and above 0",
        Range::Signed => "should lie in -1 to 1",
        Range::Direction | Range::Derived => "should be finite",
    };
    Some(format!("is {x}; it {expected}"))
}

impl LayerProgram {
    /// Parameters outside of what they may be, a sentence each. Slots that `varying` names are not looked at.
    pub fn complaints(&self, params: &Params, varying: impl Fn(usize) -> bool) -> Vec<String> {
        let mut complaints = Vec::new();
        for n in self.nodes() {
            for (parameter, slot, count) in parameters(n.x, n.y, n.w) {
                let slots = slot as usize..(slot + count) as usize;
                if slots.clone().any(&varying) {
                    continue;
                }
                let found = complaint(range(parameter), &params.v[slots]);
                complaints.extend(found.map(|found| format!("{parameter} of {} {found}", name(n.x))));
            }
        }
        complaints.dedup();
        complaints
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::{Curve, ScatterMode, Tree};

    fn complaints(tree: &Tree<f32>) -> Vec<String> {
        let (program, params) = LayerProgram::with_values(tree).expect("a small tree");
        program.complaints(&params, |_| false)
    }

    fn coat(roughness: f32, weight: f32, ior: f32) -> Tree<f32> {
        let mode = ScatterMode::Reflect;
        let layer =
            Tree::GgxSmith { tint: [1.0; 3], roughness_u: roughness, roughness_v: 0.5, mode, tangent: None };
        Tree::Layer {
            curve: Curve::Fresnel { ior },
            weight: [weight; 3],
            normal: None,
            layer: Box::new(layer),
            base: Box::new(Tree::Black),
        }
    }

    #[test]
    fn good_parameters_pass() {
        assert_eq!(complaints(&coat(0.0, 1.0, 1.5)), Vec::<String>::new());
    }

    #[test]
    fn bad_parameters_are_named() {
        for (tree, expected) in [
            (coat(f32::NAN, 1.0, 1.5), "roughness of GGX Smith is NaN; it counts as 0"),
            (coat(-0.5, 1.0, 1.5), "roughness of GGX Smith is -0.5; it counts as 0"),
            (coat(0.5, 2.0, 1.5), "weight of Fresnel layer is 2; it counts as 1"),
            (coat(0.5, 1.0, 0.0), "ior of Fresnel layer is 0; it should be finite and above 0"),
        ] {
            assert_eq!(complaints(&tree), [expected]);
        }
        let fog = Tree::AnisotropicVdf { directional_bias: 3.0 };
        assert_eq!(
            complaints(&fog),
            ["directional bias of anisotropic scattering is 3; it should lie in -1 to 1"]
        );
        assert_eq!(complaints(&Tree::FogVdf { particle_size: -1.0 }).len(), 1);
        let film = Tree::ThinFilm {
            thickness: f32::INFINITY,
            ior: [1.3, 0.0, 1.3],
            base: Box::new(Tree::Specular { tint: [1.0; 3], mode: ScatterMode::ReflectTransmit }),
        };
        assert_eq!(complaints(&film).len(), 2);
        let bumped = Tree::Layer {
            curve: Curve::Constant,
            weight: [0.5; 3],
            normal: Some([0.0; 3]),
            layer: Box::new(Tree::Black),
            base: Box::new(Tree::MeasuredFactor {
                curve: vec![[0.5, 1.5, 0.0]],
                base: Box::new(Tree::Black),
            }),
        };
        assert_eq!(
            complaints(&bumped),
            [
                "normal of weighted layer is zero; directions have a length",
                "curve of measured curve factor is 1.5; it counts as 1",
            ]
        );
    }
}
