//! Sortable tables.

use crate::formatting::{escaped, number};
use crate::record::{Record, quantile};

/// A column of a table.
pub(super) struct Column {
    /// The heading.
    pub head: &'static str,
    /// Name of the value.
    pub value: &'static str,
    /// The divisor for its unit.
    pub unit: f64,
}

/// Returns a column of a value.
pub(super) const fn column(head: &'static str, value: &'static str) -> Column {
    Column {
        head,
        value,
        unit: 1.0,
    }
}

/// Returns a column of bytes in MB.
pub(super) const fn megabytes(head: &'static str, value: &'static str) -> Column {
    Column {
        head,
        value,
        unit: 1e6,
    }
}

/// Describes what varies in a record besides scene and representation.
pub(super) fn varied(record: &Record) -> String {
    let left_out = ["size", "show", "eye"];
    let all = record.parameters.iter();
    let all = all.filter(|(key, value)| {
        !left_out.contains(&key.as_str()) || (*key == "eye" && *value != "outside")
    });
    let words: Vec<String> = all
        .map(|(key, value)| {
            let value = value
                .as_str()
                .map_or_else(|| value.to_string(), str::to_owned);
            match key.as_str() {
                "resolution" => format!("{value}³"),
                "eye" => value,
                "brick" => format!("bricks of {value}³"),
                "bits" => format!("{value} bits"),
                _ => format!("{} {value}", key.replace('_', " ")),
            }
        })
        .collect();
    words.join(", ")
}

/// Returns the command that repeats an experiment.
pub(super) fn study_command(record: &Record) -> String {
    let preset = match record.machine.preset.as_str() {
        "" | "quick" => String::new(),
        preset => format!(" --preset {preset}"),
    };
    format!("argil study{preset} --only {}", record.experiment)
}

/// Returns a table with a row per record.
pub(super) fn table(records: &[&Record], columns: &[Column], several: bool) -> String {
    let columns: Vec<&Column> = columns
        .iter()
        .filter(|c| records.iter().any(|r| r.value(c.value).is_some()))
        .collect();
    let mut text = String::from("<div class=\"wide\"><table class=\"sortable\"><thead><tr>");
    let mut heads = vec!["scene", "representation", "parameters"];
    if several {
        heads.push("device");
    }
    heads.extend(columns.iter().map(|c| c.head));
    heads.push("command");
    for head in heads {
        text += &format!("<th><button>{}</button></th>", escaped(head));
    }
    text += "</tr></thead><tbody>";
    for record in records {
        text += &format!(
            "<tr><td>{}</td><td>{}</td><td>{}</td>",
            escaped(&record.scene),
            escaped(&record.via),
            escaped(&varied(record))
        );
        if several {
            text += &format!("<td>{}</td>", escaped(&record.machine.device));
        }
        if let Some(error) = &record.error {
            text += &format!(
                "<td class=\"fault\" colspan=\"{}\">failed: {}</td>",
                columns.len() + 1,
                escaped(error)
            );
            text += "</tr>";
            continue;
        }
        for column in &columns {
            let Some(value) = record.value(column.value) else {
                text += "<td></td>";
                continue;
            };
            let shown = number(value / column.unit);
            let reach = record.samples.get(column.value).filter(|s| s.len() > 1);
            let title = reach.and_then(|samples| {
                let [low, high] = [0.0, 0.95].map(|part| quantile(samples, part));
                let text = format!(
                    "{} samples, min {}, 95th percentile {}",
                    samples.len(),
                    number(low? / column.unit),
                    number(high? / column.unit)
                );
                Some(format!(" title=\"{text}\""))
            });
            text += &format!(
                "<td data-value=\"{value}\"{}>{shown}</td>",
                title.unwrap_or_default()
            );
        }
        let usual = study_command(record);
        let command = record.command.as_deref().unwrap_or(&usual);
        text += &format!(
            "<td class=\"command\"><code>{}</code></td></tr>",
            escaped(command)
        );
    }
    text += "</tbody></table></div>";
    for record in records {
        for check in record.checks.iter().filter(|check| !check.passed) {
            text += &format!(
                "<p class=\"fault\">{}: {} is {}, expected {}</p>",
                escaped(&record.case),
                escaped(&check.value),
                check.found.map_or("missing".into(), number),
                escaped(&check.expected)
            );
        }
    }
    text
}
