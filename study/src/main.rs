//! The study as a program, which `argil study` starts.

use argil::{Backend, Engine};
use argil_study::plan::Preset;
use argil_study::{Peer, StudyOptions, StudyProgress};
use clap::{Args, Parser, Subcommand, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Repeat and extend the measurements of the 2023 study
#[derive(Parser)]
#[command(name = "argil-study", version)]
struct StudyArguments {
    #[command(flatten)]
    study: Study,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Device {
    Auto,
    Cpu,
    Gpu,
}

#[derive(Args)]
#[command(args_conflicts_with_subcommands = true)]
struct Study {
    #[command(subcommand)]
    command: Option<StudyCommand>,
    /// Folder of records, images and the report
    #[arg(short, long, value_name = "DIR", default_value = "study-out")]
    output: PathBuf,
    /// Amount of measurements
    #[arg(long, value_enum, default_value_t = Preset::Quick)]
    preset: Preset,
    /// Devices to measure; auto: the CPU and, if available, a hardware or software GPU; the preset hardware measures a GPU only
    #[arg(long, value_enum, default_value_t = Device::Auto)]
    device: Device,
    /// Run only these experiments
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    only: Vec<String>,
    /// Preset hardware: fidget-wgpu's program or its folder, to measure it too; otherwise ARGIL_FIDGET_WGPU, or
    /// ../shared/peers/fidget-wgpu if it exists
    #[arg(long, value_name = "PATH")]
    peer: Option<PathBuf>,
    /// Print one JSON object to stdout, and nothing else
    #[arg(long)]
    json: bool,
}

#[derive(Subcommand)]
enum StudyCommand {
    /// Generate the report from records, which may come from several machines
    Report {
        /// Folders written by a study, or their records.jsonl
        #[arg(required = true)]
        records: Vec<PathBuf>,
        /// Output report
        #[arg(short, long, value_name = "HTML", default_value = "report.html")]
        output: PathBuf,
    },
    /// Compare the times of two versions of Argil, case by case, measured with the same preset on one device
    Compare {
        /// Folder of the version before
        before: PathBuf,
        /// Folder of the version after
        after: PathBuf,
    },
    /// Write the findings of records as Markdown
    Findings {
        /// Folders written by a study, or their records.jsonl
        #[arg(required = true)]
        records: Vec<PathBuf>,
        /// Output file
        #[arg(short, long, value_name = "MD", default_value = "findings.md")]
        output: PathBuf,
    },
}

fn main() -> ExitCode {
    match run(&StudyArguments::parse().study) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("argil-study: {error:#}");
            let of_machine = error.chain().any(|cause| cause.is::<argil::EngineError>());
            ExitCode::from(if of_machine { 3 } else { 1 })
        }
    }
}

fn run(options: &Study) -> anyhow::Result<()> {
    match &options.command {
        Some(StudyCommand::Report { records, output }) => {
            argil_study::report(records, output)?;
            println!("{}", output.display());
            return Ok(());
        }
        Some(StudyCommand::Compare { before, after }) => {
            print!("{}", argil_study::compare(before, after)?);
            return Ok(());
        }
        Some(StudyCommand::Findings { records, output }) => {
            argil_study::findings(records, output)?;
            println!("{}", output.display());
            return Ok(());
        }
        None => {}
    }
    let engines = engines(options.preset, options.device)?;
    let mut bar = Bar::new()?;
    let what = StudyOptions {
        preset: options.preset,
        only: options.only.clone(),
        peer: peer(options, &mut bar)?,
        ..StudyOptions::default()
    };
    let summary = argil_study::study(&engines, &what, &options.output, &mut bar)?;
    bar.bar.finish_and_clear();
    let report = options.output.join("report.html");
    argil_study::report(std::slice::from_ref(&options.output), &report)?;
    let failed = (summary.failed > 0).then(|| {
        anyhow::anyhow!(
            "{} cases failed: their rows in the report give the reasons",
            summary.failed
        )
    });
    if options.json {
        println!(
            "{}",
            json!({
                "report": report.display().to_string(),
                "cases": summary.done,
                "failed": summary.failed,
                "broken_checks": summary.broken,
                "left_out": summary.left_out,
            })
        );
        return failed.map_or(Ok(()), Err);
    }
    println!("{}", report.display());
    if !summary.left_out.is_empty() {
        println!(
            "left out, because the time was used up:\n  {}",
            summary.left_out.join("\n  ")
        );
    }
    println!(
        "{} cases, {} of them failed, {} checks failed",
        summary.done, summary.failed, summary.broken
    );
    failed.map_or(Ok(()), Err)
}

/// Finds the other renderer for the preset that measures it. Says so if there is none.
fn peer(options: &Study, bar: &mut Bar) -> anyhow::Result<Option<Peer>> {
    if options.preset != Preset::Hardware {
        anyhow::ensure!(
            options.peer.is_none(),
            "--peer needs --preset hardware, which measures it"
        );
        return Ok(None);
    }
    let found = match Peer::find(options.peer.as_deref()) {
        // A peer that was asked for must be there.
        Err(error) if options.peer.is_none() => {
            bar.note(&format!("fidget-wgpu is not measured: {error:#}"));
            return Ok(None);
        }
        found => found?,
    };
    if found.is_none() {
        bar.note("fidget-wgpu is not measured: give its program with --peer");
    }
    Ok(found)
}

/// Returns the devices to measure: by default, all.
fn engines(preset: Preset, device: Device) -> anyhow::Result<Vec<Engine>> {
    if preset == Preset::Hardware {
        anyhow::ensure!(
            device != Device::Cpu,
            "the preset hardware measures a GPU: choose another preset for the CPU"
        );
        let gpu = Engine::with_backend(Backend::Gpu)?;
        if !gpu
            .gpu_kind()
            .is_some_and(argil::gpu::DeviceKind::is_real_gpu)
        {
            eprintln!(
                "argil-study: {} is not a hardware GPU: only one small scene is measured",
                gpu.device()
            );
        }
        return Ok(vec![gpu]);
    }
    Ok(match device {
        Device::Cpu => vec![Engine::cpu()],
        Device::Gpu => vec![Engine::with_backend(Backend::Gpu)?],
        Device::Auto => {
            let mut all = vec![Engine::cpu()];
            match Engine::with_backend(Backend::Gpu) {
                Ok(gpu) => all.push(gpu),
                Err(error) => eprintln!("argil-study: measuring the CPU only: {error}"),
            }
            all
        }
    })
}

struct Bar {
    bar: ProgressBar,
    /// The position of the last line, where there is no progress bar.
    printed: Option<u64>,
}

impl Bar {
    fn new() -> anyhow::Result<Self> {
        let style = ProgressStyle::with_template("{bar:30} {pos}/{len}, {eta} left: {msg}")?;
        Ok(Self {
            bar: ProgressBar::no_length().with_style(style),
            printed: None,
        })
    }
}

impl StudyProgress for Bar {
    fn started(&mut self, cases: usize, done: usize) {
        self.bar.set_length(cases as u64);
        self.bar.set_position(done as u64);
        // Earlier cases say nothing about the remaining time.
        self.bar.reset_eta();
    }

    fn case(&mut self, device: &str, experiment: &str, case: &str) {
        self.bar
            .set_message(format!("{experiment} {case} on {device}"));
        // Without a progress bar, print a line.
        let at = self.bar.position();
        if self.bar.is_hidden() && self.printed.is_none_or(|last| at >= last + 20) {
            self.printed = Some(at);
            let all = self.bar.length().unwrap_or(0);
            eprintln!("{at} of {all}: {experiment} on {device}");
        }
    }

    fn done(&mut self, error: Option<&str>) {
        self.bar.inc(1);
        if let Some(error) = error {
            self.note(error);
        }
    }

    fn note(&mut self, text: &str) {
        self.bar.suspend(|| eprintln!("argil-study: {text}"));
    }
}
