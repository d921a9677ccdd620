use argil_abi::Hit;

/// The mean, the 95th percentile and the maximum of a distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Percentiles {
    /// Arithmetic mean.
    pub mean: f64,
    /// The value that 95 % do not exceed.
    pub p95: f64,
    /// Maximum.
    pub max: f64,
}

/// What the primary rays of an image did, without the samples of normals. Rays that miss the scene's box count 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayStatistics {
    /// Everything that a ray looked up: the sum of the others.
    pub steps: Percentiles,
    /// Distances: evaluations of the field, or samples of a volume.
    pub samples: Percentiles,
    /// Nodes of a tree that were visited.
    pub descents: Percentiles,
    /// Cells of a grid that were crossed.
    pub cells: Percentiles,
}

impl RayStatistics {
    /// Creates statistics from histograms, as `resolve_samples.wgsl` counts them: first the steps of rays that looked up
    /// only distances; then for the others their steps, samples, nodes and cells. Rays in none did nothing.
    pub fn of_histograms(
        pixels: u64,
        [alone, steps, samples, descents, cells]: [&[u32]; 5],
    ) -> Self {
        let all = |histograms: [&[u32]; 2]| {
            let mut all = Histogram::default();
            for (count, rays) in histograms
                .iter()
                .flat_map(|histogram| (0..).zip(histogram.iter()))
            {
                if *rays > 0 {
                    all.add(count, u64::from(*rays));
                }
            }
            let counted: u64 = all.0.iter().sum();
            all.add(0, pixels.saturating_sub(counted));
            all.spread()
        };
        Self {
            steps: all([alone, steps]),
            samples: all([alone, samples]),
            descents: all([descents, &[]]),
            cells: all([cells, &[]]),
        }
    }
}

/// The number of rays for each count.
#[derive(Clone, Default)]
struct Histogram(Vec<u64>);

impl Histogram {
    fn add(&mut self, count: u32, rays: u64) {
        let count = count as usize;
        if self.0.len() <= count {
            self.0.resize(count + 1, 0);
        }
        self.0[count] += rays;
    }

    fn merge(&mut self, other: &Self) {
        for (count, &rays) in (0..).zip(&other.0) {
            if rays > 0 {
                self.add(count, rays);
            }
        }
    }

    fn spread(&self) -> Percentiles {
        let rays: u64 = self.0.iter().sum();
        let of = |(count, rays): (usize, &u64)| count as f64 * *rays as f64;
        let total: f64 = self.0.iter().enumerate().map(of).sum();
        let at = |share: f64| {
            let place = (rays as f64 * share).ceil() as u64;
            let mut seen = 0;
            let found = self.0.iter().position(|rays| {
                seen += rays;
                seen >= place
            });
            found.unwrap_or(0) as f64
        };
        Percentiles {
            mean: total / rays.max(1) as f64,
            p95: at(0.95),
            max: at(1.0),
        }
    }
}

/// Histograms of what rays did.
#[derive(Clone, Default)]
pub(crate) struct RayCounts {
    steps: Histogram,
    samples: Histogram,
    descents: Histogram,
    cells: Histogram,
}

impl RayCounts {
    pub(crate) fn add(&mut self, hits: &[Hit]) {
        // Many rays do nothing.
        let idle = hits.iter().filter(|hit| hit.steps == 0).count() as u64;
        for histogram in [
            &mut self.steps,
            &mut self.samples,
            &mut self.descents,
            &mut self.cells,
        ] {
            histogram.add(0, idle);
        }
        for hit in hits.iter().filter(|hit| hit.steps > 0) {
            self.steps.add(hit.steps, 1);
            let other = hit.descents + hit.cells;
            self.samples.add(hit.steps.saturating_sub(other), 1);
            self.descents.add(hit.descents, 1);
            self.cells.add(hit.cells, 1);
        }
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        self.steps.merge(&other.steps);
        self.samples.merge(&other.samples);
        self.descents.merge(&other.descents);
        self.cells.merge(&other.cells);
    }

    pub(crate) fn clear(&mut self) {
        for histogram in [
            &mut self.steps,
            &mut self.samples,
            &mut self.descents,
            &mut self.cells,
        ] {
            histogram.0.clear();
        }
    }

    pub(crate) fn statistics(&self) -> RayStatistics {
        RayStatistics {
            steps: self.steps.spread(),
            samples: self.samples.spread(),
            descents: self.descents.spread(),
            cells: self.cells.spread(),
        }
    }
}
