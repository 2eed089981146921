//! Random programs that are nearly all control flow.
//!
//! The state is a few integers, some of which start out the same for all points. Conditions look at
//! either sort. Every statement leaves a trace in the state, so that a statement executed for a wrong
//! set of points shows in the result.

use super::Random;
use std::fmt::Write;

struct Flow {
    r: Random,
    out: String,
    counter: u32,
    loops: Vec<String>,
    in_switch: bool,
    functions: u32,
    budget: i32,
}

/// The text of program `seed`: a function `f(x: u32) -> vec4<u32>`.
pub fn program(seed: u32) -> String {
    let mut g = Flow {
        r: Random::new(seed.wrapping_mul(0x85eb_ca6b)),
        out: String::new(),
        counter: 0,
        loops: Vec::new(),
        in_switch: false,
        functions: 0,
        budget: 0,
    };
    g.out.push_str("var<private> p: u32;\n");
    for i in 0..g.r.below(3) {
        let _ = writeln!(
            g.out,
            "fn g{i}(a: u32, s: ptr<function, u32>) -> u32 {{\n  var x = a; var y = 1u; var z = 0u;"
        );
        g.budget = 10;
        g.block(1);
        g.out.push_str("  return x + y;\n}\n");
        g.functions = i + 1;
    }
    g.out.push_str(
        "fn f(a: u32) -> vec4<u32> {\n  var x = a; var y = 1u; var z = 0u; var w = 3u; let s = &w;\n",
    );
    g.budget = 22;
    let before = g.out.len();
    g.block(1);
    let body = g.out.split_off(before).replace("return x", "return vec4(p, z, w, 0u) + vec4(x");
    let body = body.replace("; // end", "); // end");
    g.out.push_str(&body);
    g.out.push_str("  return vec4(x, y, z, w + p);\n}\n");
    g.out
}

impl Flow {
    fn number(&mut self) -> u32 {
        self.counter += 1;
        self.counter * 2 + 1
    }

    fn condition(&mut self) -> String {
        let bit = self.r.below(5);
        let uniform = !self.loops.is_empty() && self.r.chance(60);
        if uniform {
            let i = self.r.below(self.loops.len() as u32) as usize;
            let n = self.loops[i].clone();
            return match self.r.below(3) {
                0 => format!("({n} & 1u) == 1u"),
                1 => format!("{n} == {}u", self.r.below(4)),
                _ => format!("{n} > {}u", self.r.below(3)),
            };
        }
        match self.r.below(5) {
            0 => format!("((y >> {bit}u) & 1u) == 1u"),
            1 => format!("((z >> {bit}u) & 1u) == 0u"),
            2 => format!("((*s >> {bit}u) & 1u) == 1u"),
            _ => format!("((x >> {bit}u) & {}u) != 0u", self.r.pick(&[1, 1, 3])),
        }
    }

    fn block(&mut self, depth: usize) {
        for _ in 0..1 + self.r.below(4) {
            if self.budget <= 0 || self.statement(depth) {
                break;
            }
            self.budget -= 1;
        }
    }

    fn line(&mut self, depth: usize, text: &str) {
        let _ = writeln!(self.out, "{}{text}", "  ".repeat(depth));
    }

    fn statement(&mut self, depth: usize) -> bool {
        let k = self.number();
        match self.r.below(22) {
            0..=4 => {
                let c = self.condition();
                self.line(depth, &format!("if {c} {{"));
                self.block(depth + 1);
                if self.r.chance(40) {
                    self.line(depth, "} else {");
                    self.block(depth + 1);
                }
                self.line(depth, "}");
            }
            5 | 6 if depth < 6 => self.switch(depth),
            7..=9 if self.loops.len() < 3 && depth < 6 => self.repeat(depth),
            10 | 11 if !self.loops.is_empty() || self.in_switch => {
                self.line(depth, "break;");
                return true;
            }
            12 | 13 if !self.loops.is_empty() => {
                self.line(depth, "continue;");
                return true;
            }
            14 if depth > 1 => {
                self.line(depth, &format!("return x ^ y ^ {k}u; // end"));
                return true;
            }
            15 if self.functions > 0 => {
                let f = self.r.below(self.functions);
                let argument = self.r.pick(&["x", "y", "z", "5u"]);
                self.line(depth, &format!("z = z * 5u + g{f}({argument}, s);"));
            }
            16 => self.line(depth, &format!("y = y * 3u + {k}u;")),
            17 => self.line(depth, &format!("*s = *s * 7u + {k}u;")),
            18 => self.line(depth, &format!("p = p * 5u + {k}u;")),
            19 => self.line(depth, &format!("z = z ^ (y + {k}u);")),
            _ => self.line(depth, &format!("x = x * 747796405u + {k}u;")),
        }
        false
    }

    fn switch(&mut self, depth: usize) {
        let before = self.in_switch;
        let selector = match (self.loops.last(), self.r.below(3)) {
            (Some(n), 0 | 1) => n.clone(),
            (_, 0) => "y".into(),
            _ => "(x >> 2u)".into(),
        };
        self.line(depth, &format!("switch {selector} & 3u {{"));
        self.in_switch = true;
        for case in 0..1 + self.r.below(3) {
            let more = if self.r.chance(25) { format!(", {}u", case + 4) } else { String::new() };
            self.line(depth + 1, &format!("case {case}u{more}: {{"));
            self.block(depth + 2);
            self.line(depth + 1, "}");
        }
        self.line(depth + 1, "default: {");
        self.block(depth + 2);
        self.line(depth + 1, "}");
        self.line(depth, "}");
        self.in_switch = before;
    }

    fn repeat(&mut self, depth: usize) {
        let outer = std::mem::replace(&mut self.in_switch, false);
        let n = format!("n{}", self.number());
        let limit = 2 + self.r.below(4);
        self.line(depth, &format!("var {n} = 0u;"));
        let varying = self.r.chance(40);
        let bound = if varying { format!("(x >> 3u) % {}u", limit + 1) } else { format!("{limit}u") };
        match self.r.below(3) {
            0 => {
                self.line(depth, &format!("for (; {n} < {bound}; {n}++) {{"));
                self.loops.push(n);
                self.block(depth + 1);
                self.loops.pop();
            }
            1 => {
                self.line(depth, &format!("while {n} < {limit}u {{ {n}++;"));
                self.loops.push(n);
                self.block(depth + 1);
                self.loops.pop();
            }
            _ => {
                self.line(depth, "loop {");
                self.loops.push(n.clone());
                self.block(depth + 1);
                self.loops.pop();
                let k = self.number();
                let more = if self.r.chance(50) {
                    format!(" || ((x >> {}u) & 1u) == 1u", k % 7)
                } else {
                    String::new()
                };
                let trace = self.r.pick(&["x", "y", "z", "*s"]);
                self.line(
                    depth + 1,
                    &format!("continuing {{ {n}++; {trace} = {trace} * 3u + {k}u; break if {n} >= {limit}u{more}; }}"),
                );
            }
        }
        self.line(depth, "}");
        self.in_switch = outer;
    }
}
