//! Rays that march together, and points that are measured together.

use argil_field::{Evaluator, LANES};
use glam::Vec3;

/// Rays under way, one field an array. They march together, so all have taken the same number of steps.
#[derive(Default)]
pub(crate) struct Wave {
    pub pixel: Vec<u32>,
    pub direction: [Vec<f32>; 3],
    pub t: Vec<f32>,
    pub end: Vec<f32>,
    /// 1 outside, −1 inside, 0 before the first step.
    pub side: Vec<f32>,
    /// The level of detail that is read next.
    pub level: Vec<u32>,
    /// Empty places, and scratch to close them.
    retired: usize,
    places: Vec<u32>,
}

/// The end of a ray that is no longer under way.
pub(crate) const RETIRED: f32 = -1.0;

impl Wave {
    pub fn clear(&mut self) {
        self.truncate(0);
        self.retired = 0;
    }

    pub fn truncate(&mut self, n: usize) {
        self.pixel.truncate(n);
        self.direction.iter_mut().for_each(|d| d.truncate(n));
        self.t.truncate(n);
        self.end.truncate(n);
        self.side.truncate(n);
        self.level.truncate(n);
    }

    pub fn push(&mut self, pixel: u32, direction: Vec3, (t, end): (f32, f32)) {
        self.pixel.push(pixel);
        for k in 0..3 {
            self.direction[k].push(direction[k]);
        }
        self.t.push(t);
        self.end.push(end);
        self.side.push(0.0);
        self.level.push(0);
    }

    /// Take a ray out of the march. Its place stays until enough have gone.
    #[inline]
    pub fn retire(&mut self, i: usize) {
        self.end[i] = RETIRED;
        self.retired += 1;
    }

    /// Close the gaps once a quarter of the places is empty: moving rays costs more than marching a few for nothing.
    pub fn compact(&mut self) {
        if 4 * self.retired < self.len() {
            return;
        }
        self.places.clear();
        self.places
            .extend((0..self.len() as u32).filter(|&i| self.end[i as usize] != RETIRED));
        let kept = self.places.len();
        let close = |array: &mut Vec<f32>, places: &[u32]| {
            for (to, &from) in places.iter().enumerate() {
                array[to] = array[from as usize];
            }
        };
        let [x, y, z] = &mut self.direction;
        for array in [x, y, z, &mut self.t, &mut self.end, &mut self.side] {
            close(array, &self.places);
        }
        for (to, &from) in self.places.iter().enumerate() {
            self.pixel[to] = self.pixel[from as usize];
            self.level[to] = self.level[from as usize];
        }
        self.truncate(kept);
        self.retired = 0;
    }

    /// Whether a place holds a ray.
    #[inline]
    pub fn is_under_way(&self, i: usize) -> bool {
        self.end[i] != RETIRED
    }

    pub fn len(&self) -> usize {
        self.pixel.len()
    }
}

/// Points gathered to be evaluated, with whose they are.
#[derive(Default)]
pub(crate) struct Points {
    pub x: Vec<f32>,
    pub y: Vec<f32>,
    pub z: Vec<f32>,
    pub d: Vec<f32>,
}

impl Points {
    pub fn clear(&mut self) {
        self.x.clear();
        self.y.clear();
        self.z.clear();
    }

    #[inline]
    pub fn push(&mut self, p: Vec3) {
        self.x.push(p.x);
        self.y.push(p.y);
        self.z.push(p.z);
    }

    /// Fill `d`.
    pub fn measure(&mut self, evaluator: &mut Evaluator<'_>) {
        self.d.resize(self.x.len(), 0.0);
        for first in (0..self.x.len()).step_by(LANES) {
            let range = first..(first + LANES).min(self.x.len());
            let out = &mut self.d[range.clone()];
            evaluator.distances(
                &self.x[range.clone()],
                &self.y[range.clone()],
                &self.z[range],
                out,
            );
        }
    }
}
