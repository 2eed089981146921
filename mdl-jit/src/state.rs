//! The shading state: what a material may ask about a point, in columns.
//!
//! A renderer fills the columns that the materials of a batch need, and no others: [`StateFields`] says
//! which. All vectors are in the renderer's world space, which is MDL's *internal* space here.
//!
//! A lookup of the environment has a state, too: its direction, and zero in all other fields, as
//! [`StateBatch::reset`] leaves them; it is at the origin of an object that lies where the world has it.

/// Texture spaces that a state can hold.
pub const TEXTURE_SPACES: usize = 4;

macro_rules! fields {
    ($($(#[$doc:meta])* $name:ident: $components:literal;)*) => {
        /// A field of the state.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[repr(u8)]
        pub enum StateField { $($(#[$doc])* $name),* }

        impl StateField {
            /// All fields in order.
            pub const ALL: &'static [StateField] = &[$(StateField::$name),*];

            /// Number of columns of the field.
            pub const fn components(self) -> usize {
                match self { $(StateField::$name => $components),* }
            }
        }
    };
}

fields! {
    /// `state::position()`
    Position: 3;
    /// `state::normal()`: the shading normal of the outer side, unit length, not turned to the viewer.
    Normal: 3;
    /// `state::geometry_normal()`
    GeometryNormal: 3;
    /// `state::motion()`
    Motion: 3;
    /// `state::direction()`: where the environment is looked up, unit length; zero on surfaces.
    Direction: 3;
    /// `state::texture_coordinate(0)`
    TextureCoordinate0: 3;
    /// `state::texture_coordinate(1)`
    TextureCoordinate1: 3;
    /// `state::texture_coordinate(2)`
    TextureCoordinate2: 3;
    /// `state::texture_coordinate(3)`
    TextureCoordinate3: 3;
    /// `state::texture_tangent_u(0)`, unit length, perpendicular to the normal.
    TextureTangentU0: 3;
    /// `state::texture_tangent_u(1)`
    TextureTangentU1: 3;
    /// `state::texture_tangent_u(2)`
    TextureTangentU2: 3;
    /// `state::texture_tangent_u(3)`
    TextureTangentU3: 3;
    /// `state::texture_tangent_v(0)`
    TextureTangentV0: 3;
    /// `state::texture_tangent_v(1)`
    TextureTangentV1: 3;
    /// `state::texture_tangent_v(2)`
    TextureTangentV2: 3;
    /// `state::texture_tangent_v(3)`
    TextureTangentV3: 3;
    /// x axis of the local frame that the BSDF is evaluated in.
    FrameX: 3;
    /// y axis of the local frame.
    FrameY: 3;
    /// z axis of the local frame: the shading normal on the side of the viewer.
    FrameZ: 3;
    /// For emission: where it is seen from, unit length; zero otherwise.
    Toward: 3;
    /// `state::object_id()`, bits of an `i32`.
    ObjectId: 1;
    /// Index of the instance, bits of a `u32`: selects its transforms.
    Instance: 1;
}

/// A set of fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct StateFields(u32);

impl StateFields {
    /// No field.
    pub const NONE: StateFields = StateFields(0);

    /// The set with `field` added.
    pub const fn with(self, field: StateField) -> Self {
        Self(self.0 | 1 << field as u32)
    }

    /// Whether `field` is in the set.
    pub const fn contains(self, field: StateField) -> bool {
        self.0 & 1 << field as u32 != 0
    }

    /// Fields of either set.
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// The fields in order.
    pub fn iter(self) -> impl Iterator<Item = StateField> {
        StateField::ALL.iter().copied().filter(move |field| self.contains(*field))
    }
}

/// States of a batch of points, one column per component of each field that is present.
#[derive(Clone, Debug, Default)]
pub struct StateBatch {
    len: usize,
    fields: StateFields,
    columns: Vec<Vec<f32>>,
}

impl StateBatch {
    /// Makes room for `len` points with these fields. Memory is kept from earlier use, and its values are
    /// of no meaning; new memory holds zeros.
    pub fn reset(&mut self, len: usize, fields: StateFields) {
        self.len = len;
        self.fields = fields;
        let total: usize = StateField::ALL.iter().map(|field| field.components()).sum();
        self.columns.resize_with(total, Vec::new);
        for field in fields.iter() {
            let first = Self::first_column(field);
            for column in &mut self.columns[first..first + field.components()] {
                column.resize(len, 0.0);
            }
        }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The fields that are present.
    pub fn fields(&self) -> StateFields {
        self.fields
    }

    /// The columns of a field that is present.
    pub fn columns(&self, field: StateField) -> &[Vec<f32>] {
        debug_assert!(self.fields.contains(field), "{field:?} was not asked for");
        let first = Self::first_column(field);
        &self.columns[first..first + field.components()]
    }

    /// Sets a field of point `index`, if the field is present.
    #[inline]
    pub fn set<const N: usize>(&mut self, field: StateField, index: usize, value: [f32; N]) {
        if self.fields.contains(field) {
            debug_assert_eq!(N, field.components());
            let first = Self::first_column(field);
            for (column, value) in self.columns[first..first + N].iter_mut().zip(value) {
                column[index] = value;
            }
        }
    }

    fn first_column(field: StateField) -> usize {
        StateField::ALL[..field as usize].iter().map(|field| field.components()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_fields_asked_for_take_memory() {
        let mut batch = StateBatch::default();
        batch.reset(5, StateFields::NONE.with(StateField::Normal));
        batch.set(StateField::Normal, 3, [1.0, 2.0, 3.0]);
        batch.set(StateField::Position, 3, [9.0; 3]);
        assert_eq!(batch.columns(StateField::Normal)[1][3], 2.0);
        assert_eq!(batch.columns.iter().filter(|column| !column.is_empty()).count(), 3);
    }
}
