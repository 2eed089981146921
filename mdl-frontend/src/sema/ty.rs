//! Types while modules are checked.
//!
//! Unlike a [`crate::types::TypeId`], a [`Ty`] means the same in all modules, and the size of an array
//! may still be open.

use crate::fold::Target;
use crate::syntax::token::Builtin;
use crate::types::{DfKind, Scalar, TextureKind, Type};

/// Number of a module among those that a compiler has seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ModuleId(pub u32);

impl ModuleId {
    /// What the language itself declares: `intensity_mode` and the material structs.
    pub const LANGUAGE: ModuleId = ModuleId(0);
}

/// A declaration: its module and its index among the declarations of its kind there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct DefId {
    /// The module.
    pub module: ModuleId,
    /// The index.
    pub index: u32,
}

impl DefId {
    const fn language(index: u32) -> Self {
        Self { module: ModuleId::LANGUAGE, index }
    }
}

/// A type without an array around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Base {
    /// Of what could not be understood; compatible with everything, so that no error follows another.
    Error,
    /// `float` and its like.
    Scalar(Scalar),
    /// Component type and count.
    Vector(Scalar, u8),
    /// Component type, columns, rows.
    Matrix(Scalar, u8, u8),
    /// `color`
    Color,
    /// `string`
    String,
    /// `texture_2d` and its like.
    Texture(TextureKind),
    /// `light_profile`
    LightProfile,
    /// `bsdf_measurement`
    BsdfMeasurement,
    /// `bsdf` and its like.
    Df(DfKind),
    /// An enumeration.
    Enum(DefId),
    /// A struct, `material` among them.
    Struct(DefId),
}

/// Number of a symbol for an open array size in its function, such as `N` of `float[<N>] x`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SymbolId(pub u32);

/// Size of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Size {
    /// Known.
    Known(u32),
    /// Known only when the function is called.
    Symbol(SymbolId),
}

/// A type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Ty {
    /// The type, or of an array the type of its elements.
    pub base: Base,
    /// Of an array its size.
    pub size: Option<Size>,
}

impl Ty {
    /// Of what could not be understood.
    pub const ERROR: Ty = Ty::of(Base::Error);
    /// `bool`
    pub const BOOL: Ty = Ty::of(Base::Scalar(Scalar::Bool));
    /// `int`
    pub const INT: Ty = Ty::of(Base::Scalar(Scalar::Int));
    /// `float`
    pub const FLOAT: Ty = Ty::of(Base::Scalar(Scalar::Float));
    /// `double`
    pub const DOUBLE: Ty = Ty::of(Base::Scalar(Scalar::Double));
    /// `float3`
    pub const FLOAT3: Ty = Ty::of(Base::Vector(Scalar::Float, 3));
    /// `color`
    pub const COLOR: Ty = Ty::of(Base::Color);
    /// `string`
    pub const STRING: Ty = Ty::of(Base::String);
    /// `bsdf`
    pub const BSDF: Ty = Ty::of(Base::Df(DfKind::Bsdf));
    /// `intensity_mode`
    pub const INTENSITY_MODE: Ty = Ty::of(Base::Enum(DefId::language(0)));
    /// `material_emission`
    pub const MATERIAL_EMISSION: Ty = Ty::of(Base::Struct(DefId::language(0)));
    /// `material_surface`
    pub const MATERIAL_SURFACE: Ty = Ty::of(Base::Struct(DefId::language(1)));
    /// `material_volume`
    pub const MATERIAL_VOLUME: Ty = Ty::of(Base::Struct(DefId::language(2)));
    /// `material_geometry`
    pub const MATERIAL_GEOMETRY: Ty = Ty::of(Base::Struct(DefId::language(3)));
    /// `material`
    pub const MATERIAL: Ty = Ty::of(Base::Struct(DefId::language(4)));

    /// A type that is no array.
    pub const fn of(base: Base) -> Self {
        Self { base, size: None }
    }

    /// An array of it.
    pub const fn array(base: Base, size: Size) -> Self {
        Self { base, size: Some(size) }
    }

    /// The type behind a keyword.
    pub fn builtin(builtin: Builtin) -> Self {
        Self::of(match builtin {
            Builtin::Scalar(scalar) => Base::Scalar(scalar),
            Builtin::Vector(scalar, size) => Base::Vector(scalar, size),
            Builtin::Matrix(scalar, columns, rows) => Base::Matrix(scalar, columns, rows),
            Builtin::Color => Base::Color,
            Builtin::String => Base::String,
            Builtin::Texture(kind) => Base::Texture(kind),
            Builtin::LightProfile => Base::LightProfile,
            Builtin::BsdfMeasurement => Base::BsdfMeasurement,
            Builtin::Df(kind) => Base::Df(kind),
            Builtin::IntensityMode => return Self::INTENSITY_MODE,
            Builtin::MaterialEmission => return Self::MATERIAL_EMISSION,
            Builtin::MaterialSurface => return Self::MATERIAL_SURFACE,
            Builtin::MaterialVolume => return Self::MATERIAL_VOLUME,
            Builtin::MaterialGeometry => return Self::MATERIAL_GEOMETRY,
            Builtin::Material => return Self::MATERIAL,
        })
    }

    /// It could not be understood.
    pub fn is_error(self) -> bool {
        self.base == Base::Error
    }

    /// The type of an element of an array.
    pub fn element(self) -> Ty {
        Ty::of(self.base)
    }

    /// The scalar that the type consists of, for scalars, vectors and matrices.
    pub fn scalar(self) -> Option<Scalar> {
        match (self.base, self.size) {
            (Base::Scalar(scalar) | Base::Vector(scalar, _) | Base::Matrix(scalar, ..), None) => Some(scalar),
            _ => None,
        }
    }

    /// A reference to a file: a texture, light profile or measurement.
    pub fn is_resource(self) -> bool {
        matches!(self.base, Base::Texture(_) | Base::LightProfile | Base::BsdfMeasurement)
    }

    /// The type of a distribution function, or one of the language's structs that hold them.
    pub fn is_declarative(self) -> bool {
        match self.base {
            Base::Df(_) => true,
            Base::Struct(id) => id.module == ModuleId::LANGUAGE,
            _ => false,
        }
    }

    /// The type of a graph behind a type that is declared by no module and no array.
    pub fn simple(self) -> Option<Type> {
        Some(match (self.base, self.size) {
            (_, Some(_)) | (Base::Error | Base::Enum(_) | Base::Struct(_), _) => return None,
            (Base::Scalar(scalar), _) => Type::Scalar(scalar),
            (Base::Vector(scalar, size), _) => Type::Vector { scalar, size },
            (Base::Matrix(scalar, columns, rows), _) => Type::Matrix { scalar, columns, rows },
            (Base::Color, _) => Type::Color,
            (Base::String, _) => Type::String,
            (Base::Texture(kind), _) => Type::Texture(kind),
            (Base::LightProfile, _) => Type::LightProfile,
            (Base::BsdfMeasurement, _) => Type::BsdfMeasurement,
            (Base::Df(kind), _) => Type::Df(kind),
        })
    }

    /// What a conversion to the type makes of a constant.
    pub fn target(self) -> Target {
        self.simple().map_or(Target::Same, |ty| Target::of(&ty))
    }
}
