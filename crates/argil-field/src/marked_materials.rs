//! How much each material has of a point.

use crate::Program;
use argil_abi::{self as abi, GpuMaterial};

impl Program {
    /// Materials that [`Program::with_marked_materials`] can tell apart.
    pub const MARKED_MATERIALS: usize = 8;

    /// Returns a program whose materials are marks, without textures. Of [`Program::materials`], the one at index `first` has 1
    /// as its first word and 0 as the seven others, the next one has 1 as its second word, and so on. All others have only
    /// zeros. So [`Evaluator::materials`](crate::Evaluator::materials) returns how much each of these eight has of a point.
    ///
    /// ```
    /// use argil_field::{Evaluator, Program};
    /// use argil_scene::{Brush, Material, Scene, Shape};
    /// let mut scene = Scene::new();
    /// scene.set_material("clay", Material::default())?;
    /// scene.push(Shape::sphere(1.0))?;
    /// scene.push(Brush::new(Shape::sphere(1.0)).at([4.0, 0.0, 0.0]).with_material("clay"))?;
    /// let marked = Program::lower(&scene)?.with_marked_materials(0);
    /// let (mut d, mut shares) = ([0.0], [Default::default()]);
    /// Evaluator::new(&marked).materials(&[4.0], &[0.0], &[0.0], &mut d, &mut shares);
    /// assert_eq!(shares[0].base_roughness, [0.0, 1.0, 0.0, 0.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn with_marked_materials(&self, first: usize) -> Self {
        let mut marked = self.clone();
        let table = &mut marked.materials;
        table.entries.truncate(table.materials);
        table.extras.clear();
        (table.bump_step, table.has_glass) = (0.0, false);
        for (index, entry) in table.entries.iter_mut().enumerate() {
            let mark = |channel: usize| f32::from(u8::from(index == first + channel));
            *entry = GpuMaterial {
                base_roughness: std::array::from_fn(mark),
                emission_metallic: std::array::from_fn(|channel| mark(4 + channel)),
            };
        }
        let shapes = marked.instructions.iter_mut();
        for brush in shapes.filter(|instr| instr.op < abi::OP_SHAPES_END) {
            brush.flags &= (1 << abi::TEXTURES_SHIFT) - 1;
        }
        marked
    }
}
