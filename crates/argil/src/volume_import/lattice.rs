//! Values at the points of a lattice.

use argil_vdb::{Tree, Voxel};
use glam::{IVec3, Vec3};
use rayon::prelude::*;

/// Values at `origin + voxel_size · index`.
pub(super) struct Lattice {
    pub voxel_size: f32,
    pub origin: Vec3,
    pub samples: Samples,
}

/// Signed distances: near the surface, or everywhere.
pub(super) enum Samples {
    /// A level set. Inactive values tell only the sign.
    Sparse(Tree<f32>),
    /// All values of a box, x fastest.
    Dense(DenseValues),
}

/// All values of a box, x fastest.
pub(super) struct DenseValues {
    /// Index of the first value.
    pub low: IVec3,
    /// Number of values along each axis.
    pub size: IVec3,
    /// The values.
    pub values: Vec<f32>,
    /// The value beyond the box. Without one, those at its sides are distances, and the solid is cut off there.
    pub outside: Option<f32>,
}

impl DenseValues {
    fn place(&self, index: IVec3) -> usize {
        let [x, y, z] = (index - self.low)
            .clamp(IVec3::ZERO, self.size - 1)
            .to_array();
        let [nx, ny] = [self.size.x as usize, self.size.y as usize];
        (z as usize * ny + y as usize) * nx + x as usize
    }

    fn index(&self, place: usize) -> IVec3 {
        let [nx, ny] = [self.size.x as usize, self.size.y as usize];
        let at = [place % nx, place / nx % ny, place / nx / ny];
        self.low + IVec3::from(at.map(|c| c as i32))
    }

    fn holds(&self, index: IVec3) -> bool {
        let at = index - self.low;
        at.min_element() >= 0 && (at - self.size).max_element() < 0
    }

    /// Returns the value of an index, and whether it is one of the file.
    fn value(&self, index: IVec3, voxel_size: f32) -> (f32, bool) {
        let nearest = self.values[self.place(index)];
        match self.outside {
            Some(outside) if !self.holds(index) => (outside, false),
            Some(_) => (nearest, true),
            None => {
                let half = 0.5 * (self.size - 1).as_vec3();
                let beyond = ((index - self.low).as_vec3() - half).abs() - half;
                let to_side = beyond.max(Vec3::ZERO).length() + beyond.max_element().min(0.0);
                (nearest.max(voxel_size * to_side), true)
            }
        }
    }
}

impl Lattice {
    /// Returns the value of an index, and whether it is a distance, and not only a sign.
    pub(super) fn value(&self, index: IVec3) -> (f32, bool) {
        match &self.samples {
            Samples::Sparse(tree) => tree.value_and_state(index.to_array()),
            Samples::Dense(dense) => dense.value(index, self.voxel_size),
        }
    }

    /// Returns the origins of the boxes of 8³ indices that have distances.
    pub(super) fn known_boxes(&self) -> Vec<IVec3> {
        match &self.samples {
            Samples::Sparse(tree) => tree.leaves().map(|leaf| leaf.origin.into()).collect(),
            Samples::Dense(dense) => {
                let first = dense.low.map(|c| c & -8);
                let last = (dense.low + dense.size - 1).map(|c| c & -8);
                let along = |axis: usize| (first[axis]..=last[axis]).step_by(8);
                let rows = along(0).flat_map(|x| along(1).map(move |y| (x, y)));
                rows.flat_map(|(x, y)| along(2).map(move |z| IVec3::new(x, y, z)))
                    .collect()
            }
        }
    }

    /// Returns the values of a box of indices, x fastest.
    pub(super) fn values_in(&self, begin: IVec3, size: usize, out: &mut Vec<(f32, bool)>) {
        out.clear();
        let side = size as i32;
        let Samples::Sparse(tree) = &self.samples else {
            for i in 0..side * side * side {
                let inner = IVec3::new(i % side, i / side % side, i / side / side);
                out.push(self.value(begin + inner));
            }
            return;
        };
        // One leaf or tile holds all voxels with the same multiples of 8.
        out.resize(size * size * size, (0.0, false));
        let first = begin.map(|c| c & -8);
        let last = (begin + side - 1).map(|c| c & -8);
        for x in (first.x..=last.x).step_by(8) {
            for y in (first.y..=last.y).step_by(8) {
                for z in (first.z..=last.z).step_by(8) {
                    let origin = IVec3::new(x, y, z);
                    let leaf = tree.leaf(origin.to_array());
                    let tile = tree.value_and_state(origin.to_array());
                    let low = (origin - begin).max(IVec3::ZERO);
                    let high = (origin + 8 - begin).min(IVec3::splat(side));
                    for iz in low.z..high.z {
                        for iy in low.y..high.y {
                            for ix in low.x..high.x {
                                let [a, b, c] =
                                    (begin + IVec3::new(ix, iy, iz) - origin).to_array();
                                let place = (8 * (8 * a + b) + c) as usize;
                                let stored = leaf.map(|l| (l.values[place], l.active.is_on(place)));
                                let at = (iz * side + iy) * side + ix;
                                out[at as usize] = stored.unwrap_or(tile);
                            }
                        }
                    }
                }
            }
        }
    }

    /// Counts the voxels with values.
    pub(super) fn known_voxels(&self) -> u64 {
        match &self.samples {
            Samples::Sparse(tree) => tree.active_voxels(),
            Samples::Dense(dense) => dense.values.len() as u64,
        }
    }

    /// Returns the box of the indices that are inside.
    pub(super) fn inside(&self) -> Option<[IVec3; 2]> {
        let mut low = IVec3::MAX;
        let mut high = IVec3::MIN;
        let mut hold = |first: IVec3, last: IVec3| {
            low = low.min(first);
            high = high.max(last);
        };
        match &self.samples {
            Samples::Sparse(tree) => {
                for tile in tree.tiles.iter().filter(|tile| tile.value < 0.0) {
                    hold(tile.origin.into(), IVec3::from(tile.origin) + 4095);
                }
                for_each_tile(tree, &mut |origin, side, value| {
                    if value < 0.0 {
                        hold(origin, origin + side - 1);
                    }
                });
                for leaf in tree.leaves() {
                    let origin = IVec3::from(leaf.origin);
                    for (place, _) in leaf
                        .values
                        .iter()
                        .enumerate()
                        .filter(|(_, value)| **value < 0.0)
                    {
                        let index = origin + inner_of(place);
                        hold(index, index);
                    }
                }
            }
            Samples::Dense(dense) => {
                let places = dense.values.iter().enumerate();
                for (place, _) in places.filter(|(_, value)| **value < 0.0) {
                    hold(dense.index(place), dense.index(place));
                }
            }
        }
        (low.x <= high.x).then_some([low, high])
    }

    /// Calls a function for the indices whose values are distances.
    pub(super) fn for_each_known(&self, mut f: impl FnMut(IVec3, f32)) {
        match &self.samples {
            Samples::Sparse(tree) => {
                for leaf in tree.leaves() {
                    for place in leaf.active.places() {
                        f(
                            IVec3::from(leaf.origin) + inner_of(place),
                            leaf.values[place],
                        );
                    }
                }
            }
            Samples::Dense(dense) => {
                for (place, &value) in dense.values.iter().enumerate() {
                    f(dense.index(place), value);
                }
            }
        }
    }

    /// Returns distances whose surface is where they were `iso`.
    pub(super) fn moved(mut self, iso: f32) -> Result<Self, String> {
        match &mut self.samples {
            Samples::Sparse(tree) if iso.abs() >= tree.background.abs() => {
                return Err(format!(
                    "iso level {iso}: the file has distances up to {} only; densities need --class fog",
                    tree.background
                ));
            }
            Samples::Sparse(tree) => for_each_value(tree, &|value| value - iso),
            Samples::Dense(dense) => dense.values.par_iter_mut().for_each(|value| *value -= iso),
        }
        Ok(self)
    }

    /// Multiplies values by a factor.
    pub(super) fn scale(&mut self, factor: f32) {
        match &mut self.samples {
            Samples::Sparse(tree) => {
                tree.background *= factor;
                for_each_value(tree, &|value| value * factor);
            }
            Samples::Dense(dense) => {
                dense.outside = dense.outside.map(|value| value * factor);
                dense
                    .values
                    .par_iter_mut()
                    .for_each(|value| *value *= factor);
            }
        }
    }

    /// Whether it is a level set, whose values are distances.
    pub(super) fn is_level_set(&self) -> bool {
        matches!(self.samples, Samples::Sparse(_))
    }

    /// Whether the sides of an array cut its solid off.
    pub(super) fn is_cut(&self) -> bool {
        matches!(&self.samples, Samples::Dense(dense) if dense.outside.is_none())
    }

    /// Sets whether the sides of an array cut its solid off. Otherwise, what is beyond is outside, at no known distance.
    pub(super) fn set_cut(&mut self, is_cut: bool) {
        if let Samples::Dense(dense) = &mut self.samples {
            dense.outside = (!is_cut).then_some(f32::MAX);
        }
    }

    /// Returns distances to the surface where densities are `iso`, or half of the largest. They are estimated from the
    /// slope of the densities, and known next to the surface.
    pub(super) fn of_densities(mut self, iso: Option<f32>) -> Result<Self, String> {
        if let Samples::Dense(dense) = &mut self.samples {
            let least = dense.values.iter().copied().fold(f32::INFINITY, f32::min);
            dense.outside = Some(least.min(0.0));
        }
        let mut most = f32::NEG_INFINITY;
        self.for_each_known(|_, value| most = most.max(value));
        let iso = iso.unwrap_or(0.5 * most);
        if !(most > iso && iso.is_finite()) {
            return Err(format!("no density is above {iso}: the largest is {most}"));
        }
        let voxel = self.voxel_size;
        let of = |index: IVec3| {
            let value = |offset: IVec3| self.value(index + offset).0 - iso;
            let middle = value(IVec3::ZERO);
            let mut square = 0.0;
            let mut is_near = false;
            for axis in IVec3::AXES {
                let [before, after] = [value(-axis), value(axis)];
                square += (0.5 * (after - before)).powi(2);
                is_near |= (before > 0.0) != (middle > 0.0) || (after > 0.0) != (middle > 0.0);
            }
            let slope = square.sqrt();
            let distance = if slope > 0.0 {
                -middle / slope
            } else {
                -middle.signum()
            };
            // Farther than the next voxel, the slope says little.
            (voxel * distance.clamp(-1.2, 1.2), is_near)
        };
        let mut leaves = std::collections::BTreeMap::<[i32; 3], Vec<(IVec3, f32)>>::new();
        let mut add = |index: IVec3| {
            let (distance, is_near) = of(index);
            if is_near {
                let leaf = index.map(|c| c & -8).to_array();
                leaves.entry(leaf).or_default().push((index, distance));
            }
        };
        self.for_each_known(|index, _| {
            // Neighbors may be inactive.
            for offset in [
                IVec3::ZERO,
                IVec3::X,
                -IVec3::X,
                IVec3::Y,
                -IVec3::Y,
                IVec3::Z,
                -IVec3::Z,
            ] {
                let at = index + offset;
                if offset == IVec3::ZERO || !self.value(at).1 {
                    add(at);
                }
            }
        });
        let band = 1.3 * voxel;
        let leaves = leaves.into_iter().map(|(origin, values)| {
            let mut leaf = argil_vdb::Leaf::new(origin, band);
            for (index, value) in values {
                leaf.set(index.to_array(), value);
            }
            leaf
        });
        let mut tree = Tree::from_leaves(band, leaves.collect());
        tree.flood_signs();
        Ok(Self {
            samples: Samples::Sparse(tree),
            ..self
        })
    }
}

/// Returns the place in a leaf as an index.
pub(super) fn inner_of(place: usize) -> IVec3 {
    IVec3::from([place / 64, place / 8 % 8, place % 8].map(|c| c as i32))
}

fn for_each_tile(tree: &Tree<f32>, f: &mut dyn FnMut(IVec3, i32, f32)) {
    let at = |origin: [i32; 3], place: usize, across: usize, side: i32| {
        let inner = [
            place / across / across,
            place / across % across,
            place % across,
        ];
        IVec3::from(origin) + side * IVec3::from(inner.map(|c| c as i32))
    };
    for upper in &tree.uppers {
        for (place, &value) in upper.tiles.iter().enumerate() {
            f(at(upper.origin, place, 32, 128), 128, value);
        }
        for lower in &upper.lowers {
            for (place, &value) in lower.tiles.iter().enumerate() {
                f(at(lower.origin, place, 16, 8), 8, value);
            }
        }
    }
}

fn for_each_value<V: Voxel>(tree: &mut Tree<V>, f: &(dyn Fn(V) -> V + Sync)) {
    for upper in &mut tree.uppers {
        upper.lowers.par_iter_mut().for_each(|lower| {
            for leaf in &mut lower.leaves {
                for value in leaf.values.iter_mut() {
                    *value = f(*value);
                }
            }
        });
    }
}
