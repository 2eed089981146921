//! Scenes with materials on them, rendered to memory.

use crate::environment::EnvironmentFunction;
use crate::error::Error;
use crate::material::Material;
use crate::textures::Textures;
use mdl_jit::material::ConstantMaterial;
use renderer::images::{ImageLimits, load_environment};
use renderer::needs::Needs;
use renderer::progress::Progress;
use renderer::render::{Render, needs_with, render_with};
use renderer::scene::{Environment, SceneDescription};
use renderer::scenes::{BuiltScene, ball};
use renderer::settings::RenderSettings;
use std::path::Path;
use std::sync::Arc;

/// Geometry, camera and lights, and the materials in its slots.
///
/// ```
/// use lacquer::{RenderSettings, Scene, Session, Silent};
///
/// let marble = Session::new().import("::catalog::marble")?.material(None, &[])?;
/// let mut scene = Scene::ball();
/// scene.assign("material", &marble)?;
/// let settings = RenderSettings { width: 16, height: 16, spp: 2, ..RenderSettings::default() };
/// let picture = scene.render(&settings, &Silent)?;
/// assert_eq!(picture.film.rgb().len(), 256);
/// assert!(picture.film.mean().min_element() > 0.0);
/// # Ok::<(), lacquer::Error>(())
/// ```
#[derive(Clone)]
pub struct Scene {
    description: SceneDescription,
    /// What the scene brings along, by slot.
    own: Vec<ConstantMaterial>,
    /// What was assigned, by slot.
    assigned: Vec<Option<Material>>,
    notes: Vec<String>,
}

impl Scene {
    /// The built-in shader ball in a studio. Its slot `material` is what is looked at.
    pub fn ball() -> Self {
        let grey = renderer::scenes::diffuse("grey", [0.5; 3]);
        let BuiltScene { description, materials } = ball::ball(grey);
        Self::new(description, materials, Vec::new())
    }

    /// A scene from a file: `.gltf`, `.glb` or `.obj`.
    pub fn open(file: impl AsRef<Path>) -> Result<Self, Error> {
        let loaded = renderer::loaders::load_scene(file.as_ref())?;
        Ok(Self::new(loaded.description, loaded.materials, loaded.notes))
    }

    /// A scene made by a program, with a material for each of its slots.
    pub fn new(description: SceneDescription, own: Vec<ConstantMaterial>, notes: Vec<String>) -> Self {
        let assigned = vec![None; own.len()];
        Self { description, own, assigned, notes }
    }

    /// Names of the material slots.
    pub fn slots(&self) -> &[String] {
        &self.description.materials
    }

    /// What a file said that has no effect, in sentences.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Geometry, camera and environment.
    pub fn description(&self) -> &SceneDescription {
        &self.description
    }

    /// The same, to be changed; materials keep their slots.
    pub fn description_mut(&mut self) -> &mut SceneDescription {
        &mut self.description
    }

    /// Puts a material into a slot.
    pub fn assign(&mut self, slot: &str, material: &Material) -> Result<(), Error> {
        let index = self.slots().iter().position(|name| name == slot).ok_or_else(|| {
            let slots = self.slots().join("`, `");
            Error::Name(format!("the scene has no material slot `{slot}`; it has `{slots}`"))
        })?;
        self.assigned[index] = Some(material.clone());
        Ok(())
    }

    /// Lights the scene with a map by latitude and longitude, y upwards, in place of its environment.
    pub fn set_environment(&mut self, file: impl AsRef<Path>) -> Result<(), Error> {
        let image = load_environment(file.as_ref(), &ImageLimits::default())?;
        self.description.environment = Environment::map(image);
        Ok(())
    }

    /// Lights the scene with a function of `state::direction()` in place of its environment, such as
    /// `::base::sun_and_sky`.
    ///
    /// ```
    /// use lacquer::{Scene, Session};
    ///
    /// let sky = Session::new().import("::base")?.environment("sun_and_sky", &[("haze", "2.0")])?;
    /// Scene::ball().set_environment_function(&sky)?;
    /// # Ok::<(), lacquer::Error>(())
    /// ```
    pub fn set_environment_function(&mut self, function: &EnvironmentFunction) -> Result<(), Error> {
        self.description.environment = function.bake()?;
        Ok(())
    }

    /// Renders it. The same settings give the same picture on any number of threads.
    pub fn render(&self, settings: &RenderSettings, progress: &dyn Progress) -> Result<Render, Error> {
        let scene = renderer::scene::Scene::new(self.description.clone())?;
        let (materials, textures) = self.materials()?;
        Ok(render_with(&scene, &materials, &textures.table, settings, progress)?)
    }

    /// What rendering it would need, why, and what that costs per path.
    pub fn needs(&self) -> Result<Needs, Error> {
        let scene = renderer::scene::Scene::new(self.description.clone())?;
        let (materials, textures) = self.materials()?;
        Ok(needs_with(&scene, &materials, &textures.table)?)
    }

    /// The materials by slot, and their textures.
    fn materials(&self) -> Result<(Vec<Arc<mdl_jit::material::Material>>, Textures), Error> {
        let assigned = self.assigned.iter().flatten();
        let textures = Textures::load(assigned.map(|material| (material.module(), material.resources())))?;
        let mut numbers = textures.numbers.iter();
        let mut materials = Vec::new();
        for (own, assigned) in self.own.iter().zip(&self.assigned) {
            materials.push(match assigned {
                Some(material) => material
                    .with_textures(&textures, numbers.next().expect("one list per assigned material"))?,
                None => Arc::new(own.build().map_err(|e| Error::Setting(format!("{}: {e}", own.name)))?),
            });
        }
        Ok((materials, textures))
    }
}
