//! `argil study`.

use crate::args::{Device, Preset, Study, StudyCommand};
use crate::output;
use argil::{Backend, Engine};
use argil_study::{Options, Progress};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;

pub fn run(options: &Study) -> anyhow::Result<()> {
    match &options.command {
        Some(StudyCommand::Report { records, output }) => {
            argil_study::report(records, output)?;
            output::line(&output.display().to_string());
            return Ok(());
        }
        Some(StudyCommand::Findings { records, output }) => {
            argil_study::findings(records, output)?;
            output::line(&output.display().to_string());
            return Ok(());
        }
        None => {}
    }
    let engines = engines(options.device)?;
    let what = Options {
        full: options.preset == Preset::Full,
        only: options.only.clone(),
    };
    let mut bar = Bar::new()?;
    let summary = argil_study::study(&engines, &what, &options.output, &mut bar)?;
    bar.bar.finish_and_clear();
    let report = options.output.join("report.html");
    argil_study::report(std::slice::from_ref(&options.output), &report)?;
    let failed = (summary.failed > 0).then(|| {
        anyhow::anyhow!(
            "{} cases failed: the report says why, in their rows",
            summary.failed
        )
    });
    if options.json {
        output::json(&json!({
            "report": report.display().to_string(),
            "cases": summary.done,
            "failed": summary.failed,
            "broken_checks": summary.broken,
        }));
        return failed.map_or(Ok(()), Err);
    }
    output::line(&report.display().to_string());
    output::line(&format!(
        "{} cases, {} of them failed, {} checks did not hold",
        summary.done, summary.failed, summary.broken
    ));
    failed.map_or(Ok(()), Err)
}

/// The devices that are measured: without a wish, all that there are.
fn engines(device: Device) -> anyhow::Result<Vec<Engine>> {
    Ok(match device {
        Device::Cpu => vec![Engine::cpu()],
        Device::Gpu => vec![Engine::on(Backend::Gpu)?],
        Device::Auto => {
            let mut all = vec![Engine::cpu()];
            match Engine::on(Backend::Gpu) {
                Ok(gpu) => all.push(gpu),
                Err(error) => eprintln!("argil: the CPU alone is measured: {error}"),
            }
            all
        }
    })
}

struct Bar {
    bar: ProgressBar,
}

impl Bar {
    fn new() -> anyhow::Result<Self> {
        let style = ProgressStyle::with_template("{bar:30} {pos}/{len}, {eta} left: {msg}")?;
        Ok(Self {
            bar: ProgressBar::no_length().with_style(style),
        })
    }
}

impl Progress for Bar {
    fn begins(&mut self, cases: usize, done: usize) {
        self.bar.set_length(cases as u64);
        self.bar.set_position(done as u64);
        // What was done before tells nothing of how long the rest takes.
        self.bar.reset_eta();
    }

    fn case(&mut self, device: &str, experiment: &str, case: &str) {
        self.bar
            .set_message(format!("{experiment} {case} on {device}"));
        // Where no bar is drawn, a line tells how far it is.
        let at = self.bar.position();
        if self.bar.is_hidden() && at.is_multiple_of(20) {
            let all = self.bar.length().unwrap_or(0);
            eprintln!("{at} of {all}: {experiment} on {device}");
        }
    }

    fn done(&mut self, error: Option<&str>) {
        self.bar.inc(1);
        if let Some(error) = error {
            self.bar.suspend(|| eprintln!("argil: {error}"));
        }
    }
}
