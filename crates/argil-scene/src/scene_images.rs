//! The images that a scene names: of textures, and of the environment.

use crate::change::SceneChange;
use crate::image_file::{LoadedImage, SceneImage};
use crate::lighting::Environment;
use crate::material::Material;
use crate::scene::Scene;
use crate::texture::Pattern;
use crate::view::View;
use std::sync::Arc;

impl Scene {
    /// Returns the path of each image that is not loaded: of textures, and of the environment.
    pub fn missing_images(&self) -> Vec<String> {
        paths_of(self.images().filter(|(_, image)| image.0.is_none()))
    }

    /// Returns the path of each texture's image that is not loaded.
    pub fn missing_texture_images(&self) -> Vec<String> {
        let all = self.images_of_textures();
        paths_of(all.filter(|(_, image)| image.0.is_none()))
    }

    /// Returns the path of each image that a texture names.
    pub fn texture_images(&self) -> Vec<String> {
        paths_of(self.images_of_textures())
    }

    /// Sets an image, for all materials that name it, and the environment. This is not an undo step. Worlds of the scene must be
    /// rebuilt.
    pub fn set_image(&mut self, path: &str, image: &Arc<SceneImage>) {
        for material in self.materials.values_mut() {
            set_in(material, path, image);
        }
        if let Environment::Image {
            path: image_path,
            image: loaded,
            ..
        } = &mut self.view.environment
            && image_path == path
        {
            loaded.0 = Some(image.clone());
        }
        self.history.note(SceneChange::of_everything());
    }

    /// Gives another scene the images that this one has loaded.
    pub fn share_images(&self, other: &mut Self) {
        for path in other.missing_images() {
            let known = self.images().find(|(image_path, _)| *image_path == path);
            if let Some(image) = known.and_then(|(_, image)| image.0.clone()) {
                other.set_image(&path, &image);
            }
        }
    }

    /// Sets a gray pixel for each image that is not loaded.
    pub fn gray_missing_images(&mut self) {
        for path in self.missing_images() {
            let gray = SceneImage {
                size: [1, 1],
                pixels: vec![[0.5; 3]],
            };
            self.set_image(&path, &Arc::new(gray));
        }
    }

    fn images_of_textures(&self) -> impl Iterator<Item = (&str, &LoadedImage)> {
        let textures = self.materials.values();
        let textures = textures.filter_map(|material| material.textures.as_deref());
        textures
            .flat_map(|textures| textures.patterns())
            .filter_map(named)
    }

    fn images(&self) -> impl Iterator<Item = (&str, &LoadedImage)> {
        let of_view = match &self.view.environment {
            Environment::Image { path, image, .. } => Some((path.as_str(), image)),
            Environment::Sky | Environment::Color { .. } => None,
        };
        self.images_of_textures().chain(of_view)
    }

    /// Gives a view the image around the scene, if that is loaded.
    pub(crate) fn keep_environment(&self, view: &mut View) {
        let known = self
            .images()
            .find_map(|(path, image)| match &view.environment {
                Environment::Image {
                    path: image_path, ..
                } if image_path == path => image.0.clone(),
                _ => None,
            });
        if let (Some(known), Environment::Image { image, .. }) = (known, &mut view.environment) {
            image.0 = Some(known);
        }
    }

    /// Gives a material the images that others have loaded.
    pub(crate) fn with_images(&self, mut material: Material) -> Material {
        for (path, image) in self.images() {
            if let Some(image) = &image.0 {
                set_in(&mut material, path, image);
            }
        }
        material
    }
}

/// Returns paths, each once.
fn paths_of<'a>(images: impl Iterator<Item = (&'a str, &'a LoadedImage)>) -> Vec<String> {
    let mut all: Vec<String> = images.map(|(path, _)| path.to_owned()).collect();
    all.sort_unstable();
    all.dedup();
    all
}

fn named(pattern: &Pattern) -> Option<(&str, &LoadedImage)> {
    match pattern {
        Pattern::Image { path, image, .. } => Some((path, image)),
        _ => None,
    }
}

/// Sets an image in a material that names it.
fn set_in(material: &mut Material, path: &str, loaded: &Arc<SceneImage>) {
    let patterns = material
        .textures
        .iter_mut()
        .flat_map(|textures| textures.patterns_mut());
    for pattern in patterns {
        if let Pattern::Image {
            path: image_path,
            image,
            ..
        } = pattern
            && image_path == path
        {
            image.0 = Some(loaded.clone());
        }
    }
}
