//! Types as the executors see them: trees of scalar leaves.
//!
//! A value of any type is the sequence of its scalar *leaves*: a vector's components, a matrix's
//! columns one after another, a struct's members in order, an array's elements in order. Executors
//! store and pass leaves and nothing else; bytes matter only in buffers.
//!
//! A leaf's *class* is its position when every array is taken as one element. Storage decisions that
//! must hold for all elements of an array (is this field one value for all lanes?) are made per class.

use naga::{ArraySize, Handle, ScalarKind, TypeInner};
use std::collections::HashMap;

use crate::error::Unsupported;

/// The type of a scalar leaf.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// A truth value.
    Bool,
    /// 32-bit signed integer.
    I32,
    /// 32-bit unsigned integer.
    U32,
    /// 32-bit float: the interpreter's `Real`.
    F32,
    /// 64-bit signed integer.
    I64,
    /// 64-bit unsigned integer.
    U64,
    /// 64-bit float.
    F64,
}

impl Kind {
    /// Whether values of this kind are floats.
    pub fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    /// Whether values of this kind are signed integers.
    pub fn is_signed(self) -> bool {
        matches!(self, Self::I32 | Self::I64)
    }

    /// Whether values of this kind take 64 bits.
    pub fn is_wide(self) -> bool {
        matches!(self, Self::I64 | Self::U64 | Self::F64)
    }

    fn of(scalar: naga::Scalar) -> Result<Self, Unsupported> {
        Ok(match (scalar.kind, scalar.width) {
            (ScalarKind::Bool, _) => Self::Bool,
            (ScalarKind::Sint, 4) => Self::I32,
            (ScalarKind::Uint, 4) => Self::U32,
            (ScalarKind::Float, 4) => Self::F32,
            (ScalarKind::Sint, 8) => Self::I64,
            (ScalarKind::Uint, 8) => Self::U64,
            (ScalarKind::Float, 8) => Self::F64,
            _ => return Err(Unsupported::Type(format!("{scalar:?}"))),
        })
    }

    /// The kind that naga writes as `kind` with `width` bytes.
    pub(crate) fn from_naga(kind: ScalarKind, width: u8) -> Result<Self, Unsupported> {
        Self::of(naga::Scalar { kind, width })
    }
}

/// Index of a type in [`Types`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TyId(u32);

/// A member of a struct.
#[derive(Clone, Copy, Debug)]
pub struct Member {
    /// Its type.
    pub ty: TyId,
    /// Leaves before it.
    pub leaf: u32,
    /// Classes before it.
    pub class: u32,
    /// Bytes before it in a buffer.
    pub byte: u32,
}

/// What a type is made of.
#[derive(Clone, Debug)]
pub enum Shape {
    /// One leaf.
    Scalar(Kind),
    /// `size` leaves.
    Vector {
        /// Number of components.
        size: u32,
        /// Type of a component.
        kind: Kind,
    },
    /// `columns` vectors of `rows` leaves.
    Matrix {
        /// Number of columns.
        columns: u32,
        /// Number of rows.
        rows: u32,
        /// Type of an entry.
        kind: Kind,
    },
    /// `len` elements; `None` is as many as its buffer holds.
    Array {
        /// Element type.
        elem: TyId,
        /// Number of elements.
        len: Option<u32>,
        /// Bytes from element to element in a buffer.
        stride: u32,
    },
    /// Members in order.
    Struct(Vec<Member>),
    /// A pointer to a value of another type.
    Pointer(TyId),
    /// An image, a sampler or another type that executors do not store.
    Opaque(String),
}

/// A type with its counts.
#[derive(Clone, Debug)]
pub struct Type {
    /// What it is made of.
    pub shape: Shape,
    /// Number of leaves; a runtime-sized array counts as none, a pointer as none.
    pub leaves: u32,
    /// Number of classes.
    pub classes: u32,
}

/// Values of more leaves than this are only accessed in buffers.
const MAX_LEAVES: u32 = 1 << 16;

/// All types of a module, with those that naga gives expressions without an entry in its arena.
#[derive(Debug, Default)]
pub struct Types {
    list: Vec<Type>,
    named: Vec<TyId>,
    loose: HashMap<TypeInner, TyId>,
}

impl std::ops::Index<TyId> for Types {
    type Output = Type;
    fn index(&self, id: TyId) -> &Type {
        &self.list[id.0 as usize]
    }
}

impl Types {
    /// Resolves all types of `module`.
    pub fn new(module: &naga::Module) -> Self {
        let mut types = Self::default();
        // An arena's types only refer to earlier ones.
        for (_, ty) in module.types.iter() {
            let id = types.add(&ty.inner);
            types.named.push(id);
        }
        types
    }

    /// A type of naga's arena.
    pub fn named(&self, handle: Handle<naga::Type>) -> TyId {
        self.named[handle.index()]
    }

    /// A type that an expression has.
    pub fn resolution(&mut self, resolution: &naga::proc::TypeResolution) -> TyId {
        match resolution {
            naga::proc::TypeResolution::Handle(h) => self.named(*h),
            naga::proc::TypeResolution::Value(inner) => match self.loose.get(inner) {
                Some(&id) => id,
                None => {
                    let id = self.add(inner);
                    self.loose.insert(inner.clone(), id);
                    id
                }
            },
        }
    }

    fn push(&mut self, shape: Shape, leaves: u32, classes: u32) -> TyId {
        self.list.push(Type { shape, leaves, classes });
        TyId(self.list.len() as u32 - 1)
    }

    fn add(&mut self, inner: &TypeInner) -> TyId {
        match self.build(inner) {
            Ok((shape, leaves, classes)) => self.push(shape, leaves, classes),
            Err(e) => self.push(Shape::Opaque(e.to_string()), 0, 0),
        }
    }

    fn build(&mut self, inner: &TypeInner) -> Result<(Shape, u32, u32), Unsupported> {
        Ok(match *inner {
            TypeInner::Scalar(s) => (Shape::Scalar(Kind::of(s)?), 1, 1),
            TypeInner::Vector { size, scalar } => {
                let size = size as u32;
                (Shape::Vector { size, kind: Kind::of(scalar)? }, size, size)
            }
            TypeInner::Matrix { columns, rows, scalar } => {
                let (columns, rows) = (columns as u32, rows as u32);
                let n = columns * rows;
                (Shape::Matrix { columns, rows, kind: Kind::of(scalar)? }, n, n)
            }
            TypeInner::Array { base, size, stride } => {
                let elem = self.named(base);
                let len = match size {
                    ArraySize::Constant(n) => Some(n.get()),
                    ArraySize::Dynamic => None,
                    ArraySize::Pending(_) => return Err(Unsupported::Override),
                };
                let leaves = self[elem].leaves.saturating_mul(len.unwrap_or(0));
                (Shape::Array { elem, len, stride }, leaves, self[elem].classes)
            }
            TypeInner::Struct { ref members, .. } => {
                let (mut leaves, mut classes) = (0u32, 0);
                let mut list = Vec::with_capacity(members.len());
                for m in members {
                    let ty = self.named(m.ty);
                    list.push(Member { ty, leaf: leaves, class: classes, byte: m.offset });
                    leaves = leaves.saturating_add(self[ty].leaves);
                    classes += self[ty].classes;
                }
                (Shape::Struct(list), leaves, classes)
            }
            TypeInner::Pointer { base, .. } => (Shape::Pointer(self.named(base)), 0, 0),
            TypeInner::ValuePointer { size, scalar, .. } => {
                let inner = match size {
                    Some(size) => TypeInner::Vector { size, scalar },
                    None => TypeInner::Scalar(scalar),
                };
                (Shape::Pointer(self.add(&inner)), 0, 0)
            }
            ref other => return Err(Unsupported::Type(format!("{other:?}"))),
        })
    }

    /// The kinds of all leaves in order. Fails for opaque, runtime-sized and very large types.
    pub fn kinds(&self, id: TyId) -> Result<Vec<Kind>, Unsupported> {
        let ty = &self[id];
        if ty.leaves > MAX_LEAVES {
            return Err(Unsupported::TooLarge);
        }
        let mut out = Vec::with_capacity(ty.leaves as usize);
        self.collect_kinds(id, &mut out)?;
        Ok(out)
    }

    fn collect_kinds(&self, id: TyId, out: &mut Vec<Kind>) -> Result<(), Unsupported> {
        let ty = &self[id];
        match ty.shape {
            Shape::Scalar(kind) | Shape::Vector { kind, .. } | Shape::Matrix { kind, .. } => {
                out.extend(std::iter::repeat_n(kind, ty.leaves as usize));
            }
            Shape::Array { elem, len: Some(len), .. } => {
                let start = out.len();
                self.collect_kinds(elem, out)?;
                let end = out.len();
                (1..len).for_each(|_| out.extend_from_within(start..end));
            }
            Shape::Struct(ref members) => {
                for m in members {
                    self.collect_kinds(m.ty, out)?;
                }
            }
            Shape::Array { len: None, .. } | Shape::Pointer(_) => return Err(Unsupported::Whole),
            Shape::Opaque(ref what) => return Err(Unsupported::Type(what.clone())),
        }
        Ok(())
    }

    /// The class of every leaf in order. Fails as [`Self::kinds`] does.
    pub fn classes(&self, id: TyId) -> Result<Vec<u32>, Unsupported> {
        if self[id].leaves > MAX_LEAVES {
            return Err(Unsupported::TooLarge);
        }
        let mut out = Vec::with_capacity(self[id].leaves as usize);
        self.collect_classes(id, 0, &mut out);
        Ok(out)
    }

    fn collect_classes(&self, id: TyId, first: u32, out: &mut Vec<u32>) {
        match self[id].shape {
            Shape::Array { elem, len, .. } => {
                for _ in 0..len.unwrap_or(0) {
                    self.collect_classes(elem, first, out);
                }
            }
            Shape::Struct(ref members) => {
                for m in members {
                    self.collect_classes(m.ty, first + m.class, out);
                }
            }
            _ => out.extend(first..first + self[id].leaves),
        }
    }

    /// The kind and the byte offset in a buffer of all leaves in order. Fails as [`Self::kinds`] does.
    pub fn bytes(&self, id: TyId) -> Result<Vec<(Kind, u32)>, Unsupported> {
        if self[id].leaves > MAX_LEAVES {
            return Err(Unsupported::TooLarge);
        }
        let mut out = Vec::with_capacity(self[id].leaves as usize);
        self.collect_bytes(id, 0, &mut out)?;
        Ok(out)
    }

    fn collect_bytes(&self, id: TyId, at: u32, out: &mut Vec<(Kind, u32)>) -> Result<(), Unsupported> {
        match self[id].shape {
            Shape::Scalar(kind) => out.push((kind, at)),
            Shape::Vector { size, kind } => out.extend((0..size).map(|i| (kind, at + i * width(kind)))),
            Shape::Matrix { columns, rows, kind } => {
                let stride = column_stride(rows, kind);
                for c in 0..columns {
                    out.extend((0..rows).map(|r| (kind, at + c * stride + r * width(kind))));
                }
            }
            Shape::Array { elem, len: Some(len), stride } => {
                for i in 0..len {
                    self.collect_bytes(elem, at + i * stride, out)?;
                }
            }
            Shape::Struct(ref members) => {
                for m in members {
                    self.collect_bytes(m.ty, at + m.byte, out)?;
                }
            }
            Shape::Array { len: None, .. } | Shape::Pointer(_) => return Err(Unsupported::Whole),
            Shape::Opaque(ref what) => return Err(Unsupported::Type(what.clone())),
        }
        Ok(())
    }

    /// The parts that an index can pick from a value of this type.
    pub fn parts(&mut self, id: TyId) -> Option<Parts> {
        Some(match self[id].shape {
            Shape::Vector { size, kind } => {
                let ty = self.scalar(kind);
                Parts { ty, count: Some(size), leaves: 1, bytes: width(kind), classes: 1 }
            }
            Shape::Matrix { columns, rows, kind } => {
                let ty = self.vector(rows, kind);
                let bytes = column_stride(rows, kind);
                Parts { ty, count: Some(columns), leaves: rows, bytes, classes: rows }
            }
            Shape::Array { elem, len, stride } => {
                Parts { ty: elem, count: len, leaves: self[elem].leaves, bytes: stride, classes: 0 }
            }
            _ => return None,
        })
    }

    fn scalar(&mut self, kind: Kind) -> TyId {
        let found = self.list.iter().position(|t| matches!(t.shape, Shape::Scalar(k) if k == kind));
        found.map_or_else(|| self.push(Shape::Scalar(kind), 1, 1), |i| TyId(i as u32))
    }

    fn vector(&mut self, size: u32, kind: Kind) -> TyId {
        let found = self
            .list
            .iter()
            .position(|t| matches!(t.shape, Shape::Vector { size: s, kind: k } if s == size && k == kind));
        found.map_or_else(|| self.push(Shape::Vector { size, kind }, size, size), |i| TyId(i as u32))
    }
}

/// The equal parts of a vector, matrix or array.
#[derive(Clone, Copy, Debug)]
pub struct Parts {
    /// The type of a part.
    pub ty: TyId,
    /// How many there are; `None` is as many as the buffer holds.
    pub count: Option<u32>,
    /// Leaves of a part.
    pub leaves: u32,
    /// Bytes from part to part in a buffer.
    pub bytes: u32,
    /// Classes from part to part: none for the elements of an array, which share theirs.
    pub classes: u32,
}

/// Bytes of a scalar in a buffer.
pub(crate) fn width(kind: Kind) -> u32 {
    if kind.is_wide() { 8 } else { 4 }
}

/// Bytes from column to column of a matrix in a buffer: three rows are aligned as four.
fn column_stride(rows: u32, kind: Kind) -> u32 {
    width(kind) * if rows == 3 { 4 } else { rows }
}
