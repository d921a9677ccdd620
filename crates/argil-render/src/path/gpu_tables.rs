//! Lights and tables as shaders read them: see `emitters.wgsl`.

use super::albedo::ALBEDO;
use super::lights::PathLights;
use super::view::{PathView, StillOptions};
use argil_abi::PathUniform;

/// What paths on a GPU read besides surfaces.
#[derive(Clone, Debug)]
pub struct PathTables {
    /// What all paths share. What follows from surfaces and dispatches is 0.
    pub uniform: PathUniform,
    /// Lights, what rough mirrors reflect, and sums of the environment's rows.
    pub rows: Vec<[f32; 4]>,
    /// The environment's pixels, row by row from the top: colors, and sums within rows. One pixel if there is no image.
    pub environment: Vec<[f32; 4]>,
}

impl PathTables {
    /// Prepares a view.
    pub fn new(view: &PathView, options: &StillOptions) -> Self {
        let mut rows = Vec::new();
        let light_count = view.lights.write_rows(&mut rows);
        let albedo_at = rows.len();
        let shares: Vec<_> = ALBEDO.entries().collect();
        rows.extend(shares.chunks(2).map(|two| {
            let [a, b] = [two[0], two.get(1).copied().unwrap_or_default()];
            [a.x, a.y, b.x, b.y]
        }));
        let rows_at = rows.len();
        let mut uniform = PathUniform {
            light_count,
            albedo_at: albedo_at as u32,
            rows_at: rows_at as u32,
            clamp: options.firefly_clamp.unwrap_or(f32::MAX),
            max_bounces: options.max_bounces,
            is_transparent: u32::from(options.is_transparent),
            ..PathUniform::default()
        };
        if let Some(lens) = view.lens {
            (uniform.lens_radius, uniform.lens_focus) = (lens.radius, lens.focus);
        }
        let environment = view.lights.write_background(&mut uniform, &mut rows);
        Self {
            uniform,
            rows,
            environment,
        }
    }

    /// Returns the width and height of the environment's pixels.
    pub fn environment_size(&self) -> [u32; 2] {
        [
            self.uniform.environment_width,
            self.uniform.environment_height,
        ]
    }
}

impl PathLights {
    /// Appends four rows for each light. Returns their number.
    fn write_rows(&self, rows: &mut Vec<[f32; 4]>) -> u32 {
        let all = self.rows();
        rows.extend(all.iter().flatten());
        all.len() as u32
    }
}
