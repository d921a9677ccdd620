//! Limits of the memory that a file may ask for.

use super::error::{MAX_TRIANGLES, ReadFault};
use crate::Mesh;
use glam::{Mat4, Vec3};

/// Bytes that a file's data may take: per byte of the file, and for each file.
const DATA: (u64, u64) = (40, 16 << 20);
/// Bytes that the meshes in their places may take, likewise. A small file may place many copies.
const COPIES: (u64, u64) = (24, 256 << 20);

/// What the bytes are for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Purpose {
    /// What the file stores, unpacked.
    Data,
    /// Meshes, once per place.
    Copies,
}

/// Bytes of memory that are left for a file.
#[derive(Debug)]
pub(super) struct Budget {
    purpose: Purpose,
    file_bytes: u64,
    limit: u64,
    used: u64,
}

impl Budget {
    pub(super) fn new(purpose: Purpose, file_bytes: usize) -> Self {
        let file_bytes = file_bytes as u64;
        let (per_byte, floor) = match purpose {
            Purpose::Data => DATA,
            Purpose::Copies => COPIES,
        };
        Self {
            purpose,
            file_bytes,
            limit: floor.max(per_byte * file_bytes),
            used: 0,
        }
    }

    /// Takes bytes, before they are allocated.
    ///
    /// # Errors
    /// If there are not so many.
    pub(super) fn take(&mut self, bytes: u64) -> Result<(), ReadFault> {
        self.used = self.used.saturating_add(bytes);
        if self.used <= self.limit {
            return Ok(());
        }
        let what = match self.purpose {
            Purpose::Data => "what it stores takes",
            Purpose::Copies => "its meshes, once for each place, take",
        };
        Err(ReadFault::TooLarge(format!(
            "{what} at least {} bytes, and a file of {} bytes may take {}: it is damaged, or needs fewer copies",
            self.used, self.file_bytes, self.limit
        )))
    }

    /// Takes the bytes of several copies of a mesh.
    ///
    /// # Errors
    /// If there are not so many, or the mesh would have too many triangles.
    pub(super) fn take_copies(
        &mut self,
        copies: usize,
        vertices: usize,
        triangles: usize,
    ) -> Result<(), ReadFault> {
        let all = (copies as u64).saturating_mul(triangles as u64);
        if all > MAX_TRIANGLES as u64 {
            return Err(ReadFault::TooLarge(format!(
                "it has {all} triangles in {copies} copies of a mesh, and {MAX_TRIANGLES} can be read"
            )));
        }
        let bytes = size_of::<Vec3>() * vertices + size_of::<[u32; 3]>() * triangles;
        self.take((copies as u64).saturating_mul(bytes as u64))
    }
}

/// Adds a copy of a mesh. A mirrored one keeps its outside.
pub(super) fn place(
    positions: &[Vec3],
    triangles: &[[u32; 3]],
    mesh_from_part: Mat4,
    mesh: &mut Mesh,
) {
    let first = mesh.positions.len() as u32;
    let is_mirrored = mesh_from_part.determinant() < 0.0;
    mesh.positions.extend(
        positions
            .iter()
            .map(|&p| mesh_from_part.transform_point3(p)),
    );
    mesh.triangles.extend(triangles.iter().map(|&[a, b, c]| {
        let [b, c] = if is_mirrored { [c, b] } else { [b, c] };
        [a, b, c].map(|i| first.saturating_add(i))
    }));
}
