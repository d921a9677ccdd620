//! The methods of a device, once for its trait and once for what calls it.

/// Calls a macro with the methods of a device.
macro_rules! device_methods {
    ($with:ident) => {
        $with! {
            reads {
                /// Whether its shaders are for one program only, so that they cannot follow edits.
                fn is_specialized(&self) -> bool;
                /// Returns the bytes of the program's tables on the device, besides those of the CPU.
                fn program_bytes(&self) -> u64;
                /// Returns the bytes of what is stored, or `None` if nothing but the program is.
                fn stored_bytes(&self) -> Option<u64>;
                /// Returns the bytes of the levels from which light reads distances, besides those of the CPU.
                fn light_bytes(&self) -> u64;
                /// Whether a volume is stored.
                fn has_volume(&self) -> bool;
                /// Whether paths of light pass through what is stored.
                fn has_paths(&self) -> bool;
                /// Returns the voxel grid that the stored volume has, or that the stored triangles came from.
                fn voxel_grid(&self) -> Option<VoxelGrid>;
                /// Returns the layout of stored sparse bricks.
                fn brick_layout(&self) -> Option<BrickLayout>;
                /// Returns the stored levels of detail.
                fn levels(&self) -> Option<&Levels>;
                /// Returns the numbers of stored triangles and vertices.
                fn mesh_counts(&self) -> Option<MeshCounts>;
                /// Returns the state for edits in place, if the stored volume supports them.
                fn edits(&self) -> Option<Box<dyn PendingEdits>>;
                /// Whether a host dropped an encoder with edits.
                fn has_lost_edits(&self) -> bool;
            }
            writes {
                /// Takes another program.
                fn set_program(&mut self, program: &Program) -> Result<(), BuildError>;
                /// Follows the edits of a program.
                fn follow_program(&mut self, live: &IncrementalProgram) -> Result<(), BuildError>;
                /// Compiles shaders for a program.
                fn specialize(&mut self, program: &Program) -> Result<(), BuildError>;
                /// Frees what is stored.
                fn clear(&mut self) -> ();
                /// Stores triangles.
                fn store_mesh(&mut self, mesh: Mesh, voxel_grid: VoxelGrid) -> Result<(), BuildError>;
                /// Returns the stored levels of detail, to change them.
                fn levels_mut(&mut self) -> Option<&mut Levels>;
                /// Follows changes of the stored levels of detail.
                fn follow_levels(&mut self) -> Result<(), RenderError>;
                /// Grows to the box that the edits have grown to.
                fn grow(&mut self, edits: &dyn PendingEdits) -> ();
            }
            reads_later {
                /// Describes the stored volume.
                async fn info(&self) -> Result<Option<VolumeInfo>, BuildError>;
                /// Returns the stored volume.
                async fn volume(&self) -> Result<Option<Cow<'_, Volume>>, BuildError>;
                /// Renders an image. Returns it, and the time in milliseconds.
                async fn render(&self, request: RenderRequest<'_>) -> Result<(RenderOutput, f64), RenderError>;
                /// Adds paths of light to a still, if paths pass through what is stored.
                async fn trace_paths(&self, request: PathRequest<'_>, still: &mut Still) -> Result<(), StillError>;
                /// Extracts triangles from the stored volume, if there is one.
                async fn volume_mesh(&self, options: &MeshOptions, stages: &mut Stages) -> Result<Option<Mesh>, MeshError>;
                /// Extracts triangles of the field by marching cubes, unless the CPU does that.
                async fn field_mesh(&self, site: &BuildContext<'_>, voxel_grid: VoxelGrid, normals: MeshNormals, stages: &mut Stages) -> Result<Option<Mesh>, MeshError>;
            }
            writes_later {
                /// Builds and stores a dense volume.
                async fn build_dense(&mut self, site: &BuildContext<'_>, voxel_grid: VoxelGrid, encoding: Encoding, mips: bool, fill: DenseFill) -> Result<StageTimings, BuildError>;
                /// Builds and stores an octree.
                async fn build_octree(&mut self, site: &BuildContext<'_>, layout: OctreeLayout, brick_test: BrickTest, order: BrickOrdering) -> Result<StageTimings, BuildError>;
                /// Builds and stores sparse bricks of at most `budget` bytes.
                async fn build_bricks(&mut self, site: &BuildContext<'_>, layout: BrickLayout, budget: Option<u64>) -> Result<StageTimings, BuildError>;
                /// Builds and stores triangles of the field by marching cubes, unless the CPU does that.
                async fn build_mesh(&mut self, site: &BuildContext<'_>, voxel_grid: VoxelGrid, flat: bool) -> Result<Option<StageTimings>, BuildError>;
                /// Stores a volume of the CPU.
                async fn store_volume(&mut self, volume: Volume) -> Result<(), BuildError>;
                /// Processes remaining edits of the stored volume. Returns what they did, as far as that is known.
                async fn edit(&mut self, live: &IncrementalProgram, edits: &mut dyn PendingEdits, work: EditWork<'_>) -> Result<EditStats, BuildError>;
                /// Waits for edits. Returns what they did since the last call, and was not known before.
                async fn flush(&mut self) -> Result<EditStats, BuildError>;
                /// Frees unused memory, and waits for that.
                async fn shrink_to_fit(&mut self) -> Result<(), BuildError>;
            }
        }
    };
}
