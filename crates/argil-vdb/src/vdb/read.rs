//! Reads `.vdb` files.

use super::bytes::Reader;
use super::topology::{read_leaves, read_upper};
use super::values::Unpacking;
use super::{MAGIC, metadata};
use crate::{
    AnyGrid, Grid, GridClass, GridHeader, MetaValue, Metadata, RootTile, Tree, Upper, VdbError,
    Voxel,
};

/// A `.vdb` file in memory, whose grids are not read yet.
#[derive(Clone, Debug)]
pub struct VdbFile<'a> {
    bytes: &'a [u8],
    /// Metadata of the file.
    pub metadata: Metadata,
    /// The grids.
    pub grids: Vec<GridInfo>,
}

/// A grid of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GridInfo {
    /// Name.
    pub name: String,
    /// Type of the tree, as `Tree_float_5_4_3`.
    pub tree: String,
    at: usize,
    is_instance: bool,
}

impl<'a> VdbFile<'a> {
    /// Reads the list of grids.
    ///
    /// # Errors
    /// If these are not the bytes of a `.vdb` file of version 222 to 225, or they are damaged.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, VdbError> {
        let mut from = Reader::new(bytes, 0);
        if from
            .u64("the header")
            .map_err(|_| VdbError::NotThis("VDB"))?
            != MAGIC
        {
            return Err(VdbError::NotThis("VDB"));
        }
        let version = from.u32("the version")?;
        if !(222..=225).contains(&version) {
            return Err(VdbError::Version {
                found: version.to_string(),
                supported: "222 to 225",
            });
        }
        // The library's version.
        from.take(8, "the header")?;
        if from.u8("the header")? == 0 {
            let text = "the file was written to a stream, without positions of its grids: save it to a file";
            return Err(VdbError::Unsupported(text.into()));
        }
        from.take(36, "the header")?;
        let metadata = metadata::read(&mut from)?;
        let count = from.i32("the number of grids")?;
        let mut grids = Vec::new();
        for _ in 0..count.max(0) {
            let name = from.string("a grid's name")?;
            let tree = from.string("a grid's type")?;
            let parent = from.string("a grid's parent")?;
            let at = from.i64("a grid's position")?;
            from.i64("a grid's position")?;
            let end = from.i64("a grid's position")?;
            let end = usize::try_from(end).unwrap_or(usize::MAX);
            let at = usize::try_from(at).unwrap_or(usize::MAX);
            if at > bytes.len() || end < from.position() || end > bytes.len() {
                return Err(VdbError::Truncated {
                    at: bytes.len() as u64,
                    what: "a grid",
                });
            }
            grids.push(GridInfo {
                name: name.split('\u{1e}').next().unwrap_or_default().to_owned(),
                tree,
                at,
                is_instance: !parent.is_empty(),
            });
            from = Reader::new(bytes, end);
        }
        Ok(Self {
            bytes,
            metadata,
            grids,
        })
    }

    /// Returns the first grid of single numbers with a name, or the first of any name if `name` is `None`.
    ///
    /// # Errors
    /// If there is none, or it is damaged.
    pub fn float_grid(&self, name: Option<&str>) -> Result<Grid<f32>, VdbError> {
        let is_right = |info: &GridInfo| {
            info.tree.starts_with(f32::TREE) && name.is_none_or(|name| info.name == name)
        };
        let Some(index) = self.grids.iter().position(is_right) else {
            let all: Vec<String> = self
                .grids
                .iter()
                .map(|info| format!("{:?} ({})", info.name, info.tree))
                .collect();
            let which = name.map_or(String::new(), |name| format!(" with the name {name:?}"));
            let others = match all.is_empty() {
                true => "it has no grids at all".to_owned(),
                false => format!("only {}: convert one to floats", all.join(", ")),
            };
            return Err(VdbError::Unsupported(format!(
                "the file has no grid of floats{which}, {others}"
            )));
        };
        match self.grid(index)? {
            AnyGrid::Float(grid) => Ok(grid),
            AnyGrid::Vec3(_) => Err(VdbError::Unsupported("the grid holds vectors".into())),
        }
    }

    /// Reads a grid.
    ///
    /// # Errors
    /// If its type is not supported, or it is damaged.
    ///
    /// # Panics
    /// If there is no grid with this index.
    pub fn grid(&self, index: usize) -> Result<AnyGrid, VdbError> {
        let info = &self.grids[index];
        let (tree, is_half) = match info.tree.strip_suffix("_HalfFloat") {
            Some(tree) => (tree, true),
            None => (info.tree.as_str(), false),
        };
        if info.is_instance {
            return Err(VdbError::Unsupported(format!(
                "the grid {:?} shares its tree with another, which is not supported: save it alone",
                info.name
            )));
        }
        if tree == f32::TREE {
            Ok(AnyGrid::Float(self.read(info, is_half)?))
        } else if tree == <[f32; 3]>::TREE {
            Ok(AnyGrid::Vec3(self.read(info, is_half)?))
        } else {
            Err(VdbError::Unsupported(format!(
                "the grid {:?} has the type {}, and only {} and {} are supported",
                info.name,
                info.tree,
                f32::TREE,
                <[f32; 3]>::TREE
            )))
        }
    }

    fn read<V: Voxel>(&self, info: &GridInfo, is_half: bool) -> Result<Grid<V>, VdbError> {
        let mut from = Reader::new(self.bytes, info.at);
        let flags = from.u32("compression flags")?;
        if flags & !7 != 0 {
            return Err(from.damaged(format!("{flags} are no compression flags")));
        }
        let metadata = metadata::read(&mut from)?;
        let transform = metadata::read_transform(&mut from)?;
        if from.i32("the number of buffers")? != 1 {
            return Err(from.damaged("a tree has several buffers"));
        }
        let background = V::read(from.take(V::BYTES, "the background")?);
        let unpacking = Unpacking {
            background,
            flags,
            is_half,
        };
        let (tiles, children) = (from.u32("tiles")? as usize, from.u32("nodes")? as usize);
        let mut tree = Tree::new(background);
        if tiles > from.left() / (13 + V::BYTES) {
            return Err(from.damaged(format!("{tiles} tiles")));
        }
        for _ in 0..tiles {
            tree.tiles.push(RootTile {
                origin: from.place("a tile")?,
                value: V::read(from.take(V::BYTES, "a tile")?),
                is_active: from.u8("a tile")? != 0,
            });
        }
        for _ in 0..children {
            tree.uppers.push(read_upper(&mut from, &unpacking)?);
        }
        for upper in &mut tree.uppers {
            read_leaves(&mut from, &unpacking, upper)?;
        }
        sort(&mut tree.uppers, &from)?;
        let text = |name: &str| {
            metadata.iter().find_map(|(key, value)| match value {
                MetaValue::String(text) if key == name => Some(text.clone()),
                _ => None,
            })
        };
        let header = GridHeader {
            name: text("name").unwrap_or_else(|| info.name.clone()),
            class: GridClass::from_name(&text("class").unwrap_or_default()),
            transform,
            metadata: metadata
                .into_iter()
                .filter(|(name, _)| !is_known(name))
                .collect(),
        };
        Ok(Grid { header, tree })
    }
}

fn sort<V>(uppers: &mut [Upper<V>], from: &Reader<'_>) -> Result<(), VdbError> {
    uppers.sort_by_key(|upper| upper.origin);
    let is_twice = |pair: &[Upper<V>]| pair[0].origin == pair[1].origin;
    if uppers.windows(2).any(is_twice) {
        return Err(from.damaged("two upper nodes have one origin"));
    }
    Ok(())
}

/// Returns whether a name is that of metadata which the writer makes.
fn is_known(name: &str) -> bool {
    name.starts_with("file_")
        || name.starts_with("__delayload")
        || ["class", "name", "is_saved_as_half_float", "is_local_space"].contains(&name)
}
