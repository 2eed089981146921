//! Numbers of glTF accessors, every place checked against the buffer.

use gltf::accessor::{Accessor, DataType, Dimensions};

/// The elements of an accessor as they lie in a buffer.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
    kind: DataType,
    components: usize,
    normalized: bool,
}

impl<'a> Elements<'a> {
    fn new(accessor: &Accessor<'_>, buffers: &'a [Vec<u8>]) -> Result<Self, String> {
        let fail = |what: &str| Err(format!("accessor {} {what}", accessor.index()));
        if accessor.sparse().is_some() {
            return fail("is sparse, which is not supported");
        }
        let Some(view) = accessor.view() else { return fail("has no data") };
        let Some(buffer) = buffers.get(view.buffer().index()) else { return fail("has no buffer") };
        let view_end = view.offset().checked_add(view.length());
        let Some(view_bytes) = view_end.and_then(|end| buffer.get(view.offset()..end)) else {
            return fail("lies in a view that exceeds its buffer");
        };
        let size = accessor.size();
        let stride = view.stride().unwrap_or(size);
        if stride < size {
            return fail("has elements that overlap");
        }
        let count = accessor.count();
        let length = count.checked_sub(1).and_then(|n| n.checked_mul(stride)?.checked_add(size)).unwrap_or(0);
        let end = accessor.offset().checked_add(length);
        let Some(bytes) = end.and_then(|end| view_bytes.get(accessor.offset()..end)) else {
            return fail("exceeds its view");
        };
        let components = match accessor.dimensions() {
            Dimensions::Scalar => 1,
            Dimensions::Vec2 => 2,
            Dimensions::Vec3 => 3,
            Dimensions::Vec4 => 4,
            _ => return fail("holds matrices"),
        };
        let (kind, normalized) = (accessor.data_type(), accessor.normalized());
        Ok(Self { bytes, stride, count, kind, components, normalized })
    }

    fn element(&self, index: usize) -> &'a [u8] {
        &self.bytes[index * self.stride..]
    }
}

/// Vectors of `N` floats; integers are taken as the specification says (§3.6.2.2).
pub(super) fn vectors<const N: usize>(
    accessor: &Accessor<'_>,
    buffers: &[Vec<u8>],
) -> Result<Vec<[f32; N]>, String> {
    let elements = Elements::new(accessor, buffers)?;
    if elements.components != N {
        let (index, found) = (accessor.index(), elements.components);
        return Err(format!("accessor {index} has {found} components instead of {N}"));
    }
    let scale = |most: f32| if elements.normalized { 1.0 / most } else { 1.0 };
    let low = if elements.normalized { -1.0 } else { f32::NEG_INFINITY };
    let vector = |index: usize| {
        let bytes = elements.element(index);
        std::array::from_fn(|c| match elements.kind {
            DataType::F32 => f32::from_le_bytes(at(bytes, c)),
            DataType::U8 => f32::from(bytes[c]) * scale(255.0),
            DataType::I8 => (f32::from(bytes[c] as i8) * scale(127.0)).max(low),
            DataType::U16 => f32::from(u16::from_le_bytes(at(bytes, c))) * scale(65_535.0),
            DataType::I16 => (f32::from(i16::from_le_bytes(at(bytes, c))) * scale(32_767.0)).max(low),
            DataType::U32 => u32::from_le_bytes(at(bytes, c)) as f32,
        })
    };
    Ok((0..elements.count).map(vector).collect())
}

/// Indices of vertices.
pub(super) fn indices(accessor: &Accessor<'_>, buffers: &[Vec<u8>]) -> Result<Vec<u32>, String> {
    let elements = Elements::new(accessor, buffers)?;
    let read: fn(&[u8]) -> u32 = match (elements.kind, elements.components) {
        (DataType::U8, 1) => |b| b[0].into(),
        (DataType::U16, 1) => |b| u16::from_le_bytes(at(b, 0)).into(),
        (DataType::U32, 1) => |b| u32::from_le_bytes(at(b, 0)),
        _ => return Err(format!("accessor {} does not hold indices", accessor.index())),
    };
    Ok((0..elements.count).map(|i| read(elements.element(i))).collect())
}

/// Component `index` of `N` bytes.
fn at<const N: usize>(bytes: &[u8], index: usize) -> [u8; N] {
    std::array::from_fn(|i| bytes[index * N + i])
}
