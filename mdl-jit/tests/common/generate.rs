//! Random well-typed WGSL programs: the same for the same seed.
//!
//! A program is a struct, a private variable, a few helper functions, some with pointer parameters, and
//! a function `f` of scalars and vectors. It has every operator, most functions, arrays with computed
//! indices, structs, nested loops with `break`, `continue` and `return`, and switches. Loops are
//! bounded. Constants are bound by `let`, so that the front end does not evaluate (and refuse) them.
//! Bits of NaN, which are unspecified, are never read.

use super::Random;
use std::fmt::Write;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ty {
    F,
    I,
    U,
    B,
    V(u8),
    VI(u8),
    VU(u8),
    M(u8),
    /// An array of four floats, of ten integers, of five vectors.
    AF,
    AI,
    AV,
    S,
}

impl Ty {
    fn name(self) -> String {
        match self {
            Self::F => "f32".into(),
            Self::I => "i32".into(),
            Self::U => "u32".into(),
            Self::B => "bool".into(),
            Self::V(n) => format!("vec{n}<f32>"),
            Self::VI(n) => format!("vec{n}<i32>"),
            Self::VU(n) => format!("vec{n}<u32>"),
            Self::M(n) => format!("mat{n}x{n}<f32>"),
            Self::AF => "array<f32, 4>".into(),
            Self::AI => "array<i32, 10>".into(),
            Self::AV => "array<vec3<f32>, 5>".into(),
            Self::S => "S".into(),
        }
    }
}

const SCALARS: [Ty; 4] = [Ty::F, Ty::I, Ty::U, Ty::B];
const VALUES: [Ty; 16] = [
    Ty::F,
    Ty::F,
    Ty::F,
    Ty::I,
    Ty::U,
    Ty::B,
    Ty::V(2),
    Ty::V(3),
    Ty::V(4),
    Ty::VI(3),
    Ty::VU(2),
    Ty::M(2),
    Ty::M(3),
    Ty::AF,
    Ty::AI,
    Ty::S,
];

struct Function {
    name: String,
    args: Vec<Ty>,
    /// Types of pointer parameters, after the others.
    pointers: Vec<Ty>,
    result: Ty,
}

#[derive(Clone)]
struct Name {
    text: String,
    ty: Ty,
    /// A `var`, or behind a pointer parameter.
    mutable: bool,
    pointer: bool,
}

pub struct Generator {
    r: Random,
    out: String,
    names: Vec<Name>,
    functions: Vec<Function>,
    counter: u32,
    /// Statements left to write.
    budget: i32,
    loops: u32,
    /// Whether a `break` or `continue` would leave the innermost loop, or a switch in it.
    in_loop: bool,
    in_switch: bool,
    result: Ty,
}

/// The text of program `seed`.
pub fn program(seed: u32) -> String {
    let mut g = Generator {
        r: Random::new(seed.wrapping_mul(0x9e37_79b9)),
        out: String::new(),
        names: Vec::new(),
        functions: Vec::new(),
        counter: 0,
        budget: 0,
        loops: 0,
        in_loop: false,
        in_switch: false,
        result: Ty::F,
    };
    g.module();
    g.out
}

impl Generator {
    fn module(&mut self) {
        self.out.push_str("struct S { a: f32, b: vec3<f32>, c: array<i32, 4>, d: u32, e: bool }\n");
        self.out.push_str("struct Out { a: f32, b: vec3<f32>, c: i32, d: u32, e: u32 }\n");
        self.out.push_str(
            "const TABLE = array<f32, 12>(0.5, 1.5, -2.0, 3.25, 0.0, 7.0, -0.25, 9.0, 1.0, 2.0, 4.0, 8.0);\n",
        );
        self.out.push_str("var<private> state: vec2<u32>;\n\n");
        for i in 0..self.r.below(4) {
            let mut args = vec![];
            for _ in 0..1 + self.r.below(3) {
                args.push(self.r.pick(&VALUES));
            }
            let mut pointers = vec![];
            while self.r.chance(35) {
                pointers.push(self.r.pick(&[Ty::F, Ty::V(3), Ty::AF, Ty::S, Ty::AI, Ty::M(3)]));
            }
            let result = self.r.pick(&VALUES);
            self.function(Function { name: format!("g{i}"), args, pointers, result });
        }
        self.main();
    }

    fn constants(&mut self) {
        self.out.push_str("  let k0 = 0.0; let k1 = 1.0; let k2 = -2.5; let k3 = 0.125; let k4 = 1e10;\n");
        self.out
            .push_str("  var i0 = 0i; let i1 = 1i; var i2 = -3i; var i3 = 7i; var i4: i32 = -2147483648;\n");
        self.out.push_str("  var u0 = 0u; let u1 = 1u; var u2 = 5u; var u3 = 33u; var u4 = 4294967295u;\n");
        self.out.push_str("  let t = true; let n = false;\n");
        for (text, ty) in [
            ("k0", Ty::F),
            ("k1", Ty::F),
            ("k2", Ty::F),
            ("k3", Ty::F),
            ("k4", Ty::F),
            ("i0", Ty::I),
            ("i1", Ty::I),
            ("i2", Ty::I),
            ("i3", Ty::I),
            ("i4", Ty::I),
            ("u0", Ty::U),
            ("u1", Ty::U),
            ("u2", Ty::U),
            ("u3", Ty::U),
            ("u4", Ty::U),
            ("t", Ty::B),
            ("n", Ty::B),
        ] {
            self.names.push(Name { text: text.into(), ty, mutable: false, pointer: false });
        }
    }

    fn function(&mut self, f: Function) {
        self.names.clear();
        let mut params = Vec::new();
        for (i, ty) in f.args.iter().enumerate() {
            params.push(format!("p{i}: {}", ty.name()));
            self.names.push(Name { text: format!("p{i}"), ty: *ty, mutable: false, pointer: false });
        }
        for (i, ty) in f.pointers.iter().enumerate() {
            params.push(format!("q{i}: ptr<function, {}>", ty.name()));
            self.names.push(Name { text: format!("(*q{i})"), ty: *ty, mutable: true, pointer: true });
        }
        let _ = writeln!(self.out, "fn {}({}) -> {} {{", f.name, params.join(", "), f.result.name());
        self.constants();
        (self.budget, self.loops, self.in_loop, self.in_switch) = (8, 0, false, false);
        self.result = f.result;
        self.block(1);
        let value = self.expr(f.result, 2);
        let _ = writeln!(self.out, "  return {value};\n}}\n");
        self.functions.push(f);
    }

    fn main(&mut self) {
        self.names.clear();
        self.out.push_str("fn f(a: f32, b: vec3<f32>, i: i32, u: u32, c: u32) -> Out {\n");
        self.constants();
        for (text, ty) in [("a", Ty::F), ("b", Ty::V(3)), ("i", Ty::I), ("u", Ty::U), ("c", Ty::U)] {
            self.names.push(Name { text: text.into(), ty, mutable: false, pointer: false });
        }
        self.out.push_str("  var o: Out;\n");
        for (text, ty) in [("o.a", Ty::F), ("o.b", Ty::V(3)), ("o.c", Ty::I), ("o.d", Ty::U), ("o.e", Ty::U)]
        {
            self.names.push(Name { text: text.into(), ty, mutable: true, pointer: true });
        }
        (self.budget, self.loops, self.in_loop, self.in_switch) = (18, 0, false, false);
        self.result = Ty::S;
        let before = self.out.len();
        self.block(1);
        // `f` returns its own struct.
        let body = self.out.split_off(before).replace("return RESULT;", "return o;");
        self.out.push_str(&body);
        let (a, b, c, d) =
            (self.expr(Ty::F, 3), self.expr(Ty::V(3), 2), self.expr(Ty::I, 3), self.expr(Ty::U, 2));
        let _ = writeln!(self.out, "  o.a += {a}; o.b = {b}; o.c = o.c + {c}; o.d ^= {d};");
        self.out.push_str("  o.e = state.x ^ state.y;\n  return o;\n}\n");
    }

    fn fresh(&mut self) -> String {
        self.counter += 1;
        format!("v{}", self.counter)
    }

    fn indent(&mut self, depth: usize) {
        self.out.push_str(&"  ".repeat(depth));
    }

    fn block(&mut self, depth: usize) {
        let scope = self.names.len();
        for _ in 0..1 + self.r.below(4) {
            if self.budget <= 0 {
                break;
            }
            self.budget -= 1;
            if self.statement(depth) {
                break;
            }
        }
        self.names.truncate(scope);
    }

    /// Writes a statement. True if nothing may follow it in its block.
    fn statement(&mut self, depth: usize) -> bool {
        self.indent(depth);
        match self.r.below(20) {
            0..=3 => {
                let ty = self.r.pick(&VALUES);
                let (name, value) = (self.fresh(), self.expr(ty, 3));
                let _ = writeln!(self.out, "let {name} = {value};");
                self.names.push(Name { text: name, ty, mutable: false, pointer: false });
            }
            4..=6 => {
                let ty = self.r.pick(&VALUES);
                let name = self.fresh();
                if self.r.chance(25) {
                    let _ = writeln!(self.out, "var {name}: {};", ty.name());
                } else {
                    let value = self.expr(ty, 3);
                    let _ = writeln!(self.out, "var {name} = {value};");
                }
                self.names.push(Name { text: name, ty, mutable: true, pointer: false });
            }
            7..=10 => self.assign(),
            11..=13 => self.branch(depth),
            14 if depth < 5 => self.switch(depth),
            15 | 16 if depth < 5 && self.loops < 3 => self.repeat(depth),
            17 if self.in_loop || self.in_switch => {
                self.out.push_str("break;\n");
                return true;
            }
            18 if self.in_loop => {
                self.out.push_str("continue;\n");
                return true;
            }
            19 if depth > 1 => {
                self.leave();
                return true;
            }
            _ => self.assign(),
        }
        false
    }

    fn leave(&mut self) {
        let main = self.names.iter().any(|n| n.text == "o.a");
        if main {
            self.out.push_str("return RESULT;\n");
        } else {
            let value = self.expr(self.result, 2);
            let _ = writeln!(self.out, "return {value};");
        }
    }

    fn assign(&mut self) {
        let targets: Vec<Name> = self.names.iter().filter(|n| n.mutable).cloned().collect();
        if targets.is_empty() || self.r.chance(15) {
            let value = self.expr(Ty::U, 2);
            let part = self.r.pick(&["x", "y"]);
            let _ = writeln!(self.out, "state.{part} = state.{part} * 3u + {value};");
            return;
        }
        let i = self.r.below(targets.len() as u32) as usize;
        let (place, ty) = self.part(targets[i].text.clone(), targets[i].ty);
        let value = self.expr(ty, 3);
        let op = match ty {
            Ty::F | Ty::I | Ty::V(_) | Ty::VI(_) => self.r.pick(&["=", "=", "+=", "-=", "*="]),
            Ty::U | Ty::VU(_) => self.r.pick(&["=", "+=", "^=", "|=", "*="]),
            _ => "=",
        };
        let _ = writeln!(self.out, "{place} {op} {value};");
    }

    /// A random part of a value with this text: an element, a member, or all of it.
    fn part(&mut self, text: String, ty: Ty) -> (String, Ty) {
        let index = |g: &mut Self| {
            if g.r.chance(50) {
                let e = g.expr(Ty::I, 1);
                let limit = g.r.chance(70);
                if limit { format!("(({e}) & 7)") } else { e }
            } else {
                let e = g.expr(Ty::U, 1);
                format!("(({e}) % 6u)")
            }
        };
        match ty {
            Ty::AF => (format!("{text}[{}]", index(self)), Ty::F),
            Ty::AI => (format!("{text}[{}]", index(self)), Ty::I),
            Ty::AV => {
                let i = index(self);
                self.part(format!("{text}[{i}]"), Ty::V(3))
            }
            Ty::V(n) if self.r.chance(40) => {
                if self.r.chance(30) {
                    return (format!("{text}[{}]", index(self)), Ty::F);
                }
                let c = self.r.pick(&["x", "y", "z", "w"][..usize::from(n)]);
                (format!("{text}.{c}"), Ty::F)
            }
            Ty::M(n) if self.r.chance(60) => {
                let column =
                    if self.r.chance(50) { index(self) } else { self.r.below(u32::from(n)).to_string() };
                self.part(format!("{text}[{column}]"), Ty::V(n))
            }
            Ty::S if self.r.chance(70) => match self.r.below(5) {
                0 => (format!("{text}.a"), Ty::F),
                1 => self.part(format!("{text}.b"), Ty::V(3)),
                2 => (format!("{text}.c[{}]", index(self)), Ty::I),
                3 => (format!("{text}.d"), Ty::U),
                _ => (format!("{text}.e"), Ty::B),
            },
            _ => (text, ty),
        }
    }

    fn branch(&mut self, depth: usize) {
        let c = self.expr(Ty::B, 3);
        let _ = writeln!(self.out, "if {c} {{");
        self.block(depth + 1);
        self.indent(depth);
        if self.r.chance(50) {
            self.out.push_str("} else {\n");
            self.block(depth + 1);
            self.indent(depth);
        }
        self.out.push_str("}\n");
    }

    fn switch(&mut self, depth: usize) {
        let signed = self.r.chance(50);
        let selector = self.expr(if signed { Ty::I } else { Ty::U }, 2);
        let (suffix, spread) = if signed { ("i", "& 3i") } else { ("u", "% 4u") };
        let spread = if self.r.chance(80) { spread } else { "" };
        let _ = writeln!(self.out, "switch (({selector}) {spread}) {{");
        let before = self.in_switch;
        self.in_switch = true;
        let cases = 1 + self.r.below(3);
        for case in 0..cases {
            self.indent(depth + 1);
            let more = if self.r.chance(30) { format!(", {}{suffix}", case + 10) } else { String::new() };
            let _ = writeln!(self.out, "case {case}{suffix}{more}: {{");
            self.block(depth + 2);
            self.indent(depth + 1);
            self.out.push_str("}\n");
        }
        self.indent(depth + 1);
        self.out.push_str("default: {\n");
        self.block(depth + 2);
        self.indent(depth + 1);
        self.out.push_str("}\n");
        self.in_switch = before;
        self.indent(depth);
        self.out.push_str("}\n");
    }

    fn repeat(&mut self, depth: usize) {
        let (outer_loop, outer_switch) = (self.in_loop, self.in_switch);
        (self.in_loop, self.in_switch) = (true, false);
        self.loops += 1;
        let scope = self.names.len();
        let n = self.fresh();
        let limit = 1 + self.r.below(6);
        match self.r.below(3) {
            0 => {
                let bound = self.expr(Ty::U, 2);
                let _ = writeln!(self.out, "for (var {n} = 0u; {n} < ({bound}) % {limit}u; {n}++) {{");
                self.names.push(Name { text: n, ty: Ty::U, mutable: false, pointer: false });
                self.block(depth + 1);
            }
            1 => {
                let c = self.expr(Ty::B, 2);
                let _ = writeln!(self.out, "var {n} = 0i; while {n} < {limit} && ({c}) {{");
                self.indent(depth + 1);
                let _ = writeln!(self.out, "{n}++;");
                self.names.push(Name { text: n, ty: Ty::I, mutable: false, pointer: false });
                self.block(depth + 1);
            }
            _ => {
                let _ = writeln!(self.out, "var {n} = 0i; loop {{");
                self.names.push(Name { text: n.clone(), ty: Ty::I, mutable: false, pointer: false });
                self.block(depth + 1);
                self.indent(depth + 1);
                let c = self.expr(Ty::B, 2);
                let _ = writeln!(self.out, "continuing {{ {n}++; break if {n} >= {limit} || ({c}); }}");
            }
        }
        self.names.truncate(scope);
        self.indent(depth);
        self.out.push_str("}\n");
        self.loops -= 1;
        (self.in_loop, self.in_switch) = (outer_loop, outer_switch);
    }

    /// An expression of a type, in parentheses where it needs them.
    fn expr(&mut self, ty: Ty, depth: u32) -> String {
        if depth == 0 || self.r.chance(25) {
            return self.leaf(ty, depth);
        }
        if self.r.chance(8)
            && let Some(call) = self.call(ty)
        {
            return call;
        }
        let d = depth - 1;
        if self.r.chance(7) && !matches!(ty, Ty::AF | Ty::AI | Ty::AV | Ty::S | Ty::M(_)) {
            let (x, y, c) = (self.expr(ty, d), self.expr(ty, d), self.expr(Ty::B, d));
            return format!("select({x}, {y}, {c})");
        }
        match ty {
            Ty::F => self.float(d),
            Ty::I => self.int(d),
            Ty::U => self.unsigned(d),
            Ty::B => self.boolean(d),
            Ty::V(n) => self.vector(n, d),
            Ty::VI(_) | Ty::VU(_) => self.int_vector(ty, d),
            Ty::M(n) => self.matrix(n, d),
            _ => self.leaf(ty, depth),
        }
    }

    /// A name or a part of one, or a constructor.
    fn leaf(&mut self, ty: Ty, depth: u32) -> String {
        let names: Vec<Name> = self.names.iter().filter(|n| n.ty == ty).cloned().collect();
        if !names.is_empty() && self.r.chance(75) {
            return names[self.r.below(names.len() as u32) as usize].text.clone();
        }
        if depth > 0 {
            let wholes: Vec<Name> = self.names.iter().filter(|n| !SCALARS.contains(&n.ty)).cloned().collect();
            if !wholes.is_empty() {
                let n = wholes[self.r.below(wholes.len() as u32) as usize].clone();
                let (text, found) = self.part(n.text, n.ty);
                if found == ty {
                    return text;
                }
            }
        }
        let d = depth.saturating_sub(1);
        let list = |g: &mut Self, ty, n: u32| (0..n).map(|_| g.expr(ty, d)).collect::<Vec<_>>().join(", ");
        match ty {
            Ty::F => self.r.pick(&["k0", "k1", "k2", "k3", "k4"]).into(),
            Ty::I => self.r.pick(&["i0", "i1", "i2", "i3", "i4"]).into(),
            Ty::U => self.r.pick(&["u0", "u1", "u2", "u3", "u4", "state.x", "state.y"]).into(),
            Ty::B => self.r.pick(&["t", "n"]).into(),
            Ty::V(n) => format!("vec{n}<f32>({})", list(self, Ty::F, u32::from(n))),
            Ty::VI(n) => format!("vec{n}<i32>({})", list(self, Ty::I, u32::from(n))),
            Ty::VU(n) => format!("vec{n}<u32>({})", list(self, Ty::U, u32::from(n))),
            Ty::M(n) => format!("mat{n}x{n}<f32>({})", list(self, Ty::V(n), u32::from(n))),
            Ty::AF => format!("array<f32, 4>({})", list(self, Ty::F, 4)),
            Ty::AI => format!("array<i32, 10>({})", list(self, Ty::I, 10)),
            Ty::AV => format!("array<vec3<f32>, 5>({})", list(self, Ty::V(3), 5)),
            Ty::S => {
                let (a, b, c) = (self.expr(Ty::F, d), self.expr(Ty::V(3), d), list(self, Ty::I, 4));
                let (u, e) = (self.expr(Ty::U, d), self.expr(Ty::B, d));
                format!("S({a}, {b}, array<i32, 4>({c}), {u}, {e})")
            }
        }
    }

    fn call(&mut self, ty: Ty) -> Option<String> {
        let fitting: Vec<usize> =
            (0..self.functions.len()).filter(|&i| self.functions[i].result == ty).collect();
        if fitting.is_empty() {
            return None;
        }
        let f = self.r.pick(&fitting);
        let (name, args, pointers) = (
            self.functions[f].name.clone(),
            self.functions[f].args.clone(),
            self.functions[f].pointers.clone(),
        );
        let mut list: Vec<String> = args.iter().map(|&a| self.expr(a, 1)).collect();
        let mut used: Vec<String> = Vec::new();
        for p in pointers {
            // Distinct variables: two pointers to one must not be written through.
            let found = self
                .names
                .iter()
                .find(|n| n.mutable && n.ty == p && !n.text.contains('.') && !used.contains(&n.text))?;
            used.push(found.text.clone());
            list.push(format!("&{}", found.text));
        }
        Some(format!("{name}({})", list.join(", ")))
    }

    fn float(&mut self, d: u32) -> String {
        let (x, y) = (self.expr(Ty::F, d), self.expr(Ty::F, d));
        match self.r.below(34) {
            0..=3 => format!("({x} + {y})"),
            4 | 5 => format!("({x} - {y})"),
            6..=9 => format!("({x} * {y})"),
            10 => format!("({x} / {y})"),
            11 => format!("({x} % {y})"),
            12 => format!("(-{x})"),
            13 => format!("min({x}, {y})"),
            14 => format!("max({x}, {y})"),
            15 => {
                let f = self
                    .r
                    .pick(&["abs", "floor", "ceil", "round", "trunc", "fract", "sign", "saturate", "sqrt"]);
                format!("{f}({x})")
            }
            16 => format!("step({x}, {y})"),
            17 => {
                let f = self.r.pick(&["mix", "clamp", "fma", "smoothstep"]);
                let z = self.expr(Ty::F, d);
                format!("{f}({x}, {y}, {z})")
            }
            18 => format!("f32({})", self.expr(Ty::I, d)),
            19 => format!("f32({})", self.expr(Ty::U, d)),
            20 => format!("f32({})", self.expr(Ty::B, d)),
            21 => {
                let n = self.r.pick(&[2, 3, 4]);
                let f = self.r.pick(&["dot", "distance"]);
                let (v, w) = (self.expr(Ty::V(n), d), self.expr(Ty::V(n), d));
                format!("{f}({v}, {w})")
            }
            22 => format!("length({})", self.expr(Ty::V(3), d)),
            23 => format!("inverseSqrt({x})"),
            24 => format!("bitcast<f32>({})", self.expr(Ty::U, d)),
            25 => {
                let f =
                    self.r.pick(&["sin", "cos", "exp", "log", "exp2", "log2", "tan", "atan", "tanh", "asin"]);
                format!("{f}({x})")
            }
            26 => {
                let f = self.r.pick(&["pow", "atan2"]);
                format!("{f}({x}, {y})")
            }
            27 => format!("modf({x}).{}", self.r.pick(&["fract", "whole"])),
            28 => format!("frexp({x}).fract"),
            29 => format!("ldexp({x}, {})", self.expr(Ty::I, d)),
            30 => {
                let n = self.r.pick(&[2, 3]);
                format!("determinant({})", self.expr(Ty::M(n), d))
            }
            31 => format!("TABLE[{}]", self.expr(if d > 0 { Ty::I } else { Ty::U }, d)),
            32 => {
                let f =
                    self.r.pick(&["unpack2x16float", "unpack2x16snorm", "unpack4x8unorm", "unpack4x8snorm"]);
                format!("{f}({}).y", self.expr(Ty::U, d))
            }
            _ => format!("quantizeToF16({x})"),
        }
    }

    fn int(&mut self, d: u32) -> String {
        let (x, y) = (self.expr(Ty::I, d), self.expr(Ty::I, d));
        match self.r.below(18) {
            0..=8 => self.int_operator(&x, &y, d),
            9 => {
                let f = self.r.pick(&[
                    "abs",
                    "sign",
                    "-",
                    "~",
                    "countOneBits",
                    "reverseBits",
                    "firstLeadingBit",
                    "firstTrailingBit",
                    "countLeadingZeros",
                    "countTrailingZeros",
                ]);
                format!("({f}({x}))")
            }
            10 => format!("{}({x}, {y})", self.r.pick(&["min", "max"])),
            11 => format!("i32({})", self.expr(Ty::F, d)),
            12 => format!("i32({})", self.expr(Ty::U, d)),
            13 => format!("i32({})", self.expr(Ty::B, d)),
            14 => format!("frexp({}).exp", self.expr(Ty::F, d)),
            15 => format!("clamp({x}, {y}, {})", self.expr(Ty::I, d)),
            16 => {
                let (o, c) = (self.expr(Ty::U, d), self.expr(Ty::U, d));
                format!("insertBits({x}, {y}, {o}, {c})")
            }
            _ => format!("dot({}, {})", self.expr(Ty::VI(3), d), self.expr(Ty::VI(3), d)),
        }
    }

    fn int_operator(&mut self, x: &str, y: &str, d: u32) -> String {
        let op = self.r.pick(&["+", "-", "*", "/", "%", "&", "|", "^", "<<", ">>"]);
        if op == "<<" || op == ">>" {
            return format!("({x} {op} {})", self.expr(Ty::U, d));
        }
        format!("({x} {op} {y})")
    }

    fn unsigned(&mut self, d: u32) -> String {
        let (x, y) = (self.expr(Ty::U, d), self.expr(Ty::U, d));
        match self.r.below(18) {
            0..=8 => self.int_operator(&x, &y, d),
            9 => {
                let f = self.r.pick(&[
                    "~",
                    "countOneBits",
                    "reverseBits",
                    "firstLeadingBit",
                    "firstTrailingBit",
                    "abs",
                ]);
                format!("({f}({x}))")
            }
            10 => format!("{}({x}, {y})", self.r.pick(&["min", "max"])),
            11 => format!("u32({})", self.expr(Ty::F, d)),
            12 => format!("u32({})", self.expr(Ty::I, d)),
            13 => {
                // The bits of NaN are not to be looked at.
                let f = self.leaf(Ty::F, 0);
                format!("select(7u, bitcast<u32>({f}), {f} == {f})")
            }
            14 => {
                let (o, c) = (self.expr(Ty::U, d), self.expr(Ty::U, d));
                format!("extractBits({x}, {o}, {c})")
            }
            15 => {
                let f = self.r.pick(&["pack4x8unorm", "pack4x8snorm"]);
                format!("{f}({})", self.expr(Ty::V(4), d))
            }
            16 => {
                let f = self.r.pick(&["pack2x16float", "pack2x16unorm", "pack2x16snorm"]);
                format!("{f}({})", self.expr(Ty::V(2), d))
            }
            _ => format!("bitcast<u32>({})", self.expr(Ty::I, d)),
        }
    }

    fn boolean(&mut self, d: u32) -> String {
        let compare = self.r.pick(&["<", "<=", ">", ">=", "==", "!="]);
        match self.r.below(10) {
            0..=2 => format!("({} {compare} {})", self.expr(Ty::F, d), self.expr(Ty::F, d)),
            3 | 4 => format!("({} {compare} {})", self.expr(Ty::I, d), self.expr(Ty::I, d)),
            5 => format!("({} {compare} {})", self.expr(Ty::U, d), self.expr(Ty::U, d)),
            6 => {
                let op = self.r.pick(&["&&", "||", "==", "!=", "&", "|"]);
                format!("({} {op} {})", self.expr(Ty::B, d), self.expr(Ty::B, d))
            }
            7 => format!("(!{})", self.expr(Ty::B, d)),
            8 => {
                let n = self.r.pick(&[2, 3, 4]);
                let f = self.r.pick(&["any", "all"]);
                format!("{f}({} {compare} {})", self.expr(Ty::V(n), d), self.expr(Ty::V(n), d))
            }
            _ => format!("bool({})", self.expr(Ty::I, d)),
        }
    }

    fn vector(&mut self, n: u8, d: u32) -> String {
        let ty = Ty::V(n);
        let (x, y) = (self.expr(ty, d), self.expr(ty, d));
        match self.r.below(18) {
            0..=2 => format!("({x} {} {y})", self.r.pick(&["+", "-", "*", "/", "%"])),
            3 => format!("({x} * {})", self.expr(Ty::F, d)),
            4 => format!("({} * {x})", self.expr(Ty::F, d)),
            5 => format!("(-{x})"),
            6 => format!("{}({x}, {y})", self.r.pick(&["min", "max", "step"])),
            7 => format!("{}({x})", self.r.pick(&["abs", "floor", "fract", "sqrt", "round", "sign"])),
            8 => format!("mix({x}, {y}, {})", self.expr(Ty::F, d)),
            9 => format!("normalize({x})"),
            10 if n == 3 => format!("cross({x}, {y})"),
            11 => format!("reflect({x}, {y})"),
            12 => format!("refract({x}, {y}, {})", self.expr(Ty::F, d)),
            13 => format!("faceForward({x}, {y}, {})", self.expr(ty, d)),
            14 => format!("select({x}, {y}, {} < {})", self.expr(ty, d), self.expr(ty, d)),
            15 if n < 4 => {
                let m = self.expr(Ty::M(n), d);
                if self.r.chance(50) { format!("({m} * {x})") } else { format!("({x} * {m})") }
            }
            16 if n == 3 => {
                let pattern = self.r.pick(&["zyx", "xxy", "yzx", "bgr"]);
                format!("{x}.{pattern}")
            }
            _ => {
                let parts: Vec<String> = (0..n).map(|_| self.expr(Ty::F, d)).collect();
                format!("vec{n}<f32>({})", parts.join(", "))
            }
        }
    }

    fn int_vector(&mut self, ty: Ty, d: u32) -> String {
        let (x, y) = (self.expr(ty, d), self.expr(ty, d));
        let n = if let Ty::VI(n) | Ty::VU(n) = ty { n } else { 3 };
        match self.r.below(5) {
            0..=2 => format!("({x} {} {y})", self.r.pick(&["+", "-", "*", "&", "^", "/", "%"])),
            3 => format!("{}({})", ty.name(), self.expr(Ty::V(n), d)),
            _ => format!("({x} >> vec{n}<u32>({}))", self.expr(Ty::U, d)),
        }
    }

    fn matrix(&mut self, n: u8, d: u32) -> String {
        let ty = Ty::M(n);
        let (x, y) = (self.expr(ty, d), self.expr(ty, d));
        match self.r.below(5) {
            0 => format!("({x} * {y})"),
            1 => format!("({x} + {y})"),
            2 => format!("({x} * {})", self.expr(Ty::F, d)),
            3 => format!("transpose({x})"),
            _ => {
                let columns: Vec<String> = (0..n).map(|_| self.expr(Ty::V(n), d)).collect();
                format!("{}({})", ty.name(), columns.join(", "))
            }
        }
    }
}
