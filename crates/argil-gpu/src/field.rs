use crate::pass::{
    COLORS, FRAME, HITS, INSTRS, MATERIALS, PARAMS, PICTURE_WGSL, TABLES_WGSL, layout, pipelines,
};
use crate::table::Table;
use crate::{Gpu, GpuError};
use argil_abi::{GPU_STACK_SLOTS, Instr};
use argil_field::Program;
use std::sync::Arc;

/// An instruction that does nothing: an empty program still needs a row to bind.
const IDLE: Instr = Instr { op: u32::MAX, flags: 0, params: 0, operand: 0 };

/// A program on a GPU, ready to be drawn.
pub struct GpuField {
    gpu: Arc<Gpu>,
    instrs: Table,
    params: Table,
    materials: Table,
    /// Number of instructions, for how much a dispatch may take on.
    length: usize,
    field_wgsl: String,
    pub(crate) layout: wgpu::BindGroupLayout,
    pub(crate) trace: wgpu::ComputePipeline,
    pub(crate) shade: wgpu::ComputePipeline,
}

impl GpuField {
    /// Bring a program to a device and make the pipelines. `specialized`: for this program alone.
    pub fn new(gpu: Arc<Gpu>, program: &Program, specialized: bool) -> Result<Self, GpuError> {
        let field_wgsl = if specialized {
            program.specialized_wgsl().ok_or(GpuError::TooLongToSpecialize)?
        } else {
            check_depth(program)?;
            argil_field::wgsl()
        };
        let [camera, trace, shade] = argil_march::wgsl();
        let source = [&argil_abi::wgsl(), TABLES_WGSL, PICTURE_WGSL, &field_wgsl, camera, trace, shade].concat();
        let layout = gpu.checked(|| layout(&gpu, "Picture", &[FRAME, INSTRS, PARAMS, MATERIALS, HITS, COLORS]))?;
        let [trace, shade] = pipelines(&gpu, source, &layout, ["trace", "shade"])?;
        let mut field = Self {
            gpu,
            instrs: Table::new("instructions"),
            params: Table::new("parameters"),
            materials: Table::new("materials"),
            length: 0,
            field_wgsl,
            layout,
            trace,
            shade,
        };
        field.upload(program)?;
        Ok(field)
    }

    /// Take over another program. Compiles nothing; only for a field that was not specialised.
    pub fn update(&mut self, program: &Program) -> Result<(), GpuError> {
        check_depth(program)?;
        self.upload(program)
    }

    fn upload(&mut self, program: &Program) -> Result<(), GpuError> {
        let instrs = if program.instrs().is_empty() { &[IDLE][..] } else { program.instrs() };
        self.instrs.write(&self.gpu, instrs)?;
        self.params.write(&self.gpu, program.params())?;
        self.materials.write(&self.gpu, program.materials())?;
        self.length = instrs.len();
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
        let tables = [(&self.instrs, INSTRS), (&self.params, PARAMS), (&self.materials, MATERIALS)];
        tables.into_iter().filter_map(|(table, binding)| table.binding(binding))
    }
}

fn check_depth(program: &Program) -> Result<(), GpuError> {
    let (values, points) = program.stack_slots();
    let (slots, needed) = (GPU_STACK_SLOTS as usize, values.max(points));
    if needed > slots { Err(GpuError::TooDeep { slots, needed }) } else { Ok(()) }
}
