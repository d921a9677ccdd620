//! The table of statistics: as text, back from text, and its limits.

use super::compiler::Statistics;
use anyhow::Context;
use std::fmt::Write;

/// The statistics of all entry points.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Table {
    /// The device and the driver's version.
    pub device: String,
    /// Scenes, and the slots of their interpreter's stack.
    pub slots: Vec<(&'static str, u32)>,
    pub rows: Vec<Row>,
}

/// An entry point of some scenes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Row {
    pub scenes: String,
    pub module: String,
    pub entry_point: String,
    pub group: [u32; 3],
    pub statistics: Statistics,
}

/// What an entry point may use at most.
struct Limit {
    module: &'static str,
    entry_point: &'static str,
    vgprs: u64,
    waves: u64,
}

/// Limits of what builds volumes, and of what evaluates the field along rays.
const LIMITS: [Limit; 14] = [
    limit("Bricks::build", "fill_bricks", 80, 12),
    limit("Bricks::columns", "fill_columns", 40, 24),
    limit("Bricks::build", "measure", 72, 14),
    limit("Bricks::build", "prune_cells", 64, 16),
    limit("DenseFill", "fill_tiled", 72, 14),
    limit("Octree::fill", "fill_bricks", 72, 14),
    limit("March::project", "project_to_field", 72, 14),
    limit("field", "march", 72, 14),
    limit("field", "shadow", 72, 14),
    limit("Field::lists", "prune_near_parts", 64, 16),
    limit("field by lists", "march", 72, 14),
    limit("field by lists", "shadow", 72, 14),
    limit("DenseFill::lists", "fill_tiled", 72, 14),
    limit("March::project by lists", "project_to_field", 72, 14),
];

const fn limit(module: &'static str, entry_point: &'static str, vgprs: u64, waves: u64) -> Limit {
    Limit {
        module,
        entry_point,
        vgprs,
        waves,
    }
}

/// How much more code than in the committed table an entry point may have.
const CODE_GROWTH: f64 = 1.1;

const COLUMNS: &str = "| scenes | module | entry point | group | registers | spilled | scratch | shared | waves | code | instructions | scalar loads | vector loads | texture loads | shared loads | cost |";

const HEAD: &str = "# What hardware is given

The compiler's statistics of every compute shader, as a hardware device gets it. `cargo xtask shader-stats` writes this page. It
compiles for a GPU that need not be there, with RADV, Mesa's driver of AMD's GPUs. Nothing runs. `cargo xtask test` compares.

* **registers**: 32-bit registers of each thread. Fewer registers leave room for more waves.
* **spilled**: registers that do not fit. **scratch**: bytes in memory for a wave. An array that is indexed at run time ends there,
  and each access is a load or a store. Both must be 0.
* **shared**: bytes of a workgroup. **shared loads** read them.
* **waves**: waves of 32 threads that a unit can hold, of 32. They hide the latency of loads. Below 10, a shader that loads in a
  chain waits.
* **code**: bytes. More than 32,768 do not fit the instruction cache.
* **scalar loads** run once for a wave, and **vector loads** once for each thread.
* **cost**: the compiler's estimate for one pass through the code, without loops. It compares two versions of one shader, and
  predicts no time.

A shader that is alike for several scenes is listed once. The interpreter's stack has as many slots as a scene needs:
";

impl Table {
    /// Formats the page.
    pub(crate) fn page(&self, family: &str) -> String {
        let mut text = HEAD.to_owned();
        let slots = self.slots.iter();
        let slots: Vec<_> = slots
            .map(|(scene, slots)| format!("{scene} {slots}"))
            .collect();
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "{}.\n\nGPU: {family}. Driver: {}.\n",
            slots.join(", "),
            self.device
        );
        let _ = writeln!(
            text,
            "{COLUMNS}\n|{}",
            " --- |".repeat(COLUMNS.matches('|').count() - 1)
        );
        for row in &self.rows {
            let statistics = &row.statistics;
            let [scalar, vector, texture, shared] = statistics.loads;
            let [x, y, z] = row.group;
            let _ = writeln!(
                text,
                "| {} | {} | `{}` | {x}×{y}×{z} | {} | {} | {} | {} | {} | {} | {} | {scalar} | {vector} | {texture} | {shared} | {} |",
                row.scenes,
                row.module,
                row.entry_point,
                statistics.vgprs,
                statistics.spilled,
                statistics.scratch_bytes,
                statistics.shared_bytes,
                statistics.waves,
                statistics.code_bytes,
                statistics.instructions,
                statistics.cost,
            );
        }
        text
    }

    /// Reads a page.
    pub(crate) fn parse(text: &str) -> anyhow::Result<Self> {
        let driver = text.lines().find_map(|line| line.split_once("Driver: "));
        let (_, device) = driver.context("the page names no driver")?;
        let rows = text.lines().filter(|line| line.contains('×'));
        let rows = rows.map(|line| Row::parse(line).with_context(|| line.to_owned()));
        Ok(Self {
            device: device.trim_end_matches('.').to_owned(),
            slots: Vec::new(),
            rows: rows.collect::<anyhow::Result<_>>()?,
        })
    }

    /// Lists what got worse since another table. Another driver allocates other registers, so only entry points are compared
    /// then.
    pub(crate) fn worse_than(&self, committed: &Self) -> Vec<String> {
        let mut faults = Vec::new();
        for row in &self.rows {
            let Some(before) = committed.rows.iter().find(|other| other.is_same_as(row)) else {
                faults.push(format!("{}: not in the table", row.name()));
                continue;
            };
            if self.device == committed.device {
                faults.extend(row.worse_than(before));
            }
        }
        for row in &committed.rows {
            if !self.rows.iter().any(|other| other.is_same_as(row)) {
                faults.push(format!("{}: only in the table", row.name()));
            }
        }
        faults
    }
}

impl Row {
    fn name(&self) -> String {
        format!("{} `{}` ({})", self.module, self.entry_point, self.scenes)
    }

    fn is_same_as(&self, other: &Self) -> bool {
        let key = |row: &Self| [&row.scenes, &row.module, &row.entry_point].map(String::clone);
        key(self) == key(other)
    }

    fn parse(line: &str) -> anyhow::Result<Self> {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        let [scenes, module, entry_point, group, numbers @ ..] = &cells[..] else {
            anyhow::bail!("too few columns");
        };
        let numbers: Vec<u64> = numbers
            .iter()
            .map(|cell| cell.parse())
            .collect::<Result<_, _>>()?;
        let [
            vgprs,
            spilled,
            scratch_bytes,
            shared_bytes,
            waves,
            code_bytes,
            instructions,
            scalar,
            vector,
            texture,
            shared,
            cost,
        ] = numbers[..]
        else {
            anyhow::bail!("not 12 numbers");
        };
        let sides: Vec<u32> = group.split('×').map(str::parse).collect::<Result<_, _>>()?;
        Ok(Self {
            scenes: (*scenes).to_owned(),
            module: (*module).to_owned(),
            entry_point: entry_point.trim_matches('`').to_owned(),
            group: sides.try_into().ok().context("a group has three sides")?,
            statistics: Statistics {
                vgprs,
                spilled,
                scratch_bytes,
                shared_bytes,
                waves,
                code_bytes,
                instructions,
                loads: [scalar, vector, texture, shared],
                cost,
            },
        })
    }

    fn worse_than(&self, before: &Self) -> Vec<String> {
        let (now, then) = (&self.statistics, &before.statistics);
        let mut faults = Vec::new();
        let mut fault = |what: &str, now: u64, then: u64| {
            faults.push(format!("{}: {what} {now}, was {then}", self.name()));
        };
        if now.scratch_bytes > then.scratch_bytes {
            fault("bytes of scratch", now.scratch_bytes, then.scratch_bytes);
        }
        if now.spilled > then.spilled {
            fault("spilled registers", now.spilled, then.spilled);
        }
        if now.waves < then.waves {
            fault("waves", now.waves, then.waves);
        }
        if now.code_bytes as f64 > CODE_GROWTH * then.code_bytes as f64 {
            fault("bytes of code", now.code_bytes, then.code_bytes);
        }
        faults
    }
}

/// Lists what exceeds the limits, whatever the committed table says.
pub(crate) fn limits(table: &Table) -> Vec<String> {
    let mut faults = Vec::new();
    for row in &table.rows {
        let statistics = &row.statistics;
        if statistics.scratch_bytes > 0 || statistics.spilled > 0 {
            faults.push(format!(
                "{}: {} bytes of scratch, {} spilled registers",
                row.name(),
                statistics.scratch_bytes,
                statistics.spilled
            ));
        }
    }
    for limit in &LIMITS {
        let mut is_there = false;
        for row in &table.rows {
            if (&row.module[..], &row.entry_point[..]) != (limit.module, limit.entry_point) {
                continue;
            }
            is_there = true;
            let statistics = &row.statistics;
            if statistics.vgprs > limit.vgprs || statistics.waves < limit.waves {
                faults.push(format!(
                    "{}: {} registers and {} waves, limits {} and {}",
                    row.name(),
                    statistics.vgprs,
                    statistics.waves,
                    limit.vgprs,
                    limit.waves
                ));
            }
        }
        if !is_there {
            faults.push(format!(
                "{} {}: no such entry point",
                limit.module, limit.entry_point
            ));
        }
    }
    faults
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let row = |limit: &Limit| Row {
            scenes: "csg20 temple".into(),
            module: limit.module.into(),
            entry_point: limit.entry_point.into(),
            group: [64, 1, 1],
            statistics: Statistics {
                vgprs: limit.vgprs,
                waves: limit.waves,
                code_bytes: 1000,
                loads: [1, 2, 3, 4],
                ..Statistics::default()
            },
        };
        Table {
            device: "a device, Mesa 1.2".into(),
            slots: vec![("csg20", 2)],
            rows: LIMITS.iter().map(row).collect(),
        }
    }

    #[test]
    fn a_page_is_read_back() {
        let table = table();
        let read = Table::parse(&table.page("navi21")).expect("a page");
        assert_eq!((&read.device, &read.rows), (&table.device, &table.rows));
        assert!(Table::parse("no page").is_err());
    }

    /// Each kind of change for the worse is found, and none without a change.
    #[test]
    fn changes_for_the_worse_are_found() {
        let committed = table();
        assert!(committed.worse_than(&committed).is_empty() && limits(&committed).is_empty());
        let changes: [fn(&mut Row); 5] = [
            |row| row.statistics.scratch_bytes = 16,
            |row| row.statistics.spilled = 1,
            |row| row.statistics.waves -= 1,
            |row| row.statistics.code_bytes = 1200,
            |row| row.entry_point = "another".into(),
        ];
        for (index, change) in changes.iter().enumerate() {
            let mut now = committed.clone();
            change(&mut now.rows[0]);
            assert!(!now.worse_than(&committed).is_empty(), "change {index}");
        }
        // Without the table, too.
        for change in [changes[0], changes[1], changes[2], changes[4]] {
            let mut now = committed.clone();
            change(&mut now.rows[0]);
            assert!(!limits(&now).is_empty());
        }
        // Registers of another driver are other ones.
        let mut now = committed.clone();
        now.device = "a device, Mesa 1.3".into();
        changes[2](&mut now.rows[0]);
        assert!(now.worse_than(&committed).is_empty());
    }
}
