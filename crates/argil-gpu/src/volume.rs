//! Volumes on the device: what is kept of them, pictures, and the ways to and from the CPU.

use crate::bricks::{self, BrickTables};
use crate::pass::{BRICK_MATERIALS, CELLS, LINEAR, NODES, STORED, TREE_WORDS, VOLUME, entry};
use crate::picture::Way;
use crate::table::Table;
use crate::texels::TexelFormat;
use crate::{Gpu, GpuError, GpuField};
use argil_abi::{self as abi, Frame, Node, Volume as Words};
use argil_march::Picture;
use argil_volume::{
    Bits, BrickLayout, Dense, Encoding, Lattice, Layout, Octree, Texels, Tree, Volume,
};

/// Bytes that a row of texels takes in a buffer is a multiple of this.
const ROW_ALIGNMENT: u32 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;

/// What a volume is, besides its texture.
pub(crate) enum Kind {
    Dense,
    Octree(Box<TreeTables>),
    Bricks(Box<BrickTables>),
}

impl Kind {
    fn way(&self) -> Way {
        match self {
            Self::Dense => Way::Dense,
            Self::Octree(_) => Way::Octree,
            Self::Bricks(tables) if tables.cells.table.levels() > 0 => Way::WideBricks,
            Self::Bricks(_) => Way::Bricks,
        }
    }
}

/// An octree's tables.
pub(crate) struct TreeTables {
    pub layout: Layout,
    pub keys: Table,
    pub nodes: Table,
    pub words: Table,
}

/// A volume on a device.
pub struct GpuVolume {
    lattice: Lattice,
    encoding: Encoding,
    texture: wgpu::Texture,
    sampler: wgpu::Sampler,
    words: Words,
    uniform: wgpu::Buffer,
    kind: Kind,
}

impl GpuVolume {
    pub(crate) fn new(
        field: &GpuField,
        lattice: Lattice,
        encoding: Encoding,
        texture: wgpu::Texture,
        words: Words,
        kind: Kind,
    ) -> Result<Self, GpuError> {
        let gpu = field.gpu();
        let way = kind.way();
        // Compiled now, if it was not yet, and not when the first picture is wanted.
        field.picture(way)?;
        let (sampler, uniform) = gpu.checked(|| {
            let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("stored distances"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..wgpu::SamplerDescriptor::default()
            });
            (sampler, uniform_of::<Words>(gpu, "volume"))
        })?;
        Ok(Self {
            lattice,
            encoding,
            texture,
            sampler,
            words,
            uniform,
            kind,
        })
    }

    /// Bring a volume over. `field` is what it was made from: it gives the light.
    pub async fn upload(field: &GpuField, volume: &Volume) -> Result<Self, GpuError> {
        let gpu = field.gpu();
        match volume {
            Volume::Dense(dense) => {
                let (lattice, encoding) = (*dense.lattice(), *dense.encoding());
                let levels = dense.levels().len() as u32;
                let texture = texture(gpu, &lattice, encoding.bits, levels)?;
                for (level, texels) in (0..).zip(dense.levels()) {
                    upload(gpu, &texture, &lattice, level, texels).await?;
                }
                let words = dense_words(&lattice, &encoding, levels);
                Self::new(field, lattice, encoding, texture, words, Kind::Dense)
            }
            Volume::Bricks(bricks) => Self::upload_bricks(field, bricks).await,
            Volume::Octree(octree) => {
                let layout = *octree.layout();
                let texture = texture(gpu, &layout.lattice, layout.encoding.bits, 1)?;
                upload(gpu, &texture, &layout.lattice, 0, octree.texels()).await?;
                let tree = octree.tree();
                let mut tables = TreeTables::new(layout);
                let mut words = [0u32; abi::TREE_WORDS as usize];
                words[abi::TREE_BRICKS as usize] = tree.codes().len() as u32;
                words[abi::TREE_NODES as usize] = tree.nodes().len() as u32;
                for (to, from) in words[abi::TREE_LEVELS as usize..]
                    .iter_mut()
                    .zip(tree.levels())
                {
                    *to = *from;
                }
                tables.words.write(gpu, &words)?;
                tables.keys.write(gpu, tree.codes())?;
                tables.nodes.write(gpu, tree.nodes())?;
                let words = octree_words(&layout);
                let kind = Kind::Octree(Box::new(tables));
                Self::new(field, layout.lattice, layout.encoding, texture, words, kind)
            }
        }
    }

    /// Draw as [`GpuField::render`] does, primary rays and normals through the volume.
    pub async fn render(
        &self,
        field: &GpuField,
        frames: &[Frame],
    ) -> Result<(Picture, f64), GpuError> {
        let gpu = field.gpu();
        gpu.queue
            .write_buffer(&self.uniform, 0, bytemuck::bytes_of(&self.words));
        let view = self
            .texture
            .create_view(&wgpu::TextureViewDescriptor::default());
        let mut own = vec![
            entry(VOLUME, &self.uniform),
            wgpu::BindGroupEntry {
                binding: STORED,
                resource: wgpu::BindingResource::TextureView(&view),
            },
            wgpu::BindGroupEntry {
                binding: LINEAR,
                resource: wgpu::BindingResource::Sampler(&self.sampler),
            },
        ];
        if let Kind::Octree(tables) = &self.kind {
            own.extend(tables.nodes.binding(NODES));
            own.extend(tables.words.binding(TREE_WORDS));
        }
        if let Kind::Bricks(tables) = &self.kind {
            own.extend(tables.cells.buffer.binding(CELLS));
            own.extend(tables.materials.binding(BRICK_MATERIALS));
        }
        field
            .picture(self.kind.way())?
            .draw(field, &own, frames)
            .await
    }

    /// Where the voxels lie.
    pub fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// What texels mean.
    pub fn encoding(&self) -> &Encoding {
        &self.encoding
    }

    /// Levels of detail.
    pub fn levels(&self) -> u32 {
        self.texture.mip_level_count()
    }

    /// An octree's measures.
    pub fn layout(&self) -> Option<&Layout> {
        match &self.kind {
            Kind::Octree(tables) => Some(&tables.layout),
            _ => None,
        }
    }

    /// Where an octree's look-ups begin from now on.
    pub fn set_descent(&mut self, descent: argil_march::Descent) {
        self.words.descent = match descent {
            argil_march::Descent::Root => abi::DESCENT_ROOT,
            argil_march::Descent::Path => abi::DESCENT_PATH,
        };
    }

    /// The numbers of an octree's bricks and nodes.
    pub async fn tree_size(&self, gpu: &Gpu) -> Result<Option<(u64, u64)>, GpuError> {
        let Kind::Octree(tables) = &self.kind else {
            return Ok(None);
        };
        let words = tables.read_words(gpu).await?;
        let word = |i: u32| u64::from(words.get(i as usize).copied().unwrap_or(0));
        Ok(Some((word(abi::TREE_BRICKS), word(abi::TREE_NODES))))
    }

    /// What sparse bricks are, and how many, after a wait for edits.
    pub async fn sparse(&self, gpu: &Gpu) -> Result<Option<(BrickLayout, u64)>, GpuError> {
        match &self.kind {
            Kind::Bricks(tables) => Ok(Some((tables.layout, tables.count(gpu).await?))),
            _ => Ok(None),
        }
    }

    /// How sparse bricks lie.
    pub fn brick_layout(&self) -> Option<&BrickLayout> {
        match &self.kind {
            Kind::Bricks(tables) => Some(&tables.layout),
            _ => None,
        }
    }

    /// What marching reads: the texture, the words, and of bricks the cells' table.
    pub(crate) fn march_parts(&self) -> (&wgpu::Texture, &Words, Option<&Table>) {
        let cells = match &self.kind {
            Kind::Bricks(tables) => Some(&tables.cells.buffer),
            _ => None,
        };
        (&self.texture, &self.words, cells)
    }

    pub(crate) fn set_lattice(&mut self, lattice: Lattice) {
        self.lattice = lattice;
    }

    /// What edits of bricks change.
    pub(crate) fn brick_parts(
        &mut self,
    ) -> (&mut Words, &mut wgpu::Texture, Option<&mut BrickTables>) {
        let tables = match &mut self.kind {
            Kind::Bricks(tables) => Some(&mut **tables),
            _ => None,
        };
        (&mut self.words, &mut self.texture, tables)
    }

    /// Bytes on the device: textures and tables.
    pub fn memory_bytes(&self) -> u64 {
        let texel = TexelFormat::of(self.texture.format()).bytes() as u64;
        if let Kind::Bricks(tables) = &self.kind {
            return tables.memory_bytes(texel);
        }
        let texels: u64 = (0..self.texture.mip_level_count())
            .map(|level| self.lattice.texel_count(level) * texel)
            .sum();
        let tables = match &self.kind {
            Kind::Octree(t) => t.keys.size() + t.nodes.size() + t.words.size(),
            _ => 0,
        };
        texels + tables
    }

    /// Bring the volume back.
    pub async fn read(&self, gpu: &Gpu) -> Result<Volume, GpuError> {
        let odd = || GpuError::Lost("the volume came back in parts that do not fit".into());
        match &self.kind {
            Kind::Dense => {
                let mut levels = Vec::new();
                for level in 0..self.texture.mip_level_count() {
                    levels.push(self.read_level(gpu, level).await?);
                }
                let dense = Dense::from_levels(self.lattice, self.encoding, levels);
                Ok(Volume::Dense(dense.ok_or_else(odd)?))
            }
            Kind::Bricks(tables) => Ok(Volume::Bricks(
                bricks::read(gpu, &self.texture, tables).await?,
            )),
            Kind::Octree(tables) => {
                let tree = tables.read(gpu).await?;
                let octree =
                    Octree::from_parts(tables.layout, tree, self.read_level(gpu, 0).await?);
                Ok(Volume::Octree(octree.ok_or_else(odd)?))
            }
        }
    }

    async fn read_level(&self, gpu: &Gpu, level: u32) -> Result<Texels, GpuError> {
        let size = self.lattice.level_size(level);
        let bits = self.encoding.bits;
        let layer_bytes = (size.x * size.y) as u64 * bits.bytes() as u64;
        let mut bytes = Vec::with_capacity((layer_bytes * u64::from(size.z)) as usize);
        // Some layers at a time: a buffer has its limits.
        let layers = (STAGING_BYTES / layer_bytes).clamp(1, u64::from(size.z)) as u32;
        for first in (0..size.z).step_by(layers as usize) {
            let range = first..(first + layers).min(size.z);
            let part =
                read_texels(gpu, &self.texture, level, bits, [size.x, size.y], range).await?;
            bytes.extend_from_slice(&part);
        }
        Texels::from_bytes(bits, bytes).ok_or_else(|| GpuError::Lost("half a texel".into()))
    }
}

/// The texels of some layers of a texture, without gaps.
pub(crate) async fn read_texels(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    mip_level: u32,
    bits: Bits,
    [width, height]: [u32; 2],
    layers: std::ops::Range<u32>,
) -> Result<Vec<u8>, GpuError> {
    let texels = gpu.texels(bits);
    let row = width as usize * texels.bytes();
    let padded = (row as u32).next_multiple_of(ROW_ALIGNMENT);
    let staged = gpu.checked(|| {
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("texels"),
            size: u64::from(padded) * u64::from(height) * layers.len() as u64,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let mut encoder = gpu
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level,
                origin: wgpu::Origin3d {
                    x: 0,
                    y: 0,
                    z: layers.start,
                },
                aspect: wgpu::TextureAspect::All,
            },
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded),
                    rows_per_image: Some(height),
                },
            },
            extent(width, height, layers.len() as u32),
        );
        gpu.queue.submit([encoder.finish()]);
        buffer
    })?;
    let read = gpu.read_back(&staged, staged.size()).await?;
    let samples = width as usize * height as usize * layers.len();
    let mut bytes = Vec::with_capacity(samples * bits.bytes());
    for line in read.chunks_exact(padded as usize) {
        texels.samples_into(&line[..row], &mut bytes);
    }
    Ok(bytes)
}

/// Most bytes of texels on their way from or to the device at once.
pub(crate) const STAGING_BYTES: u64 = 64 << 20;

impl TreeTables {
    pub fn new(layout: Layout) -> Self {
        Self {
            layout,
            keys: Table::new("bricks' codes"),
            nodes: Table::new("nodes"),
            words: Table::new("tree"),
        }
    }

    async fn read_words(&self, gpu: &Gpu) -> Result<Vec<u32>, GpuError> {
        let bytes = read_table(gpu, &self.words, 4 * u64::from(abi::TREE_WORDS)).await?;
        Ok(bytes
            .chunks_exact(4)
            .map(bytemuck::pod_read_unaligned)
            .collect())
    }

    /// Bring the tree back.
    pub async fn read(&self, gpu: &Gpu) -> Result<Tree, GpuError> {
        let words = self.read_words(gpu).await?;
        let word = |i: u32| words.get(i as usize).copied().unwrap_or(0);
        let (bricks, nodes) = (word(abi::TREE_BRICKS), word(abi::TREE_NODES));
        let codes = read_table(gpu, &self.keys, 4 * u64::from(bricks))
            .await?
            .chunks_exact(4)
            .map(bytemuck::pod_read_unaligned)
            .collect();
        let nodes = read_table(
            gpu,
            &self.nodes,
            size_of::<Node>() as u64 * u64::from(nodes),
        )
        .await?
        .chunks_exact(size_of::<Node>())
        .map(bytemuck::pod_read_unaligned)
        .collect();
        let levels = (0..self.layout.depth)
            .map(|level| word(abi::TREE_LEVELS + level))
            .collect();
        Ok(Tree::from_parts(codes, nodes, levels))
    }
}

pub(crate) async fn read_table(gpu: &Gpu, table: &Table, bytes: u64) -> Result<Vec<u8>, GpuError> {
    let lost = || GpuError::Lost("a table is not there".into());
    if bytes == 0 {
        return Ok(Vec::new());
    }
    gpu.read_back(table.buffer().ok_or_else(lost)?, bytes).await
}

pub(crate) fn dense_words(lattice: &Lattice, encoding: &Encoding, levels: u32) -> Words {
    let [cx, cy, cz] = lattice.corner.to_array();
    let [ex, ey, ez] = lattice.extent().to_array();
    Words {
        corner_range: [cx, cy, cz, encoding.range_length(lattice, 0)],
        extent_voxel: [ex, ey, ez, lattice.voxel],
        size_x: lattice.size.x,
        size_y: lattice.size.y,
        size_z: lattice.size.z,
        levels,
        quanta: encoding.bits.quanta(),
        ..Words::default()
    }
}

/// Words for marching, which needs nothing of the field.
fn octree_words(layout: &Layout) -> Words {
    Words {
        grid_x: layout.grid.x,
        grid_y: layout.grid.y,
        grid_z: layout.grid.z,
        brick: layout.brick,
        depth: layout.depth,
        code_count: layout.code_count(),
        ..dense_words(&layout.lattice, &layout.encoding, 1)
    }
}

pub(crate) fn uniform_of<T>(gpu: &Gpu, label: &str) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: size_of::<T>() as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// An empty texture for a lattice that shaders can write and filter.
pub(crate) fn texture(
    gpu: &Gpu,
    lattice: &Lattice,
    bits: Bits,
    levels: u32,
) -> Result<wgpu::Texture, GpuError> {
    let size = extent(lattice.size.x, lattice.size.y, lattice.size.z);
    texture_of(gpu, size, bits, levels)
}

/// An empty texture that shaders can write and filter.
pub(crate) fn texture_of(
    gpu: &Gpu,
    size: wgpu::Extent3d,
    bits: Bits,
    levels: u32,
) -> Result<wgpu::Texture, GpuError> {
    let format = gpu.texels(bits).format();
    let voxels = size.width.max(size.height).max(size.depth_or_array_layers);
    let limit = gpu.device.limits().max_texture_dimension_3d;
    if voxels > limit {
        return Err(GpuError::TooFine {
            name: gpu.info.name.clone(),
            voxels,
            limit,
        });
    }
    gpu.checked(|| {
        gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("volume"),
            size,
            mip_level_count: levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::STORAGE_BINDING
                | wgpu::TextureUsages::COPY_SRC
                | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        })
    })
}

pub(crate) fn extent(width: u32, height: u32, depth_or_array_layers: u32) -> wgpu::Extent3d {
    wgpu::Extent3d {
        width,
        height,
        depth_or_array_layers,
    }
}

async fn upload(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    lattice: &Lattice,
    level: u32,
    texels: &Texels,
) -> Result<(), GpuError> {
    let size = lattice.level_size(level);
    let row = size.x as usize * texels.bits().bytes();
    let layer_bytes = row * size.y as usize;
    let layers = (STAGING_BYTES as usize / layer_bytes).clamp(1, size.z as usize);
    let format = gpu.texels(texels.bits());
    let texel_row = size.x as usize * format.bytes();
    for (i, part) in texels.bytes().chunks(layers * layer_bytes).enumerate() {
        gpu.checked(|| {
            gpu.queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture,
                    mip_level: level,
                    origin: wgpu::Origin3d {
                        x: 0,
                        y: 0,
                        z: (i * layers) as u32,
                    },
                    aspect: wgpu::TextureAspect::All,
                },
                &format.texels_of(part),
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(texel_row as u32),
                    rows_per_image: Some(size.y),
                },
                extent(size.x, size.y, (part.len() / layer_bytes) as u32),
            );
        })?;
        // What is staged is freed once it has arrived.
        gpu.queue.submit([]);
        gpu.wait().await?;
    }
    Ok(())
}
