use crate::bindings::{INSTRS, MATERIALS, PARAMS};
use crate::cache::Cache;
use crate::storage_buffer::StorageBuffer;
use crate::trace_mode::BoundResource;
use crate::{DeviceKind, Gpu, GpuError};
use argil_abi::{GPU_STACK_SLOTS, Instruction};
use argil_field::{IncrementalProgram, OpcodeSet, Program};
use std::any::Any;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// An instruction that does nothing: an empty program still needs a row to bind.
pub(crate) const NOP: &[Instruction] = &[Instruction {
    op: u32::MAX,
    flags: 0,
    params: 0,
    operand: 0,
}];

/// A program on a GPU, ready to be drawn.
#[derive(Debug)]
pub struct GpuProgram {
    gpu: Arc<Gpu>,
    instrs: StorageBuffer,
    params: StorageBuffer,
    materials: StorageBuffer,
    /// Number of instructions, for how much a dispatch may take on.
    length: usize,
    /// What an interpreter for the program can run.
    pub(crate) opcodes: OpcodeSet,
    field_wgsl: String,
    /// Most field evaluations that one thread may do in one dispatch.
    pub(crate) budget: u32,
    /// The passes that were asked for, with the interpreter in them.
    passes: Cache,
    is_specialized: bool,
    /// Whether the parameters are a live program's.
    is_live: bool,
    /// Whether the instructions are those of the parameters.
    is_whole: AtomicBool,
}

impl GpuProgram {
    /// Bring a program to a device and make the pipelines. `specialized`: for this program alone.
    ///
    /// # Errors
    /// If the program nests too deep for the device, exceeds its limits or memory, or the device fails.
    pub fn new(gpu: Arc<Gpu>, program: &Program, specialized: bool) -> Result<Self, GpuError> {
        // A software device pays for every case of the interpreter, used or not.
        let opcodes = if gpu.info().kind == DeviceKind::Software {
            OpcodeSet::of(program)
        } else {
            OpcodeSet::ALL
        };
        let field_wgsl = if specialized {
            program
                .specialized_wgsl()
                .ok_or(GpuError::TooLongToSpecialize)?
        } else {
            check_depth(program)?;
            opcodes.wgsl()
        };
        let mut field = Self {
            gpu,
            instrs: StorageBuffer::new("instructions"),
            params: StorageBuffer::new("parameters"),
            materials: StorageBuffer::new("materials"),
            length: 0,
            opcodes,
            field_wgsl,
            budget: 0,
            passes: Cache::default(),
            is_specialized: specialized,
            is_live: false,
            is_whole: AtomicBool::new(true),
        };
        field.upload(program)?;
        Ok(field)
    }

    /// Take over another program; only for a field that was not specialized. Compiles nothing, but on a software device
    /// whose trimmed interpreter lacks one of the program's opcodes.
    ///
    /// # Errors
    /// If the program nests too deep for the device, exceeds its limits or memory, or the device fails.
    pub fn update(&mut self, program: &Program) -> Result<(), GpuError> {
        check_depth(program)?;
        self.extend_opcodes(OpcodeSet::of(program));
        self.upload(program)
    }

    /// Follow a live program: what its last update wrote, or all of it the first time. Its instructions are brought over
    /// when something is to be drawn through the field, by [`GpuProgram::upload_instructions`]. Only for a field that was not specialized.
    ///
    /// # Errors
    /// If the device cannot run the program; the field is then as it was.
    pub fn update_from(&mut self, live: &IncrementalProgram) -> Result<(), GpuError> {
        let program = live.program();
        check_depth(program)?;
        let budget = budget(&self.gpu, live.max_iterations())?;
        self.instrs.reserve(
            &self.gpu,
            (live.instruction_count() * size_of::<Instruction>()) as u64,
        )?;
        self.extend_opcodes(live.opcodes());
        let params = program.params();
        let written: usize = live
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
            for (begin, end) in joined(live.dirty_ranges()) {
                let words = &params[begin as usize..end as usize];
                let at = u64::from(begin) * size_of::<f32>() as u64;
                self.params
                    .patch(&self.gpu, at, bytemuck::cast_slice(words));
            }
        } else {
            self.params.write(&self.gpu, params)?;
        }
        self.materials.write(&self.gpu, program.materials())?;
        self.length = live.instruction_count().max(1);
        self.budget = budget;
        self.is_live = true;
        *self.is_whole.get_mut() = false;
        Ok(())
    }

    /// Bring over the instructions of the program that is followed, if they are not there. `program` gives it.
    pub fn upload_instructions<'a>(&self, program: impl FnOnce() -> &'a Program) {
        if !self.is_whole.load(Ordering::Acquire) {
            self.instrs.rewrite(&self.gpu, rows_of(program()));
            self.is_whole.store(true, Ordering::Release);
        }
    }

    /// Compile anew, when it is needed, if there are opcodes that could not be run so far.
    fn extend_opcodes(&mut self, opcodes: OpcodeSet) {
        if !self.opcodes.is_superset(opcodes) {
            self.opcodes = self.opcodes.union(opcodes);
            self.field_wgsl = self.opcodes.wgsl();
            self.passes = Cache::default();
        }
    }

    /// Whether its shaders are for one program alone.
    pub fn is_specialized(&self) -> bool {
        self.is_specialized
    }

    /// Passes of a name, made when they are first asked for.
    pub(crate) fn passes<T: Any + Send + Sync>(
        &self,
        name: &'static str,
        make: impl FnOnce() -> Result<T, GpuError>,
    ) -> Result<Arc<T>, GpuError> {
        self.passes.get(name, make)
    }

    fn upload(&mut self, program: &Program) -> Result<(), GpuError> {
        let instrs = rows_of(program);
        self.instrs.write(&self.gpu, instrs)?;
        self.params.write(&self.gpu, program.params())?;
        self.materials.write(&self.gpu, program.materials())?;
        self.length = instrs.len();
        self.budget = budget(&self.gpu, program.max_iterations())?;
        self.is_live = false;
        *self.is_whole.get_mut() = true;
        Ok(())
    }

    /// The device.
    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    /// Bytes of the program's tables on the device.
    pub fn memory_bytes(&self) -> u64 {
        self.instrs.size() + self.params.size() + self.materials.size()
    }

    pub(crate) fn length(&self) -> usize {
        self.length
    }

    pub(crate) fn field_wgsl(&self) -> &str {
        &self.field_wgsl
    }

    pub(crate) fn table_bindings(&self) -> impl Iterator<Item = wgpu::BindGroupEntry<'_>> {
        self.bindings_with(&self.instrs)
    }

    /// The same for a frame.
    pub(crate) fn bound(&self) -> impl Iterator<Item = BoundResource> + '_ {
        let tables = [
            (&self.instrs, INSTRS),
            (&self.params, PARAMS),
            (&self.materials, MATERIALS),
        ];
        tables.into_iter().filter_map(|(table, at)| table.bound(at))
    }

    /// The tables with other instructions for the same parameters.
    pub(crate) fn bindings_with<'a>(
        &'a self,
        instrs: &'a StorageBuffer,
    ) -> impl Iterator<Item = wgpu::BindGroupEntry<'a>> {
        let tables = [
            (instrs, INSTRS),
            (&self.params, PARAMS),
            (&self.materials, MATERIALS),
        ];
        tables
            .into_iter()
            .filter_map(|(table, binding)| table.binding(binding))
    }
}

/// What a program's table of instructions holds.
fn rows_of(program: &Program) -> &[Instruction] {
    match program.instructions() {
        [] => NOP,
        instrs => instrs,
    }
}

/// Stretches in order, as one where one begins at another's end.
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

/// lavapipe ends all loops of a thread after 65,535 iterations, without a word; some are the passes' own.
const SOFTWARE_ITERATIONS: u64 = 60_000;

/// Evaluations that the longest pass does at once: six for a normal, a material and five taps for the light.
const MIN_BUDGET: u64 = 7;

/// How many evaluations one thread may do in a dispatch: any number on hardware, which only the picture's size limits.
fn budget(gpu: &Gpu, iterations: u64) -> Result<u32, GpuError> {
    if gpu.info().kind != DeviceKind::Software {
        return Ok(u32::MAX);
    }
    let iterations = iterations.max(1);
    let budget = SOFTWARE_ITERATIONS / (iterations + 1);
    if budget < MIN_BUDGET {
        return Err(GpuError::TooLong {
            name: gpu.info().name.clone(),
            iterations,
            limit: SOFTWARE_ITERATIONS / MIN_BUDGET,
        });
    }
    Ok(budget as u32)
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
