//! Compiles SPIR-V with Mesa's RADV for an AMD GPU that need not be there, and reads what its compiler says. Nothing runs.

use anyhow::{Context, bail};
use ash::vk;
use std::collections::BTreeMap;
use std::ffi::{CStr, CString};

/// What the compiler says of an entry point.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Statistics {
    /// Registers that each thread has.
    pub vgprs: u64,
    /// Registers that do not fit, and are kept in memory.
    pub spilled: u64,
    /// Bytes in memory for a wave of threads.
    pub scratch_bytes: u64,
    /// Bytes that a workgroup shares.
    pub shared_bytes: u64,
    /// Waves of 32 threads that a unit can hold.
    pub waves: u64,
    pub code_bytes: u64,
    pub instructions: u64,
    /// Loads by kind, if they are counted: once for a wave, for each thread, of textures, and of shared memory.
    pub loads: [u64; 4],
    /// The compiler's estimate of clocks between two waves.
    pub cost: u64,
}

/// A device of a GPU that is not there.
pub(crate) struct Compiler {
    device: ash::Device,
    properties: ash::khr::pipeline_executable_properties::Device,
    /// The name of the device, and the version of the driver.
    pub name: String,
    /// Whether it reads assembly to count loads, which takes as long as compiling.
    counts_loads: bool,
    // Dropped last.
    _instance: ash::Instance,
    _entry: ash::Entry,
}

impl Compiler {
    /// Opens the device that the environment names.
    pub(crate) fn open(counts_loads: bool) -> anyhow::Result<Self> {
        // SAFETY: the loader that is found is Vulkan's. Each object is used while those exist that it was made from.
        unsafe {
            let entry = ash::Entry::load().context("no Vulkan loader: install libvulkan1")?;
            let application =
                vk::ApplicationInfo::default().api_version(vk::make_api_version(0, 1, 3, 0));
            let create = vk::InstanceCreateInfo::default().application_info(&application);
            let instance = entry.create_instance(&create, None)?;
            let all = instance.enumerate_physical_devices()?;
            let physical = *all.first().context("RADV offers no device")?;
            let mut driver = vk::PhysicalDeviceDriverProperties::default();
            let mut about = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
            instance.get_physical_device_properties2(physical, &mut about);
            let device = about.properties.device_name_as_c_str()?.to_string_lossy();
            let name = format!(
                "{device}, {}",
                driver.driver_info_as_c_str()?.to_string_lossy()
            );
            let queues = [vk::DeviceQueueCreateInfo::default().queue_priorities(&[1.0])];
            let extensions = [ash::khr::pipeline_executable_properties::NAME.as_ptr()];
            let mut executables =
                vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
                    .pipeline_executable_info(true);
            let mut twelve = vk::PhysicalDeviceVulkan12Features::default()
                .vulkan_memory_model(true)
                .vulkan_memory_model_device_scope(true);
            let mut thirteen = vk::PhysicalDeviceVulkan13Features::default()
                .shader_zero_initialize_workgroup_memory(true);
            let features = vk::PhysicalDeviceFeatures::default()
                .robust_buffer_access(true)
                .shader_storage_image_extended_formats(true);
            let create = vk::DeviceCreateInfo::default()
                .queue_create_infos(&queues)
                .enabled_extension_names(&extensions)
                .enabled_features(&features)
                .push_next(&mut executables)
                .push_next(&mut twelve)
                .push_next(&mut thirteen);
            let device = instance.create_device(physical, &create, None)?;
            let properties =
                ash::khr::pipeline_executable_properties::Device::new(&instance, &device);
            Ok(Self {
                device,
                properties,
                name,
                counts_loads,
                _instance: instance,
                _entry: entry,
            })
        }
    }

    /// Compiles an entry point.
    pub(crate) fn compile(
        &self,
        words: &[u32],
        module: &naga::Module,
        entry_point: &str,
    ) -> anyhow::Result<Statistics> {
        let sets = bindings(module);
        let name = CString::new(entry_point)?;
        // SAFETY: the words are valid SPIR-V, whose bindings the layout has. Each object is destroyed after its last use.
        unsafe {
            let device = &self.device;
            let layouts = sets
                .iter()
                .map(|bindings| {
                    let create = vk::DescriptorSetLayoutCreateInfo::default().bindings(bindings);
                    device.create_descriptor_set_layout(&create, None)
                })
                .collect::<Result<Vec<_>, _>>()?;
            let create = vk::PipelineLayoutCreateInfo::default().set_layouts(&layouts);
            let layout = device.create_pipeline_layout(&create, None)?;
            let create = vk::ShaderModuleCreateInfo::default().code(words);
            let shader = device.create_shader_module(&create, None)?;
            let stage = vk::PipelineShaderStageCreateInfo::default()
                .stage(vk::ShaderStageFlags::COMPUTE)
                .module(shader)
                .name(&name);
            let mut capture = vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR;
            if self.counts_loads {
                capture |= vk::PipelineCreateFlags::CAPTURE_INTERNAL_REPRESENTATIONS_KHR;
            }
            let create = vk::ComputePipelineCreateInfo::default()
                .stage(stage)
                .layout(layout)
                .flags(capture);
            let made = device.create_compute_pipelines(vk::PipelineCache::null(), &[create], None);
            let statistics = match made {
                Ok(pipelines) => {
                    let statistics = self.statistics(pipelines[0]);
                    device.destroy_pipeline(pipelines[0], None);
                    statistics
                }
                Err((_, error)) => Err(error.into()),
            };
            device.destroy_shader_module(shader, None);
            device.destroy_pipeline_layout(layout, None);
            for layout in layouts {
                device.destroy_descriptor_set_layout(layout, None);
            }
            statistics
        }
    }

    /// Reads what the compiler has kept of a pipeline.
    fn statistics(&self, pipeline: vk::Pipeline) -> anyhow::Result<Statistics> {
        let executable = vk::PipelineExecutableInfoKHR::default().pipeline(pipeline);
        // SAFETY: the pipeline has one executable, and was created to keep statistics and text.
        let (values, assembly) = unsafe {
            let values = self
                .properties
                .get_pipeline_executable_statistics(&executable)?;
            let assembly = match self.counts_loads {
                true => self.assembly(&executable)?,
                false => String::new(),
            };
            (values, assembly)
        };
        let mut found = BTreeMap::new();
        for value in &values {
            // SAFETY: RADV's statistics are unsigned.
            let number = unsafe { value.value.u64 };
            found.insert(
                value.name_as_c_str()?.to_string_lossy().into_owned(),
                number,
            );
        }
        let of = |name: &str| found.get(name).copied();
        let (Some(vgprs), Some(waves)) = (of("VGPRs"), of("Subgroups per SIMD")) else {
            bail!("the driver has no statistics of registers: {found:?}");
        };
        let or_none = |name| of(name).unwrap_or(0);
        Ok(Statistics {
            vgprs,
            waves,
            spilled: or_none("Spilled VGPRs") + or_none("Spilled SGPRs"),
            scratch_bytes: or_none("Scratch size"),
            shared_bytes: or_none("LDS size"),
            code_bytes: or_none("Code size"),
            instructions: or_none("Instructions"),
            loads: loads_in(&assembly),
            cost: or_none("Inverse Throughput"),
        })
    }

    /// Returns the assembly of an executable.
    ///
    /// # Safety
    /// Its pipeline keeps internal representations.
    unsafe fn assembly(
        &self,
        executable: &vk::PipelineExecutableInfoKHR<'_>,
    ) -> anyhow::Result<String> {
        let function = self
            .properties
            .fp()
            .get_pipeline_executable_internal_representations_khr;
        let handle = self.device.handle();
        let mut count = 0;
        // SAFETY: without rows, it returns their number.
        unsafe { function(handle, executable, &mut count, std::ptr::null_mut()) }.result()?;
        let mut rows =
            vec![vk::PipelineExecutableInternalRepresentationKHR::default(); count as usize];
        // SAFETY: without memory for text, it returns the length.
        unsafe { function(handle, executable, &mut count, rows.as_mut_ptr()) }.result()?;
        let mut memory: Vec<Vec<u8>> = rows.iter().map(|row| vec![0; row.data_size]).collect();
        for (row, bytes) in rows.iter_mut().zip(&mut memory) {
            row.p_data = bytes.as_mut_ptr().cast();
        }
        // SAFETY: each row has memory of the length that it asked for.
        unsafe { function(handle, executable, &mut count, rows.as_mut_ptr()) }.result()?;
        for (row, bytes) in rows.iter().zip(&memory) {
            let name = row.name_as_c_str()?.to_string_lossy();
            if name.contains("Assembly") || name.contains("assembly") {
                let text = CStr::from_bytes_until_nul(bytes)?;
                return Ok(text.to_string_lossy().into_owned());
            }
        }
        bail!("the driver has no assembly of a pipeline")
    }
}

impl Drop for Compiler {
    fn drop(&mut self) {
        // SAFETY: nothing uses the device any more.
        unsafe {
            self.device.destroy_device(None);
            self._instance.destroy_instance(None);
        }
    }
}

/// Returns the bindings of a module, by set.
fn bindings(module: &naga::Module) -> Vec<Vec<vk::DescriptorSetLayoutBinding<'static>>> {
    let mut sets: Vec<Vec<vk::DescriptorSetLayoutBinding<'static>>> = Vec::new();
    for (_, variable) in module.global_variables.iter() {
        let Some(binding) = &variable.binding else {
            continue;
        };
        let kind = match (&variable.space, &module.types[variable.ty].inner) {
            (naga::AddressSpace::Uniform, _) => vk::DescriptorType::UNIFORM_BUFFER,
            (naga::AddressSpace::Storage { .. }, _) => vk::DescriptorType::STORAGE_BUFFER,
            (_, naga::TypeInner::Sampler { .. }) => vk::DescriptorType::SAMPLER,
            (
                _,
                naga::TypeInner::Image {
                    class: naga::ImageClass::Storage { .. },
                    ..
                },
            ) => vk::DescriptorType::STORAGE_IMAGE,
            _ => vk::DescriptorType::SAMPLED_IMAGE,
        };
        let set = binding.group as usize;
        sets.resize(sets.len().max(set + 1), Vec::new());
        sets[set].push(
            vk::DescriptorSetLayoutBinding::default()
                .binding(binding.binding)
                .descriptor_count(1)
                .descriptor_type(kind)
                .stage_flags(vk::ShaderStageFlags::COMPUTE),
        );
    }
    sets
}

/// Counts loads in assembly, by kind: see [`Statistics::loads`].
fn loads_in(assembly: &str) -> [u64; 4] {
    let mut loads = [0; 4];
    for line in assembly.lines() {
        let Some(name) = line.split_whitespace().next() else {
            continue;
        };
        let kind = if name.starts_with("s_buffer_load") || name.starts_with("s_load") {
            0
        } else if ["buffer_load", "global_load", "flat_load"]
            .iter()
            .any(|prefix| name.starts_with(prefix))
        {
            1
        } else if ["image_load", "image_sample", "image_gather"]
            .iter()
            .any(|prefix| name.starts_with(prefix))
        {
            2
        } else if name.starts_with("ds_read") || name.starts_with("ds_load") {
            3
        } else {
            continue;
        };
        loads[kind] += 1;
    }
    loads
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loads_are_counted_by_kind() {
        let assembly = "\ts_load_dwordx4 s[0:3], s[2:3], null ; 1\n\tv_add_f32 v0, v1, v2\n\
            BB1:\n\tbuffer_load_dword v0, off, s[0:3], 0\n\timage_sample_lz v0, v[0:2], s[0:7], s[8:11]\n\
            \tds_read_b32 v1, v2\n\ts_buffer_load_dword s4, s[0:3], null\n\tbuffer_store_dword v0, v1";
        assert_eq!(loads_in(assembly), [2, 1, 1, 1]);
    }
}
