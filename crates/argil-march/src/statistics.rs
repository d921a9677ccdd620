use argil_abi::Hit;

/// A distribution's mean, 95th percentile and maximum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Arithmetic mean.
    pub mean: f64,
    /// The value that 95 of 100 do not exceed.
    pub p95: f64,
    /// The greatest.
    pub max: f64,
}

/// What the primary rays of a picture did, the normal's samples apart. Rays that miss the scene's box count 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// All that a ray looked up: the sum of the others.
    pub steps: Spread,
    /// Distances: evaluations of the field, or samples of a volume.
    pub samples: Spread,
    /// Nodes of a tree that were visited.
    pub descents: Spread,
    /// Cells of a grid that were walked through.
    pub cells: Spread,
}

impl Statistics {
    /// Of the first sample of each pixel.
    pub fn of(hits: &[Hit]) -> Self {
        Self {
            steps: spread(hits, |h| h.steps),
            samples: spread(hits, |h| h.steps.saturating_sub(h.descents + h.cells)),
            descents: spread(hits, |h| h.descents),
            cells: spread(hits, |h| h.cells),
        }
    }
}

fn spread(hits: &[Hit], count: impl Fn(&Hit) -> u32) -> Spread {
    let mut counts: Vec<u32> = hits.iter().map(count).collect();
    counts.sort_unstable();
    let at = |share: f64| {
        let place = ((counts.len() as f64 * share).ceil() as usize).saturating_sub(1);
        f64::from(counts.get(place).copied().unwrap_or(0))
    };
    Spread {
        mean: counts.iter().map(|&s| f64::from(s)).sum::<f64>() / counts.len().max(1) as f64,
        p95: at(0.95),
        max: at(1.0),
    }
}
