//! Progress of long work, on stderr. Nothing is printed if stderr is not a terminal.

use argil::Engine;
use argil::math::Control;
use std::io::{IsTerminal, Write};
use std::time::{Duration, Instant};

/// Duration before progress is shown.
const PATIENCE: Duration = Duration::from_secs(1);
const PERIOD: Duration = Duration::from_millis(250);

/// Returns the engine with a progress display.
pub(crate) fn watched(engine: Engine) -> Engine {
    engine.with_control(&control())
}

/// Returns a control with a progress display.
pub(crate) fn control() -> Control {
    if !std::io::stderr().is_terminal() {
        return Control::new();
    }
    let control = Control::new();
    let seen = control.clone();
    std::thread::spawn(move || watch(&seen));
    control
}

fn watch(control: &Control) {
    let mut begun: Option<(&str, Instant)> = None;
    let mut is_shown = false;
    loop {
        std::thread::sleep(PERIOD);
        let Some(now) = control.progress() else {
            continue;
        };
        let start = match begun {
            Some((stage, start)) if stage == now.stage => start,
            _ => begun.insert((now.stage, Instant::now())).1,
        };
        let passed = start.elapsed();
        let share = now.done as f64 / (now.total as f64).max(1.0);
        // The total amount of work is not always known.
        let line = if now.total == 0 && passed > PATIENCE {
            format!(
                "{}: {:.0} s (Ctrl-C stops)",
                now.stage,
                passed.as_secs_f64()
            )
        } else if now.total > 0 && share < 1.0 && passed > PATIENCE {
            let left = passed.as_secs_f64() * (1.0 - share) / share.max(1e-3);
            format!(
                "{}: {:.0} %, about {left:.0} s left (Ctrl-C stops)",
                now.stage,
                100.0 * share
            )
        } else if is_shown {
            String::new()
        } else {
            continue;
        };
        is_shown = !line.is_empty();
        // Return to the beginning of the line and overwrite it.
        let _ = write!(std::io::stderr(), "\r\x1b[2K{line}");
    }
}
