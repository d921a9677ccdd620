use crate::pass::{INSTRS, MATERIALS, PARAMS};
use crate::picture::{PicturePass, Way};
use crate::query::QueryPass;
use crate::table::Table;
use crate::{DeviceKind, Gpu, GpuError};
use argil_abi::{Frame, GPU_STACK_SLOTS, Instr};
use argil_field::{Opcodes, Program};
use argil_march::Picture;
use std::sync::{Arc, OnceLock};

/// An instruction that does nothing: an empty program still needs a row to bind.
const IDLE: Instr = Instr {
    op: u32::MAX,
    flags: 0,
    params: 0,
    operand: 0,
};

/// A program on a GPU, ready to be drawn.
pub struct GpuField {
    gpu: Arc<Gpu>,
    instrs: Table,
    params: Table,
    materials: Table,
    /// Number of instructions, for how much a dispatch may take on.
    length: usize,
    /// What an interpreter for the program can run.
    pub(crate) opcodes: Opcodes,
    field_wgsl: String,
    /// Most field evaluations that one thread may do in one dispatch.
    pub(crate) budget: u32,
    picture: PicturePass,
    pub(crate) query: OnceLock<QueryPass>,
}

impl GpuField {
    /// Bring a program to a device and make the pipelines. `specialized`: for this program alone.
    pub fn new(gpu: Arc<Gpu>, program: &Program, specialized: bool) -> Result<Self, GpuError> {
        // A software device pays for every case of the interpreter, used or not.
        let opcodes = if gpu.info().kind == DeviceKind::Software {
            Opcodes::of(program)
        } else {
            Opcodes::ALL
        };
        let field_wgsl = if specialized {
            program
                .specialized_wgsl()
                .ok_or(GpuError::TooLongToSpecialize)?
        } else {
            check_depth(program)?;
            opcodes.wgsl()
        };
        let picture = PicturePass::new(&gpu, &field_wgsl, Way::Field)?;
        let mut field = Self {
            gpu,
            instrs: Table::new("instructions"),
            params: Table::new("parameters"),
            materials: Table::new("materials"),
            length: 0,
            opcodes,
            field_wgsl,
            budget: 0,
            picture,
            query: OnceLock::new(),
        };
        field.upload(program)?;
        Ok(field)
    }

    /// Take over another program; only for a field that was not specialised. Compiles nothing, but on a software device
    /// whose trimmed interpreter lacks one of the program's opcodes.
    pub fn update(&mut self, program: &Program) -> Result<(), GpuError> {
        check_depth(program)?;
        let opcodes = Opcodes::of(program);
        if !self.opcodes.covers(opcodes) {
            self.opcodes = self.opcodes.union(opcodes);
            self.field_wgsl = self.opcodes.wgsl();
            self.query = OnceLock::new();
            self.picture = PicturePass::new(&self.gpu, &self.field_wgsl, Way::Field)?;
        }
        self.upload(program)
    }

    fn upload(&mut self, program: &Program) -> Result<(), GpuError> {
        let instrs = if program.instrs().is_empty() {
            &[IDLE][..]
        } else {
            program.instrs()
        };
        self.instrs.write(&self.gpu, instrs)?;
        self.params.write(&self.gpu, program.params())?;
        self.materials.write(&self.gpu, program.materials())?;
        self.length = instrs.len();
        self.budget = budget(&self.gpu, program)?;
        Ok(())
    }

    /// Draw: `frames` as `argil_march::frames` makes them, one a sample. With the picture, what its passes took, by the
    /// device's time stamps where it has them, else by the clock.
    pub fn render(&self, frames: &[Frame]) -> Result<(Picture, f64), GpuError> {
        self.picture.draw(self, &[], frames)
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
        let tables = [
            (&self.instrs, INSTRS),
            (&self.params, PARAMS),
            (&self.materials, MATERIALS),
        ];
        tables
            .into_iter()
            .filter_map(|(table, binding)| table.binding(binding))
    }
}

/// lavapipe ends all loops of a thread after 65,535 iterations, without a word; some are the passes' own.
const SOFTWARE_ITERATIONS: u64 = 60_000;

/// Evaluations that the longest pass does at once: six for a normal, a material and five taps for the light.
const LEAST_BUDGET: u64 = 7;

/// How many evaluations one thread may do in a dispatch: any number on hardware, which only the picture's size limits.
fn budget(gpu: &Gpu, program: &Program) -> Result<u32, GpuError> {
    if gpu.info().kind != DeviceKind::Software {
        return Ok(u32::MAX);
    }
    let iterations = program.iterations().max(1);
    let budget = SOFTWARE_ITERATIONS / (iterations + 1);
    if budget < LEAST_BUDGET {
        return Err(GpuError::TooLong {
            name: gpu.info().name.clone(),
            iterations,
            limit: SOFTWARE_ITERATIONS / LEAST_BUDGET,
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
