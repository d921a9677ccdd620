//! Reads cells of a level from tiles, where they have surface.

use argil::abi::GpuMaterial;
use argil::glam::{IVec3, Vec3};
use argil::volume::{
    Encoding, LevelsLayout, Tile, TileAddress, TileBrick, TileCell, TileSource, TileState,
};
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// Voxels along the side of a cell.
pub(super) const CELL: usize = 8;

/// A cell as the wanted level sees it.
pub(super) struct FoundCell<'a> {
    /// In cells of the wanted level.
    pub cell: IVec3,
    /// Whether the surface passes through it. Else the brick is the finest one around it, and coarser.
    pub has_surface: bool,
    brick: TileBrick<'a>,
    /// The brick's cell, and how many levels coarser it is. With surface, it is a plane then, or a tile is missing.
    stored_cell: IVec3,
    up: u32,
    encoding: Encoding,
}

impl FoundCell<'_> {
    /// Whether finer levels have more detail here.
    pub(super) fn is_refined(&self) -> bool {
        self.has_surface && self.up == 0 && !self.brick.is_flat()
    }

    /// Returns the 9³ distances in voxels of the wanted level.
    pub(super) fn distances(&self) -> Vec<f32> {
        let stored: Vec<f32> = self.brick.distances(&self.encoding).collect();
        if self.up == 0 {
            return stored;
        }
        let scale = (1u32 << self.up) as f32;
        let side = CELL + 1;
        let nodes = (0..side * side * side).map(|i| [i % side, i / side % side, i / side / side]);
        nodes
            .map(|node| {
                let at = self.inner(Vec3::from_array(node.map(|n| n as f32)));
                let first = at.floor().min(Vec3::splat(7.0));
                let share = at - first;
                let [x, y, z] = first.to_array().map(|n| n as usize);
                let value = |i: usize, j: usize, k: usize| {
                    stored[(x + i) + side * ((y + j) + side * (z + k))]
                };
                let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
                let row = |j, k| mix(value(0, j, k), value(1, j, k), share.x);
                let layer = |k| mix(row(0, k), row(1, k), share.y);
                scale * mix(layer(0), layer(1), share.z)
            })
            .collect()
    }

    /// Converts a position in the cell, in its voxels, to one in the brick, in the brick's.
    fn inner(&self, at: Vec3) -> Vec3 {
        let first = (CELL as i32 * (self.cell - (self.stored_cell << self.up))).as_vec3();
        (first + at) / (1u32 << self.up) as f32
    }

    /// Returns the material at a position in the cell, in voxels.
    pub(super) fn material(
        &self,
        at: Vec3,
        outward: Vec3,
        palette: &[GpuMaterial],
    ) -> Option<GpuMaterial> {
        let at = self.inner(at);
        self.brick.material(at, outward, &self.encoding, palette)
    }
}

/// Reads the tiles of a world, and keeps those of one job.
pub(super) struct CellReader<'a> {
    source: &'a dyn TileSource,
    layout: &'a LevelsLayout,
    tiles: FxHashMap<(TileAddress, u32), Option<Arc<Tile>>>,
    /// Tiles that should be there.
    pub missing: Vec<TileAddress>,
}

impl<'a> CellReader<'a> {
    pub(super) fn new(source: &'a dyn TileSource, layout: &'a LevelsLayout) -> Self {
        Self {
            source,
            layout,
            tiles: FxHashMap::default(),
            missing: Vec::new(),
        }
    }

    fn tile(&mut self, level: u32, cell: IVec3) -> Option<Arc<Tile>> {
        let address = TileAddress::of_page(level, cell >> 1);
        let source = self.source;
        let held = self.tiles.entry((address, level));
        let found = held.or_insert_with(|| match source.tile(address, level) {
            TileState::Ready(tile) => Some(tile),
            TileState::Pending | TileState::Missing => None,
        });
        if found.is_none() && self.missing.last() != Some(&address) {
            self.missing.push(address);
        }
        found.clone()
    }

    /// Calls `visit` for all cells of a level within a range of cells, the end excluded, around which a brick is.
    pub(super) fn visit(
        &mut self,
        level: u32,
        range: [IVec3; 2],
        visit: &mut dyn FnMut(&FoundCell<'_>),
    ) {
        let root = self.layout.root();
        let up = root - level;
        // Nothing is outside of the world's box.
        let [first, end] = self.layout.root_pages().map(|page| 2 * page);
        let low = (range[0] >> up).max(first);
        let high = ((range[1] - 1) >> up).min(end - 1);
        for z in low.z..=high.z {
            for y in low.y..=high.y {
                for x in low.x..=high.x {
                    self.descend(root, IVec3::new(x, y, z), None, (level, range), visit);
                }
            }
        }
    }

    fn descend(
        &mut self,
        own_level: u32,
        stored_cell: IVec3,
        above: Option<TileBrick<'_>>,
        (level, range): (u32, [IVec3; 2]),
        visit: &mut dyn FnMut(&FoundCell<'_>),
    ) {
        let up = own_level - level;
        let begin = (stored_cell << up).max(range[0]);
        let end = ((stored_cell + 1) << up).min(range[1]);
        if begin.cmpge(end).any() {
            return;
        }
        let tile = self.tile(own_level, stored_cell);
        // Of a tile that is missing nothing is known but that the surface is here.
        let is_missing = tile.is_none();
        let found = tile
            .as_ref()
            .and_then(|tile| tile.cell(own_level, stored_cell.to_array()));
        let brick = match found {
            Some(TileCell::Brick(brick)) => Some(brick),
            Some(TileCell::Away) | None => None,
        };
        if let Some(brick) = brick
            && up > 0
            && !brick.is_flat()
        {
            for octant in 0..8 {
                let place = IVec3::new(octant & 1, octant >> 1 & 1, octant >> 2);
                let finer = 2 * stored_cell + place;
                self.descend(own_level - 1, finer, Some(brick), (level, range), visit);
            }
            return;
        }
        let (brick, stored_cell, up, has_surface) = match (brick, above) {
            (Some(brick), _) => (brick, stored_cell, up, true),
            (None, Some(above)) => (above, stored_cell >> 1, up + 1, is_missing),
            (None, None) => return,
        };
        let encoding = *self.layout.level(0).encoding();
        for z in begin.z..end.z {
            for y in begin.y..end.y {
                for x in begin.x..end.x {
                    visit(&FoundCell {
                        cell: IVec3::new(x, y, z),
                        has_surface,
                        brick,
                        stored_cell,
                        up,
                        encoding,
                    });
                }
            }
        }
    }
}

/// Samples at the corners of voxels of a cube of cells. Where no surface is near, they have the sign of the side.
pub(super) struct Samples {
    /// Cells along a side.
    pub cells: usize,
    /// In voxels, x fastest; NaN where it is not known yet.
    pub values: Vec<f32>,
    /// The same from coarser bricks, where those are the finest.
    #[cfg(feature = "zarr")]
    far: Vec<f32>,
    /// Whether each cell has surface.
    has_surface: Vec<bool>,
}

impl Samples {
    pub(super) fn new(cells: usize) -> Self {
        let side = CELL * cells + 1;
        Self {
            cells,
            values: vec![f32::NAN; side * side * side],
            #[cfg(feature = "zarr")]
            far: Vec::new(),
            has_surface: vec![false; cells * cells * cells],
        }
    }

    pub(super) fn side(&self) -> usize {
        CELL * self.cells + 1
    }

    fn at(&self, place: [usize; 3]) -> usize {
        place[0] + self.side() * (place[1] + self.side() * place[2])
    }

    fn cell_at(&self, cell: [usize; 3]) -> usize {
        cell[0] + self.cells * (cell[1] + self.cells * cell[2])
    }

    /// Puts the samples of a cell with surface, which is counted from the cube's first.
    pub(super) fn put(&mut self, cell: [usize; 3], distances: &[f32]) {
        let index = self.cell_at(cell);
        self.has_surface[index] = true;
        self.put_into(cell, distances, |samples| &mut samples.values);
    }

    /// Puts the samples of a cell without surface.
    #[cfg(feature = "zarr")]
    pub(super) fn put_far(&mut self, cell: [usize; 3], distances: &[f32]) {
        self.far.resize(self.values.len(), f32::NAN);
        self.put_into(cell, distances, |samples| &mut samples.far);
    }

    /// Replaces the width of the band, which [`flood`](Self::flood) put where no surface is near, by distances from coarser bricks.
    /// `values` are those before.
    #[cfg(feature = "zarr")]
    pub(super) fn mend(&mut self, values: &[f32], band: f32) {
        for ((value, before), far) in self.values.iter_mut().zip(values).zip(&self.far) {
            if before.is_nan() && !far.is_nan() {
                *value = far.abs().min(band).copysign(*value);
            }
        }
    }

    /// Returns what is known where no cell has surface: distances from coarser bricks up to the band, or nothing.
    #[cfg(feature = "zarr")]
    pub(super) fn without_surface(&self, band: f32) -> Option<Vec<f32>> {
        let known = self.far.iter().find(|far| !far.is_nan())?;
        let value = |far: &f32| if far.is_nan() { *known } else { *far };
        Some(
            self.far
                .iter()
                .map(|far| value(far).clamp(-band, band))
                .collect(),
        )
    }

    fn put_into(
        &mut self,
        cell: [usize; 3],
        distances: &[f32],
        to: impl Fn(&mut Self) -> &mut Vec<f32>,
    ) {
        for (row, row_distances) in distances.chunks_exact(CELL + 1).enumerate() {
            let place = [
                CELL * cell[0],
                CELL * cell[1] + row % (CELL + 1),
                CELL * cell[2] + row / (CELL + 1),
            ];
            let first = self.at(place);
            to(self)[first..first + CELL + 1].copy_from_slice(row_distances);
        }
    }

    /// Gives all other samples the width of the band, with the sign that the neighbors have: no surface passes through their
    /// cells. Returns false if no cell has surface, so that no sign is known.
    pub(super) fn flood(&mut self, band: f32) -> bool {
        let n = self.cells;
        let mut open: Vec<[usize; 3]> = Vec::new();
        let mut is_done = self.has_surface.clone();
        let all = (0..n * n * n).map(|i| [i % n, i / n % n, i / n / n]);
        open.extend(all.filter(|&cell| self.has_surface[self.cell_at(cell)]));
        if open.is_empty() {
            return false;
        }
        while let Some(cell) = open.pop() {
            for axis in 0..3 {
                for step in [-1isize, 1] {
                    let Some(next) = cell[axis].checked_add_signed(step).filter(|&c| c < n) else {
                        continue;
                    };
                    let mut beside = cell;
                    beside[axis] = next;
                    let index = self.cell_at(beside);
                    if is_done[index] {
                        continue;
                    }
                    is_done[index] = true;
                    self.fill_away(beside, band);
                    open.push(beside);
                }
            }
        }
        true
    }

    fn fill_away(&mut self, cell: [usize; 3], band: f32) {
        let side = CELL + 1;
        let places = (0..side * side * side).map(|i| {
            let inner = [i % side, i / side % side, i / side / side];
            [0, 1, 2].map(|axis| CELL * cell[axis] + inner[axis])
        });
        let places: Vec<usize> = places.map(|place| self.at(place)).collect();
        // What is the farthest away has the surest sign.
        let known = places.iter().map(|&at| self.values[at]);
        let farthest = known
            .filter(|value| !value.is_nan())
            .fold(0.0f32, |a, b| if b.abs() > a.abs() { b } else { a });
        for at in places {
            if self.values[at].is_nan() {
                self.values[at] = band.copysign(farthest);
            }
        }
    }
}
