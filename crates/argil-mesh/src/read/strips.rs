//! Strips and fans of triangles.

/// Iterates over the triangles of a strip. Every other one is reversed.
pub(super) fn strip(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    let all = corners.windows(3).enumerate();
    all.map(|(index, own)| match index % 2 {
        0 => [own[0], own[1], own[2]],
        _ => [own[1], own[0], own[2]],
    })
}

/// Iterates over the triangles of a fan.
pub(super) fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    let sides = corners.get(1..).unwrap_or_default().windows(2);
    sides.map(|side| [corners[0], side[0], side[1]])
}
