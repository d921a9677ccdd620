//! Writes `.vdb` files.

use super::bytes::{write_place, write_string};
use super::topology::{write_leaves, write_upper};
use super::values::Packing;
use super::{FILE_VERSION, FLAG_ACTIVE_MASK, FLAG_BLOSC, FLAG_ZIP, MAGIC, metadata};
use crate::tree::TreeStatistics;
use crate::{AnyGrid, Codec, Grid, GridHeader, MetaValue, Metadata, RootTile, Upper, Voxel};
use std::io::{Read, Result, Seek, SeekFrom, Write};

/// How grids are written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WriteOptions {
    /// The compression of values.
    pub codec: Codec,
    /// Whether active values have 16 bits.
    pub is_half: bool,
    /// Metadata of the file.
    pub metadata: Metadata,
}

/// Writes grids to a `.vdb` file. Grids with one name get numbers.
///
/// ```
/// use argil_vdb::{Grid, GridClass, GridHeader, Leaf, Transform, Tree, vdb};
/// let mut leaf = Leaf::new([0, 0, 0], 3.0f32);
/// leaf.set([1, 2, 3], -0.5);
/// let header = GridHeader::new("surface", GridClass::LevelSet, Transform::uniform(0.1, [0.0; 3]));
/// let grid = Grid::new(header, Tree::from_leaves(3.0, vec![leaf]));
/// let mut bytes = std::io::Cursor::new(Vec::new());
/// vdb::write(&mut bytes, &[grid.clone().into()], &vdb::WriteOptions::default())?;
/// let file = vdb::VdbFile::parse(bytes.get_ref())?;
/// assert_eq!(file.grid(0)?.as_float().unwrap().tree, grid.tree);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If `out` fails.
pub fn write(
    out: &mut (impl Write + Seek),
    grids: &[AnyGrid],
    options: &WriteOptions,
) -> Result<()> {
    let mut file = VdbWriter::new(out, grids.len(), options)?;
    for grid in grids {
        match grid {
            AnyGrid::Float(grid) => file.grid(grid)?,
            AnyGrid::Vec3(grid) => file.grid(grid)?,
        }
    }
    file.finish()
}

/// Writes a `.vdb` file grid by grid, and a grid upper node by upper node.
#[derive(Debug)]
pub struct VdbWriter<W> {
    out: W,
    at: u64,
    grids: usize,
    names: Vec<String>,
    options: WriteOptions,
}

impl<W: Write + Seek> VdbWriter<W> {
    /// Begins a file of a number of grids.
    ///
    /// # Errors
    /// If `out` fails.
    pub fn new(mut out: W, grids: usize, options: &WriteOptions) -> Result<Self> {
        let mut head = Vec::new();
        head.extend(MAGIC.to_le_bytes());
        for word in [FILE_VERSION, 10, 0] {
            head.extend(word.to_le_bytes());
        }
        head.push(1);
        head.extend(b"61726769-6c2d-7664-6230-303030303030");
        metadata::write(&options.metadata, &mut head);
        head.extend((grids as i32).to_le_bytes());
        out.write_all(&head)?;
        Ok(Self {
            out,
            at: head.len() as u64,
            grids,
            names: Vec::new(),
            options: options.clone(),
        })
    }

    fn put(&mut self, bytes: &[u8]) -> Result<()> {
        self.at += bytes.len() as u64;
        self.out.write_all(bytes)
    }

    /// Overwrites bytes that came before.
    fn patch(&mut self, at: u64, bytes: &[u8]) -> Result<()> {
        let back = self.at as i64 - at as i64;
        self.out.seek(SeekFrom::Current(-back))?;
        self.out.write_all(bytes)?;
        self.out
            .seek(SeekFrom::Current(back - bytes.len() as i64))?;
        Ok(())
    }

    /// Writes a whole grid.
    ///
    /// # Errors
    /// If `out` fails, or more grids are written than were announced.
    pub fn grid<V: Voxel>(&mut self, grid: &Grid<V>) -> Result<()> {
        let tree = &grid.tree;
        let begun = self.begin(&grid.header, tree.background, &tree.tiles)?;
        let mut statistics = begun.statistics;
        for upper in &tree.uppers {
            let mut topology = Vec::new();
            statistics.add_upper(upper);
            write_upper(upper, &begun.packing, &mut topology);
            self.put(&topology)?;
        }
        let buffers = self.at;
        for upper in &tree.uppers {
            write_leaves(upper, &begun.packing, &mut |bytes| self.put(bytes))?;
        }
        self.end(&begun, &statistics, tree.uppers.len(), buffers)
    }

    /// Begins a grid whose upper nodes come one after another. The values of leaves are kept in `scratch`, such as a
    /// temporary file, because a file has the masks of all nodes first.
    ///
    /// # Errors
    /// If `out` fails, or more grids are written than were announced.
    pub fn stream<'a, V: Voxel, S: Read + Write + Seek>(
        &'a mut self,
        header: &GridHeader,
        background: V,
        tiles: &[RootTile<V>],
        scratch: S,
    ) -> Result<GridWriter<'a, W, V, S>> {
        let begun = self.begin(header, background, tiles)?;
        Ok(GridWriter {
            file: self,
            statistics: begun.statistics,
            begun,
            uppers: 0,
            scratch,
        })
    }

    fn begin<V: Voxel>(
        &mut self,
        header: &GridHeader,
        background: V,
        tiles: &[RootTile<V>],
    ) -> Result<BegunGrid<V>> {
        if self.names.len() == self.grids {
            let text = format!(
                "more than {} grids are written, which were announced",
                self.grids
            );
            return Err(std::io::Error::other(text));
        }
        let packing = Packing {
            background,
            codec: self.options.codec,
            is_half: self.options.is_half,
        };
        let mut statistics = TreeStatistics::default();
        for tile in tiles.iter().filter(|tile| tile.is_active) {
            statistics.add_root_tile(tile.origin);
        }
        let mut out = self.descriptor::<V>(&header.name);
        let offsets = self.at + out.len() as u64;
        out.extend([0; 24]);
        let grid = self.at + out.len() as u64;
        let flags = FLAG_ACTIVE_MASK
            | match self.options.codec {
                Codec::None => 0,
                Codec::Zip => FLAG_ZIP,
                Codec::Blosc => FLAG_BLOSC,
            };
        out.extend(flags.to_le_bytes());
        let known = self.known_metadata(header);
        // Statistics come last and have fixed lengths, because they are known at the end.
        let mut metadata_bytes = Vec::new();
        metadata::write(
            &[
                known,
                header.metadata.clone(),
                statistics_metadata(&statistics),
            ]
            .concat(),
            &mut metadata_bytes,
        );
        let patched = self.at + (out.len() + metadata_bytes.len()) as u64
            - statistics_bytes(&statistics).len() as u64;
        out.extend(metadata_bytes);
        metadata::write_transform(&header.transform, &mut out);
        out.extend(1i32.to_le_bytes());
        let rounded = |value: V| match self.options.is_half {
            true => value.rounded(),
            false => value,
        };
        rounded(background).write(&mut out);
        out.extend((tiles.len() as u32).to_le_bytes());
        let children = self.at + out.len() as u64;
        out.extend(0u32.to_le_bytes());
        for tile in tiles {
            write_place(tile.origin, &mut out);
            rounded(tile.value).write(&mut out);
            out.push(u8::from(tile.is_active));
        }
        self.put(&out)?;
        Ok(BegunGrid {
            packing,
            offsets,
            grid,
            patched,
            children,
            statistics,
        })
    }

    /// Returns the name and the type of the next grid.
    fn descriptor<V: Voxel>(&mut self, name: &str) -> Vec<u8> {
        let mut out = Vec::new();
        let count = self.names.iter().filter(|other| *other == name).count();
        let unique = match count {
            0 => name.to_owned(),
            n => format!("{name}\u{1e}{n}"),
        };
        self.names.push(name.to_owned());
        write_string(&unique, &mut out);
        let half = if self.options.is_half {
            "_HalfFloat"
        } else {
            ""
        };
        write_string(&format!("{}{half}", V::TREE), &mut out);
        write_string("", &mut out);
        out
    }

    fn known_metadata(&self, header: &GridHeader) -> Metadata {
        let codec = match self.options.codec {
            Codec::None => "active values",
            Codec::Zip => "zip + active values",
            Codec::Blosc => "blosc + active values",
        };
        let named = |name: &str, value| (name.to_owned(), value);
        let text = |text: &str| MetaValue::String(text.to_owned());
        vec![
            named("class", text(header.class.name())),
            named("name", text(&header.name)),
            named(
                "is_saved_as_half_float",
                MetaValue::Bool(self.options.is_half),
            ),
            named("is_local_space", MetaValue::Bool(false)),
            named("file_compression", text(codec)),
        ]
    }

    fn end<V>(
        &mut self,
        begun: &BegunGrid<V>,
        statistics: &TreeStatistics,
        uppers: usize,
        buffers: u64,
    ) -> Result<()> {
        self.patch(begun.children, &(uppers as u32).to_le_bytes())?;
        self.patch(begun.patched, &statistics_bytes(statistics))?;
        let offsets = [begun.grid, buffers, self.at].map(u64::to_le_bytes);
        self.patch(begun.offsets, offsets.as_flattened())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// If `out` fails, or fewer grids were written than were announced.
    pub fn finish(mut self) -> Result<()> {
        if self.names.len() < self.grids {
            let text = format!("{} of {} grids were written", self.names.len(), self.grids);
            return Err(std::io::Error::other(text));
        }
        self.out.flush()
    }
}

/// What is patched when a grid ends.
#[derive(Debug)]
struct BegunGrid<V> {
    packing: Packing<V>,
    offsets: u64,
    grid: u64,
    patched: u64,
    children: u64,
    statistics: TreeStatistics,
}

fn statistics_metadata(statistics: &TreeStatistics) -> Metadata {
    let [low, high] = if statistics.active_voxels == 0 {
        [[0; 3]; 2]
    } else {
        statistics.bounds
    };
    let leaves = statistics.nodes[0].saturating_mul(2144);
    let bytes = leaves + statistics.nodes[1] * 33_856 + statistics.nodes[2] * 270_400;
    vec![
        ("file_bbox_min".to_owned(), MetaValue::Vec3i(low)),
        ("file_bbox_max".to_owned(), MetaValue::Vec3i(high)),
        (
            "file_voxel_count".to_owned(),
            MetaValue::Int64(statistics.active_voxels as i64),
        ),
        ("file_mem_bytes".to_owned(), MetaValue::Int64(bytes as i64)),
    ]
}

/// Returns the entries of the statistics, without their count.
fn statistics_bytes(statistics: &TreeStatistics) -> Vec<u8> {
    let mut bytes = Vec::new();
    metadata::write(&statistics_metadata(statistics), &mut bytes);
    bytes.split_off(4)
}

/// Writes a grid upper node by upper node: see [`VdbWriter::stream`].
#[derive(Debug)]
pub struct GridWriter<'a, W, V, S> {
    file: &'a mut VdbWriter<W>,
    begun: BegunGrid<V>,
    statistics: TreeStatistics,
    uppers: usize,
    scratch: S,
}

impl<W: Write + Seek, V: Voxel, S: Read + Write + Seek> GridWriter<'_, W, V, S> {
    /// Writes an upper node. Each has another origin.
    ///
    /// # Errors
    /// If the file or the scratch space fails.
    pub fn upper(&mut self, upper: &Upper<V>) -> Result<()> {
        let mut topology = Vec::new();
        self.statistics.add_upper(upper);
        self.uppers += 1;
        write_upper(upper, &self.begun.packing, &mut topology);
        self.file.put(&topology)?;
        let scratch = &mut self.scratch;
        write_leaves(upper, &self.begun.packing, &mut |bytes| {
            scratch.write_all(bytes)
        })
    }

    /// Ends the grid.
    ///
    /// # Errors
    /// If the file or the scratch space fails.
    pub fn finish(mut self) -> Result<()> {
        let buffers = self.file.at;
        self.scratch.rewind()?;
        let mut chunk = vec![0; 1 << 20];
        loop {
            let count = self.scratch.read(&mut chunk)?;
            if count == 0 {
                break;
            }
            self.file.put(&chunk[..count])?;
        }
        self.file
            .end(&self.begun, &self.statistics, self.uppers, buffers)
    }
}
