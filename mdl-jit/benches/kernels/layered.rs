//! An evaluator of layer programs: a loop over nodes with a small stack.

use wgsl_rs::wgsl;

#[wgsl]
#[allow(
    missing_docs,
    clippy::approx_constant,
    clippy::assign_op_pattern,
    reason = "WGSL has one spelling of these"
)]
pub mod code {
    use crate::kernels::ggx::code::*;
    use wgsl_rs::std::*;

    pub const OP_DIFFUSE: u32 = 0;
    pub const OP_GGX: u32 = 1;
    pub const OP_WEIGHTED: u32 = 2;
    pub const OP_FRESNEL: u32 = 3;

    pub struct Params {
        pub v: [f32; 64],
    }
    pub struct Layers {
        pub nodes: [Vec4u; 16],
    }
    #[derive(Clone, Copy)]
    pub struct Entry {
        pub weight: Vec3f,
        pub prob: f32,
        pub node: u32,
    }
    pub struct Value {
        pub diffuse: Vec3f,
        pub glossy: Vec3f,
        pub pdf: f32,
    }

    pub fn param_vec3(p: ptr!(function, Params), i: u32) -> Vec3f {
        vec3f(p.v[i as usize], p.v[(i + 1) as usize], p.v[(i + 2) as usize])
    }

    pub fn fresnel(c: f32, eta: f32) -> f32 {
        let g = sqrt(max((eta - 1.0) * (eta + 1.0) + c * c, 0.0));
        let s = (g - c) / (g + c);
        let q = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
        0.5 * s * s * (1.0 + q * q)
    }

    pub fn evaluate(prog: ptr!(function, Layers), p: ptr!(function, Params), wo: Vec3f, wi: Vec3f) -> Value {
        let mut out: Value = Value { diffuse: vec3f(0.0, 0.0, 0.0), glossy: vec3f(0.0, 0.0, 0.0), pdf: 0.0 };
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return out;
        }
        let e0 = Entry { weight: vec3f(0.0, 0.0, 0.0), prob: 0.0, node: 0 };
        let mut stack: [Entry; 4] = [e0, e0, e0, e0];
        let mut sp: u32 = 0;
        let mut node: u32 = 0;
        let mut weight: Vec3f = vec3f(1.0, 1.0, 1.0);
        let mut prob: f32 = 1.0;
        let mut done: bool = false;
        while !done {
            let n = prog.nodes[node as usize];
            let mut leaf: bool = true;
            #[wgsl_allow(non_literal_match_statement_patterns)]
            match n.x {
                OP_DIFFUSE => {
                    let tint = param_vec3(p, n.y);
                    let c = wi.z / PI;
                    out.diffuse = out.diffuse + weight * tint * c;
                    out.pdf += prob * c;
                }
                OP_GGX => {
                    let a = vec2f(p.v[n.y as usize], p.v[(n.y + 1) as usize]);
                    let tint = param_vec3(p, n.y + 2);
                    let r = ggx_eval(wo, wi, a);
                    out.glossy = out.glossy + weight * tint * r.x;
                    out.pdf += prob * r.y;
                }
                OP_WEIGHTED => {
                    let w = p.v[n.y as usize];
                    stack[sp as usize] =
                        Entry { weight: weight * (1.0 - w), prob: prob * (1.0 - w), node: n.z };
                    sp += 1;
                    weight = weight * w;
                    prob = prob * w;
                    node += 1;
                    leaf = false;
                }
                OP_FRESNEL => {
                    let eta = p.v[n.y as usize];
                    let h = normalize(wo + wi);
                    let fo = fresnel(wo.z, eta);
                    let fi = fresnel(wi.z, eta);
                    let fh = fresnel(dot(wo, h), eta);
                    let base = 1.0 - max(fo, fi);
                    stack[sp as usize] = Entry { weight: weight * base, prob: prob * (1.0 - fo), node: n.z };
                    sp += 1;
                    weight = weight * fh;
                    prob = prob * fo;
                    node += 1;
                    leaf = false;
                }
                _ => {}
            }
            if leaf {
                if sp == 0 {
                    done = true;
                } else {
                    sp -= 1;
                    let e = stack[sp as usize];
                    weight = e.weight;
                    prob = e.prob;
                    node = e.node;
                }
            }
        }
        out
    }
}
pub use code::*;
