//! The graph of a material or function: parameters, roots, and what is left between them.

use super::arguments::{self, Argument, Prepared};
use super::{Abort, Builder, Built, Frame, prune};
use crate::compiler::{CheckedModule, Compiler, Failure};
use crate::diagnostics::{build as problems, similar};
use crate::graph::{
    FunctionGraph, Graph, MaterialGraph, MaterialRoots, Mode, NodeId, Op, Parameter, SurfaceRoots,
};
use crate::sema::hir::{Entity, ParamSig, Signature};
use crate::sema::parameter_ui;
use crate::sema::ty::{DefId, Size, Ty};
use crate::syntax::ast::Frequency;
use crate::types::TypeId;
use crate::verify::verify;

/// Builds the graph of a material.
pub fn material_graph(
    compiler: &Compiler,
    checked: &CheckedModule,
    name: &str,
    mode: Mode,
    args: &[(&str, Argument)],
) -> Result<MaterialGraph, Failure> {
    refuse_errors(checked)?;
    let id = find_material(checked, name)?;
    let signature = checked.function(id).signature.clone();
    let prepared = arguments::prepare(compiler, checked, &signature, args)?;
    let mut builder = Builder::new(&checked.world, compiler.folder());
    let built = builder.material(checked, id, mode, &prepared);
    let (mut roots, parameters) = built.map_err(|Abort| builder.failure(checked, args))?;
    let mut graph = builder.into_graph(parameters);
    prune::graph(&mut graph, &mut each_root(&mut roots));
    debug_assert_eq!(verify(&graph), Ok(()));
    Ok(MaterialGraph { name: signature.qualified.clone(), mode, graph, roots })
}

/// Builds the graph of a function. In class mode a parameter without default starts as zero.
pub fn function_graph(
    compiler: &Compiler,
    checked: &CheckedModule,
    name: &str,
    mode: Mode,
    args: &[(&str, Argument)],
) -> Result<FunctionGraph, Failure> {
    refuse_errors(checked)?;
    let id = find_function(checked, name, args)?;
    let signature = checked.function(id).signature.clone();
    let prepared = arguments::prepare(compiler, checked, &signature, args)?;
    let mut builder = Builder::new(&checked.world, compiler.folder());
    let built = builder.function_result(checked, id, mode, &prepared);
    let (mut result, parameters) = built.map_err(|Abort| builder.failure(checked, args))?;
    let mut graph = builder.into_graph(parameters);
    prune::graph(&mut graph, &mut [&mut result]);
    debug_assert_eq!(verify(&graph), Ok(()));
    Ok(FunctionGraph { name: signature.qualified.clone(), graph, result })
}

/// Only modules without errors are built.
fn refuse_errors(checked: &CheckedModule) -> Result<(), Failure> {
    match checked.has_errors() {
        true => Err(checked.failure(checked.diagnostics().to_vec())),
        false => Ok(()),
    }
}

/// Own exported functions of a name.
fn exported(checked: &CheckedModule, name: &str) -> Vec<DefId> {
    let entities = checked.module().exports.get(name).map_or(&[][..], |entities| entities);
    let function = |entity: &Entity| match entity {
        Entity::Function(id) => Some(*id),
        _ => None,
    };
    entities.iter().filter_map(function).collect()
}

fn find_material(checked: &CheckedModule, name: &str) -> Result<DefId, Failure> {
    let is_material = |id: &DefId| checked.function(*id).signature.result == Ty::MATERIAL;
    exported(checked, name).into_iter().find(is_material).ok_or_else(|| {
        let names: Vec<_> = checked.materials().into_iter().map(|info| info.name).collect();
        let similar = similar(name, names.iter().map(|name| &**name));
        Failure::placeless(problems::NoSuchMaterial {
            name: name.to_string(),
            module: checked.name(),
            similar,
        })
    })
}

/// A function by name, or by name and types such as `f(float,int)`. Of several overloads, the one whose
/// parameters have the names of all arguments.
fn find_function(checked: &CheckedModule, name: &str, args: &[(&str, Argument)]) -> Result<DefId, Failure> {
    let (short, types) = match name.split_once('(') {
        Some((short, types)) => (short.trim(), Some(types.trim_end().trim_end_matches(')'))),
        None => (name, None),
    };
    let mut found = exported(checked, short);
    if found.is_empty() {
        let names: Vec<_> = checked.functions().into_iter().map(|info| info.name).collect();
        let similar = similar(short, names.iter().map(|name| &**name));
        let (name, module) = (short.to_string(), checked.name());
        return Err(Failure::placeless(problems::NoSuchFunction { name, module, similar }));
    }
    let all = found.clone();
    found.retain(|id| {
        let signature = &checked.function(*id).signature;
        let written = |param: &ParamSig| checked.display(param.ty, &signature.symbols);
        let fits = types.is_none_or(|types| {
            let types: Vec<&str> = types.split(',').map(str::trim).filter(|ty| !ty.is_empty()).collect();
            types == signature.params.iter().map(written).collect::<Vec<_>>()
        });
        fits && args.iter().all(|(name, _)| signature.params.iter().any(|param| *param.name == **name))
    });
    match (&found[..], &all[..]) {
        ([id], _) | ([], [id]) => Ok(*id),
        _ => {
            let candidates = all.iter().map(|id| checked.function(*id).signature.span.clone()).collect();
            let problem = problems::AmbiguousFunction { name: short.to_string(), candidates };
            let mut failure = Failure::placeless(problem);
            failure.sources = checked.sources();
            Err(failure)
        }
    }
}

impl<'w> Builder<'w> {
    fn failure(&mut self, checked: &CheckedModule, args: &[(&str, Argument)]) -> Failure {
        let mut failure = checked.failure(std::mem::take(&mut self.diagnostics));
        failure.sources.extend(args.iter().filter_map(|(name, argument)| match argument {
            Argument::Text(text) => Some((format!("<argument {name}>").into(), text.as_str().into())),
            Argument::Value(_) => None,
        }));
        failure
    }

    fn into_graph(self, parameters: Vec<Parameter>) -> Graph {
        let Builder { types, nodes, functions, resources, .. } = self;
        Graph { types: types.table, nodes: nodes.into_vec(), functions, parameters, resources }
    }

    fn material(
        &mut self,
        checked: &'w CheckedModule,
        id: DefId,
        mode: Mode,
        args: &'w [Option<Prepared>],
    ) -> Built<(MaterialRoots, Vec<Parameter>)> {
        let (args, parameters) = self.parameters(checked, id, mode, args, false)?;
        let place = self.function(id).signature.span.clone();
        let material = self.call_on(id, args.into_iter().map(Some).collect(), place)?;
        Ok((self.roots(material), parameters))
    }

    fn function_result(
        &mut self,
        checked: &'w CheckedModule,
        id: DefId,
        mode: Mode,
        args: &'w [Option<Prepared>],
    ) -> Built<(NodeId, Vec<Parameter>)> {
        let signature = &self.function(id).signature;
        let place = signature.span.clone();
        if signature.declarative {
            let (name, ty) =
                (signature.name.to_string(), checked.display(signature.result, &signature.symbols));
            return self.abort(place, problems::NotAFunctionOfValues { name, ty });
        }
        let (args, parameters) = self.parameters(checked, id, mode, args, true)?;
        let result = self.call_on(id, args.into_iter().map(Some).collect(), place)?;
        Ok((result, parameters))
    }

    /// Nodes for the parameters of the function that the graph is of.
    fn parameters(
        &mut self,
        checked: &'w CheckedModule,
        id: DefId,
        mode: Mode,
        args: &'w [Option<Prepared>],
        is_function: bool,
    ) -> Built<(Vec<NodeId>, Vec<Parameter>)> {
        let function = self.function(id);
        let signature = &function.signature;
        let place = &signature.span;
        let mut frame = Frame::new(self.module(id), &function.body, signature.symbols.len());
        frame.locals.resize(frame.locals.len().max(signature.params.len()), None);
        let mut nodes = Vec::new();
        let mut parameters = Vec::new();
        for (index, param) in signature.params.iter().enumerate() {
            let given = args.get(index).and_then(Option::as_ref);
            let has_default = function.defaults.get(index).is_some_and(Option::is_some);
            let value = match given {
                Some(prepared) => self.argument(checked, prepared, param)?,
                None if has_default => self.default_arg(id, &frame, index, place)?,
                None => self.missing_argument(param, signature, is_function && mode == Mode::Class)?,
            };
            let (node, default) = match (mode, self.nodes.value(value).cloned()) {
                (Mode::Class, Some(default)) if !self.types.is_declarative(self.nodes.ty(value)) => {
                    (self.nodes.parameter(index as u32, self.nodes.ty(value)), Some(default))
                }
                _ => (value, None),
            };
            frame.locals[index] = Some(node);
            self.bind_size(function, &mut frame, index, node, place)?;
            nodes.push(node);
            if mode == Mode::Class {
                parameters.push(Parameter {
                    name: param.name.clone(),
                    ty: self.nodes.ty(node),
                    uniform: param.frequency == Some(Frequency::Uniform),
                    default,
                    ui: parameter_ui(function.param_uses.get(index).map_or(&[], |uses| uses), param.ty),
                });
            }
        }
        Ok((nodes, parameters))
    }

    /// A parameter without default and argument.
    fn missing_argument(
        &mut self,
        param: &ParamSig,
        signature: &Signature,
        may_be_zero: bool,
    ) -> Built<NodeId> {
        if may_be_zero && !matches!(param.ty.size, Some(Size::Symbol(_))) {
            return self.default_of(param.ty);
        }
        let (name, owner) = (param.name.to_string(), signature.name.to_string());
        self.abort(param.span.clone(), problems::ArgumentRequired { name, owner })
    }

    fn field(&mut self, x: NodeId, path: &[u32]) -> NodeId {
        path.iter().fold(x, |x, index| {
            let ty = self.types.part(self.nodes.ty(x), *index).unwrap_or(TypeId::INT);
            self.nodes.op(&mut self.types, Op::Member(*index), vec![x], ty)
        })
    }

    /// The fields of a material, by their numbers in the language's structs.
    fn roots(&mut self, m: NodeId) -> MaterialRoots {
        let mut surface = |field: u32| SurfaceRoots {
            scattering: self.field(m, &[field, 0]),
            emission: self.field(m, &[field, 1, 0]),
            intensity: self.field(m, &[field, 1, 1]),
            mode: self.field(m, &[field, 1, 2]),
        };
        let (front, back) = (surface(1), surface(2));
        MaterialRoots {
            thin_walled: self.field(m, &[0]),
            surface: front,
            backface: back,
            ior: self.field(m, &[3]),
            volume_scattering: self.field(m, &[4, 0]),
            absorption_coefficient: self.field(m, &[4, 1]),
            scattering_coefficient: self.field(m, &[4, 2]),
            volume_emission_intensity: self.field(m, &[4, 3]),
            displacement: self.field(m, &[5, 0]),
            cutout_opacity: self.field(m, &[5, 1]),
            normal: self.field(m, &[5, 2]),
            hair: self.field(m, &[6]),
        }
    }
}

/// All roots of a material.
fn each_root(roots: &mut MaterialRoots) -> Vec<&mut NodeId> {
    let MaterialRoots {
        thin_walled,
        surface,
        backface,
        ior,
        volume_scattering,
        absorption_coefficient,
        scattering_coefficient,
        volume_emission_intensity,
        displacement,
        cutout_opacity,
        normal,
        hair,
    } = roots;
    let mut all = vec![
        thin_walled,
        ior,
        volume_scattering,
        absorption_coefficient,
        scattering_coefficient,
        volume_emission_intensity,
        displacement,
        cutout_opacity,
        normal,
        hair,
    ];
    for SurfaceRoots { scattering, emission, intensity, mode } in [surface, backface] {
        all.extend([scattering, emission, intensity, mode]);
    }
    all
}
