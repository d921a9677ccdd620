//! Takes pages from a store instead of the field.

use super::bake::{BakedPage, PageContext};
use super::fill::FillStats;
use super::page::{Page, octant_place};
use super::requests::PageRequest;
use super::source::{StoredTiles, TileSource, TileState};
use super::tile::{Tile, TileAddress};
use super::tree::Levels;
use crate::Texel;
use argil_field::Program;
use glam::IVec3;
use std::borrow::Cow;
use std::sync::Arc;

/// Where a page is to come from.
enum Origin {
    Tile(Arc<Tile>),
    Field,
    Later,
    Nowhere,
}

impl Levels {
    /// Takes pages from a store from now on, as far as edits did not change them. Without `bakes_missing`, pages of tiles that
    /// the store lacks stay missing, and rays see what is coarser.
    pub fn set_source(
        &mut self,
        source: Arc<dyn TileSource>,
        program: &Program,
        bakes_missing: bool,
    ) {
        self.stored = Some(Box::new(StoredTiles {
            source,
            bakes_missing,
            palette: program.materials().to_vec(),
            edited: vec![Vec::new(); self.layout.count() as usize],
        }));
    }

    fn origin_of(&self, stored: &StoredTiles, page: &Page) -> Origin {
        if self.is_edited(stored, page) {
            return Origin::Field;
        }
        let address = TileAddress::of_page(page.level, page.place());
        match stored.source.tile(address, page.level) {
            TileState::Ready(tile) => Origin::Tile(tile),
            TileState::Pending => Origin::Later,
            TileState::Missing if stored.bakes_missing => Origin::Field,
            TileState::Missing => Origin::Nowhere,
        }
    }

    /// Whether an edit changed the field in a page since it was stored.
    fn is_edited(&self, stored: &StoredTiles, page: &Page) -> bool {
        let held = self.layout.page_box(page);
        let edited = &stored.edited[page.level as usize];
        edited.iter().any(|one| !one.intersection(held).is_empty())
    }

    /// Returns the page that a request is for.
    fn page_of(&self, request: &PageRequest) -> Page {
        let (cell, child) = request.place();
        let page = &self.pages[cell as usize / 8];
        match child {
            None => *page,
            Some(_) => {
                let place: IVec3 = 2 * page.place() + octant_place(cell % 8);
                Page::new(page.level.saturating_sub(1), place, cell)
            }
        }
    }

    /// Returns the requests that can be answered now. Asks the store for all their tiles at once.
    pub(super) fn available<'a>(
        &self,
        program: &Program,
        asked: &'a [PageRequest],
        done: &mut FillStats,
    ) -> Cow<'a, [PageRequest]> {
        let Some(stored) = self.usable(program) else {
            return asked.into();
        };
        let pages: Vec<Page> = asked.iter().map(|request| self.page_of(request)).collect();
        let stored_pages = pages.iter().filter(|page| !self.is_edited(stored, page));
        let mut wanted: Vec<(TileAddress, u32)> = stored_pages
            .map(|page| (TileAddress::of_page(page.level, page.place()), page.level))
            .collect();
        // The finest level of each tile.
        wanted.sort_unstable();
        wanted.dedup_by_key(|(address, _)| *address);
        stored.source.prefetch(&wanted);
        let is_available = |page: &Page| match self.origin_of(stored, page) {
            Origin::Tile(_) | Origin::Field => true,
            Origin::Later => {
                done.pending += 1;
                false
            }
            Origin::Nowhere => {
                done.missing += 1;
                false
            }
        };
        let kept: Vec<bool> = pages.iter().map(is_available).collect();
        let some = asked.iter().zip(kept).filter(|(_, kept)| *kept);
        some.map(|(request, _)| *request).collect::<Vec<_>>().into()
    }

    /// Returns the store, if its materials are the program's.
    fn usable(&self, program: &Program) -> Option<&StoredTiles> {
        self.stored
            .as_deref()
            .filter(|stored| program.materials().starts_with(&stored.palette))
    }

    /// Returns pages from the store, or bakes them, with the samples of some of their cells.
    pub(super) fn stored_or_baked_pages<T: Texel>(
        &mut self,
        context: &PageContext<'_>,
        slots: &[u32],
        cells: &[u8],
    ) -> Vec<BakedPage<T>> {
        let Some(stored) = self.usable(context.program()) else {
            return self.bake_pages(context, slots, cells);
        };
        let palette = stored.palette.len();
        let mut found: Vec<Option<BakedPage<T>>> = slots
            .iter()
            .zip(cells)
            .map(|(&slot, &cells)| {
                let page = &self.pages[slot as usize];
                match self.origin_of(stored, page) {
                    Origin::Tile(tile) if tile.fits(palette) => tile.baked(page, cells),
                    _ => None,
                }
            })
            .collect();
        let rest = || (0..slots.len()).filter(|&index| found[index].is_none());
        let some: Vec<u32> = rest().map(|index| slots[index]).collect();
        let own: Vec<u8> = rest().map(|index| cells[index]).collect();
        let mut baked = self.bake_pages(context, &some, &own).into_iter();
        for one in &mut found {
            if one.is_none() {
                *one = baked.next();
            }
        }
        found.into_iter().map(Option::unwrap_or_default).collect()
    }
}
