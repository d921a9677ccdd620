//! Reads `.nvdb` files.

use super::NanoType;
use super::layout::{
    FILE_HEADER, FILE_METADATA, GRID, Inner, LEAF_HEAD, LOWER, MAGIC, NEWER_MAGICS, ROOT,
    ROOT_TILE, TREE, UPPER, origin_of,
};
use crate::tree::voxel_of;
use crate::{
    Grid, GridClass, GridHeader, LEAF_SIZE, Leaf, Lower, Mask, RootTile, Transform, Tree, Upper,
    VdbError,
};

/// Reads the grids of a `.nvdb` file with 32-bit, 16-bit or 8-bit floats. Checksums are checked where the file has them.
///
/// # Errors
/// If these are not the bytes of such a file of version 32, or they are damaged.
pub fn read(bytes: &[u8]) -> Result<Vec<Grid<f32>>, VdbError> {
    let file = Part { bytes, base: 0 };
    let magic = file.u64(0).map_err(|_| VdbError::NotThis("NanoVDB"))?;
    if magic != MAGIC && !NEWER_MAGICS.contains(&magic) {
        return Err(VdbError::NotThis("NanoVDB"));
    }
    if magic == NEWER_MAGICS[0] {
        // A grid alone.
        return Ok(vec![read_grid(file)?.0]);
    }
    check_version(file.u32(8)?)?;
    let words = file.u32(12)?;
    let (count, codec) = ((words & 0xffff) as usize, words >> 16);
    if codec != 0 {
        let text = "the file is compressed, which is not supported: write it without a codec";
        return Err(VdbError::Unsupported(text.into()));
    }
    let mut at = FILE_HEADER;
    for _ in 0..count {
        let name = file.u32(at + 136)? as usize;
        at = at
            .checked_add(FILE_METADATA + name)
            .filter(|&at| at <= bytes.len())
            .ok_or_else(|| file.truncated())?;
    }
    let mut grids = Vec::new();
    for _ in 0..count {
        let rest = bytes.get(at..).ok_or_else(|| file.truncated())?;
        let (grid, size) = read_grid(Part {
            bytes: rest,
            base: at as u64,
        })?;
        grids.push(grid);
        at += size;
    }
    Ok(grids)
}

fn check_version(version: u32) -> Result<(), VdbError> {
    let (major, minor) = (version >> 21, version >> 10 & 0x7ff);
    if major == 32 {
        return Ok(());
    }
    Err(VdbError::Version {
        found: format!("{major}.{minor}"),
        supported: "32",
    })
}

/// Bytes of a file, with checked access.
#[derive(Clone, Copy)]
struct Part<'a> {
    bytes: &'a [u8],
    base: u64,
}

impl<'a> Part<'a> {
    fn truncated(&self) -> VdbError {
        VdbError::Truncated {
            at: self.base + self.bytes.len() as u64,
            what: "a grid",
        }
    }

    fn damaged(&self, at: usize, what: impl Into<String>) -> VdbError {
        VdbError::Damaged {
            at: self.base + at as u64,
            what: what.into(),
        }
    }

    fn take(&self, at: usize, count: usize) -> Result<&'a [u8], VdbError> {
        let bytes = at
            .checked_add(count)
            .and_then(|end| self.bytes.get(at..end));
        bytes.ok_or_else(|| self.truncated())
    }

    fn array<const N: usize>(&self, at: usize) -> Result<[u8; N], VdbError> {
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(at, N)?);
        Ok(bytes)
    }

    fn u16(&self, at: usize) -> Result<u16, VdbError> {
        Ok(u16::from_le_bytes(self.array(at)?))
    }

    fn u32(&self, at: usize) -> Result<u32, VdbError> {
        Ok(u32::from_le_bytes(self.array(at)?))
    }

    fn u64(&self, at: usize) -> Result<u64, VdbError> {
        Ok(u64::from_le_bytes(self.array(at)?))
    }

    fn float(&self, at: usize) -> Result<f32, VdbError> {
        Ok(f32::from_le_bytes(self.array(at)?))
    }

    fn double(&self, at: usize) -> Result<f64, VdbError> {
        Ok(f64::from_le_bytes(self.array(at)?))
    }

    fn mask<const N: usize>(&self, at: usize) -> Result<Mask<N>, VdbError> {
        let mut mask = Mask::default();
        for (word, bytes) in mask
            .0
            .iter_mut()
            .zip(self.take(at, 8 * N)?.as_chunks::<8>().0)
        {
            *word = u64::from_le_bytes(*bytes);
        }
        Ok(mask)
    }

    /// Adds a signed offset of a file to a position.
    fn place(&self, from: usize, offset: u64) -> Result<usize, VdbError> {
        let at = (from as i64).checked_add(offset as i64);
        let at = at.and_then(|at| usize::try_from(at).ok());
        at.filter(|&at| at < self.bytes.len())
            .ok_or_else(|| self.damaged(from, "a node's offset leads out of the file"))
    }
}

/// Reads a grid, and returns its length.
fn read_grid(part: Part<'_>) -> Result<(Grid<f32>, usize), VdbError> {
    let magic = part.u64(0)?;
    if magic != MAGIC && magic != NEWER_MAGICS[0] {
        return Err(part.damaged(0, "a grid has no magic number"));
    }
    check_version(part.u32(16)?)?;
    let size = usize::try_from(part.u64(32)?).unwrap_or(usize::MAX);
    let part = Part {
        bytes: part.take(0, size.max(GRID + TREE + ROOT))?,
        base: part.base,
    };
    let number = part.u32(636)?;
    let kind = NanoType::from_number(number).ok_or_else(|| {
        let text = format!(
            "a grid of the type {number} is not supported, only 1 (Float), 14 (Fp8) and 15 (Fp16)"
        );
        VdbError::Unsupported(text)
    })?;
    check_head(&part)?;
    let name = part.take(40, 256)?;
    let name = name.split(|&byte| byte == 0).next().unwrap_or_default();
    let class = match part.u32(632)? {
        1 => GridClass::LevelSet,
        2 => GridClass::FogVolume,
        _ => GridClass::Unknown,
    };
    let header = GridHeader::new(String::from_utf8_lossy(name), class, transform(&part)?);
    let tree = NodeReader {
        part,
        kind,
        bytes_left: part.bytes.len(),
    }
    .tree()?;
    Ok((Grid::new(header, tree), size))
}

/// Compares the checksum of the grid, the tree and the root, if there is one.
fn check_head(part: &Part<'_>) -> Result<(), VdbError> {
    // Since 32.6 other bytes are summed.
    let minor = part.u32(16)? >> 10 & 0x7ff;
    let (sum, of_nodes) = (part.u32(8)?, part.u32(12)?);
    if minor >= 6 || (sum == u32::MAX && of_nodes == u32::MAX) {
        return Ok(());
    }
    let root = part.place(GRID, part.u64(GRID + 24)?)?;
    let tiles = part.u32(root + 24)? as usize;
    let length = tiles
        .checked_mul(ROOT_TILE)
        .map(|tile_bytes| GRID + TREE + ROOT + tile_bytes);
    let bytes = part.take(16, length.unwrap_or(usize::MAX).saturating_sub(16))?;
    if crc32fast::hash(bytes) == sum {
        Ok(())
    } else {
        Err(VdbError::Checksum)
    }
}

fn transform(part: &Part<'_>) -> Result<Transform, VdbError> {
    // The matrix in double precision, its inverse, and the translation.
    let matrix = 296 + 36 + 36 + 12 + 4;
    let mut transform = Transform::uniform(1.0, [0.0; 3]);
    for row in 0..3 {
        for axis in 0..3 {
            transform.columns[axis][row] = part.double(matrix + 8 * (3 * row + axis))?;
        }
        transform.translation[row] = part.double(matrix + 144 + 8 * row)?;
    }
    if transform.is_finite() {
        Ok(transform)
    } else {
        Err(part.damaged(296, "a transform is not finite"))
    }
}

struct NodeReader<'a> {
    part: Part<'a>,
    kind: NanoType,
    /// Bytes of nodes that were not read yet. Nodes that share a child would have more than the file.
    bytes_left: usize,
}

impl NodeReader<'_> {
    fn tree(mut self) -> Result<Tree<f32>, VdbError> {
        let part = self.part;
        let root = part.place(GRID, part.u64(GRID + 24)?)?;
        let count = part.u32(root + 24)? as usize;
        let mut tree = Tree::new(part.float(root + 28)?);
        for i in 0..count {
            let at = root + ROOT + ROOT_TILE * i;
            let origin = origin_of(part.u64(at)?);
            let child = part.u64(at + 8)?;
            if child == 0 {
                tree.tiles.push(RootTile {
                    origin,
                    value: part.float(at + 20)?,
                    is_active: part.u32(at + 16)? != 0,
                });
                continue;
            }
            tree.uppers
                .push(self.upper(part.place(root, child)?, origin)?);
        }
        tree.uppers.sort_by_key(|upper| upper.origin);
        let is_twice = |pair: &[Upper<f32>]| pair[0].origin == pair[1].origin;
        if tree.uppers.windows(2).any(is_twice) {
            return Err(part.damaged(root, "two upper nodes have one origin"));
        }
        Ok(tree)
    }

    fn count(&mut self, at: usize, bytes: usize) -> Result<(), VdbError> {
        self.bytes_left = self
            .bytes_left
            .checked_sub(bytes)
            .ok_or_else(|| self.part.damaged(at, "several nodes share a child"))?;
        Ok(())
    }

    fn upper(&mut self, at: usize, origin: [i32; 3]) -> Result<Upper<f32>, VdbError> {
        self.count(at, UPPER.bytes())?;
        let (children, active) = self.masks::<512>(at, &UPPER)?;
        let mut lowers = Vec::new();
        let tiles = self.tiles(at, &UPPER, &children)?;
        for place in children.places() {
            let child = self.child(at, &UPPER, place)?;
            lowers.push(self.lower(child, voxel_of(origin, place, 4096, 128))?);
        }
        Ok(Upper {
            origin,
            children,
            active,
            tiles,
            lowers,
        })
    }

    fn lower(&mut self, at: usize, origin: [i32; 3]) -> Result<Lower<f32>, VdbError> {
        self.count(at, LOWER.bytes())?;
        let (children, active) = self.masks::<64>(at, &LOWER)?;
        let tiles = self.tiles(at, &LOWER, &children)?;
        let mut leaves = Vec::new();
        for place in children.places() {
            let child = self.child(at, &LOWER, place)?;
            leaves.push(self.leaf(child, voxel_of(origin, place, 128, 8))?);
        }
        Ok(Lower {
            origin,
            children,
            active,
            tiles,
            leaves,
        })
    }

    fn masks<const N: usize>(
        &self,
        at: usize,
        layout: &Inner,
    ) -> Result<(Mask<N>, Mask<N>), VdbError> {
        let children = self.part.mask(at + layout.children())?;
        Ok((children, self.part.mask(at + Inner::ACTIVE)?))
    }

    fn tiles<const N: usize>(
        &self,
        at: usize,
        layout: &Inner,
        children: &Mask<N>,
    ) -> Result<Vec<f32>, VdbError> {
        let table = self.part.take(at + layout.table(), 8 * layout.places)?;
        let words = table.as_chunks::<8>().0.iter().enumerate();
        let value = |(place, word): (usize, &[u8; 8])| match children.is_on(place) {
            true => 0.0,
            false => f32::from_le_bytes([word[0], word[1], word[2], word[3]]),
        };
        Ok(words.map(value).collect())
    }

    fn child(&self, at: usize, layout: &Inner, place: usize) -> Result<usize, VdbError> {
        let offset = self.part.u64(at + layout.table() + 8 * place)?;
        self.part.place(at, offset)
    }

    fn leaf(&mut self, at: usize, origin: [i32; 3]) -> Result<Leaf<f32>, VdbError> {
        self.count(at, self.kind.leaf_bytes())?;
        let part = self.part;
        let mut leaf = Leaf::new(origin, 0.0);
        leaf.active = part.mask(at + 16)?;
        if self.kind == NanoType::Float {
            let bytes = part.take(at + LEAF_HEAD, 4 * LEAF_SIZE)?;
            for (value, chunk) in leaf.values.iter_mut().zip(bytes.as_chunks::<4>().0) {
                *value = f32::from_le_bytes(*chunk);
            }
            return Ok(leaf);
        }
        let (least, quantum) = (part.float(at + 80)?, part.float(at + 84)?);
        for (i, value) in leaf.values.iter_mut().enumerate() {
            let code = match self.kind {
                NanoType::Fp8 => u16::from(part.take(at + LEAF_HEAD + i, 1)?[0]),
                _ => part.u16(at + LEAF_HEAD + 2 * i)?,
            };
            *value = f32::from(code) * quantum + least;
        }
        Ok(leaf)
    }
}
