//! Tables of a program that depend on its arguments, computed when these change.

use crate::conserve::{CONSERVE_ENTRIES, conserve_slot};
use crate::nodes::*;
use crate::prelude::*;
use wgsl_rs::std::{Vec4u, vec4u};

/// Samples per entry.
const SAMPLES: u32 = 4096;

impl LayerProgram {
    /// Fills the tables of layers that conserve energy, after [`LayerProgram::prepare`], for light from air
    /// in front of `point`. Layers with a slot that `varying` names, or with measured tables, keep MDL's weights.
    pub fn conserve(&self, params: &mut Params, point: ShadingPoint, varying: impl Fn(usize) -> bool) {
        for index in (0..self.nodes().len()).rev() {
            let n = self.nodes()[index];
            let op = n.x & OP_MASK;
            if !(OP_WEIGHTED_LAYER..OP_DIFFUSE_EDF).contains(&op) || n.x & FLAG_CONSERVING == 0 {
                continue;
            }
            let table = conserve_slot(n) as usize;
            let (layer, slots) = self.lone_layer(index);
            let tables =
                layer.iter().any(|n| matches!(n.x & OP_MASK, OP_MEASURED_BSDF | OP_MEASURED_PICTURE));
            if tables || slots.into_iter().any(&varying) {
                params.v[table] = -1.0;
                continue;
            }
            let mut program = Program {
                count: layer.len() as u32,
                nodes: [vec4u(0, 0, 0, 0); MAX_NODES as usize],
                tables: Tables::default(),
            };
            program.nodes[..layer.len()].copy_from_slice(&layer);
            let mut alone = *params;
            alone.v[(n.y + SLOT_LAYER_IMPORTANCE) as usize + 1] = 0.0;
            for entry in 0..CONSERVE_ENTRIES {
                let x = (entry as f32 / (CONSERVE_ENTRIES - 1) as f32).max(1e-3);
                let albedo = sampled_albedo(&mut program, &mut alone, point, x * x);
                let at = table + 3 * entry as usize;
                params.v[at..at + 3].copy_from_slice(&albedo);
            }
        }
    }

    /// The layer at `index` over nothing, and the slots that it depends on.
    fn lone_layer(&self, index: usize) -> (Vec<Vec4u>, Vec<usize>) {
        let nodes = self.nodes();
        let n = nodes[index];
        let base_first = n.x & FLAG_BASE_FIRST != 0;
        let start = if base_first { n.z as usize } else { index + 1 };
        let end = self.end(start);
        // The layer comes first, then its black base.
        let count = (end - start) as u32;
        let word = n.x & !(FLAG_CONSERVING | FLAG_BASE_FIRST);
        let mut alone = vec![vec4u(word, n.y, 1 + count, n.w)];
        let shift = start as u32 - 1;
        for m in &nodes[start..end] {
            let second = if m.x & OP_MASK >= OP_WEIGHTED_LAYER { m.z - shift } else { m.z };
            alone.push(vec4u(m.x, m.y, second, m.w));
        }
        alone.push(vec4u(OP_BLACK, 0, 0, 0));
        let own = n.y as usize..conserve_slot(n) as usize;
        let first = nodes[start].y as usize;
        let last = nodes.get(end).map_or(self.slots(), |next| next.y as usize);
        // Behind a layer that comes second lie the slots of what follows.
        (alone, own.chain(first..last.max(first)).collect())
    }

    /// One past the last node of the subtree at `index`.
    fn end(&self, index: usize) -> usize {
        let n = self.nodes()[index];
        match n.x & OP_MASK {
            OP_WEIGHTED_LAYER.. => self.end(n.z as usize),
            OP_TINT.. => self.end(index + 1),
            _ => index + 1,
        }
    }
}

/// The mean weight of samples at points that fill the cube evenly, seen at cosine `c`.
fn sampled_albedo(program: &mut Program, params: &mut Params, point: ShadingPoint, c: f32) -> [f32; 3] {
    let wo = vec3f((1.0 - c * c).max(0.0).sqrt(), 0.0, c);
    let mut sum = [0.0f64; 3];
    for i in 0..SAMPLES {
        // Powers of the inverse root of x⁴ = x + 1 (M. Roberts, 2018).
        let k = f64::from(i) + 0.5;
        let u =
            [0.819_172_5, 0.671_043_6, 0.549_700_5].map(|step| ((k * step).fract() as f32).min(0.999_999_9));
        let weight = bsdf_sample(program, params, point, wo, vec3f(u[0], u[1], u[2])).weight;
        for (sum, weight) in sum.iter_mut().zip([weight.x, weight.y, weight.z]) {
            *sum += f64::from(weight);
        }
    }
    sum.map(|sum| (sum / f64::from(SAMPLES)).clamp(0.0, 1.0) as f32)
}
