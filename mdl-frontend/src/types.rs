//! Types of MDL values, interned.
//!
//! A [`TypeId`] is an index into a [`TypeTable`]; equal types of one table have equal ids, so types are
//! compared by id. A table starts with the types that the language itself defines, at the fixed ids of
//! the constants on [`TypeId`]; struct, enum and array types follow as modules declare or use them.

use std::collections::HashMap;
use std::sync::Arc;

/// Index of a type in its [`TypeTable`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TypeId(pub u32);

/// Scalar types that vectors and matrices are built from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Scalar {
    /// `bool`
    Bool,
    /// `int`: 32 bits, two's complement, wraps around.
    Int,
    /// `float`: IEEE binary32.
    Float,
    /// `double`: IEEE binary64.
    Double,
}

/// Kind of a texture type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TextureKind {
    /// `texture_2d`
    D2,
    /// `texture_3d`
    D3,
    /// `texture_cube`
    Cube,
    /// `texture_ptex`
    Ptex,
}

/// Kind of a distribution function type: opaque, declarative, without fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DfKind {
    /// `bsdf`
    Bsdf,
    /// `edf`
    Edf,
    /// `vdf`
    Vdf,
    /// `hair_bsdf`
    Hair,
}

/// A type.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Type {
    /// `bool`, `int`, `float`, `double`
    Scalar(Scalar),
    /// `float3` and its like; 2 to 4 components.
    Vector {
        /// Type of a component.
        scalar: Scalar,
        /// Number of components.
        size: u8,
    },
    /// `float4x3` and its like, column-major: `columns` vectors of `rows` components.
    Matrix {
        /// `Float` or `Double`.
        scalar: Scalar,
        /// Number of columns, 2 to 4.
        columns: u8,
        /// Number of rows, 2 to 4.
        rows: u8,
    },
    /// `color`: linear RGB for now, three floats.
    Color,
    /// `string`
    String,
    /// `texture_2d` and its like.
    Texture(TextureKind),
    /// `light_profile`
    LightProfile,
    /// `bsdf_measurement`
    BsdfMeasurement,
    /// `bsdf`, `edf`, `vdf`, `hair_bsdf`
    Df(DfKind),
    /// An enumeration, `intensity_mode` among them.
    Enum(Arc<EnumType>),
    /// A struct, `material` and its parts among them.
    Struct(Arc<StructType>),
    /// An array of known size; deferred sizes are resolved before a graph is built.
    Array {
        /// Type of an element.
        element: TypeId,
        /// Number of elements, zero allowed.
        size: u32,
    },
}

/// An enumeration type.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct EnumType {
    /// Qualified name, such as `::tex::wrap_mode`.
    pub name: Arc<str>,
    /// Enumerators in order of declaration; values need not be unique.
    pub values: Vec<(Arc<str>, i32)>,
}

/// A struct type.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct StructType {
    /// Qualified name, such as `::base::texture_return`; the language's own are unqualified (`material`).
    pub name: Arc<str>,
    /// Fields in order of declaration.
    pub fields: Vec<(Arc<str>, TypeId)>,
}

macro_rules! fixed_types {
    ($($(#[$doc:meta])* $name:ident = $index:literal: $ty:expr;)*) => {
        impl TypeId {
            $($(#[$doc])* pub const $name: TypeId = TypeId($index);)*
        }

        /// The types at fixed ids, in id order.
        fn fixed() -> Vec<Type> {
            let types = vec![$(($index, $ty)),*];
            debug_assert!(types.iter().enumerate().all(|(i, (index, _))| i == *index as usize));
            types.into_iter().map(|(_, ty)| ty).collect()
        }
    };
}

fixed_types! {
    /// `bool`
    BOOL = 0: Type::Scalar(Scalar::Bool);
    /// `int`
    INT = 1: Type::Scalar(Scalar::Int);
    /// `float`
    FLOAT = 2: Type::Scalar(Scalar::Float);
    /// `double`
    DOUBLE = 3: Type::Scalar(Scalar::Double);
    /// `float2`
    FLOAT2 = 4: Type::Vector { scalar: Scalar::Float, size: 2 };
    /// `float3`
    FLOAT3 = 5: Type::Vector { scalar: Scalar::Float, size: 3 };
    /// `float4`
    FLOAT4 = 6: Type::Vector { scalar: Scalar::Float, size: 4 };
    /// `color`
    COLOR = 7: Type::Color;
    /// `string`
    STRING = 8: Type::String;
    /// `bsdf`
    BSDF = 9: Type::Df(DfKind::Bsdf);
    /// `edf`
    EDF = 10: Type::Df(DfKind::Edf);
    /// `vdf`
    VDF = 11: Type::Df(DfKind::Vdf);
    /// `hair_bsdf`
    HAIR_BSDF = 12: Type::Df(DfKind::Hair);
    /// `texture_2d`
    TEXTURE_2D = 13: Type::Texture(TextureKind::D2);
    /// `texture_3d`
    TEXTURE_3D = 14: Type::Texture(TextureKind::D3);
    /// `texture_cube`
    TEXTURE_CUBE = 15: Type::Texture(TextureKind::Cube);
    /// `texture_ptex`
    TEXTURE_PTEX = 16: Type::Texture(TextureKind::Ptex);
    /// `light_profile`
    LIGHT_PROFILE = 17: Type::LightProfile;
    /// `bsdf_measurement`
    BSDF_MEASUREMENT = 18: Type::BsdfMeasurement;
    /// `intensity_mode`
    INTENSITY_MODE = 19: Type::Enum(Arc::new(EnumType {
        name: "intensity_mode".into(),
        values: vec![("intensity_radiant_exitance".into(), 0), ("intensity_power".into(), 1)],
    }));
    /// `material_emission`
    MATERIAL_EMISSION = 20: language_struct("material_emission", &[
        ("emission", TypeId::EDF),
        ("intensity", TypeId::COLOR),
        ("mode", TypeId::INTENSITY_MODE),
    ]);
    /// `material_surface`
    MATERIAL_SURFACE = 21: language_struct("material_surface", &[
        ("scattering", TypeId::BSDF),
        ("emission", TypeId::MATERIAL_EMISSION),
    ]);
    /// `material_volume`
    MATERIAL_VOLUME = 22: language_struct("material_volume", &[
        ("scattering", TypeId::VDF),
        ("absorption_coefficient", TypeId::COLOR),
        ("scattering_coefficient", TypeId::COLOR),
        ("emission_intensity", TypeId::COLOR),
    ]);
    /// `material_geometry`
    MATERIAL_GEOMETRY = 23: language_struct("material_geometry", &[
        ("displacement", TypeId::FLOAT3),
        ("cutout_opacity", TypeId::FLOAT),
        ("normal", TypeId::FLOAT3),
    ]);
    /// `material`
    MATERIAL = 24: language_struct("material", &[
        ("thin_walled", TypeId::BOOL),
        ("surface", TypeId::MATERIAL_SURFACE),
        ("backface", TypeId::MATERIAL_SURFACE),
        ("ior", TypeId::COLOR),
        ("volume", TypeId::MATERIAL_VOLUME),
        ("geometry", TypeId::MATERIAL_GEOMETRY),
        ("hair", TypeId::HAIR_BSDF),
    ]);
}

fn language_struct(name: &str, fields: &[(&str, TypeId)]) -> Type {
    Type::Struct(Arc::new(StructType {
        name: name.into(),
        fields: fields.iter().map(|(name, ty)| ((*name).into(), *ty)).collect(),
    }))
}

/// Interner of types. Ids are stable: a table only grows.
#[derive(Clone, Debug)]
pub struct TypeTable {
    types: Vec<Type>,
    ids: HashMap<Type, TypeId>,
}

impl Default for TypeTable {
    fn default() -> Self {
        let types = fixed();
        let ids = types.iter().cloned().zip((0..).map(TypeId)).collect();
        Self { types, ids }
    }
}

impl TypeTable {
    /// The type with this id.
    pub fn get(&self, id: TypeId) -> &Type {
        &self.types[id.0 as usize]
    }

    /// The id of this type, added if it is new.
    pub fn intern(&mut self, ty: Type) -> TypeId {
        if let Some(&id) = self.ids.get(&ty) {
            return id;
        }
        let id = TypeId(self.types.len() as u32);
        self.types.push(ty.clone());
        self.ids.insert(ty, id);
        id
    }

    /// The id of this type, if the table has it.
    pub fn find(&self, ty: &Type) -> Option<TypeId> {
        self.ids.get(ty).copied()
    }

    /// The type as a user writes it, such as `float3` or `color[4]`.
    pub fn display(&self, id: TypeId) -> String {
        let scalar_name = |scalar: &Scalar| match scalar {
            Scalar::Bool => "bool",
            Scalar::Int => "int",
            Scalar::Float => "float",
            Scalar::Double => "double",
        };
        match self.get(id) {
            Type::Scalar(scalar) => scalar_name(scalar).to_string(),
            Type::Vector { scalar, size } => format!("{}{size}", scalar_name(scalar)),
            Type::Matrix { scalar, columns, rows } => format!("{}{columns}x{rows}", scalar_name(scalar)),
            Type::Color => "color".to_string(),
            Type::String => "string".to_string(),
            Type::Texture(TextureKind::D2) => "texture_2d".to_string(),
            Type::Texture(TextureKind::D3) => "texture_3d".to_string(),
            Type::Texture(TextureKind::Cube) => "texture_cube".to_string(),
            Type::Texture(TextureKind::Ptex) => "texture_ptex".to_string(),
            Type::LightProfile => "light_profile".to_string(),
            Type::BsdfMeasurement => "bsdf_measurement".to_string(),
            Type::Df(DfKind::Bsdf) => "bsdf".to_string(),
            Type::Df(DfKind::Edf) => "edf".to_string(),
            Type::Df(DfKind::Vdf) => "vdf".to_string(),
            Type::Df(DfKind::Hair) => "hair_bsdf".to_string(),
            Type::Enum(ty) => ty.name.to_string(),
            Type::Struct(ty) => ty.name.to_string(),
            Type::Array { element, size } => format!("{}[{size}]", self.display(*element)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixed_types_are_at_their_ids() {
        let mut table = TypeTable::default();
        assert_eq!(table.intern(Type::Color), TypeId::COLOR);
        assert_eq!(table.display(TypeId::MATERIAL), "material");
        assert_eq!(table.display(TypeId::FLOAT3), "float3");
    }

    #[test]
    fn equal_types_get_equal_ids() {
        let mut table = TypeTable::default();
        let array = Type::Array { element: TypeId::COLOR, size: 4 };
        let first = table.intern(array.clone());
        assert_eq!(first, table.intern(array));
        assert_eq!(table.display(first), "color[4]");
    }
}
