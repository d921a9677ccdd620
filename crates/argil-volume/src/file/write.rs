use super::format::{ALIGNMENT, ENTRY_BYTES, FORMAT_VERSION, HEADER_BYTES, MAGIC, Section};
use super::meshes::StoredMesh;
use super::meshes::bytes_of;
use crate::Volume;
use crate::{Encoding, VoxelGrid};
use std::io::{self, Write};

/// Words of the description: kind, format, band in voxels, corner, voxel size, size, levels, brick size, and depth
/// or, for sparse bricks, the Lipschitz constant; then the first voxel, and whether the box clips the solid.
/// Version 1 lacks the last two.
pub(super) const DESCRIPTION_WORDS: usize = 17;
pub(super) const DESCRIPTION_WORDS_1: usize = 13;

fn write(
    volume: &Volume,
    scene_json: &str,
    meshes: &[StoredMesh<'_>],
    mut out: impl Write,
) -> io::Result<()> {
    // Gather the sections. Large ones are borrowed.
    let (kind, part) = volume.file_parts();
    let description = describe(
        kind,
        volume.encoding(),
        volume.voxel_grid(),
        part.kind_parameters,
    );
    let mut sections: Vec<(Section, &[u8])> = vec![
        (Section::Description, &description),
        (Section::Scene, scene_json.as_bytes()),
    ];
    let own = part.sections.iter();
    sections.extend(own.map(|(section, bytes)| (*section, &bytes[..])));
    let meshes = bytes_of(meshes);
    if !meshes.is_empty() {
        sections.insert(2, (Section::Meshes, &meshes));
    }

    // Lay them out.
    let mut table = Vec::new();
    let mut at = (HEADER_BYTES + ENTRY_BYTES * sections.len()) as u64;
    let mut offsets = Vec::new();
    for (section, bytes) in &sections {
        at = at.next_multiple_of(ALIGNMENT);
        offsets.push(at);
        table.extend(section.name());
        table.extend(crc32fast::hash(bytes).to_le_bytes());
        table.extend(at.to_le_bytes());
        table.extend((bytes.len() as u64).to_le_bytes());
        table.extend([0; 8]);
        at += bytes.len() as u64;
    }
    let mut head = Vec::new();
    head.extend(MAGIC);
    head.extend(FORMAT_VERSION.to_le_bytes());
    head.extend((sections.len() as u32).to_le_bytes());
    head.extend(at.to_le_bytes());
    let mut crc = crc32fast::Hasher::new();
    crc.update(&head);
    crc.update(&table);
    head.extend(crc.finalize().to_le_bytes());
    head.extend([0; 4]);

    out.write_all(&head)?;
    out.write_all(&table)?;
    let mut written = (head.len() + table.len()) as u64;
    for ((_, bytes), offset) in sections.iter().zip(offsets) {
        let gap = [0; ALIGNMENT as usize];
        out.write_all(&gap[..(offset - written) as usize])?;
        out.write_all(bytes)?;
        written = offset + bytes.len() as u64;
    }
    out.flush()
}

fn describe(kind: u32, encoding: &Encoding, voxel_grid: &VoxelGrid, own: [u32; 3]) -> Vec<u8> {
    let [x, y, z] = voxel_grid.corner.to_array().map(f32::to_bits);
    let [nx, ny, nz] = voxel_grid.size.to_array();
    let range = encoding.band.voxels().to_bits();
    let bits = 8 * encoding.format.bytes() as u32;
    let [levels, brick, depth] = own;
    let words: [u32; DESCRIPTION_WORDS] = [
        kind,
        bits,
        range,
        x,
        y,
        z,
        voxel_grid.voxel_size.to_bits(),
        nx,
        ny,
        nz,
        levels,
        brick,
        depth,
        voxel_grid.begin.x as u32,
        voxel_grid.begin.y as u32,
        voxel_grid.begin.z as u32,
        u32::from(voxel_grid.is_clipped),
    ];
    words.iter().flat_map(|w| w.to_le_bytes()).collect()
}

impl Volume {
    /// Writes a volume file, with the scene that was sampled, as JSON text, and its meshes.
    ///
    /// # Errors
    /// If `out` fails.
    pub fn write(
        &self,
        scene_json: &str,
        meshes: &[StoredMesh<'_>],
        out: impl std::io::Write,
    ) -> std::io::Result<()> {
        write(self, scene_json, meshes, out)
    }
}
