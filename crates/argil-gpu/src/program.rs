mod beside;
mod budget;
mod near;

use crate::bindings::{INSTRS, LISTS, MATERIALS, PARAMS};
use crate::cache::{Cache, PassKey};
use crate::near_lists::NearLists;
use crate::storage_buffer::StorageBuffer;
use crate::tile_source::TileSource;
use crate::trace_mode::BoundResource;
use crate::{DeviceKind, Gpu, GpuError};
use argil_abi::{GPU_STACK_SLOTS, Instruction};
use argil_field::{IncrementalProgram, Interpreter, Program};
use std::any::Any;
use std::borrow::Cow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// An instruction that does nothing, because an empty program still needs a row to bind.
pub(crate) const NOP: &[Instruction] = &[Instruction {
    op: u32::MAX,
    flags: 0,
    params: 0,
    operand: 0,
}];

/// Shorter programs of common instructions are faster three samples at a time than by lists.
const LONG_COLUMNS: usize = 64;

/// A program on a GPU, ready to render.
///
/// It owns the buffers of instructions, parameters and materials, and the pipelines with its interpreter.
#[derive(Debug)]
pub struct GpuProgram {
    gpu: Arc<Gpu>,
    instructions: StorageBuffer,
    params: StorageBuffer,
    materials: StorageBuffer,
    /// Number of instructions, which limits the size of dispatches.
    length: usize,
    /// The interpreter that its passes contain.
    interpreter: Interpreter,
    /// The WGSL that stands for the interpreter, if the shaders are for one program only.
    specialized_wgsl: Option<String>,
    /// The program for three points at once, if all of its instructions are common.
    columns: Option<StorageBuffer>,
    /// The program's lists for frames and paths.
    near: Mutex<NearLists>,
    /// Maximum evaluations per thread and dispatch.
    pub(crate) budget: u32,
    /// Loop iterations of one evaluation.
    iterations: u64,
    /// The passes that were requested, with the interpreter.
    passes: Cache,
    /// Whether the parameters are an incremental program's.
    is_live: bool,
    /// Whether the instructions match the parameters.
    is_whole: AtomicBool,
}

impl GpuProgram {
    /// Uploads a program and creates the pipelines. If `specialized`, the shaders are for this program only.
    ///
    /// # Errors
    /// If the program nests too deep for the device, exceeds its limits or memory, or the device fails.
    pub fn new(gpu: Arc<Gpu>, program: &Program, specialized: bool) -> Result<Self, GpuError> {
        let specialized_wgsl = if specialized {
            let text = program.specialized_wgsl();
            Some(text.ok_or(GpuError::TooLongToSpecialize)?)
        } else {
            check_depth(program)?;
            None
        };
        let interpreter = interpreter_for(&gpu, program);
        let mut field = Self {
            gpu,
            instructions: StorageBuffer::new("instructions"),
            params: StorageBuffer::new("parameters"),
            materials: StorageBuffer::new("materials"),
            length: 0,
            interpreter,
            specialized_wgsl,
            columns: None,
            near: Mutex::default(),
            budget: 0,
            iterations: 1,
            passes: Cache::default(),
            is_live: false,
            is_whole: AtomicBool::new(true),
        };
        field.upload(program)?;
        Ok(field)
    }

    /// Replaces the program. Only if it is not specialized. It compiles nothing, unless the program needs a deeper
    /// stack, or a software device's reduced interpreter lacks an opcode.
    ///
    /// # Errors
    /// If the program nests too deep for the device, exceeds its limits or memory, or the device fails.
    pub fn update(&mut self, program: &Program) -> Result<(), GpuError> {
        check_depth(program)?;
        self.extend(interpreter_for(&self.gpu, program));
        self.upload(program)
    }

    /// Follows an incremental program: uploads what its last update wrote, or everything the first time.
    /// Instructions are uploaded by [`GpuProgram::upload_instructions`] when something is rendered through the
    /// field. Only if it is not specialized.
    ///
    /// # Errors
    /// If the device cannot run the program. Nothing changes then.
    pub fn update_from(&mut self, incremental: &IncrementalProgram) -> Result<(), GpuError> {
        let program = incremental.program();
        check_depth(program)?;
        self.instructions.reserve(
            &self.gpu,
            (incremental.instruction_count() * size_of::<Instruction>()) as u64,
        )?;
        self.extend(Interpreter::new(incremental.opcodes(), program));
        let params = program.params();
        let written: usize = incremental
            .dirty_ranges()
            .iter()
            .map(|&(a, b)| (b - a) as usize)
            .sum();
        let has_room = self
            .params
            .buffer()
            .is_some_and(|buffer| buffer.size() >= size_of_val(params) as u64);
        if self.is_live && has_room && 4 * written < params.len() {
            self.params.reserve(&self.gpu, size_of_val(params) as u64)?;
            for (begin, end) in joined(incremental.dirty_ranges()) {
                let words = &params[begin as usize..end as usize];
                let at = u64::from(begin) * size_of::<f32>() as u64;
                self.params
                    .patch(&self.gpu, at, bytemuck::cast_slice(words));
            }
        } else {
            self.params.write(&self.gpu, params)?;
        }
        self.materials.write(&self.gpu, program.material_table())?;
        self.columns = None;
        self.length = incremental.instruction_count().max(1);
        self.set_iterations(incremental.max_iterations());
        self.is_live = true;
        *self.is_whole.get_mut() = false;
        Ok(())
    }

    /// Uploads the instructions of the followed program, unless they are up to date.
    pub fn upload_instructions<'a>(&self, program: impl FnOnce() -> &'a Program) {
        if !self.is_whole.load(Ordering::Acquire) {
            let program = program();
            self.instructions.rewrite(&self.gpu, rows_of(program));
            self.near
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .follow(program);
            self.is_whole.store(true, Ordering::Release);
        }
    }

    /// Compiles again when needed, if the interpreter lacks opcodes or slots.
    fn extend(&mut self, needed: Interpreter) {
        let interpreter = self.interpreter.union(needed);
        if interpreter != self.interpreter {
            self.interpreter = interpreter;
            self.passes = Cache::default();
        }
    }

    /// Whether its shaders are for one program only.
    pub fn is_specialized(&self) -> bool {
        self.specialized_wgsl.is_some()
    }

    /// Returns passes that evaluate the field, and creates them when first asked for.
    pub(crate) fn passes<T: Any + Send + Sync>(
        &self,
        key: impl Into<PassKey>,
        make: impl FnOnce() -> Result<T, GpuError>,
    ) -> Result<Arc<T>, GpuError> {
        self.check_length()?;
        self.passes.get(key.into(), make)
    }

    /// Returns passes that do not evaluate the field, and creates them when first asked for.
    pub(crate) fn plain_passes<T: Any + Send + Sync>(
        &self,
        key: impl Into<PassKey>,
        make: impl FnOnce() -> Result<T, GpuError>,
    ) -> Result<Arc<T>, GpuError> {
        self.passes.get(key.into(), make)
    }

    fn upload(&mut self, program: &Program) -> Result<(), GpuError> {
        let instructions = rows_of(program);
        self.instructions.write(&self.gpu, instructions)?;
        self.params.write(&self.gpu, program.params())?;
        self.materials.write(&self.gpu, program.material_table())?;
        self.columns = None;
        if let (None, Some(words)) = (&self.specialized_wgsl, program.column_words()) {
            let columns = self.columns.insert(StorageBuffer::new("columns"));
            columns.write(&self.gpu, &words)?;
        }
        if self.specialized_wgsl.is_none() {
            self.near
                .get_mut()
                .unwrap_or_else(PoisonError::into_inner)
                .follow(program);
        }
        self.length = instructions.len();
        self.set_iterations(program.max_iterations());
        self.is_live = false;
        *self.is_whole.get_mut() = true;
        Ok(())
    }

    /// Returns the device.
    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    /// Returns the bytes of the program's tables on the device.
    pub fn memory_bytes(&self) -> u64 {
        let columns = self.columns.as_ref().map_or(0, StorageBuffer::size);
        let near = self
            .near
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .bytes();
        self.instructions.size() + self.params.size() + self.materials.size() + columns + near
    }

    pub(crate) fn length(&self) -> usize {
        self.length
    }

    /// Returns the WGSL that evaluates the field.
    pub(crate) fn field_wgsl(&self) -> Cow<'_, str> {
        match &self.specialized_wgsl {
            Some(text) => text.into(),
            None => self.interpreter.wgsl().into(),
        }
    }

    /// Returns the WGSL that evaluates the field by pruned lists.
    pub(crate) fn pruning_wgsl(&self) -> String {
        self.interpreter.pruning_wgsl()
    }

    /// Returns the WGSL that evaluates the field, each point by the list of its part or by the whole program.
    pub(crate) fn wgsl_by(&self, by_lists: bool) -> Cow<'_, str> {
        match by_lists {
            true => self.interpreter.near_wgsl().into(),
            false => self.field_wgsl(),
        }
    }

    /// Returns the WGSL that finds how far points moved.
    pub(crate) fn motion_wgsl(&self) -> String {
        self.interpreter.motion_wgsl()
    }

    /// Returns the WGSL that evaluates three points of a column at once, if any shape of the program is common.
    pub(crate) fn column_wgsl(&self) -> Option<String> {
        self.interpreter.column_wgsl()
    }

    /// Returns how passes that fill tiles evaluate the program for some samples, and its tables. Without `at_once`, one at a time and
    /// whole.
    pub(crate) fn tile_field(&self, at_once: bool, samples: u64) -> Result<TileField, GpuError> {
        let columns = self.columns.as_ref().filter(|_| at_once);
        let near = match at_once && (columns.is_none() || self.length >= LONG_COLUMNS) {
            true => self.near_for(samples, None)?,
            false => None,
        };
        let columns = columns.filter(|_| near.is_none());
        if let (Some(table), Some(wgsl)) = (columns, self.column_wgsl()) {
            let tables = [(table, LISTS), (&self.params, PARAMS)];
            let bound = tables.iter().filter_map(|(buffer, at)| buffer.bound(*at));
            return Ok(TileField {
                source: TileSource::of_columns(wgsl),
                bound: bound.collect(),
            });
        }
        let source = match near {
            Some(_) => TileSource::of_lists(self.interpreter.near_wgsl()),
            None => TileSource::of_any(self.field_wgsl()),
        };
        let bound = self.bound().chain(near.into_iter().flatten()).collect();
        Ok(TileField { source, bound })
    }

    pub(crate) fn table_bindings(&self) -> impl Iterator<Item = wgpu::BindGroupEntry<'_>> {
        self.bindings_with(&self.instructions)
    }

    /// Iterates over the bindings of the tables for a frame.
    pub(crate) fn bound(&self) -> impl Iterator<Item = BoundResource> + '_ {
        let tables = [
            (&self.instructions, INSTRS),
            (&self.params, PARAMS),
            (&self.materials, MATERIALS),
        ];
        tables.into_iter().filter_map(|(table, at)| table.bound(at))
    }

    /// Returns the tables with other instructions for the same parameters.
    pub(crate) fn bindings_with<'a>(
        &'a self,
        instructions: &'a StorageBuffer,
    ) -> impl Iterator<Item = wgpu::BindGroupEntry<'a>> {
        let tables = [
            (instructions, INSTRS),
            (&self.params, PARAMS),
            (&self.materials, MATERIALS),
        ];
        tables
            .into_iter()
            .filter_map(|(table, binding)| table.binding(binding))
    }
}

/// What passes that fill tiles evaluate.
pub(crate) struct TileField {
    pub source: TileSource,
    pub bound: Vec<BoundResource>,
}

/// Returns the interpreter that a device gets for a program. A software device executes every case of it, used or not.
fn interpreter_for(gpu: &Gpu, program: &Program) -> Interpreter {
    let interpreter = if gpu.info().kind == DeviceKind::Software {
        Interpreter::of(program)
    } else {
        Interpreter::full(program)
    };
    let has_subgroups = gpu.device.features().contains(wgpu::Features::SUBGROUP);
    interpreter
        .with_subgroups(has_subgroups)
        .with_turns(has_subgroups && gpu.is_hardware())
}

/// Returns the rows of a program's table of instructions.
fn rows_of(program: &Program) -> &[Instruction] {
    match program.instructions() {
        [] => NOP,
        instructions => instructions,
    }
}

/// Merges adjacent ranges.
fn joined(stretches: &[(u32, u32)]) -> Vec<(u32, u32)> {
    let mut all = stretches.to_vec();
    all.sort_unstable();
    all.dedup_by(|next, last| {
        let touches = next.0 <= last.1;
        if touches {
            last.1 = last.1.max(next.1);
        }
        touches
    });
    all
}

pub(crate) fn check_depth(program: &Program) -> Result<(), GpuError> {
    let (values, points) = program.stack_slots();
    let (slots, needed) = (GPU_STACK_SLOTS as usize, values.max(points));
    if needed > slots {
        Err(GpuError::TooDeep { slots, needed })
    } else {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use argil_scene::{Group, NodeId, Scene, Shape};

    /// A program whose operands are a balanced tree, which is as deep as asked for.
    fn nested(depth: u32) -> Program {
        let mut scene = Scene::new();
        let mut level: Vec<NodeId> = vec![Scene::ROOT];
        for _ in 0..depth {
            let halves = level.iter().flat_map(|&parent| [parent; 2]);
            level = halves
                .map(|parent| {
                    // A group that blends is an operand of its own.
                    let group = Group::new().smooth(0.05);
                    scene.push_into(parent, group).expect("a group").node
                })
                .collect();
        }
        for (index, parent) in level.into_iter().enumerate() {
            for side in [0.0, 0.1] {
                let solid = Shape::sphere(0.3) | Shape::sphere(0.2);
                let away = [0.1 * index as f32, side, 0.0];
                scene
                    .push_into(parent, solid.at(away).smooth(0.05))
                    .expect("a group");
            }
        }
        Program::lower(&scene).expect("a program")
    }

    /// An edit that nests deeper makes the interpreter's stack longer. Its distances stay those of the CPU.
    #[test]
    fn stacks_follow_the_depth_of_programs() {
        let gpu = Arc::new(pollster::block_on(Gpu::open()).expect("a device"));
        let mut field = GpuProgram::new(gpu, &nested(0), false).expect("a field");
        let mut lengths = Vec::new();
        for depth in [0, 2, 5, 1] {
            let program = nested(depth);
            field.update(&program).expect("a field");
            lengths.push(field.interpreter.stack_slots());
            let points = [[0.1, 0.2, 0.05], [0.5, -0.1, 0.2], [1.0, 0.4, -0.3]];
            let answers = pollster::block_on(field.evaluate(&points)).expect("answers");
            for (point, answer) in points.iter().zip(answers) {
                let expected = program.distance((*point).into());
                assert!(
                    (answer.distance[0] - expected).abs() < 1e-6,
                    "{depth} at {point:?}"
                );
            }
        }
        assert!(lengths[0] < lengths[2], "{lengths:?}");
        assert_eq!(lengths[2], lengths[3], "a stack is not shortened");
    }
}
