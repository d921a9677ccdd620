//! The format of samples in a device's textures: their own, or if shaders cannot write it, the first of four
//! channels, with 16-bit samples as half floats. WebGPU guarantees only the latter. A half float has 11 significant
//! bits, so near a surface it is as precise as 16 bits.

use crate::Gpu;
use argil_volume::SampleFormat;
use half::f16;
use std::borrow::Cow;

/// The format of texels.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum TexelFormat {
    /// The samples' own format.
    Plain(SampleFormat),
    /// The first of four channels.
    Wide(SampleFormat),
}

/// The code of 1 in a 16-bit sample.
const ONE: f32 = 32_767.0;

impl Gpu {
    /// Returns the texel format for a sample format, in textures that shaders write and filter.
    pub(crate) fn texels(&self, bits: SampleFormat) -> TexelFormat {
        let [eight, sixteen] = self.writes_snorm;
        let is_plain = match bits {
            SampleFormat::Snorm8 => eight,
            SampleFormat::Snorm16 => sixteen,
        };
        if is_plain {
            TexelFormat::Plain(bits)
        } else {
            TexelFormat::Wide(bits)
        }
    }

    /// Returns the bytes in a texture for a number of bytes of samples.
    pub(crate) fn texture_bytes(&self, bits: SampleFormat, sample_bytes: u64) -> u64 {
        sample_bytes / bits.bytes() as u64 * self.texels(bits).bytes() as u64
    }
}

impl TexelFormat {
    /// Returns the texel format of a texture.
    pub(crate) fn of(format: wgpu::TextureFormat) -> Self {
        match format {
            wgpu::TextureFormat::R8Snorm => Self::Plain(SampleFormat::Snorm8),
            wgpu::TextureFormat::R16Snorm => Self::Plain(SampleFormat::Snorm16),
            wgpu::TextureFormat::Rgba8Snorm => Self::Wide(SampleFormat::Snorm8),
            _ => Self::Wide(SampleFormat::Snorm16),
        }
    }

    /// Returns wgpu's format.
    pub(crate) fn format(self) -> wgpu::TextureFormat {
        match self {
            Self::Plain(SampleFormat::Snorm8) => wgpu::TextureFormat::R8Snorm,
            Self::Plain(SampleFormat::Snorm16) => wgpu::TextureFormat::R16Snorm,
            Self::Wide(SampleFormat::Snorm8) => wgpu::TextureFormat::Rgba8Snorm,
            Self::Wide(SampleFormat::Snorm16) => wgpu::TextureFormat::Rgba16Float,
        }
    }

    /// Returns the name in WGSL.
    pub(crate) fn wgsl(self) -> &'static str {
        match self {
            Self::Plain(SampleFormat::Snorm8) => "r8snorm",
            Self::Plain(SampleFormat::Snorm16) => "r16snorm",
            Self::Wide(SampleFormat::Snorm8) => "rgba8snorm",
            Self::Wide(SampleFormat::Snorm16) => "rgba16float",
        }
    }

    /// Returns the sample format.
    pub(crate) fn bits(self) -> SampleFormat {
        match self {
            Self::Plain(bits) | Self::Wide(bits) => bits,
        }
    }

    /// Returns the bytes of a texel.
    pub(crate) fn bytes(self) -> usize {
        match self {
            Self::Plain(bits) => bits.bytes(),
            Self::Wide(bits) => 4 * bits.bytes(),
        }
    }

    /// Converts samples to texels.
    pub(crate) fn texels_of(self, samples: &[u8]) -> Cow<'_, [u8]> {
        let mut texels = match self {
            Self::Plain(_) => return Cow::Borrowed(samples),
            Self::Wide(bits) => Vec::with_capacity(samples.len() / bits.bytes() * self.bytes()),
        };
        match self.bits() {
            SampleFormat::Snorm8 => texels.extend(samples.iter().flat_map(|&byte| [byte, 0, 0, 0])),
            SampleFormat::Snorm16 => {
                texels.extend(samples.as_chunks().0.iter().flat_map(|&sample| {
                    let value = f32::from(i16::from_le_bytes(sample)) / ONE;
                    let [a, b] = f16::from_f32(value).to_le_bytes();
                    [a, b, 0, 0, 0, 0, 0, 0]
                }))
            }
        }
        Cow::Owned(texels)
    }

    /// Appends the samples of texels.
    pub(crate) fn samples_into(self, texels: &[u8], samples: &mut Vec<u8>) {
        match self {
            Self::Plain(_) => samples.extend_from_slice(texels),
            Self::Wide(SampleFormat::Snorm8) => samples.extend(texels.iter().step_by(4)),
            Self::Wide(SampleFormat::Snorm16) => {
                let texels = texels.as_chunks::<8>().0.iter();
                samples.extend(texels.flat_map(|&[a, b, ..]| {
                    let value = f16::from_le_bytes([a, b]).to_f32() * ONE;
                    (value.round() as i16).to_le_bytes()
                }));
            }
        }
    }
}
