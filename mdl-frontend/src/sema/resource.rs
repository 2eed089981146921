//! References to files: `texture_2d("oak.png", tex::gamma_srgb)`.

use super::Checker;
use super::hir::{ExprId, ExprKind, ResourceExpr};
use super::ty::{Base, Ty};
use crate::diagnostics::types as problems;
use crate::graph::ResourceKind;
use crate::loader::{LoadError, ModuleIdentity};
use crate::span::Span;
use crate::syntax::ast;
use crate::syntax::version::Version;
use crate::types::TextureKind;
use std::sync::Arc;

impl<'a> Checker<'_, 'a> {
    /// A constructor of a resource type.
    pub(super) fn resource(&mut self, ty: Ty, args: &[ast::Arg], span: Span) -> ExprId {
        let Some(name) = args.first() else { return self.push(ExprKind::Default, ty, span) };
        let literal = args.iter().find(|arg| arg.name.is_some_and(|name| self.name_of(name) == "name"));
        let name = literal.unwrap_or(name).value;
        let ast::ExprKind::String(written) = &self.nodes.expr(unparenthesised(self.nodes, name)).kind else {
            return self.copied_resource(ty, args, span);
        };
        let (written, name_span) = (written.clone(), self.nodes.expr(name).span);
        let (mut gamma, mut selector) = (None, None);
        for (index, arg) in args.iter().enumerate() {
            if arg.value == name {
                continue;
            }
            let is_texture = matches!(ty.base, Base::Texture(_));
            let has_selector = matches!(ty.base, Base::Texture(TextureKind::D2 | TextureKind::D3));
            match (arg.name.map(|name| self.name_of(name)), index) {
                (Some("gamma"), _) | (None, 1) if is_texture => gamma = Some(self.gamma(arg.value)),
                (Some("selector"), _) | (None, 2) if has_selector => {
                    let value = self.expr(arg.value);
                    selector = Some(self.coerce(value, Ty::STRING));
                }
                _ => {
                    let checked = self.args(args);
                    let (name, args) = (self.display(ty), self.describe(&checked));
                    self.emit(span, problems::NoConstructor { ty: name, args });
                    return self.push(ExprKind::Error, ty, span);
                }
            }
        }
        let kind = kind(ty);
        let resolved = match written.is_empty() {
            true => {
                let ty = self.display(ty);
                self.emit(name_span, problems::EmptyResourcePath { ty });
                None
            }
            false => self.resolve_resource(&written, kind, name_span),
        };
        let span_of_name = self.m.sink.place(name_span);
        let resource = ResourceExpr { kind, written, resolved, gamma, selector, span: span_of_name };
        self.push(ExprKind::Resource(Box::new(resource)), ty, span)
    }

    /// A resource from another value: only its copy is possible.
    fn copied_resource(&mut self, ty: Ty, args: &[ast::Arg], span: Span) -> ExprId {
        let args = self.args(args);
        if let [arg] = args[..] {
            let from = self.body.ty(arg.value);
            if from == ty || from.is_error() {
                return arg.value;
            }
        }
        let ty_name = self.display(ty);
        self.emit(span, problems::ResourceNotLiteral { ty: ty_name });
        self.push(ExprKind::Error, ty, span)
    }

    /// The gamma mode: a value of `tex::gamma_mode`, which may be written without an import of `tex`.
    fn gamma(&mut self, id: ast::ExprId) -> ExprId {
        let value = self.expr(id);
        let ty = self.body.ty(value);
        let is_gamma = match ty.base {
            Base::Enum(id) => &*self.m.enumeration(id).name == "::tex::gamma_mode",
            Base::Error => true,
            _ => false,
        };
        if !is_gamma {
            let span = self.body.expr(value).span;
            let found = self.display(ty);
            let expected = "::tex::gamma_mode".to_string();
            self.emit(span, problems::Mismatch { found, expected, constructor: false });
        }
        value
    }

    /// The path under which the loader knows a file; reports if there is none.
    fn resolve_resource(&mut self, written: &Arc<str>, kind: ResourceKind, span: Span) -> Option<Arc<str>> {
        let identity = self.m.module.identity.clone();
        let candidates = match candidates(written, &identity, self.m.module.version) {
            Ok(candidates) => candidates,
            Err(reason) => {
                self.emit(span, problems::BadResourcePath { path: written.to_string(), reason });
                return None;
            }
        };
        for path in candidates {
            match self.m.loader.resolve_resource(&path, kind, &identity) {
                Ok(Some(resolved)) => return Some(resolved.path),
                Ok(None) => {}
                Err(LoadError(reason)) => {
                    self.emit(span, problems::BadResourcePath { path: written.to_string(), reason });
                    return None;
                }
            }
        }
        self.emit(span, problems::ResourceNotFound { path: written.to_string() });
        None
    }
}

fn unparenthesised(nodes: &ast::Nodes, mut id: ast::ExprId) -> ast::ExprId {
    while let ast::ExprKind::Paren(inner) = nodes.expr(id).kind {
        id = inner;
    }
    id
}

fn kind(ty: Ty) -> ResourceKind {
    match ty.base {
        Base::Texture(TextureKind::D3) => ResourceKind::Texture3d,
        Base::Texture(TextureKind::Cube) => ResourceKind::TextureCube,
        Base::Texture(TextureKind::Ptex) => ResourceKind::TexturePtex,
        Base::LightProfile => ResourceKind::LightProfile,
        Base::BsdfMeasurement => ResourceKind::BsdfMeasurement,
        _ => ResourceKind::Texture2d,
    }
}

/// Absolute paths that a path as written may mean, in order of preference.
fn candidates(written: &str, from: &ModuleIdentity, version: Version) -> Result<Vec<String>, String> {
    if let Some(c) = written.chars().find(|c| matches!(c, ':' | '\\') || c.is_control()) {
        let c = if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
        return Err(format!("it contains `{c}`"));
    }
    if let Some(absolute) = written.strip_prefix('/') {
        return Ok(vec![normalised(&[], absolute)?]);
    }
    let mut candidates = vec![normalised(from.package(), written)?];
    let weak = !written.starts_with("./") && !written.starts_with("../");
    if weak && version <= Version::new(1, 5) {
        candidates.push(normalised(&[], written)?);
    }
    Ok(candidates)
}

/// A path below a package without `.` and `..`.
fn normalised(package: &[String], path: &str) -> Result<String, String> {
    let mut parts: Vec<&str> = package.iter().map(String::as_str).collect();
    for part in path.split('/') {
        match part {
            "." => {}
            "" => return Err("it has an empty part".to_string()),
            ".." => {
                parts.pop().ok_or("it leads above the search root")?;
            }
            part => parts.push(part),
        }
    }
    Ok(parts.iter().flat_map(|part| ["/", part]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(written: &str, expected: Result<&[&str], &str>) {
        let from = ModuleIdentity::new("::a::b::m", "m.mdl", "root");
        let found = candidates(written, &from, Version::new(1, 6));
        let expected = expected.map(|paths| paths.iter().map(|path| path.to_string()).collect());
        assert_eq!(found, expected.map_err(str::to_string), "{written}");
    }

    #[test]
    fn paths_stay_below_the_search_root() {
        check("x.png", Ok(&["/a/b/x.png"]));
        check("./x.png", Ok(&["/a/b/x.png"]));
        check("../x.png", Ok(&["/a/x.png"]));
        check("/x/y.png", Ok(&["/x/y.png"]));
        check("../../../x.png", Err("it leads above the search root"));
        check("/../x.png", Err("it leads above the search root"));
        check("C:/x.png", Err("it contains `:`"));
        check("a\\x.png", Err("it contains `\\`"));
        check("a//b.png", Err("it has an empty part"));
    }

    #[test]
    fn old_versions_look_from_the_root_too() {
        let from = ModuleIdentity::new("::a::m", "m.mdl", "root");
        let found = candidates("x.png", &from, Version::new(1, 5));
        assert_eq!(found, Ok(vec!["/a/x.png".to_string(), "/x.png".to_string()]));
    }
}
