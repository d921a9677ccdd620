use crate::{BuildError, Engine, Representation, World};
use argil_field::Program;
use argil_scene::Scene;

/// A scene that an engine has checked and lowered, and that is to become a [`World`], kept in some way.
/// [`Engine::build`](crate::Engine::build) makes it.
///
/// ```
/// use argil::prelude::*;
/// let mut scene = Scene::new();
/// scene.push(Brush::new(Shape::sphere(0.5)))?;
/// let field = Engine::cpu().build(&scene)?.field();
/// let bricks = Engine::cpu().build(&scene)?.bricks(64)?;
/// assert_eq!(field.distance([0.0, 1.0, 0.0]), 0.5);
/// assert_eq!(bricks.resolution(), Some([64, 64, 64]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Build<'a> {
    world: World,
    scene: &'a Scene,
}

impl Engine {
    /// Check and lower a scene, to be kept in some way: [`Build`] says how.
    ///
    /// # Errors
    /// If the scene cannot be lowered, or not by a GPU.
    pub fn build<'a>(&self, scene: &'a Scene) -> Result<Build<'a>, BuildError> {
        Ok(Build::new(World::new(self.clone(), scene)?, scene))
    }
}

impl<'a> Build<'a> {
    pub(crate) fn new(world: World, scene: &'a Scene) -> Self {
        Self { world, scene }
    }

    /// What the scene was lowered to.
    pub fn program(&self) -> &Program {
        self.world.program()
    }

    /// Kept as its field: every distance is evaluated when it is asked for.
    pub fn field(self) -> World {
        self.world
    }

    /// [`Build::with_representation`] where a GPU cannot be waited for in place: in a browser. A future of a world on the CPU does all of its work
    /// when it is first polled, as nothing is waited for: poll it on a thread that may be busy, and stop it by a
    /// [`Control`](crate::Control).
    ///
    /// # Errors
    /// As [`Build::bricks`].
    pub async fn with_representation_async(
        self,
        via: impl Into<Representation>,
    ) -> Result<World, BuildError> {
        let via = via.into();
        if via == Representation::Field {
            return Ok(self.world);
        }
        self.world.rebuilt_as_async(self.scene, via).await
    }
}
