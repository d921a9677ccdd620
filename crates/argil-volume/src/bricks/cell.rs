//! The meaning of a cell's word. `bricks/cell.wgsl` is the twin.

use glam::IVec3;

/// The top bit of a word without a brick.
const EMPTY: u32 = argil_abi::WORD_EMPTY;
/// Set in such a word if its whole block has no brick.
const BLOCK_EMPTY: u32 = argil_abi::WORD_BLOCK_EMPTY;

/// The word of a cell through which a surface can pass, and whose brick is not resident. Only levels of detail have
/// such cells.
pub const MISSING_BRICK: u32 = argil_abi::MISSING_BRICK;

/// The contents of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BrickCell {
    /// A brick, with its index in the pool.
    Brick(u32),
    /// No surface.
    Empty {
        /// A lower bound of the distance from the cell's center to the surface, negative inside.
        center: f32,
        /// Whether no cell of the block has a brick.
        is_block_empty: bool,
    },
}

impl BrickCell {
    /// Decodes a word.
    #[inline(always)]
    pub fn of(word: u32) -> Self {
        if is_brick(word) {
            Self::Brick(word)
        } else {
            Self::Empty {
                center: center_of(word),
                is_block_empty: is_block_empty(word),
            }
        }
    }
}

/// Returns the word of a cell without a brick. It keeps 22 bits of the fraction, rounded toward 0.
#[inline(always)]
pub fn empty_word(center: f32) -> u32 {
    EMPTY | (center.to_bits() >> 1) & !BLOCK_EMPTY
}

/// Returns the word of a cell without a brick, in a block without bricks.
#[inline(always)]
pub(crate) fn block_empty_word(word: u32) -> u32 {
    word | BLOCK_EMPTY
}

/// Whether a cell has a brick.
#[inline(always)]
pub fn is_brick(word: u32) -> bool {
    word & EMPTY == 0
}

/// Whether a cell's whole block has no brick. False for cells with a brick.
#[inline(always)]
pub fn is_block_empty(word: u32) -> bool {
    word & BLOCK_EMPTY != 0
}

/// Returns the distance at the center of a cell without a brick.
#[inline(always)]
pub fn center_of(word: u32) -> f32 {
    f32::from_bits((word & !BLOCK_EMPTY) << 1)
}

/// Returns the position of a cell in its block, by its index.
pub(crate) fn inner_cell(index: usize) -> IVec3 {
    let index = index as i32;
    IVec3::new(index % 4, index / 4 % 4, index / 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_keep_their_sign_and_never_grow() {
        for d in [0.0, 1.0, -1.0, 0.1, -0.3, 1e-20, 1e30, -1e30, 1e-40] {
            let BrickCell::Empty {
                center,
                is_block_empty,
            } = BrickCell::of(empty_word(d))
            else {
                panic!("{d} became a brick");
            };
            assert!(center.abs() <= d.abs() && center.abs() >= d.abs() * 0.999_999 - 1e-44);
            assert_eq!(center.is_sign_negative(), d.is_sign_negative());
            assert!(!is_block_empty);
            let is_block_empty = BrickCell::of(block_empty_word(empty_word(d)));
            assert_eq!(
                is_block_empty,
                BrickCell::Empty {
                    center,
                    is_block_empty: true
                }
            );
        }
        assert_eq!(BrickCell::of(77), BrickCell::Brick(77));
    }
}
