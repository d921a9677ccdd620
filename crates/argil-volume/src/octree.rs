//! Bricks near the surface under a tree: the 2023 study's structure.
//!
//! *Theory.* The volume is cut into cubes of `brick_size_voxels`. A brick is kept if the surface can pass through
//! it: if the distance at its center is at most the Lipschitz constant times half of its diagonal, including half a
//! voxel around it, because interpolation at its border reads that far. Bricks are listed by ascending Morton code,
//! so the eight children of a node are neighbors. The tree is built bottom-up by comparing neighbors (Laine and
//! Karras, "Efficient sparse voxel octrees", 2010).
//!
//! *Practice.* There are three stages, each with a WGSL twin: [`select`], [`fill`], [`tree`]. As in the study,
//! bricks stay in the texture where a dense volume would have them. So a brick needs no pointer, and a filter finds
//! its neighbors' samples.
//!
//! ```text
//!   codes   ·  ·  ·  ·  ·  ·  ·     bricks, ascending
//!   level 0 └──┬─┘  └─┬┘  └┬─┘      nodes above bricks: where their children begin, and which of the eight there are
//!   level 1    └──┬───┘    │
//!   level 2       └────┬───┘        the root, which comes last
//! ```
//!
//! There are three differences from the study. Its test of the center alone loses bricks, so it is only an option. Its
//! enumeration sort is an option too, because bricks listed in Morton order need no sort. Cells without a brick hold a
//! conservative distance, whereas the study leaves their texels unchanged.

mod fill;
mod layout;
mod select;
mod tree;
mod volume_kind;

use crate::{SampleFormat, Texels};
use argil_field::Program;
use argil_math::{Control, morton, morton_cell};
use glam::UVec3;
use web_time::Instant;

pub use layout::{BrickOrdering, BrickTest, OctreeError, OctreeLayout, OctreeSettings};
pub use select::BrickSelection;
pub use tree::{DescentPath, Lookup, OctreeNodes};

/// Durations of the stages of a build, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OctreeTimings {
    /// Selecting bricks.
    pub select: f64,
    /// Filling bricks and vacant cells.
    pub fill: f64,
    /// Building the tree.
    pub tree: f64,
}

/// An octree of bricks.
///
/// ```
/// use argil_field::Program;
/// use argil_scene::{Scene, Shape};
/// use argil_volume::{Octree, OctreeLayout, OctreeSettings, VoxelGrid};
/// let mut scene = Scene::new();
/// scene.push(Shape::sphere(0.5))?;
/// let program = Program::lower(&scene)?;
/// let grid = VoxelGrid::fitting(program.aabb(), None, 64)?;
/// let layout = OctreeLayout::new(grid, &OctreeSettings { brick_size_voxels: 8, ..Default::default() })?;
/// let (octree, _) = Octree::bake(&program, layout, Default::default());
/// assert!(octree.cells().count() > 100);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Octree {
    layout: OctreeLayout,
    tree: OctreeNodes,
    texels: Texels,
}

impl Octree {
    /// Bakes a field, on rayon's current threads.
    pub fn bake(program: &Program, layout: OctreeLayout, keep: BrickTest) -> (Self, OctreeTimings) {
        Self::made(program, layout, keep, &Control::default())
    }

    /// Bakes as [`Octree::bake`] does, reports progress, and can be canceled. Returns `None` if it was.
    pub fn bake_with_control(
        program: &Program,
        layout: OctreeLayout,
        keep: BrickTest,
        control: &Control,
    ) -> Option<(Self, OctreeTimings)> {
        let made = Self::made(program, layout, keep, control);
        (!control.is_cancelled()).then_some(made)
    }

    fn made(
        program: &Program,
        layout: OctreeLayout,
        keep: BrickTest,
        control: &Control,
    ) -> (Self, OctreeTimings) {
        let start = Instant::now();
        let selection = BrickSelection::of(program, &layout, keep);
        let selected = start.elapsed();
        let tree = OctreeNodes::from_codes(selection.codes, layout.depth);
        let built = start.elapsed();
        let fill = layout.encoding.fill_uniform(program, &layout.voxel_grid, 0);
        let words = layout.uniform(program, keep);
        let tree_of = (&tree, &selection.centers[..]);
        let texels = match layout.encoding.format {
            SampleFormat::Snorm8 => {
                fill::bricks::<i8>(program, &layout, &words, &fill, tree_of, control)
            }
            SampleFormat::Snorm16 => {
                fill::bricks::<i16>(program, &layout, &words, &fill, tree_of, control)
            }
        };
        let ms = |d: std::time::Duration| d.as_secs_f64() * 1e3;
        let stages = OctreeTimings {
            select: ms(selected),
            tree: ms(built - selected),
            fill: ms(start.elapsed() - built),
        };
        (
            Self {
                layout,
                tree,
                texels,
            },
            stages,
        )
    }

    /// Creates an octree from stored parts. Returns `None` if they do not match.
    pub fn from_parts(layout: OctreeLayout, tree: OctreeNodes, texels: Texels) -> Option<Self> {
        let bytes = layout.voxel_grid.texel_count(0) * layout.encoding.format.bytes() as u64;
        let fits = texels.bits() == layout.encoding.format
            && texels.bytes().len() as u64 == bytes
            && tree.check(&layout).is_none();
        fits.then_some(Self {
            layout,
            tree,
            texels,
        })
    }

    /// Returns the settings that would build it. A file does not record the brick test.
    pub fn settings(&self) -> OctreeSettings {
        OctreeSettings {
            encoding: self.layout.encoding,
            brick_size_voxels: self.layout.brick_size_voxels,
            depth: Some(self.layout.depth),
            brick_test: BrickTest::Conservative,
        }
    }

    /// Returns the layout of bricks.
    pub fn layout(&self) -> &OctreeLayout {
        &self.layout
    }

    /// Returns the bricks' codes and the nodes.
    pub fn tree(&self) -> &OctreeNodes {
        &self.tree
    }

    /// Returns the samples of the texture.
    pub fn texels(&self) -> &Texels {
        &self.texels
    }

    /// Returns the bytes of everything: the texture, which has room for all bricks, the codes and the nodes.
    pub fn memory_bytes(&self) -> u64 {
        self.texels.bytes().len() as u64 + self.tree.memory_bytes()
    }

    /// Counts the bricks that the conservative test keeps and this octree lacks.
    pub fn lost_bricks(&self, program: &Program) -> usize {
        let whole = BrickSelection::of(program, &self.layout, BrickTest::Conservative);
        let own = self.tree.codes();
        whole
            .codes
            .iter()
            .filter(|code| own.binary_search(code).is_err())
            .count()
    }

    /// Whether a cell has a brick.
    pub fn has_brick(&self, cell: UVec3) -> bool {
        self.layout.contains_voxels(cell) && self.tree.codes().binary_search(&morton(cell)).is_ok()
    }

    /// Iterates over the cells of all bricks, in the order of their codes.
    pub fn cells(&self) -> impl Iterator<Item = UVec3> + '_ {
        self.tree.codes().iter().map(|&code| morton_cell(code))
    }
}
