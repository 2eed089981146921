//! Hair of a material: the parameters of one lobe, below tints.

use super::distribution::{Distributions, Param, Structure};
use super::error::LowerError;
use mdl_frontend::graph::{BinaryOp, NodeId, NodeKind, Op, Stage};

/// Deepest nesting of tints and conditions.
const MAX_DEPTH: usize = 256;

impl<S: Structure> Distributions<'_, S> {
    /// The slots of a `hair_bsdf`, as [`layered_bsdf::lobes::hair`] orders them; none if it is black.
    pub fn hair(&mut self, root: NodeId) -> Result<Option<Vec<Param>>, LowerError> {
        let mut node = root;
        let mut tint: Option<NodeId> = None;
        for _ in 0..MAX_DEPTH {
            let NodeKind::Op(op, args) = self.graph.graph.node(node).kind.clone() else { return Ok(None) };
            let name = match &op {
                Op::Builtin(name) => name.strip_prefix("::df::").unwrap_or(name),
                Op::Select if self.graph.graph.node(args[0]).stage < Stage::Varying => {
                    let chosen = self.structure.integer(self.graph, args[0])? != 0;
                    node = if chosen { args[1] } else { args[2] };
                    continue;
                }
                Op::Select => return Err(LowerError::Structure),
                _ => "",
            };
            match (name, &args[..]) {
                ("tint", &[color, base]) => {
                    tint = Some(match tint {
                        Some(outer) => self.graph.binary(BinaryOp::Mul, outer, color),
                        None => color,
                    });
                    node = base;
                }
                ("chiang_hair_bsdf", &[weight, diffuse, r, tt, trt, cuticle, absorption, ior, _]) => {
                    let mut slots = tint.map_or([Param::Const(1.0); 3], |tint| self.color(tint)).to_vec();
                    slots.push(self.float(weight));
                    slots.extend(self.color(diffuse));
                    // The first two components of each.
                    slots.extend([r, tt, trt].into_iter().flat_map(|node| self.pair(node)));
                    slots.push(self.float(cuticle));
                    slots.extend(self.color(absorption));
                    slots.push(self.float(ior));
                    return Ok(Some(slots));
                }
                _ => return Err(LowerError::Distribution(format!("`df::{name}` as hair"))),
            }
        }
        Err(LowerError::TooDeep(MAX_DEPTH))
    }
}
