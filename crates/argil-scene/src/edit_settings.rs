//! Edits of materials and of the view.

use crate::change::SceneChange;
use crate::edit::{EditError, EditOutcome};
use crate::history::HistoryStep;
use crate::{Material, Scene, View};
use argil_math::Aabb;

impl Scene {
    /// Checks a change of a material and turns it into a step.
    pub(crate) fn material_step(
        &self,
        name: String,
        material: Option<Material>,
    ) -> Result<HistoryStep, EditError> {
        match &material {
            Some(material) => material.check()?,
            None => self.check_unused(&name)?,
        }
        let material = material.map(|material| self.with_images(material));
        Ok(HistoryStep::SetMaterial {
            name,
            material,
            place: None,
        })
    }

    /// Changes a material. Returns the step that reverses it.
    pub(crate) fn take_material(
        &mut self,
        name: String,
        material: Option<Material>,
        place: Option<usize>,
    ) -> (EditOutcome, HistoryStep) {
        let place_before = self.materials.get_index_of(&name);
        let before = self.put_material(&name, material, place);
        let edited = EditOutcome {
            node: Self::ROOT,
            dirty_box: Aabb::ALL,
        };
        let inverse = HistoryStep::SetMaterial {
            name,
            material: before,
            place: place_before,
        };
        (edited, inverse)
    }

    /// Changes, adds or removes a material. New ones come last, so that the places of others stay, unless they had a place before.
    /// Returns the material before.
    pub(crate) fn put_material(
        &mut self,
        name: &str,
        material: Option<Material>,
        place: Option<usize>,
    ) -> Option<Material> {
        let count = self.materials.len();
        let is_unused = match (self.materials.get_index_of(name), &material) {
            (None, _) => place.is_none_or(|place| place >= count),
            (Some(index), None) => index + 1 == count,
            (Some(_), Some(_)) => false,
        };
        self.history.note(match is_unused {
            true => SceneChange::of_unused_material(),
            false => SceneChange::of_everything(),
        });
        match material {
            Some(material) if self.materials.contains_key(name) => {
                self.materials.insert(name.to_owned(), material)
            }
            Some(material) => {
                let place = place.map_or(count, |place| place.min(count));
                self.materials
                    .shift_insert(place, name.to_owned(), material)
            }
            None => self.materials.shift_remove(name),
        }
    }

    /// Changes the view. Returns the step that reverses it.
    pub(crate) fn take_view(&mut self, mut view: View) -> (EditOutcome, HistoryStep) {
        self.keep_environment(&mut view);
        let before = std::mem::replace(&mut self.view, view);
        let is_elsewhere = before.bounds != self.view.bounds;
        if is_elsewhere {
            self.history.note(SceneChange::of_everything());
        }
        let edited = EditOutcome {
            node: Self::ROOT,
            dirty_box: if is_elsewhere { Aabb::ALL } else { Aabb::EMPTY },
        };
        let view = Box::new(before);
        (edited, HistoryStep::SetView { view })
    }
}
