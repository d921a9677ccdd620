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

/// What the primary rays of a picture did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Field evaluations a ray, the normal's apart; rays that miss the scene's box count 0.
    pub steps: Spread,
}

impl Statistics {
    /// Of the first sample of each pixel.
    pub fn of(hits: &[Hit]) -> Self {
        let mut steps: Vec<u32> = hits.iter().map(|h| h.steps).collect();
        steps.sort_unstable();
        let at = |share: f64| {
            steps
                .get(((steps.len() as f64 * share).ceil() as usize).saturating_sub(1))
                .copied()
        };
        let mean = steps.iter().map(|&s| f64::from(s)).sum::<f64>() / steps.len().max(1) as f64;
        let number = |v: Option<u32>| f64::from(v.unwrap_or(0));
        Self {
            steps: Spread {
                mean,
                p95: number(at(0.95)),
                max: number(steps.last().copied()),
            },
        }
    }
}
