//! A checked module as its users see it.

use super::session::world;
use super::{Checked, Failure, standard};
use crate::diagnostics::{Diagnostic, Sink};
use crate::graph::ParameterUi;
use crate::sema::hir::{AnnotationUse, DefaultArg, Entity, FieldDefault, Function, Module, World};
use crate::sema::ty::{Base, DefId, Size, Ty};
use crate::sema::{parameter_ui, type_name};
use crate::span::FileSpan;
use crate::syntax;
use crate::syntax::ast::Frequency;
use crate::syntax::version::Version;
use crate::value::Value;
use std::sync::Arc;

/// A checked module with everything that it imports.
#[derive(Clone)]
pub struct CheckedModule {
    pub(crate) checked: Checked,
    pub(crate) world: Arc<World>,
    diagnostics: Arc<[Diagnostic]>,
}

/// A function or material that a module exports.
#[derive(Clone, Debug)]
pub struct FunctionInfo {
    /// Name within the module.
    pub name: Arc<str>,
    /// Qualified name.
    pub qualified: Arc<str>,
    /// Its parameters.
    pub parameters: Vec<ParameterInfo>,
    /// Type of its result.
    pub result: String,
    /// It is a material.
    pub is_material: bool,
    /// Qualified name of what it is a variant of.
    pub variant_of: Option<Arc<str>>,
    /// Its annotations.
    pub annotations: Vec<AnnotationInfo>,
    /// Where it is declared.
    pub span: FileSpan,
}

/// A parameter of a [`FunctionInfo`].
#[derive(Clone, Debug)]
pub struct ParameterInfo {
    /// Its name.
    pub name: Arc<str>,
    /// Its type as written.
    pub ty: String,
    /// Declared `uniform`.
    pub uniform: bool,
    /// Source text of its default.
    pub default: Option<String>,
    /// What annotations tell a user interface.
    pub ui: ParameterUi,
    /// All its annotations.
    pub annotations: Vec<AnnotationInfo>,
}

/// A struct or enumeration that a module exports.
#[derive(Clone, Debug)]
pub struct TypeInfo {
    /// Name within the module.
    pub name: Arc<str>,
    /// Its annotations.
    pub annotations: Vec<AnnotationInfo>,
    /// What it is made of.
    pub content: TypeContent,
}

/// What a [`TypeInfo`] is made of.
#[derive(Clone, Debug)]
pub enum TypeContent {
    /// The values of an enumeration in order of declaration.
    Enum(Vec<ValueInfo>),
    /// The fields of a struct.
    Struct(Vec<ParameterInfo>),
}

/// A value of an enumeration.
#[derive(Clone, Debug)]
pub struct ValueInfo {
    /// Its name.
    pub name: Arc<str>,
    /// Its number.
    pub number: i32,
    /// Its annotations.
    pub annotations: Vec<AnnotationInfo>,
}

/// An annotation.
#[derive(Clone, Debug, PartialEq)]
pub struct AnnotationInfo {
    /// Qualified name, such as `::anno::display_name`.
    pub name: Arc<str>,
    /// Parameters and values.
    pub arguments: Vec<(Arc<str>, Value)>,
}

impl CheckedModule {
    pub(crate) fn new(checked: Checked) -> Self {
        let world = world([&checked.module].into_iter());
        let mut diagnostics = checked.module.diagnostics.clone();
        // Errors of imported modules belong to the picture; their warnings are somebody else's.
        for module in world.modules().filter(|module| module.id != checked.module.id) {
            diagnostics.extend(module.diagnostics.iter().filter(|diagnostic| diagnostic.is_error()).cloned());
        }
        Self { checked, world: world.into(), diagnostics: diagnostics.into() }
    }

    pub(crate) fn standard(module: Arc<Module>) -> Self {
        let mut sink = Sink::new(module.identity.file.clone());
        let syntax = Arc::new(syntax::parse_module(module.text.clone(), &mut sink));
        let imports = module.imports.iter().cloned().map(Some).collect();
        Self::new(Checked { syntax, module, imports, record: None })
    }

    pub(crate) fn module(&self) -> &Module {
        &self.checked.module
    }

    /// The qualified name of the module.
    pub fn name(&self) -> String {
        self.module().identity.name()
    }

    /// The name of its file.
    pub fn file(&self) -> &Arc<str> {
        &self.module().identity.file
    }

    /// The version of the language that it is written in.
    pub fn version(&self) -> Version {
        self.module().version
    }

    /// Errors and warnings of the module, and errors of all that it imports.
    pub fn diagnostics(&self) -> &[Diagnostic] {
        &self.diagnostics
    }

    /// Whether the module cannot be compiled.
    pub fn has_errors(&self) -> bool {
        self.diagnostics.iter().any(Diagnostic::is_error)
    }

    /// The text of a file that a diagnostic refers to.
    pub fn source(&self, file: &str) -> Option<Arc<str>> {
        let found = self.world.modules().find(|module| *module.identity.file == *file);
        found.map(|module| module.text.clone())
    }

    /// Texts of all files that diagnostics may refer to.
    pub(crate) fn sources(&self) -> Vec<(Arc<str>, Arc<str>)> {
        self.world.modules().map(|module| (module.identity.file.clone(), module.text.clone())).collect()
    }

    /// A failure with these diagnostics.
    pub(crate) fn failure(&self, diagnostics: Vec<Diagnostic>) -> Failure {
        Failure { diagnostics, sources: self.sources() }
    }

    /// Annotations of the module.
    pub fn annotations(&self) -> Vec<AnnotationInfo> {
        annotations(&self.module().uses)
    }

    /// The materials that it exports, in order of declaration.
    pub fn materials(&self) -> Vec<FunctionInfo> {
        self.exported(|function| function.signature.result == Ty::MATERIAL)
    }

    /// The functions that it exports which are no materials, in order of declaration.
    pub fn functions(&self) -> Vec<FunctionInfo> {
        self.exported(|function| function.signature.result != Ty::MATERIAL)
    }

    /// The structs and enumerations that it exports, in order of declaration.
    pub fn types(&self) -> Vec<TypeInfo> {
        let module = self.module();
        let named =
            module.export_order.iter().flat_map(|name| module.exports[name].iter().map(move |e| (name, e)));
        named.filter_map(|(name, entity)| self.type_info(name, *entity)).collect()
    }

    fn type_info(&self, name: &Arc<str>, entity: Entity) -> Option<TypeInfo> {
        let module = self.module();
        let Entity::Type(ty) = entity else { return None };
        let (uses, content) = match ty.base {
            _ if ty.size.is_some() => return None,
            Base::Enum(id) if id.module == module.id => {
                let definition = &module.enums[id.index as usize];
                let values = definition.values.iter().zip(&definition.value_uses);
                let values = values.map(|((name, number), uses)| ValueInfo {
                    name: name.clone(),
                    number: *number,
                    annotations: annotations(uses),
                });
                (&definition.uses, TypeContent::Enum(values.collect()))
            }
            Base::Struct(id) if id.module == module.id => {
                let definition = &module.structs[id.index as usize];
                let fields = definition.fields.iter().map(|field| ParameterInfo {
                    name: field.name.clone(),
                    ty: self.display(field.ty, &[]),
                    uniform: field.uniform,
                    default: match &field.default {
                        FieldDefault::Expr(id) => module.slice(definition.body.expr(*id).span),
                        _ => None,
                    },
                    ui: parameter_ui(&field.uses, field.ty),
                    annotations: annotations(&field.uses),
                });
                (&definition.uses, TypeContent::Struct(fields.collect()))
            }
            _ => return None,
        };
        Some(TypeInfo { name: name.clone(), annotations: annotations(uses), content })
    }

    fn exported(&self, wanted: impl Fn(&Function) -> bool) -> Vec<FunctionInfo> {
        let module = self.module();
        let entities = module.export_order.iter().flat_map(|name| &module.exports[name]);
        let ids = entities.filter_map(|entity| match entity {
            Entity::Function(id) if id.module == module.id => Some(*id),
            _ => None,
        });
        ids.filter(|id| wanted(self.function(*id))).map(|id| self.info(id)).collect()
    }

    pub(crate) fn function(&self, id: DefId) -> &Function {
        let module =
            self.world.module(id.module).expect("a checked module's world holds all that it refers to");
        &module.functions[id.index as usize]
    }

    fn info(&self, id: DefId) -> FunctionInfo {
        let function = self.function(id);
        let signature = &function.signature;
        let parameters = signature.params.iter().enumerate().map(|(index, param)| {
            let uses = function.param_uses.get(index).map_or(&[][..], |uses| uses);
            ParameterInfo {
                name: param.name.clone(),
                ty: self.display(param.ty, &signature.symbols),
                uniform: param.frequency == Some(Frequency::Uniform),
                default: self.default_text(id, index),
                ui: parameter_ui(uses, param.ty),
                annotations: annotations(uses),
            }
        });
        FunctionInfo {
            name: signature.name.clone(),
            qualified: signature.qualified.clone(),
            parameters: parameters.collect(),
            result: self.display(signature.result, &signature.symbols),
            is_material: signature.result == Ty::MATERIAL,
            variant_of: function.variant_of.map(|id| self.function(id).signature.qualified.clone()),
            annotations: annotations(&function.uses),
            span: signature.span.clone(),
        }
    }

    /// Source text of a default.
    fn default_text(&self, id: DefId, param: usize) -> Option<String> {
        let mut id = id;
        loop {
            let function = self.function(id);
            match function.defaults.get(param)?.as_ref()? {
                DefaultArg::Inherited(original) => id = *original,
                DefaultArg::Own(value) => {
                    let span = function.body.expr(*value).span;
                    return self.world.module(id.module)?.slice(span);
                }
            }
        }
    }

    pub(crate) fn display(&self, ty: Ty, symbols: &[Arc<str>]) -> String {
        let module = |id: DefId| self.world.module(id.module);
        let base = match ty.base {
            Base::Enum(id) => module(id).map(|module| module.enums[id.index as usize].name.to_string()),
            Base::Struct(id) => module(id).map(|module| module.structs[id.index as usize].name.to_string()),
            base => Some(type_name(base)),
        };
        let base = base.unwrap_or_default();
        match ty.size {
            None => base,
            Some(Size::Known(size)) => format!("{base}[{size}]"),
            Some(Size::Symbol(id)) => {
                format!("{base}[<{}>]", symbols.get(id.0 as usize).map_or("N", |name| name))
            }
        }
    }
}

fn annotations(uses: &[AnnotationUse]) -> Vec<AnnotationInfo> {
    let info =
        |used: &AnnotationUse| AnnotationInfo { name: used.name.clone(), arguments: used.args.clone() };
    uses.iter().map(info).collect()
}

/// The modules of the standard library, by name without `::`.
pub fn standard_modules() -> impl Iterator<Item = &'static str> {
    standard::names()
}
