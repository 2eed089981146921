//! Compilation of scenes.

use super::compiled::SceneError;
use super::description::*;
use super::sanitise::{Repairs, sanitise};
use super::*;
use crate::camera::{Camera, FieldOfView};
use crate::geometry::Ray;
use crate::geometry::traverse::Filter;
use crate::scenes::shapes;
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec2, Vec3, Vec4};

fn describe(meshes: Vec<Mesh>, instances: Vec<Instance>) -> SceneDescription {
    SceneDescription {
        meshes,
        instances,
        materials: vec!["a".to_string(), "b".to_string()],
        camera: Camera::look_at(DVec3::Z * 5.0, DVec3::ZERO, FieldOfView::Vertical(40.0)),
        environment: Environment::None,
        background_visible: true,
        meters_per_unit: 1.0,
    }
}

fn sphere() -> Mesh {
    let (positions, triangles) = shapes::icosphere(3);
    Mesh { name: "sphere".to_string(), normals: positions.clone(), positions, triangles, ..Mesh::default() }
}

fn quad() -> Mesh {
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
    let uvs = vec![Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], uvs: vec![uvs], ..Mesh::default() }
}

fn hit(scene: &Scene, ray: Ray) -> Surface {
    let hit = scene.accel.closest(ray, Filter::All, &mut scene.accel.stack());
    assert!(hit.is_some());
    scene.surface(&hit)
}

#[test]
fn broken_triangles_are_dropped_and_counted() {
    let mut mesh = quad();
    mesh.positions.extend([
        Vec3::splat(f32::NAN),
        Vec3::splat(f32::INFINITY),
        Vec3::splat(1e30),
        Vec3::X * 0.5,
    ]);
    mesh.uvs[0].extend([Vec2::ZERO; 4]);
    mesh.triangles.extend([[0, 1, 4], [0, 5, 1], [6, 1, 2], [0, 0, 1], [0, 7, 1], [0, 1, 99]]);
    mesh.groups = vec![1, 0, 0, 0, 0, 0, 0, 0];
    let repairs = sanitise(&mut mesh);
    assert_eq!(repairs, Repairs { broken: 4, degenerate: 2, ..Repairs::default() });
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.groups, [1, 0]);
    assert_eq!(repairs.messages().len(), 2);
}

#[test]
fn mesh_wound_against_its_normals_is_turned() {
    let mut mesh = sphere();
    mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert_eq!(sanitise(&mut mesh).turned, 1);
    assert_eq!(sanitise(&mut mesh).turned, 0);
}

#[test]
fn normals_point_outwards_under_every_transform() {
    let turn = DQuat::from_rotation_x(0.4) * DQuat::from_rotation_z(1.1);
    for scale in [DVec3::new(1e-6, 2e-6, 1e-6), DVec3::new(-2.0, 1.0, 0.3), DVec3::new(-1.0, -1.0, -3.0)] {
        let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.7, 1.0, 0.0), DVec3::Z);
        let linear = DMat3::from_quat(turn) * shear * DMat3::from_diagonal(scale);
        let transform = DAffine3 { matrix3: linear, translation: DVec3::new(1.0, 2.0, 3.0) * 1e-3 };
        let one = Instance { transform, ..Instance::new(0, 0) };
        let far = Instance { transform: DAffine3::from_translation(DVec3::X * 1e3), ..Instance::new(0, 0) };
        let baked = Scene::new(describe(vec![sphere()], vec![one.clone()])).expect("valid");
        let placed = Scene::new(describe(vec![sphere()], vec![one, far])).expect("valid");
        assert!(baked.places[0].transforms.is_none() && placed.places[0].transforms.is_some());
        for (x, y) in [(0.1, 0.2), (-0.5, 0.3), (0.7, -0.6)] {
            let local = DVec3::new(x, y, (1.0f64 - x * x - y * y).sqrt());
            let center = transform.transform_point3(DVec3::ZERO);
            let on_surface = transform.transform_point3(local);
            let ray = Ray::new(center.as_vec3(), (on_surface - center).as_vec3());
            for scene in [&baked, &placed] {
                let surface = hit(scene, ray);
                let exact = (linear.inverse().transpose() * local).normalize().as_vec3();
                assert!(surface.geometry_normal.dot(ray.direction) > 0.0);
                assert!((surface.normal.length() - 1.0).abs() < 1e-5);
                assert!(surface.normal.dot(exact) > 0.98, "{scale} {}", surface.normal.dot(exact));
            }
            let (a, b) = (hit(&baked, ray), hit(&placed, ray));
            // The smallest sphere is 3000 times closer to the origin than it is large.
            assert!((a.normal - b.normal).length() < 1e-3);
        }
    }
}

#[test]
fn tangents_follow_the_coordinates_also_mirrored() {
    let transforms = [
        DAffine3::IDENTITY,
        DAffine3::from_scale(DVec3::new(-2.0, 1.0, 1.0)),
        DAffine3::from_scale_rotation_translation(
            DVec3::new(1.0, 3.0, -1.0),
            DQuat::from_rotation_y(0.6),
            DVec3::ONE,
        ),
    ];
    for transform in transforms {
        for copies in [1, 2] {
            let instance = Instance { transform, ..Instance::new(0, 0) };
            let far = Instance { transform: DAffine3::from_translation(DVec3::X * 99.0), ..instance.clone() };
            let instances = if copies == 1 { vec![instance] } else { vec![instance, far] };
            let scene = Scene::new(describe(vec![quad()], instances)).expect("valid");
            let surface = scene.surface_at(0, 0, 0.3, 0.4);
            let (u, v) = scene.tangents(&surface, 0, surface.normal);
            let along = |d: DVec3| transform.transform_vector3(d).normalize().as_vec3();
            assert!((u - along(DVec3::X)).length() < 1e-5, "{transform:?} {u}");
            assert!((v - along(DVec3::Y)).length() < 1e-5, "{transform:?} {v}");
            assert_eq!(scene.texture_coordinate(&surface, 1), Vec3::ZERO);
            let uv = scene.texture_coordinate(&surface, 0);
            let at = transform.transform_point3(DVec3::new(uv.x.into(), uv.y.into(), 0.0)).as_vec3();
            assert!((at - surface.point.position).length() < 1e-4);
        }
    }
}

#[test]
fn given_tangents_are_used() {
    let mut mesh = quad();
    mesh.tangents = vec![Vec4::new(0.0, 1.0, 0.0, -1.0); 4];
    let scene = Scene::new(describe(vec![mesh], vec![Instance::new(0, 0)])).expect("valid");
    let surface = scene.surface_at(0, 1, 0.1, 0.1);
    let (u, v) = scene.tangents(&surface, 0, surface.normal);
    assert!((u - Vec3::Y).length() < 1e-6 && (v - Vec3::X).length() < 1e-6, "{u} {v}");
}

#[test]
fn scene_far_away_is_shifted_to_the_camera() {
    let far = DVec3::new(4.1e6, -2e6, 1e6);
    let instance = Instance { transform: DAffine3::from_translation(far), ..Instance::new(0, 0) };
    let mut description = describe(vec![sphere()], vec![instance]);
    description.camera.position += far;
    description.camera.target += far;
    let scene = Scene::new(description).expect("valid");
    assert_eq!(scene.origin, far + DVec3::Z * 5.0);
    let surface = hit(&scene, Ray::new(Vec3::ZERO, -Vec3::Z));
    assert!((surface.point.position + Vec3::Z * 4.0).length() < 1e-2);
    assert!((scene.described(surface.point.position).as_dvec3() - far).length() < 2.0);
}

#[test]
fn faults_are_errors_with_names() {
    let named = |i: Instance| Instance { name: "chair".to_string(), ..i };
    let build = |instance| Scene::new(describe(vec![quad()], vec![instance])).map(|_| ());
    let error = |instance| build(named(instance)).expect_err("broken");
    assert!(matches!(error(Instance::new(1, 0)), SceneError::NoSuchMesh { mesh: 1, .. }));
    assert!(matches!(error(Instance::new(0, 2)), SceneError::NoSuchSlot { slot: 2, .. }));
    let none = Instance { materials: Vec::new(), ..Instance::new(0, 0) };
    assert!(error(none).to_string().contains("`chair` has no material slot"));
    let squashed =
        Instance { transform: DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0)), ..Instance::new(0, 0) };
    assert!(matches!(error(squashed), SceneError::Transform { .. }));
    let empty = Scene::new(describe(Vec::new(), Vec::new())).map(|_| ());
    assert!(matches!(empty, Err(SceneError::NoGeometry { .. })));
    let mut blind = describe(vec![quad()], vec![Instance::new(0, 0)]);
    blind.camera.target = blind.camera.position;
    assert!(matches!(Scene::new(blind).map(|_| ()), Err(SceneError::Camera(_))));
}
