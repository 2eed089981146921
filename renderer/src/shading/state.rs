//! Filling the columns that materials ask for.

use super::frame::ShadingFrame;
use crate::scene::{Scene, Surface};
use glam::Vec3;
use mdl_jit::state::{StateBatch, StateField, StateFields};

const COORDINATES: [StateField; 4] = [
    StateField::TextureCoordinate0,
    StateField::TextureCoordinate1,
    StateField::TextureCoordinate2,
    StateField::TextureCoordinate3,
];
const TANGENTS: [(StateField, StateField); 4] = [
    (StateField::TextureTangentU0, StateField::TextureTangentV0),
    (StateField::TextureTangentU1, StateField::TextureTangentV1),
    (StateField::TextureTangentU2, StateField::TextureTangentV2),
    (StateField::TextureTangentU3, StateField::TextureTangentV3),
];

/// Sets what `batch` has of a point in row `row`. `normal` is the unit shading normal of the outer side.
pub fn fill(batch: &mut StateBatch, row: usize, scene: &Scene, surface: &Surface, normal: Vec3) {
    let fields = batch.fields();
    if fields == StateFields::NONE {
        return;
    }
    if fields.contains(StateField::Position) {
        let position = scene.described(surface.point.position);
        batch.set(StateField::Position, row, position.to_array());
    }
    batch.set(StateField::GeometryNormal, row, surface.geometry_normal.to_array());
    batch.set(StateField::Motion, row, [0.0; 3]);
    batch.set(StateField::Direction, row, [0.0; 3]);
    batch.set(StateField::Toward, row, [0.0; 3]);
    for (set, field) in COORDINATES.into_iter().enumerate() {
        if fields.contains(field) {
            batch.set(field, row, scene.texture_coordinate(surface, set).to_array());
        }
    }
    let object = scene.places[surface.instance as usize].object_id;
    batch.set(StateField::ObjectId, row, [f32::from_bits(object as u32)]);
    batch.set(StateField::Instance, row, [f32::from_bits(surface.instance)]);
    fill_normal(batch, row, scene, surface, normal);
}

/// Sets what depends on the shading normal of the outer side.
pub fn fill_normal(batch: &mut StateBatch, row: usize, scene: &Scene, surface: &Surface, normal: Vec3) {
    let fields = batch.fields();
    batch.set(StateField::Normal, row, normal.to_array());
    for (set, (u, v)) in TANGENTS.into_iter().enumerate() {
        if fields.contains(u) || fields.contains(v) {
            let tangents = scene.tangents(surface, set, normal);
            batch.set(u, row, tangents.0.to_array());
            batch.set(v, row, tangents.1.to_array());
        }
    }
}

/// Sets the local frame.
pub fn fill_frame(batch: &mut StateBatch, row: usize, frame: &ShadingFrame) {
    batch.set(StateField::FrameX, row, frame.x.to_array());
    batch.set(StateField::FrameY, row, frame.y.to_array());
    batch.set(StateField::FrameZ, row, frame.z.to_array());
}
