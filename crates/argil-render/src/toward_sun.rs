//! Directions in the sky.

/// Returns the direction to the sun.
pub(crate) fn toward_sun(azimuth_elevation_degrees: [f32; 2]) -> [f32; 3] {
    let [azimuth, elevation] = azimuth_elevation_degrees.map(f32::to_radians);
    [
        elevation.cos() * azimuth.sin(),
        elevation.sin(),
        elevation.cos() * azimuth.cos(),
    ]
}
