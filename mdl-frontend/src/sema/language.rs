//! What the language declares without a module: `intensity_mode` and the material structs.

use super::hir::{Body, Enum, Field, FieldDefault, Module, Struct, Window};
use super::ty::{Base, ModuleId, Ty};
use crate::loader::ModuleIdentity;
use crate::span::Span;
use crate::syntax::version::Version;
use crate::types::{DfKind, Scalar, TextureKind};
use crate::value::Value;
use std::sync::Arc;

/// The module that stands for the language itself.
pub fn module() -> Module {
    let identity = ModuleIdentity::new("", "<language>", "<language>");
    let mut module = Module::empty(ModuleId::LANGUAGE, identity, "".into(), Version::LATEST);
    module.enums.push(Arc::new(Enum {
        name: "intensity_mode".into(),
        values: vec![("intensity_radiant_exitance".into(), 0), ("intensity_power".into(), 1)],
        uses: Vec::new(),
        value_uses: Vec::new(),
        window: Window::ALWAYS,
        span: Span::default(),
    }));
    let df = |kind| Ty::of(Base::Df(kind));
    let plain = |name, ty| field(name, ty, FieldDefault::Language);
    let valued = |name, ty, value| field(name, ty, FieldDefault::Value(value));
    let structs = [
        (
            "material_emission",
            vec![
                plain("emission", df(DfKind::Edf)),
                plain("intensity", Ty::COLOR),
                Field { uniform: true, ..since(1, plain("mode", Ty::INTENSITY_MODE)) },
            ],
        ),
        ("material_surface", vec![plain("scattering", Ty::BSDF), plain("emission", Ty::MATERIAL_EMISSION)]),
        (
            "material_volume",
            vec![
                plain("scattering", df(DfKind::Vdf)),
                plain("absorption_coefficient", Ty::COLOR),
                plain("scattering_coefficient", Ty::COLOR),
                since(7, plain("emission_intensity", Ty::COLOR)),
            ],
        ),
        (
            "material_geometry",
            vec![
                plain("displacement", Ty::FLOAT3),
                valued("cutout_opacity", Ty::FLOAT, Value::Float(1.0)),
                field("normal", Ty::FLOAT3, FieldDefault::Normal),
            ],
        ),
        (
            "material",
            vec![
                Field { uniform: true, ..plain("thin_walled", Ty::BOOL) },
                plain("surface", Ty::MATERIAL_SURFACE),
                plain("backface", Ty::MATERIAL_SURFACE),
                valued("ior", Ty::COLOR, Value::floats(&[1.0; 3])),
                plain("volume", Ty::MATERIAL_VOLUME),
                plain("geometry", Ty::MATERIAL_GEOMETRY),
                since(5, plain("hair", df(DfKind::Hair))),
            ],
        ),
    ];
    for (name, fields) in structs {
        module.structs.push(Arc::new(Struct {
            name: name.into(),
            fields,
            category: None,
            declarative: true,
            scalars: 32,
            depth: 3,
            body: Body::default(),
            uses: Vec::new(),
            window: Window::ALWAYS,
            span: Span::default(),
        }));
    }
    module
}

fn field(name: &str, ty: Ty, default: FieldDefault) -> Field {
    let varying_default = default == FieldDefault::Normal;
    Field {
        name: name.into(),
        ty,
        uniform: false,
        default,
        varying_default,
        since: Version::new(1, 0),
        uses: Vec::new(),
        span: Span::default(),
    }
}

/// A field that came with MDL 1.`minor`. Such fields stand last: versions before see those in front of them.
fn since(minor: u16, field: Field) -> Field {
    Field { since: Version::new(1, minor), ..field }
}

/// The keyword of a type that has one.
pub fn type_name(base: Base) -> String {
    let scalar_name = |scalar: Scalar| match scalar {
        Scalar::Bool => "bool",
        Scalar::Int => "int",
        Scalar::Float => "float",
        Scalar::Double => "double",
    };
    match base {
        Base::Scalar(scalar) => scalar_name(scalar).to_string(),
        Base::Vector(scalar, size) => format!("{}{size}", scalar_name(scalar)),
        Base::Matrix(scalar, columns, rows) => format!("{}{columns}x{rows}", scalar_name(scalar)),
        Base::Color => "color".to_string(),
        Base::String => "string".to_string(),
        Base::Texture(TextureKind::D2) => "texture_2d".to_string(),
        Base::Texture(TextureKind::D3) => "texture_3d".to_string(),
        Base::Texture(TextureKind::Cube) => "texture_cube".to_string(),
        Base::Texture(TextureKind::Ptex) => "texture_ptex".to_string(),
        Base::LightProfile => "light_profile".to_string(),
        Base::BsdfMeasurement => "bsdf_measurement".to_string(),
        Base::Df(DfKind::Bsdf) => "bsdf".to_string(),
        Base::Df(DfKind::Edf) => "edf".to_string(),
        Base::Df(DfKind::Vdf) => "vdf".to_string(),
        Base::Df(DfKind::Hair) => "hair_bsdf".to_string(),
        Base::Error | Base::Enum(_) | Base::Struct(_) => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::{Type, TypeId, TypeTable};

    #[test]
    fn structs_are_those_of_the_graph() {
        let module = module();
        let types = TypeTable::default();
        let ids = [
            TypeId::MATERIAL_EMISSION,
            TypeId::MATERIAL_SURFACE,
            TypeId::MATERIAL_VOLUME,
            TypeId::MATERIAL_GEOMETRY,
            TypeId::MATERIAL,
        ];
        for (declared, id) in module.structs.iter().zip(ids) {
            let Type::Struct(ty) = types.get(id) else { panic!("not a struct") };
            assert_eq!(ty.name, declared.name);
            let names = |fields: Vec<&Arc<str>>| fields.into_iter().cloned().collect::<Vec<_>>();
            let fields = names(declared.fields.iter().map(|field| &field.name).collect());
            assert_eq!(names(ty.fields.iter().map(|(name, _)| name).collect()), fields);
        }
    }
}
