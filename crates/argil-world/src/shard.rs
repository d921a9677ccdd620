//! Parts of a world's tiles.

use crate::WorldError;
use std::str::FromStr;

/// A part of a world's tiles: every `count`-th run of neighbors, from the `index`-th on.
///
/// ```
/// use argil_world::Shard;
/// assert_eq!("3/8".parse(), Ok(Shard { index: 3, count: 8 }));
/// assert!("8/8".parse::<Shard>().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// From 0 to `count` − 1.
    pub index: u64,
    /// At least 1.
    pub count: u64,
}

/// Runs of a shard at least, if there are enough tiles, and the least and most tiles of a run: neighbors are baked sooner.
const RUNS: u64 = 16;
const RUN_TILES: [u64; 2] = [4, 64];

/// Variables in which systems that run arrays of jobs tell each job its number, and how many there are.
const VARIABLES: [(&str, Option<&str>, Option<&str>); 4] = [
    (
        "SLURM_ARRAY_TASK_ID",
        Some("SLURM_ARRAY_TASK_COUNT"),
        Some("SLURM_ARRAY_TASK_MIN"),
    ),
    ("JOB_COMPLETION_INDEX", None, None),
    ("AWS_BATCH_JOB_ARRAY_INDEX", None, None),
    ("CLOUD_RUN_TASK_INDEX", Some("CLOUD_RUN_TASK_COUNT"), None),
];

impl Shard {
    /// All tiles.
    pub const WHOLE: Self = Self { index: 0, count: 1 };

    /// Returns the shard of this job, from the variables of Slurm, Kubernetes, AWS Batch or Cloud Run. `count` is the number of
    /// jobs, for systems that do not tell it. Returns `None` outside of them.
    ///
    /// # Errors
    /// If a variable is no number, the number of jobs is not known, or the job's number is too large.
    pub fn from_environment(
        count: Option<u64>,
        variable: impl Fn(&str) -> Option<String>,
    ) -> Result<Option<Self>, String> {
        let read = |name: &str| -> Result<Option<u64>, String> {
            let value = variable(name).filter(|value| !value.is_empty());
            let number = value.map(|value| {
                let number = value.trim().parse();
                number.map_err(|_| format!("{name} is {value:?}: expected a number"))
            });
            number.transpose()
        };
        for (index, all, first) in VARIABLES {
            let Some(job) = read(index)? else { continue };
            let known = all.map(read).transpose()?.flatten();
            let first = first.map(read).transpose()?.flatten().unwrap_or(0);
            let shard = match (count, known) {
                // Whoever names the number runs all of them, or some again: the job's own number is the shard's.
                (Some(count), _) => Self { index: job, count },
                (None, Some(count)) => Self {
                    index: job.saturating_sub(first),
                    count,
                },
                (None, None) => {
                    return Err(format!(
                        "{index} is {job}, and the number of jobs is unknown: add --shards N"
                    ));
                }
            };
            return shard.checked().map(Some).map_err(|error| {
                format!("{index} is {job}: {error}. For jobs with other numbers, add --shards N, or --shard INDEX/COUNT")
            });
        }
        match count {
            Some(count) if count > 1 => Err(format!(
                "--shards {count}: this is no job of an array, so its shard is unknown: use --shard INDEX/{count}"
            )),
            _ => Ok(None),
        }
    }

    /// Returns the shard's part of all tiles. Runs are short enough that each shard has several, if there are enough tiles.
    pub(crate) fn part<T: Copy>(&self, all: &[T]) -> Vec<T> {
        let run = (all.len() as u64 / (RUNS * self.count)).clamp(RUN_TILES[0], RUN_TILES[1]);
        let run_of = |index: usize| index as u64 / run;
        let indices = (0..all.len()).filter(|&index| run_of(index) % self.count == self.index);
        indices.map(|index| all[index]).collect()
    }

    fn checked(self) -> Result<Self, String> {
        if self.index < self.count {
            return Ok(self);
        }
        let Self { index, count } = self;
        Err(WorldError::Shard { index, count }.to_string())
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/');
        let parsed = numbers.and_then(|(index, count)| {
            Some(Self {
                index: index.parse().ok()?,
                count: count.parse().ok()?,
            })
        });
        parsed
            .ok_or_else(|| format!("{text:?}: expected INDEX/COUNT, as 0/4"))?
            .checked()
    }
}

#[cfg(test)]
mod tests {
    use super::Shard;

    #[test]
    fn shards_cover_all_tiles_once() {
        for (tiles, count) in [(0, 3), (1, 3), (52, 4), (10_000, 7), (100, 1)] {
            let all: Vec<u64> = (0..tiles).collect();
            let parts: Vec<Vec<u64>> = (0..count)
                .map(|index| Shard { index, count }.part(&all))
                .collect();
            let mut found = parts.concat();
            found.sort_unstable();
            assert_eq!(found, all);
            let longest = parts.iter().map(Vec::len).max().unwrap_or(0) as u64;
            assert!(longest <= tiles / count + 65, "{longest}");
        }
    }

    #[test]
    fn jobs_know_their_shards() {
        let of = |all: &[(&str, &str)], count| {
            Shard::from_environment(count, |name| {
                let found = all.iter().find(|(variable, _)| *variable == name);
                found.map(|(_, value)| (*value).to_owned())
            })
        };
        let shard = |index, count| Ok(Some(Shard { index, count }));
        assert_eq!(of(&[], None), Ok(None));
        let slurm = [
            ("SLURM_ARRAY_TASK_ID", "5"),
            ("SLURM_ARRAY_TASK_COUNT", "4"),
            ("SLURM_ARRAY_TASK_MIN", "2"),
        ];
        assert_eq!(of(&slurm, None), shard(3, 4));
        // One job of the array again: of how many, only the user knows.
        let again = [
            ("SLURM_ARRAY_TASK_ID", "3"),
            ("SLURM_ARRAY_TASK_COUNT", "1"),
            ("SLURM_ARRAY_TASK_MIN", "3"),
        ];
        assert_eq!(of(&again, Some(4)), shard(3, 4));
        let outside = of(&[], Some(3)).expect_err("no array");
        assert!(outside.contains("--shard INDEX/3"), "{outside}");
        assert_eq!(of(&[("JOB_COMPLETION_INDEX", "2")], Some(3)), shard(2, 3));
        assert_eq!(
            of(&[("AWS_BATCH_JOB_ARRAY_INDEX", "0")], Some(9)),
            shard(0, 9)
        );
        let run = [("CLOUD_RUN_TASK_INDEX", "1"), ("CLOUD_RUN_TASK_COUNT", "2")];
        assert_eq!(of(&run, None), shard(1, 2));
        assert!(of(&[("JOB_COMPLETION_INDEX", "2")], None).is_err());
        assert!(of(&[("JOB_COMPLETION_INDEX", "3")], Some(3)).is_err());
        assert!(of(&[("JOB_COMPLETION_INDEX", "-1")], Some(3)).is_err());
        for text in ["", "1", "0/0", "2/2", "a/b", "-1/2", "1/2/3"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
