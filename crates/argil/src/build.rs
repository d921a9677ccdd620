use crate::{BuildError, Engine, Representation, World};
use argil_field::Program;
use argil_scene::Scene;

/// A scene that an engine has checked and compiled to a program. Its methods build a [`World`] with a representation.
/// [`Engine::build`](crate::Engine::build) returns it.
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
    /// Checks and lowers a scene. The returned [`Build`] builds a world from it.
    ///
    /// # Errors
    /// If the scene exceeds a limit, or nests too deep for the GPU.
    pub fn build<'a>(&self, scene: &'a Scene) -> Result<Build<'a>, BuildError> {
        Ok(Build::new(World::new(self.clone(), scene)?, scene))
    }
}

impl<'a> Build<'a> {
    pub(crate) fn new(world: World, scene: &'a Scene) -> Self {
        Self { world, scene }
    }

    /// Returns the program that the scene was compiled to.
    pub fn program(&self) -> &Program {
        self.world.program()
    }

    /// Builds a world that stores only its program, and evaluates each distance when asked.
    pub fn field(self) -> World {
        self.world
    }

    /// Builds a world with a representation, as a future. A page needs it, because it cannot wait for a GPU.
    /// For a world on the CPU, the future does all its work when it is first polled. Poll it on a worker thread,
    /// and cancel it through a [`Control`](argil_math::Control).
    ///
    /// # Errors
    /// If an option is out of range, or the result exceeds the memory budget or the device's limits.
    pub async fn with_representation_async(
        self,
        representation: impl Into<Representation>,
    ) -> Result<World, BuildError> {
        let representation = representation.into();
        if representation == Representation::Field {
            return Ok(self.world);
        }
        self.world
            .rebuilt_as_async(self.scene, representation)
            .await
    }
}
