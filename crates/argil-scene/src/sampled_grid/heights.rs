//! Heights over a plane, as a grid.

use super::SampledGrid;
use crate::{MAX_POSTS, SAMPLED_HEADER};
use argil_math::Aabb;
use glam::{Vec3, uvec3};

impl SampledGrid {
    /// Creates a grid of heights from 0 to 1, x fastest. `posts` are the numbers along x and z, from 2 to
    /// [`MAX_POSTS`] each. Returns `None` if the counts do not match, or a height is out of range.
    ///
    /// ```
    /// use argil_scene::{LoadedGrid, SampledGrid, Shape};
    /// let roof = SampledGrid::from_heights([3, 2], &[0.0, 1.0, 0.0, 0.0, 1.0, 0.0]).expect("heights");
    /// let grid = LoadedGrid(Some(std::sync::Arc::new(roof)));
    /// let shape = Shape::Heightmap {
    ///     path: "roof.png".into(),
    ///     half_size: [2.0, 1.0],
    ///     height: 0.5,
    ///     base: 0.1,
    ///     resolution: 16,
    ///     grid,
    /// };
    /// assert!(shape.check().is_ok());
    /// ```
    pub fn from_heights(posts: [u32; 2], heights: &[f32]) -> Option<Self> {
        let [nx, nz] = posts.map(|n| n as usize);
        let is_count = |n: u32| (2..=MAX_POSTS).contains(&n);
        let is_height = |h: &f32| (0.0..=1.0).contains(h);
        if !posts.into_iter().all(is_count)
            || heights.len() != nx * nz
            || !heights.iter().all(is_height)
        {
            return None;
        }
        let steps = |of: &dyn Fn(usize) -> Option<usize>| {
            let all = heights.iter().enumerate();
            all.filter_map(|(i, h)| Some((heights[of(i)?] - h).abs()))
                .fold(0.0, f32::max)
        };
        let along_x = steps(&|i| ((i + 1) % nx != 0).then_some(i + 1));
        let along_z = steps(&|i| (i + nx < heights.len()).then_some(i + nx));
        let least = heights.iter().copied().fold(1.0, f32::min);
        let greatest = heights.iter().copied().fold(0.0, f32::max);
        let mut words = vec![
            along_x, along_z, least, greatest, nx as f32, 0.0, nz as f32, 0.0,
        ];
        words.extend_from_slice(heights);
        Some(Self {
            words,
            corner: Vec3::ZERO,
            cell: 1.0,
            cells: uvec3(posts[0], 0, posts[1]),
            solid: Aabb::new(Vec3::ZERO, Vec3::new(1.0, greatest, 1.0)),
            lipschitz: 1.0,
        })
    }

    /// Returns the posts along x and z, for a grid of heights.
    pub fn posts(&self) -> [u32; 2] {
        [self.cells.x, self.cells.z]
    }

    /// Returns the slope of the steepest step between posts, as a multiple of the 99th percentile. Flat ground
    /// returns 1.
    pub fn steepest_share(&self) -> f32 {
        if !self.has_heights() {
            return 1.0;
        }
        let row = self.cells.x as usize;
        let heights = &self.words[SAMPLED_HEADER..];
        let along_x = heights.chunks(row.max(1)).flat_map(|row| row.windows(2));
        let along_x = along_x.map(|pair| (pair[1] - pair[0]).abs());
        let along_z = heights.iter().zip(heights.iter().skip(row));
        let mut steps: Vec<f32> = along_x.chain(along_z.map(|(a, b)| (b - a).abs())).collect();
        let usual = steps.len() * 99 / 100;
        let (_, &mut usual, _) = steps.select_nth_unstable_by(usual, f32::total_cmp);
        let greatest = self.words[0].max(self.words[1]);
        if greatest > 0.0 {
            greatest / usual.max(1e-6)
        } else {
            1.0
        }
    }

    /// Whether the grid holds heights.
    pub fn has_heights(&self) -> bool {
        self.cells.y == 0
    }
}
