//! What materials ask of a scene as a whole.

use lacquer::{RenderSettings, Scene, Session, Silent};

fn material(fields: &str) -> Result<lacquer::Material, lacquer::Error> {
    let text = format!(
        "mdl 1.8; import ::df::*; import ::state::*; import ::math::*; \
         float both() {{ return state::meters_per_scene_unit() + 0.01 * state::scene_units_per_meter(); }} \
         export material m() = material({fields});"
    );
    Session::new().source("::m", &text).material(None, &[])
}

#[test]
fn scenes_have_their_unit() {
    let glowing = "surface: material_surface(emission: material_emission(emission: df::diffuse_edf(), \
                   intensity: color(math::PI * X)))";
    for (meters, expression, expected) in [
        (0.25, "state::meters_per_scene_unit()", 0.25),
        (0.25, "state::scene_units_per_meter()", 4.0),
        (0.5, "both()", 0.52),
        (0.5, "state::meters_per_scene_unit() + 0.0 * state::animation_time()", 0.5),
    ] {
        let mut scene = Scene::ball();
        scene.description_mut().meters_per_unit = meters;
        let material = material(&glowing.replace('X', expression)).expect("it compiles");
        scene.assign("material", &material).expect("the ball has the slot");
        let settings = RenderSettings { width: 9, height: 9, spp: 4, ..RenderSettings::default() };
        let picture = scene.render(&settings, &Silent).expect("it renders");
        let middle = picture.film.rgb()[40];
        assert!((middle[0] / expected - 1.0).abs() < 1e-4, "{expression}: {middle:?} for {expected}");
    }
}

/// What decides the structure of a material must be known before rendering.
#[test]
fn structure_by_the_scene_is_an_error() {
    for condition in ["state::meters_per_scene_unit() > 0.5", "state::object_id() == 1", "both() > 0.5"] {
        let error =
            material(&format!("thin_walled: {condition}")).map(|_| ()).expect_err(condition).to_string();
        assert!(error.contains("the structure depends on"), "{condition}: {error}");
    }
}
