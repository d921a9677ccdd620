//! Where light reads distances.

use crate::probe::FieldProbe;
use crate::ray_batch::Points;
use crate::source::{ByLength, DistanceSource};
use argil_abi::FrameUniform;
use argil_field::LANES;

/// Rays to the sun that march through the field together.
const FIELD_BATCH: usize = 64 * LANES;

/// Where light reads distances: stored ones, or the exact field.
pub(crate) struct LightSource<'a, 'p> {
    pub probe: &'a mut FieldProbe<'p>,
    pub air: Option<&'a dyn DistanceSource>,
}

impl LightSource<'_, '_> {
    /// Computes the distances of points into their `d`.
    pub(super) fn measure(&mut self, points: &mut Points) {
        match self.air {
            None => self.probe.measure(points),
            Some(air) => air.measure(points),
        }
    }

    /// Returns the number of points to measure at once. The field has a program for each batch of many.
    pub(super) fn batch(&self) -> usize {
        match self.air {
            None => self.probe.batch().max(FIELD_BATCH),
            Some(_) => LANES,
        }
    }

    /// Returns the shortest step of a shadow's ray.
    pub(super) fn min_step(&self, frame: &FrameUniform) -> ByLength {
        match self.air {
            None => ByLength::constant(2.0 * frame.epsilon),
            Some(air) => air.min_step(frame),
        }
    }

    /// Returns how far above the surface a shadow begins.
    pub(super) fn lift(&self, frame: &FrameUniform) -> ByLength {
        match self.air {
            None => ByLength::constant(frame.light_offset),
            Some(air) => air.lift(frame),
        }
    }

    /// Returns the distance beyond which results are clamped.
    pub(super) fn far(&self) -> f32 {
        match self.air {
            None => self.probe.far(),
            Some(_) => f32::INFINITY,
        }
    }
}
