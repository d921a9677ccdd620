//! Strips and fans of triangles.

/// Iterates over the triangles of a strip. Every other one is reversed.
pub(super) fn strip(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    let all = corners.windows(3).enumerate();
    all.map(|(index, window)| match index % 2 {
        0 => [window[0], window[1], window[2]],
        _ => [window[1], window[0], window[2]],
    })
}

/// Iterates over the triangles of a fan.
pub(super) fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    let sides = corners.get(1..).unwrap_or_default().windows(2);
    sides.map(|side| [corners[0], side[0], side[1]])
}
