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
        let material = material.map(|own| self.with_images(own));
        Ok(HistoryStep::SetMaterial { name, material })
    }

    /// Changes a material. Returns the step that reverses it.
    pub(crate) fn take_material(
        &mut self,
        name: String,
        material: Option<Material>,
    ) -> (EditOutcome, HistoryStep) {
        let before = match material {
            Some(material) => self.materials.insert(name.clone(), material),
            None => self.materials.remove(&name),
        };
        self.history.note(SceneChange::of_everything());
        let edited = EditOutcome {
            node: Self::ROOT,
            dirty_box: Aabb::ALL,
        };
        let inverse = HistoryStep::SetMaterial {
            name,
            material: before,
        };
        (edited, inverse)
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
