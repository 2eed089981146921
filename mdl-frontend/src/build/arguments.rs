//! Arguments given from outside: values, or source text.

use super::{Builder, Built, Frame};
use crate::compiler::{CheckedModule, Compiler, Failure};
use crate::diagnostics::{Problem, Sink, build as problems, similar, types as type_problems};
use crate::graph::{NodeId, Stage};
use crate::sema::hir::{Body, ExprId, ParamSig, Signature};
use crate::sema::ty::{ModuleId, Size, Ty};
use crate::sema::{self, Input, ModuleCx};
use crate::span::{FileSpan, Span};
use crate::syntax;
use crate::syntax::ast::Frequency;
use crate::value::Value;
use crate::verify::has_type;
use std::sync::Arc;

/// A value for a parameter.
#[derive(Clone, Debug)]
pub enum Argument {
    /// A value of the parameter's type.
    Value(Value),
    /// An expression in MDL, such as `color(1.0, 0.5, 0.0)`. It sees the names of the module, and the
    /// values of the parameter's enumeration. A string names the file of a resource.
    Text(String),
}

impl From<Value> for Argument {
    fn from(value: Value) -> Self {
        Argument::Value(value)
    }
}

impl From<&str> for Argument {
    fn from(text: &str) -> Self {
        Argument::Text(text.to_string())
    }
}

/// An argument that was checked.
pub enum Prepared {
    /// A value.
    Value(Value),
    /// An expression.
    Expr(Body, ExprId),
}

/// The name of the text of an argument, for diagnostics.
fn argument_file(name: &str) -> Arc<str> {
    format!("<argument {name}>").into()
}

/// Checks arguments against a signature; one per parameter.
pub fn prepare(
    compiler: &Compiler,
    checked: &CheckedModule,
    signature: &Signature,
    args: &[(&str, Argument)],
) -> Result<Vec<Option<Prepared>>, Failure> {
    let mut prepared: Vec<Option<Prepared>> = signature.params.iter().map(|_| None).collect();
    let mut diagnostics = Vec::new();
    let mut sources = Vec::new();
    for (name, argument) in args {
        let file = argument_file(name);
        let place = FileSpan { file: file.clone(), span: Span::default() };
        let Some(index) = signature.params.iter().position(|param| *param.name == **name) else {
            let similar = similar(name, signature.params.iter().map(|param| &*param.name));
            let (name, owner) = (name.to_string(), signature.name.to_string());
            let parameters = signature.params.iter().map(|param| param.name.to_string()).collect();
            let problem = problems::NoSuchParameter { name, owner, similar, parameters };
            diagnostics.push(problem.at(FileSpan { file: "".into(), ..place }));
            continue;
        };
        match argument {
            Argument::Value(value) => prepared[index] = Some(Prepared::Value(value.clone())),
            Argument::Text(text) => {
                let param = &signature.params[index];
                match check_text(compiler, checked, param, text, file.clone()) {
                    Ok((body, value)) => prepared[index] = Some(Prepared::Expr(body, value)),
                    Err(errors) => diagnostics.extend(errors),
                }
                sources.push((file, Arc::from(text.as_str())));
            }
        }
    }
    match diagnostics.is_empty() {
        true => Ok(prepared),
        false => Err(Failure { diagnostics, sources }),
    }
}

/// Checks the text of an argument.
fn check_text(
    compiler: &Compiler,
    checked: &CheckedModule,
    param: &ParamSig,
    text: &str,
    file: Arc<str>,
) -> Result<(Body, ExprId), Vec<crate::diagnostics::Diagnostic>> {
    let mut sink = Sink::new(file.clone());
    let parsed = syntax::parse_expression(text, checked.version(), &mut sink);
    let (Some((nodes, root)), false) = (parsed, sink.has_errors()) else { return Err(sink.finish()) };
    let input = Input {
        id: ModuleId(u32::MAX),
        identity: checked.module().identity.clone(),
        syntax: &checked.checked.syntax,
        imports: &checked.checked.imports,
        world: &checked.world,
        folder: compiler.folder(),
        loader: compiler.loader(),
        standard: false,
    };
    let mut cx = ModuleCx::new(&input, Sink::new(file.clone()));
    cx.adopt(&checked.checked.module, &checked.checked.imports, file);
    let (body, value) = sema::check_argument(&mut cx, text, &nodes, root, param.ty);
    let sink = cx.into_sink();
    match sink.has_errors() {
        true => Err(sink.finish()),
        false => Ok((body, value)),
    }
}

impl<'w> Builder<'w> {
    /// The node of an argument.
    pub(super) fn argument(
        &mut self,
        checked: &'w CheckedModule,
        prepared: &'w Prepared,
        param: &ParamSig,
    ) -> Built<NodeId> {
        let place = FileSpan { file: argument_file(&param.name), span: Span::default() };
        let node = match prepared {
            Prepared::Value(value) => self.value_argument(value, param, place.clone())?,
            Prepared::Expr(body, value) => {
                let mut frame = Frame::new(checked.module(), body, 0);
                self.eval(&mut frame, *value)?
            }
        };
        if param.frequency == Some(Frequency::Uniform) && self.nodes.get(node).stage == Stage::Varying {
            let name = param.name.to_string();
            let problem =
                type_problems::VaryingToUniform { name, cause: None, parameter: Some(param.span.clone()) };
            return self.abort(place, problem);
        }
        Ok(node)
    }

    /// A constant of a parameter's type; an array of open size may have any.
    fn value_argument(&mut self, value: &Value, param: &ParamSig, place: FileSpan) -> Built<NodeId> {
        let ty = match param.ty.size {
            Some(Size::Symbol(_)) => {
                Ty { size: Some(Size::Known(value.elements().len() as u32)), ..param.ty }
            }
            _ => param.ty,
        };
        let id = self.types.known(ty);
        // References to files mean nothing outside of a graph, so none is accepted.
        if !has_type(value, id, &self.types.table, 0) {
            let (name, expected) = (param.name.to_string(), self.types.table.display(id));
            return self.abort(place, problems::ArgumentValue { name, expected });
        }
        Ok(self.nodes.constant(value.clone(), id))
    }
}
