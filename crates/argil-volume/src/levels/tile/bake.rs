//! Bakes tiles.

use super::codec::BRICK_SAMPLES;
use super::{CellKind, Tile, TileAddress, TilePage};
use crate::bricks::PLACES;
use crate::levels::bake::{BakedPage, PageBaker, PageContext, PageJob};
use crate::levels::kept_list::PageList;
use crate::levels::layout::LevelsLayout;
use crate::levels::page::{NO_PAGE, Page, octant_of, octant_place};
use crate::{MISSING_BRICK, SampleFormat, Texel};
use argil_abi::Instruction;
use argil_field::Program;
use argil_math::Control;
use glam::IVec3;
use rayon::prelude::*;
use std::sync::Arc;

/// Bakes tiles of a program's levels.
///
/// ```
/// use argil_field::Program;
/// use argil_math::Control;
/// use argil_scene::{Scene, Shape};
/// use argil_volume::{BrickSettings, LevelsLayout, TileBaker, VoxelGrid};
/// let mut scene = Scene::new();
/// scene.push(Shape::sphere(0.5))?;
/// let program = Program::lower(&scene)?;
/// let grid = VoxelGrid::fitting(program.aabb(), None, 1024)?;
/// let baker = TileBaker::new(&program, LevelsLayout::new(grid, &BrickSettings::default())?);
/// let candidates = baker.candidates(&Control::default());
/// let tile = baker.bake(candidates[0]);
/// assert!(tile.brick_count() > 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct TileBaker<'a> {
    context: PageContext<'a>,
    layout: LevelsLayout,
}

impl std::fmt::Debug for TileBaker<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TileBaker")
            .field("layout", &self.layout)
            .finish_non_exhaustive()
    }
}

/// Pages below which candidates are looked for at once.
const PAGES_AT_ONCE: usize = 128;

/// A page whose place bounds do not rule out, with its program.
type Found<'a> = (IVec3, PageList<'a>);

impl<'a> TileBaker<'a> {
    /// Creates a baker.
    pub fn new(program: &'a Program, layout: LevelsLayout) -> Self {
        Self {
            context: PageContext::new(program, &layout),
            layout,
        }
    }

    /// Returns the layout.
    pub fn layout(&self) -> &LevelsLayout {
        &self.layout
    }

    /// Returns the places of all tiles that bounds do not rule out, the coarsest first, on rayon's current threads. Empty
    /// and solid parts of the world are left out as a whole.
    pub fn candidates(&self, control: &Control) -> Vec<TileAddress> {
        let [low, high] = self.layout.root_pages();
        let roots = crate::bricks::places(low, high - 1);
        let pages: Vec<Found<'_>> = roots.map(|place| (place, self.context.whole())).collect();
        let root = self.layout.root();
        let mut tiers = vec![Vec::new(); (root / super::TIER_LEVELS + 1) as usize];
        self.descend(root, &pages, &mut tiers, control);
        tiers.reverse();
        tiers.concat()
    }

    /// Adds the tiles below some pages of a level. It goes down for a few pages at a time, so that few programs are held.
    fn descend(
        &self,
        level: u32,
        pages: &[Found<'_>],
        tiers: &mut [Vec<TileAddress>],
        control: &Control,
    ) {
        let address = |place: IVec3| TileAddress::of_page(level, place);
        let tier = level / super::TIER_LEVELS;
        if level == address(IVec3::ZERO).top_level(&self.layout) {
            tiers[tier as usize].extend(pages.iter().map(|(place, _)| address(*place)));
        }
        if tier == 0 || control.is_cancelled() {
            return;
        }
        let is_last = level == super::TIER_LEVELS;
        for some in pages.chunks(PAGES_AT_ONCE) {
            let below: Vec<Found<'_>> = some
                .par_iter()
                .with_min_len(16)
                .map_init(
                    || self.context.baker(),
                    |baker, (place, list)| self.below(baker, level, *place, list, is_last),
                )
                .flatten_iter()
                .collect();
            self.descend(level - 1, &below, tiers, control);
        }
    }

    /// Returns the pages below a page that bounds do not rule out. The last ones need no programs.
    fn below<'b>(
        &self,
        baker: &mut PageBaker<'_>,
        level: u32,
        place: IVec3,
        list: &[Instruction],
        is_last: bool,
    ) -> Vec<Found<'b>> {
        let page = Page::new(level, place, NO_PAGE);
        let (near, kept) = baker.near_cells(&page, list);
        let lists = if is_last {
            Default::default()
        } else {
            baker.cell_lists(&page, list, near, Some(&kept)).0
        };
        let cells = (0u32..8).filter(|i| near >> i & 1 != 0);
        cells
            .zip(lists_of(near, lists))
            .map(|(i, list)| (2 * place + octant_place(i), PageList::Pruned(list)))
            .collect()
    }

    /// Returns what a thread bakes tiles with.
    pub fn worker(&self) -> TileWorker<'_> {
        TileWorker {
            tiles: self,
            baker: self.context.baker(),
            trail: Vec::new(),
        }
    }

    /// Bakes a tile on this thread. A tile whose page does not exist is empty. A [`worker`](Self::worker) bakes several
    /// sooner.
    pub fn bake(&self, address: TileAddress) -> Tile {
        self.worker().bake(address)
    }
}

/// A step on the way down from the root: a cell of a page, and the program of the page below, if there is one.
#[derive(Debug)]
struct Step<'a> {
    level: u32,
    place: IVec3,
    cell: u32,
    below: Option<PageList<'a>>,
}

/// Bakes tiles on one thread. It remembers the way down to the last tile, because neighbors share most of it.
pub struct TileWorker<'a> {
    tiles: &'a TileBaker<'a>,
    baker: PageBaker<'a>,
    trail: Vec<Step<'a>>,
}

impl std::fmt::Debug for TileWorker<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TileWorker")
            .field("trail", &self.trail.len())
            .finish_non_exhaustive()
    }
}

impl<'a> TileWorker<'a> {
    /// Bakes a tile. A tile whose page does not exist is empty.
    pub fn bake(&mut self, address: TileAddress) -> Tile {
        match self.tiles.layout.level(0).encoding.format {
            SampleFormat::Snorm8 => self.bake_as::<i8>(address),
            SampleFormat::Snorm16 => self.bake_as::<i16>(address),
        }
    }

    fn bake_as<T: Texel>(&mut self, address: TileAddress) -> Tile {
        let mut tile = Tile {
            address,
            format: T::FORMAT,
            finest_held: address.finest_level(),
            pages: Vec::new(),
            materials: Vec::new(),
            mixed: Vec::new(),
            texels: Vec::new(),
        };
        let Some(list) = self.top_list::<T>(address) else {
            return tile;
        };
        let mut pages: Vec<Found<'_>> = vec![(address.place.into(), list)];
        let finest = address.finest_level();
        for level in (finest..=address.top_level(&self.tiles.layout)).rev() {
            let mut finer = Vec::new();
            for (place, list) in &pages {
                let page = Page::new(level, *place, NO_PAGE);
                let job = PageJob {
                    page,
                    list: list.clone(),
                    cells: u8::MAX,
                    kept: None,
                };
                let baked = self.baker.page::<T>(&job);
                let refined = tile.add(&page, &baked);
                if level > finest && refined != 0 {
                    let kept = baked.marks.as_deref();
                    let lists = self.baker.cell_lists(&page, list, refined, kept).0;
                    let cells = (0u32..8).filter(|i| refined >> i & 1 != 0);
                    finer.extend(
                        cells.zip(lists_of(refined, lists)).map(|(i, list)| {
                            (2 * *place + octant_place(i), PageList::Pruned(list))
                        }),
                    );
                }
            }
            pages = finer;
        }
        tile
    }

    /// Returns the program of a tile's coarsest page, or `None` if that does not exist: a cell above it has no brick, or a
    /// flat one.
    fn top_list<T: Texel>(&mut self, address: TileAddress) -> Option<PageList<'a>> {
        let layout = &self.tiles.layout;
        let top = address.top_level(layout);
        let [low, high] = layout.root_pages();
        let place = IVec3::from_array(address.place);
        let root_place = place >> (layout.root() - top);
        if root_place.cmplt(low).any() || root_place.cmpge(high).any() {
            return None;
        }
        let mut list = self.tiles.context.whole();
        for (index, level) in (top + 1..=layout.root()).rev().enumerate() {
            let at = (level, place >> (level - top));
            let cell = octant_of(place >> (level - 1 - top) & 1);
            let known = self.trail.get(index);
            if known.is_none_or(|step| (step.level, step.place, step.cell) != (at.0, at.1, cell)) {
                self.trail.truncate(index);
                let below = self.below::<T>(at, cell, &list);
                self.trail.push(Step {
                    level: at.0,
                    place: at.1,
                    cell,
                    below,
                });
            }
            list = self.trail[index].below.clone()?;
        }
        Some(list)
    }

    /// Returns the program of the page below a page's cell, if that is refined.
    fn below<T: Texel>(
        &mut self,
        (level, place): (u32, IVec3),
        cell: u32,
        list: &PageList<'a>,
    ) -> Option<PageList<'a>> {
        let page = Page::new(level, place, NO_PAGE);
        let job = PageJob {
            page,
            list: list.clone(),
            cells: 1 << cell,
            kept: None,
        };
        let baked = self.baker.page::<T>(&job);
        let own = baked.cells.iter().find(|own| own.cell == cell)?;
        if !matches!(own.brick, Some((_, false))) {
            return None;
        }
        let kept = baked.marks.as_deref();
        let mut lists = self.baker.cell_lists(&page, list, 1 << cell, kept).0;
        Some(PageList::Pruned(std::mem::take(&mut lists[cell as usize])))
    }
}

/// Returns the programs of some cells, one bit each.
fn lists_of(cells: u8, lists: [Arc<[Instruction]>; 8]) -> impl Iterator<Item = Arc<[Instruction]>> {
    let all = lists.into_iter().enumerate();
    all.filter(move |(i, _)| cells >> i & 1 != 0)
        .map(|(_, list)| list)
}

impl Tile {
    /// Adds a page all of whose cells were sampled. Returns the cells that finer pages refine, one bit each.
    fn add<T: Texel>(&mut self, page: &Page, baked: &BakedPage<T>) -> u8 {
        let mut own = TilePage {
            level: page.level,
            place: page.place().to_array(),
            kinds: [CellKind::Clear; 8],
            words: baked.words,
            first_brick: self.materials.len() as u32,
            first_mixed: (self.mixed.len() / PLACES) as u32,
        };
        let mut refined = 0;
        for cell in &baked.cells {
            let index = cell.cell as usize;
            own.kinds[index] = match cell.brick {
                None => CellKind::Cleared,
                Some((_, true)) => CellKind::Flat,
                Some((_, false)) => CellKind::Brick,
            };
            own.words[index] = match cell.brick {
                None => baked.clear[index],
                Some((material, is_flat)) => {
                    self.materials.push(material);
                    refined |= u8::from(!is_flat) << index;
                    MISSING_BRICK
                }
            };
        }
        self.mixed.extend_from_slice(&baked.mixed);
        match T::FORMAT {
            SampleFormat::Snorm8 => {
                let codes: &[i8] = bytemuck::cast_slice(&baked.texels);
                self.texels
                    .extend(codes.iter().map(|&code| i16::from(code)));
            }
            SampleFormat::Snorm16 => {
                let codes: &[i16] = bytemuck::cast_slice(&baked.texels);
                self.texels.extend_from_slice(codes);
            }
        }
        self.pages.push(own);
        refined
    }

    /// Returns a page as it is baked, if the tile has it. `cells` are those whose bricks are wanted, one bit each.
    pub(in crate::levels) fn baked<T: Texel>(
        &self,
        page: &Page,
        cells: u8,
    ) -> Option<BakedPage<T>> {
        let own = self.page(page)?;
        let mut made = BakedPage {
            words: own.words,
            clear: own.words,
            ..BakedPage::default()
        };
        let samples = BRICK_SAMPLES;
        let (mut brick, mut mixed) = (own.first_brick as usize, own.first_mixed as usize);
        for (cell, &kind) in (0u32..).zip(&own.kinds) {
            let is_wanted = cells >> cell & 1 != 0;
            let mut found = None;
            if kind == CellKind::Cleared && !is_wanted {
                // Without its samples, a baker does not know it.
                made.words[cell as usize] = MISSING_BRICK;
            }
            if kind.has_brick() {
                let material = self.materials[brick];
                let own_mixed = usize::from(material & argil_abi::BRICK_MIXED != 0);
                if is_wanted {
                    let texels = &self.texels[brick * samples..(brick + 1) * samples];
                    made.texels
                        .extend(texels.iter().map(|&code| T::from_code(code.into())));
                    made.mixed.extend_from_slice(
                        &self.mixed[mixed * PLACES..(mixed + own_mixed) * PLACES],
                    );
                    found = Some((material, kind == CellKind::Flat));
                }
                brick += 1;
                mixed += own_mixed;
            }
            if is_wanted && kind != CellKind::Clear {
                made.cells
                    .push(crate::levels::bake::BakedCell { cell, brick: found });
            }
        }
        Some(made)
    }
}
