//! Bricks where the surface is, and a tree that finds them: the 2023 study's structure.
//!
//! *Theory.* The volume is cut into cubes of `brick` voxels. A brick is kept where the surface can be in it: the distance
//! at its center is at most the Lipschitz constant times half of its diagonal, half a voxel around the brick included,
//! because interpolation at its border reads that far. Bricks are listed by ascending Morton code, so the eight
//! children of a node are neighbors, and the tree is made bottom-up by looking at neighbors only (after Laine and
//! Karras, "Efficient sparse voxel octrees", 2010, and the study's bottom-up construction).
//!
//! *Practice.* Three stages, each with a twin in WGSL: [`select`], [`fill`], [`tree`]. Bricks stand in the volume's
//! texture where a dense volume would have them, as in the study, so that a brick needs no pointer and its neighbors'
//! texels are where a filter looks for them.
//!
//! ```text
//!   codes   ·  ·  ·  ·  ·  ·  ·     bricks, ascending
//!   level 0 └──┬─┘  └─┬┘  └┬─┘      nodes above bricks: where their children begin, and which of the eight there are
//!   level 1    └──┬───┘    │
//!   level 2       └────┬───┘        the root, which comes last
//! ```
//!
//! What differs from the study: its test of the center alone loses bricks and is an option; a list in Morton order
//! needs no sort, its enumeration sort is an option; and cells without a brick hold a distance that is never too large,
//! where the study leaves texels as they were.

mod fill;
mod layout;
mod select;
mod tree;
mod volume_kind;

use crate::{SampleFormat, Texels};
use argil_field::Program;
use argil_math::{Control, cell_of, morton};
use glam::UVec3;
use web_time::Instant;

pub use layout::{BrickTest, OctreeError, OctreeLayout, OctreeSettings};
pub use select::BrickSelection;
pub use tree::{DescentPath, Lookup, OctreeNodes};

/// What the stages of a build took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OctreeTimings {
    /// Choosing bricks.
    pub select: f64,
    /// Filling bricks, and the cells without one.
    pub fill: f64,
    /// Making the tree.
    pub tree: f64,
}

/// An octree of bricks.
#[derive(Clone, Debug, PartialEq)]
pub struct Octree {
    layout: OctreeLayout,
    tree: OctreeNodes,
    texels: Texels,
}

impl Octree {
    /// Build from a field, on rayon's current threads.
    pub fn bake(program: &Program, layout: OctreeLayout, keep: BrickTest) -> (Self, OctreeTimings) {
        Self::made(program, layout, keep, &Control::default())
    }

    /// [`Octree::bake`], which can be stopped and tells how far it is: `None` if it was cancelled.
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
        let fill = layout.encoding.fill(program, &layout.voxel_grid, 0);
        let words = layout.words(program, keep);
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

    /// From stored parts; `None` where they do not fit one another.
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

    /// What it would be built by; which bricks were kept is not known of a file.
    pub fn settings(&self) -> OctreeSettings {
        OctreeSettings {
            encoding: self.layout.encoding,
            brick_size_voxels: self.layout.brick_size_voxels,
            depth: Some(self.layout.depth),
            brick_test: BrickTest::Conservative,
        }
    }

    /// Its measures.
    pub fn layout(&self) -> &OctreeLayout {
        &self.layout
    }

    /// Its bricks' codes and its nodes.
    pub fn tree(&self) -> &OctreeNodes {
        &self.tree
    }

    /// The volume's texels.
    pub fn texels(&self) -> &Texels {
        &self.texels
    }

    /// Bytes of everything: the texture, which has room for all bricks, the codes and the nodes.
    pub fn memory_bytes(&self) -> u64 {
        self.texels.bytes().len() as u64 + self.tree.memory_bytes()
    }

    /// The cells of the study's test that the conservative one would keep and it does not: bricks lost.
    pub fn lost_bricks(&self, program: &Program) -> usize {
        let whole = BrickSelection::of(program, &self.layout, BrickTest::Conservative);
        let own = self.tree.codes();
        whole
            .codes
            .iter()
            .filter(|code| own.binary_search(code).is_err())
            .count()
    }

    /// Whether the brick of a cell is there.
    pub fn has_brick(&self, cell: UVec3) -> bool {
        self.layout.holds(cell) && self.tree.codes().binary_search(&morton(cell)).is_ok()
    }

    /// The cells of all bricks, in the order of their codes.
    pub fn cells(&self) -> impl Iterator<Item = UVec3> + '_ {
        self.tree.codes().iter().map(|&code| cell_of(code))
    }
}
