//! Graphs as text, for people and for tests.
//!
//! Constants and parameters are written where they are used, every operation gets a line and a number.
//! Fields of a material that have their default are left out, and so is what only they need.

use crate::graph::{
    Expression, ExpressionId, ExpressionKind, Function, FunctionGraph, GammaMode, Graph, MaterialGraph, Mode,
    Node, NodeId, NodeKind, Op, Place, Projection, Stage, Statement, SurfaceRoots, UnaryOp,
};
use crate::sema::spelling;
use crate::types::{DfKind, Type, TypeId};
use crate::value::Value;
use std::fmt::{self, Display, Formatter, Write};

impl Display for MaterialGraph {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let mode = match self.mode {
            Mode::Class => "class",
            Mode::Instance => "instance",
        };
        writeln!(f, "material {} ({mode})", self.name)?;
        let mut printer = Printer { graph: &self.graph, numbers: Vec::new() };
        let roots = self.named_roots().into_iter().filter(|(_, root)| !printer.is_default(*root));
        let roots: Vec<(&str, NodeId)> = roots.collect();
        printer.number(roots.iter().map(|(_, root)| *root));
        printer.graph(f)?;
        roots.iter().try_for_each(|(name, root)| writeln!(f, "{name} = {}", printer.operand(*root)))
    }
}

impl Display for FunctionGraph {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "function {}", self.name)?;
        let mut printer = Printer { graph: &self.graph, numbers: Vec::new() };
        printer.number([self.result].into_iter());
        printer.graph(f)?;
        writeln!(f, "result = {}", printer.operand(self.result))
    }
}

impl MaterialGraph {
    /// The roots with the names of their fields, such as `surface.scattering`.
    pub fn named_roots(&self) -> Vec<(&'static str, NodeId)> {
        let roots = &self.roots;
        let surface = |names: [&'static str; 4], surface: &SurfaceRoots| {
            let nodes = [surface.scattering, surface.emission, surface.intensity, surface.mode];
            names.into_iter().zip(nodes)
        };
        let front = [
            "surface.scattering",
            "surface.emission.emission",
            "surface.emission.intensity",
            "surface.emission.mode",
        ];
        let back = [
            "backface.scattering",
            "backface.emission.emission",
            "backface.emission.intensity",
            "backface.emission.mode",
        ];
        let mut named = vec![("thin_walled", roots.thin_walled)];
        named.extend(surface(front, &roots.surface));
        named.extend(surface(back, &roots.backface));
        named.extend([
            ("ior", roots.ior),
            ("volume.scattering", roots.volume_scattering),
            ("volume.absorption_coefficient", roots.absorption_coefficient),
            ("volume.scattering_coefficient", roots.scattering_coefficient),
            ("volume.emission_intensity", roots.volume_emission_intensity),
            ("geometry.displacement", roots.displacement),
            ("geometry.cutout_opacity", roots.cutout_opacity),
            ("geometry.normal", roots.normal),
            ("hair", roots.hair),
        ]);
        named
    }
}

struct Printer<'g> {
    graph: &'g Graph,
    /// Numbers of the operations that are printed.
    numbers: Vec<Option<usize>>,
}

impl Printer<'_> {
    /// Numbers the operations that some roots need.
    fn number(&mut self, roots: impl Iterator<Item = NodeId>) {
        let nodes = &self.graph.nodes;
        let mut live = vec![false; nodes.len()];
        roots.for_each(|root| live[root.0 as usize] = true);
        for index in (0..nodes.len()).rev() {
            if let (true, NodeKind::Op(_, args)) = (live[index], &nodes[index].kind) {
                args.iter().for_each(|arg| live[arg.0 as usize] = true);
            }
        }
        let mut next = 0..;
        let is_printed = |(node, live): (&Node, bool)| live && matches!(node.kind, NodeKind::Op(..));
        let number = |pair| if is_printed(pair) { next.next() } else { None };
        self.numbers = nodes.iter().zip(live).map(number).collect();
    }

    /// Whether a root has the value that the language gives a field that is left out.
    fn is_default(&self, root: NodeId) -> bool {
        let Node { kind, ty, .. } = self.graph.node(root);
        match kind {
            NodeKind::Constant(value) => {
                let zero = Value::zero(&self.graph.types, *ty);
                *value == zero || *value == Value::floats(&[1.0; 3]) || *value == Value::Float(1.0)
            }
            NodeKind::Op(Op::Builtin(name), _) => &**name == "::state::normal",
            _ => false,
        }
    }

    fn graph(&self, f: &mut Formatter<'_>) -> fmt::Result {
        for parameter in &self.graph.parameters {
            let uniform = if parameter.uniform { "uniform " } else { "" };
            write!(f, "parameter {uniform}{} {}", self.ty(parameter.ty), parameter.name)?;
            match &parameter.default {
                Some(default) => writeln!(f, " = {}", self.value(default, parameter.ty))?,
                None => writeln!(f, " (built in)")?,
            }
        }
        for (index, resource) in self.graph.resources.iter().enumerate() {
            let gamma = match resource.gamma {
                GammaMode::Default => "",
                GammaMode::Linear => " linear",
                GammaMode::Srgb => " srgb",
            };
            let selector = if resource.selector.is_empty() { "" } else { " " };
            writeln!(f, "resource #{index} {:?}{gamma}{selector}{}", resource.path, resource.selector)?;
        }
        for (index, function) in self.graph.functions.iter().enumerate() {
            self.function(f, index, function)?;
        }
        for (index, node) in (0..).map(NodeId).zip(&self.graph.nodes) {
            if let (NodeKind::Op(op, args), Some(_)) = (&node.kind, self.numbers[index.0 as usize]) {
                let args: Vec<String> = args.iter().map(|arg| self.operand(*arg)).collect();
                let text = self.operation(op, &args, node.ty);
                writeln!(f, "{} = {text}: {} {}", self.operand(index), self.ty(node.ty), stage(node.stage))?;
            }
        }
        Ok(())
    }

    fn ty(&self, id: TypeId) -> String {
        self.graph.types.display(id)
    }

    /// A node as an operand.
    fn operand(&self, id: NodeId) -> String {
        let node = self.graph.node(id);
        match &node.kind {
            NodeKind::Constant(value) => self.value(value, node.ty),
            NodeKind::Parameter(index) => match self.graph.parameters.get(*index as usize) {
                Some(parameter) => parameter.name.to_string(),
                None => format!("parameter {index}"),
            },
            NodeKind::Op(..) => match self.numbers[id.0 as usize] {
                Some(number) => format!("%{number}"),
                None => "%?".to_string(),
            },
        }
    }

    fn operation(&self, op: &Op, args: &[String], ty: TypeId) -> String {
        match (op, args) {
            (Op::Unary(op), [x]) => {
                let op = match op {
                    UnaryOp::Negate => "-",
                    UnaryOp::Not => "!",
                    UnaryOp::BitNot => "~",
                };
                format!("{op}{x}")
            }
            (Op::Binary(op), [x, y]) => format!("{x} {} {y}", spelling(*op)),
            (Op::Member(index), [x]) => format!("{x}.{index}"),
            (Op::Index, [x, index]) => format!("{x}[{index}]"),
            (Op::Select, [condition, x, y]) => format!("{condition} ? {x} : {y}"),
            (Op::Convert | Op::Construct, _) => format!("{}({})", self.ty(ty), args.join(", ")),
            (Op::Builtin(name), _) => format!("{name}({})", args.join(", ")),
            (Op::Call(id), _) => format!("f{}({})", id.0, args.join(", ")),
            _ => format!("{op:?}({})", args.join(", ")),
        }
    }

    /// A constant as a user would write it, as far as that is possible.
    fn value(&self, value: &Value, ty: TypeId) -> String {
        let parts = |types: &mut dyn Iterator<Item = TypeId>| {
            let parts = value.elements().iter().zip(types).map(|(part, ty)| self.value(part, ty));
            format!("{}({})", self.ty(ty), parts.collect::<Vec<_>>().join(", "))
        };
        match (value, self.graph.types.get(ty)) {
            (Value::Int(value), Type::Enum(ty)) => {
                let name = ty.values.iter().find(|(_, other)| other == value);
                name.map_or(value.to_string(), |(name, _)| name.to_string())
            }
            (Value::Bool(value), _) => value.to_string(),
            (Value::Int(value), _) => value.to_string(),
            (Value::Float(value), _) => float(f64::from(*value), &value.to_string()),
            (Value::Double(value), _) => format!("{}d", float(*value, &value.to_string())),
            (Value::String(value), _) => format!("{value:?}"),
            (Value::Resource(Some(index)), _) => format!("#{index}"),
            (Value::Resource(None), _) => format!("{}()", self.ty(ty)),
            (Value::DefaultDf, Type::Df(kind)) => match kind {
                DfKind::Bsdf => "bsdf()".to_string(),
                DfKind::Edf => "edf()".to_string(),
                DfKind::Vdf => "vdf()".to_string(),
                DfKind::Hair => "hair_bsdf()".to_string(),
            },
            (_, Type::Struct(ty)) => parts(&mut ty.fields.iter().map(|(_, field)| *field)),
            (_, Type::Array { element, .. }) => parts(&mut std::iter::repeat(*element)),
            _ => {
                // Vectors, matrices and colours: the components say what they are.
                let parts: Vec<String> = value.elements().iter().map(|part| self.component(part)).collect();
                format!("{}({})", self.ty(ty), parts.join(", "))
            }
        }
    }

    fn component(&self, value: &Value) -> String {
        match value {
            Value::Compound(parts) => {
                format!("({})", parts.iter().map(|part| self.component(part)).collect::<Vec<_>>().join(", "))
            }
            Value::Float(value) => float(f64::from(*value), &value.to_string()),
            Value::Double(value) => float(*value, &value.to_string()),
            Value::Int(value) => value.to_string(),
            Value::Bool(value) => value.to_string(),
            _ => "?".to_string(),
        }
    }

    fn function(&self, f: &mut Formatter<'_>, index: usize, function: &Function) -> fmt::Result {
        let locals = function.locals.iter().enumerate();
        let mut locals =
            locals.map(|(id, local)| format!("{} {}", self.ty(local.ty), local_name(function, id)));
        let parameters: Vec<String> = locals.by_ref().take(function.parameters as usize).collect();
        let state = if function.reads_state { " reads state" } else { "" };
        let (result, name) = (self.ty(function.result), &function.name);
        writeln!(f, "f{index} {result} {name}({}){state} {{", parameters.join(", "))?;
        for local in locals {
            writeln!(f, "    {local};")?;
        }
        let mut body = Body { printer: self, function, pinned: vec![false; function.expressions.len()] };
        let mut text = String::new();
        body.statements(&mut text, &function.body, 1)?;
        write!(f, "{text}")?;
        writeln!(f, "}}")
    }
}

/// A number that is seen to be no integer.
fn float(value: f64, text: &str) -> String {
    match value.fract() == 0.0 && value.abs() < 1e15 {
        true => format!("{text}.0"),
        false => text.to_string(),
    }
}

fn stage(stage: Stage) -> &'static str {
    match stage {
        Stage::Const => "const",
        Stage::Uniform => "uniform",
        Stage::Varying => "varying",
    }
}

fn local_name(function: &Function, id: usize) -> String {
    let name = &function.locals[id].name;
    let repeated =
        function.locals.iter().enumerate().any(|(other, local)| other != id && local.name == *name);
    if repeated || name.is_empty() { format!("{name}_{id}") } else { name.to_string() }
}

/// Prints the body of a function.
struct Body<'p, 'g> {
    printer: &'p Printer<'g>,
    function: &'p Function,
    /// Which expressions have a name, because a statement has evaluated them.
    pinned: Vec<bool>,
}

impl Body<'_, '_> {
    fn expression(&self, id: ExpressionId) -> String {
        if self.pinned[id.0 as usize] {
            return format!("e{}", id.0);
        }
        self.inner(id)
    }

    fn inner(&self, id: ExpressionId) -> String {
        let Expression { kind, ty, .. } = &self.function.expressions[id.0 as usize];
        match kind {
            ExpressionKind::Constant(value) => self.printer.value(value, *ty),
            ExpressionKind::Read(place) => self.place(place),
            ExpressionKind::Op(op, args) => {
                let args: Vec<String> = args.iter().map(|arg| self.expression(*arg)).collect();
                match op {
                    Op::Unary(_) | Op::Binary(_) | Op::Select => {
                        format!("({})", self.printer.operation(op, &args, *ty))
                    }
                    _ => self.printer.operation(op, &args, *ty),
                }
            }
        }
    }

    fn place(&self, place: &Place) -> String {
        let mut text = local_name(self.function, place.local.0 as usize);
        for projection in &place.path {
            match projection {
                Projection::Member(index) => text += &format!(".{index}"),
                Projection::Index(index) => text += &format!("[{}]", self.expression(*index)),
            }
        }
        text
    }

    fn statements(&mut self, f: &mut String, statements: &[Statement], depth: usize) -> fmt::Result {
        statements.iter().try_for_each(|statement| self.statement(f, statement, depth))
    }

    fn statement(&mut self, f: &mut String, statement: &Statement, depth: usize) -> fmt::Result {
        let indent = "    ".repeat(depth);
        match statement {
            Statement::Evaluate(id) => {
                let text = self.inner(*id);
                self.pinned[id.0 as usize] = true;
                writeln!(f, "{indent}let e{} = {text};", id.0)
            }
            Statement::Store { place, value } => {
                writeln!(f, "{indent}{} = {};", self.place(place), self.expression(*value))
            }
            Statement::If { condition, then, otherwise } => {
                writeln!(f, "{indent}if {} {{", self.expression(*condition))?;
                self.statements(f, then, depth + 1)?;
                if !otherwise.is_empty() {
                    writeln!(f, "{indent}}} else {{")?;
                    self.statements(f, otherwise, depth + 1)?;
                }
                writeln!(f, "{indent}}}")
            }
            Statement::Switch { selector, cases } => {
                writeln!(f, "{indent}switch {} {{", self.expression(*selector))?;
                for case in cases {
                    let label =
                        |label: &Option<i32>| label.map_or("default".to_string(), |label| label.to_string());
                    let labels: Vec<String> = case.labels.iter().map(label).collect();
                    writeln!(f, "{indent}{}:", labels.join(", "))?;
                    self.statements(f, &case.body, depth + 1)?;
                    if case.falls_through {
                        writeln!(f, "{indent}    fall through;")?;
                    }
                }
                writeln!(f, "{indent}}}")
            }
            Statement::Loop { body, continuing, .. } => {
                writeln!(f, "{indent}loop {{")?;
                self.statements(f, body, depth + 1)?;
                if !continuing.is_empty() {
                    writeln!(f, "{indent}}} continuing {{")?;
                    self.statements(f, continuing, depth + 1)?;
                }
                writeln!(f, "{indent}}}")
            }
            Statement::Break => writeln!(f, "{indent}break;"),
            Statement::Continue => writeln!(f, "{indent}continue;"),
            Statement::Return(id) => writeln!(f, "{indent}return {};", self.expression(*id)),
        }
    }
}
