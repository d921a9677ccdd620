//! How samples lie in a device's textures: as they are, or where shaders cannot write such textures, in the first of four
//! channels, samples of 16 bits as half floats. WebGPU promises shaders the latter two alone. A half float has 11 bits, from
//! its first that is not 0 on: near a surface it is as exact as 16 bits are.

use crate::Gpu;
use argil_volume::SampleFormat;
use half::f16;
use std::borrow::Cow;

/// See the module's page.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum TexelFormat {
    /// As they are.
    Plain(SampleFormat),
    /// In the first of four channels.
    Wide(SampleFormat),
}

/// What stands for 1 in a sample of 16 bits.
const ONE: f32 = 32_767.0;

impl Gpu {
    /// The texels that hold samples of some width, in textures that shaders write and filter.
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

    /// Bytes that so many bytes of samples take in a texture.
    pub(crate) fn texture_bytes(&self, bits: SampleFormat, sample_bytes: u64) -> u64 {
        sample_bytes / bits.bytes() as u64 * self.texels(bits).bytes() as u64
    }
}

impl TexelFormat {
    /// Of a texture that was made for samples of some width.
    pub(crate) fn of(format: wgpu::TextureFormat) -> Self {
        match format {
            wgpu::TextureFormat::R8Snorm => Self::Plain(SampleFormat::Snorm8),
            wgpu::TextureFormat::R16Snorm => Self::Plain(SampleFormat::Snorm16),
            wgpu::TextureFormat::Rgba8Snorm => Self::Wide(SampleFormat::Snorm8),
            _ => Self::Wide(SampleFormat::Snorm16),
        }
    }

    /// As wgpu calls it.
    pub(crate) fn format(self) -> wgpu::TextureFormat {
        match self {
            Self::Plain(SampleFormat::Snorm8) => wgpu::TextureFormat::R8Snorm,
            Self::Plain(SampleFormat::Snorm16) => wgpu::TextureFormat::R16Snorm,
            Self::Wide(SampleFormat::Snorm8) => wgpu::TextureFormat::Rgba8Snorm,
            Self::Wide(SampleFormat::Snorm16) => wgpu::TextureFormat::Rgba16Float,
        }
    }

    /// As shaders call it.
    pub(crate) fn wgsl(self) -> &'static str {
        match self {
            Self::Plain(SampleFormat::Snorm8) => "r8snorm",
            Self::Plain(SampleFormat::Snorm16) => "r16snorm",
            Self::Wide(SampleFormat::Snorm8) => "rgba8snorm",
            Self::Wide(SampleFormat::Snorm16) => "rgba16float",
        }
    }

    /// The width of the samples.
    pub(crate) fn bits(self) -> SampleFormat {
        match self {
            Self::Plain(bits) | Self::Wide(bits) => bits,
        }
    }

    /// Bytes of a texel.
    pub(crate) fn bytes(self) -> usize {
        match self {
            Self::Plain(bits) => bits.bytes(),
            Self::Wide(bits) => 4 * bits.bytes(),
        }
    }

    /// Samples as texels.
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

    /// The samples of some texels, after others.
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
