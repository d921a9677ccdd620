//! Samples bricks.

use super::BrickLayout;
use super::material::packed;
use super::octants::{OCTANTS, place_of};
use super::sample_offsets::{BETWEEN, SampleOffsets};
use super::store::PLACES;
use crate::Texel;
use crate::encoding::encode;
use argil_abi::{
    BRICK_MIXED, FillUniform, GpuMaterial, Instruction, MATERIAL_OWN_RATIO, MATERIAL_SIDE,
};
use argil_field::{CELLS_PER_BATCH, Evaluator, FAR, HardBrush, LANES, Program, Pruner};
use glam::{DVec3, IVec3, Vec3, uvec3};
use multiversion::multiversion;

/// Evaluates bricks for one thread.
pub(crate) struct BrickBaker<'a> {
    program: &'a Program,
    layout: &'a BrickLayout,
    fill: &'a FillUniform,
    evaluator: Evaluator<'a>,
    places: &'a SampleOffsets,
    d: Vec<f32>,
    /// What cells are counted from, if that is not the scene's origin.
    origin: Option<DVec3>,
    /// For long programs.
    pub(crate) pruner: Option<PartPruner<'a>>,
}

/// Prunes programs for parts of bricks.
pub(crate) type PartPruner<'a> = Box<(Pruner<'a>, Vec<Instruction>)>;

/// A brick's program of more instructions is pruned again for its octants, which have a third more samples than the
/// brick.
const LONG: usize = 48;

impl<'a> BrickBaker<'a> {
    pub(super) fn new(
        program: &'a Program,
        layout: &'a BrickLayout,
        fill: &'a FillUniform,
        places: &'a SampleOffsets,
    ) -> Self {
        Self {
            program,
            layout,
            fill,
            evaluator: Evaluator::new(program),
            places,
            d: vec![0.0; layout.brick_samples() as usize],
            origin: None,
            pruner: None,
        }
    }

    /// Sets the corner of the region that cells are counted from.
    pub(super) fn set_origin(&mut self, origin: Option<DVec3>) {
        self.origin = origin;
        self.evaluator.set_origin(origin);
    }

    /// Samples a cell's brick. Returns the distance nearest to the surface.
    pub(super) fn brick<T: Texel>(
        &mut self,
        instructions: &[Instruction],
        cell: IVec3,
        out: &mut [T],
    ) -> f32 {
        if instructions.len() > LONG {
            return self.octants(instructions, cell, u8::MAX, out);
        }
        let first = (cell * self.layout.brick_size_voxels as i32).as_vec3();
        let Self { places, d, .. } = self;
        let places = &places.brick;
        let from = (FAR, instructions);
        sample(self.layout, &mut self.evaluator, from, first, places, d);
        encode(d, self.fill, out);
        nearest(d)
    }

    /// Returns the program of a cell's only surface, if that is a plane to within `tolerance`, in the cell and one voxel
    /// around it. Then finer samples would tell nothing more.
    ///
    /// Parts of the cell near the surface are pruned again. If one shape remains in all of them, nothing else can be
    /// seen there, however small. Its own distances are then measured, also between samples.
    pub(super) fn flat_program(
        &mut self,
        instructions: &[Instruction],
        cell: IVec3,
        (lipschitz, tolerance): (f32, f32),
    ) -> Option<Vec<Instruction>> {
        let only = if is_plain(instructions) {
            instructions.to_vec()
        } else {
            self.only_surface(instructions, cell, lipschitz)?
        };
        self.is_plane(&only, cell, tolerance).then_some(only)
    }

    /// Returns the program of one shape, if it is the same in all parts of a cell near the surface.
    fn only_surface(
        &mut self,
        instructions: &[Instruction],
        cell: IVec3,
        lipschitz: f32,
    ) -> Option<Vec<Instruction>> {
        let mut pruner = self.pruner.take().unwrap_or_else(|| {
            let (pruner, list) = (Pruner::new(self.program), Vec::new());
            Box::new((pruner, list))
        });
        let (own, list) = &mut *pruner;
        own.set_origin(self.origin);
        let layout = self.layout;
        let voxel = layout.voxel_grid.voxel_size;
        let box_of = layout.cell_box(cell);
        let part = 0.25 * layout.cell_length();
        let centers: [Vec3; CELLS_PER_BATCH] =
            std::array::from_fn(|i| box_of.min + part * (super::inner_cell(i).as_vec3() + 0.5));
        // Normals also need the next samples.
        let radius = 0.5 * 3f32.sqrt() * (part + 2.0 * voxel);
        let mut d = [0.0; CELLS_PER_BATCH];
        own.classify_cells(instructions, &centers, radius, &mut d);
        let reach = lipschitz * (radius + voxel);
        let mut only: Option<Vec<Instruction>> = None;
        let mut is_one = true;
        for (i, _) in d.iter().enumerate().filter(|(_, d)| d.abs() <= reach) {
            list.clear();
            own.prune_into(instructions, i, list);
            is_one = is_plain(list) && only.as_ref().is_none_or(|only| only == list);
            if !is_one {
                break;
            }
            only.get_or_insert_with(|| list.clone());
        }
        self.pruner = Some(pruner);
        only.filter(|_| is_one)
    }

    /// Whether a program's distances are those of a plane, in a cell and one voxel around it.
    fn is_plane(&mut self, instructions: &[Instruction], cell: IVec3, tolerance: f32) -> bool {
        let n = self.layout.brick_size_voxels as usize;
        let first = (cell * n as i32).as_vec3();
        let between = &self.places.between;
        let mut found = [0.0; BETWEEN.pow(3)];
        let evaluator = &mut self.evaluator;
        sample(
            self.layout,
            evaluator,
            (FAR, instructions),
            first,
            between,
            &mut found,
        );
        // The lattice begins a voxel before the brick.
        let step = (n + 2) as f32 / (BETWEEN - 1) as f32;
        let slope = [1, BETWEEN, BETWEEN * BETWEEN].map(|far| (found[far] - found[0]) / step);
        let plane = |[x, y, z]: [f32; 3]| {
            found[0] + slope[0] * (x + 1.0) + slope[1] * (y + 1.0) + slope[2] * (z + 1.0)
        };
        let is_near = |d: f32, place: [f32; 3]| (d - plane(place)).abs() <= tolerance;
        let mut all = found.iter().enumerate();
        if !all.all(|(i, &d)| is_near(d, [0, 1, 2].map(|axis: usize| between[axis][i]))) {
            return false;
        }
        let places = &self.places.brick;
        let d = &mut self.d;
        sample(
            self.layout,
            &mut self.evaluator,
            (FAR, instructions),
            first,
            places,
            d,
        );
        let mut all = d.iter().enumerate();
        all.all(|(i, &d)| is_near(d, [0, 1, 2].map(|axis: usize| places[axis][i])))
    }

    /// Samples some octants of a cell's brick again, one bit each. Returns the distance nearest to the surface. A
    /// long program is pruned for each octant.
    pub(super) fn octants<T: Texel>(
        &mut self,
        instructions: &[Instruction],
        cell: IVec3,
        some: u8,
        out: &mut [T],
    ) -> f32 {
        let some = (0..OCTANTS).filter(|octant| some >> octant & 1 != 0);
        let mut least = f32::INFINITY;
        let mut nearer = |found: f32| {
            if found.abs() < least.abs() {
                least = found;
            }
        };
        if instructions.len() <= LONG {
            some.for_each(|octant| {
                nearer(self.octant((FAR, instructions), cell, octant, out));
            });
            return least;
        }
        let mut pruner = self.pruner.take().unwrap_or_else(|| {
            let (pruner, list) = (Pruner::new(self.program), Vec::new());
            Box::new((pruner, list))
        });
        let (own, list) = &mut *pruner;
        own.set_origin(self.origin);
        let centers: [Vec3; OCTANTS] =
            std::array::from_fn(|octant| self.layout.middle_of_octant(cell, octant));
        // Samples also lie on the sides of octants.
        let radius = 0.500_1 * self.layout.half_diagonal(1);
        let mut d = [0.0; OCTANTS];
        own.classify_cells(instructions, &centers, radius, &mut d);
        for octant in some {
            list.clear();
            own.prune_into(instructions, octant, list);
            let start = self.start_of(d[octant], centers[octant], radius);
            nearer(self.octant((start, list), cell, octant, out));
        }
        self.pruner = Some(pruner);
        least
    }

    /// Returns a distance that a long list of hard unions can begin with: no distance within `radius` of a center is more.
    fn start_of(&self, d: f32, center: Vec3, radius: f32) -> f32 {
        let farthest = center.abs().max_element() + d.abs();
        if self.program.is_hard_union() && self.origin.is_none() && radius > 1e-4 * farthest {
            d + 1.01 * self.program.lipschitz() * radius
        } else {
            FAR
        }
    }

    /// Samples an octant of a cell's brick again. Returns the distance nearest to the surface.
    fn octant<T: Texel>(
        &mut self,
        from: (f32, &[Instruction]),
        cell: IVec3,
        octant: usize,
        out: &mut [T],
    ) -> f32 {
        let half = self.layout.brick_size_voxels / 2;
        let corner = place_of(octant) * half;
        let first = (cell * self.layout.brick_size_voxels as i32).as_vec3() + corner.as_vec3();
        let count = (half + 1).pow(3) as usize;
        let d = &mut self.d[..count];
        let evaluator = &mut self.evaluator;
        sample(self.layout, evaluator, from, first, &self.places.octant, d);
        // No brick has more.
        let mut texels = [T::default(); 729];
        encode(d, self.fill, &mut texels[..count]);
        let (row, side) = (
            half as usize + 1,
            self.layout.brick_size_voxels as usize + 1,
        );
        for (line, texels) in texels[..count].chunks_exact(row).enumerate() {
            let (y, z) = (
                corner.y as usize + line % row,
                corner.z as usize + line / row,
            );
            let to = (z * side + y) * side + corner.x as usize;
            out[to..to + row].copy_from_slice(texels);
        }
        nearest(d)
    }

    /// Joins a cell's existing brick with appended brushes in order. Returns an upper bound of the distance nearest
    /// to the surface. Encoding keeps the order of distances, so codes can be compared directly.
    pub(super) fn joined<T: Texel>(
        &mut self,
        brushes: &[HardBrush],
        cell: IVec3,
        brick: &mut [T],
    ) -> f32 {
        let first = (cell * self.layout.brick_size_voxels as i32).as_vec3();
        let Self { places, d, .. } = self;
        // No brick has more.
        let mut own = [T::default(); 17 * 17 * 17];
        let own = &mut own[..brick.len()];
        for brush in brushes {
            let evaluator = &mut self.evaluator;
            let from = (brush.start(), brush.list());
            sample(self.layout, evaluator, from, first, &places.brick, d);
            encode(d, self.fill, own);
            for (texel, &own) in brick.iter_mut().zip(&*own) {
                let is_greater = own.code() > texel.code();
                if is_greater != brush.is_union {
                    *texel = own;
                }
            }
        }
        self.nearest_stored(brick)
    }

    /// Returns an upper bound of the distance of a brick's samples that is nearest to the surface.
    pub(super) fn nearest_stored<T: Texel>(&self, brick: &[T]) -> f32 {
        let least = brick.iter().map(|texel| texel.code().abs());
        let least = least.fold(f32::INFINITY, f32::min);
        if least < self.fill.max_code as f32 {
            (least + 1.0) / self.fill.spacing_scale[3]
        } else {
            f32::INFINITY
        }
    }

    /// Returns a cell's material: one material, or an index among the block's mixed bricks. Distances near the cell change no
    /// faster than `lipschitz` per unit of length.
    pub(super) fn material(
        &mut self,
        instructions: &[Instruction],
        (cell, lipschitz): (IVec3, f32),
        mixed: &mut Vec<[u32; 2]>,
    ) -> u32 {
        if let Some(only) = only_material(instructions, self.program.materials()) {
            return only;
        }
        let voxel_grid = &self.layout.voxel_grid;
        let begin = (cell * self.layout.brick_size_voxels as i32).as_vec3();
        let step = self.layout.brick_size_voxels as f32 / (MATERIAL_SIDE - 1) as f32;
        let [mut x, mut y, mut z, mut d] = [[0.0f32; PLACES]; 4];
        for i in 0..PLACES {
            let place = i as u32;
            let place = uvec3(
                place % MATERIAL_SIDE,
                place / MATERIAL_SIDE % MATERIAL_SIDE,
                place / MATERIAL_SIDE / MATERIAL_SIDE,
            );
            let p = voxel_grid.corner + voxel_grid.voxel_size * (begin + step * place.as_vec3());
            (x[i], y[i], z[i]) = (p.x, p.y, p.z);
        }
        let mut found = [GpuMaterial::default(); PLACES];
        self.evaluator
            .materials_with(instructions, [&x, &y, &z], &mut d, &mut found);
        // If two neighboring points are farther from the surface than the distance between them, no surface lies
        // between.
        let reach = 1.01 * lipschitz * 3f32.sqrt() * step * voxel_grid.voxel_size;
        // If no point is near, all of them count. Then a program may contain more than it needs.
        let has_near = d.iter().any(|d| d.abs() <= reach);
        let reach = if has_near { reach } else { f32::INFINITY };
        let mut near = found.iter().zip(&d).filter(|(_, d)| d.abs() <= reach);
        let palette = self.program.materials();
        let mut first = [0; 2];
        if let Some((one, _)) = near.next() {
            let own = packed(one);
            first = own;
            if near.all(|(m, _)| m == one || packed(m) == own)
                && let Some(place) = palette.iter().position(|m| packed(m) == own)
            {
                return place as u32;
            }
        }
        // Neighbors often have the same material. Programs do not give distances that are too far to be looked
        // at.
        let far = MATERIAL_OWN_RATIO * reach;
        let (mut last, mut word) = (&found[0], packed(&found[0]));
        mixed.extend(found.iter().zip(&d).map(|(m, d)| {
            if m != last {
                (last, word) = (m, packed(m));
            }
            if d.abs() <= far { word } else { first }
        }));
        BRICK_MIXED | (mixed.len() / PLACES - 1) as u32
    }
}

/// Whether a program consists of one shape, placed by affine maps, whose distance is exact.
fn is_plain(instructions: &[Instruction]) -> bool {
    let shapes = instructions
        .iter()
        .filter(|i| i.op < argil_abi::OP_SHAPES_END);
    let is_shape = |op: u32| op < argil_abi::OP_FIRST_ITERATIVE;
    let is_place = |op: u32| {
        matches!(
            op,
            argil_abi::OP_AFFINE | argil_abi::OP_PUSH_POINT | argil_abi::OP_POP_POINT
        )
    };
    shapes.count() == 1
        && instructions
            .iter()
            .all(|i| is_shape(i.op) || is_place(i.op))
}

/// Returns the material of a program that has only one. Equal materials of the table count as the first of them.
pub(super) fn only_material(instructions: &[Instruction], palette: &[GpuMaterial]) -> Option<u32> {
    let takes = |i: &&Instruction| {
        i.op < argil_abi::OP_SHAPES_END && i.flags & argil_abi::FLAG_KEEP_MATERIAL == 0
    };
    let has_textures = |i: &Instruction| i.flags >> argil_abi::TEXTURES_SHIFT != 0;
    if instructions.iter().filter(takes).any(has_textures) {
        return None;
    }
    let mut all = instructions.iter().filter(takes).map(|i| i.operand);
    let only = all.next().unwrap_or(0);
    if !all.all(|other| other == only) {
        return None;
    }
    let Some(own) = palette.get(only as usize).map(packed) else {
        return Some(only);
    };
    let before = &palette[..only as usize];
    let first = before.iter().position(|m| packed(m) == own);
    Some(first.map_or(only, |first| first as u32))
}

/// Evaluates a program at points from a first sample on.
fn sample(
    layout: &BrickLayout,
    evaluator: &mut Evaluator<'_>,
    (start, instructions): (f32, &[Instruction]),
    first: Vec3,
    places: &[Vec<f32>; 3],
    d: &mut [f32],
) {
    let voxel_grid = &layout.voxel_grid;
    let [mut x, mut y, mut z] = [[0.0f32; LANES]; 3];
    for begin in (0..d.len()).step_by(LANES) {
        let n = LANES.min(d.len() - begin);
        for (axis, out) in [&mut x, &mut y, &mut z].into_iter().enumerate() {
            let (corner, first) = (voxel_grid.corner[axis], first[axis]);
            let places = &places[axis][begin..begin + n];
            for (out, place) in out[..n].iter_mut().zip(places) {
                *out = corner + voxel_grid.voxel_size * (first + place);
            }
        }
        let d = &mut d[begin..begin + n];
        evaluator.distances_from(start, instructions, [&x[..n], &y[..n], &z[..n]], d);
    }
}

/// Returns the value of smallest magnitude.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl", "x86_64+avx2"))]
fn nearest(d: &[f32]) -> f32 {
    // Positive floats sort like their bits. The sign moves to the lowest bit.
    let least = d
        .iter()
        .map(|d| d.to_bits().rotate_left(1))
        .fold(u32::MAX, |a, b| if b < a { b } else { a });
    f32::from_bits(least.rotate_right(1))
}
