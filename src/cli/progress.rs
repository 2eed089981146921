//! Progress of a rendering: a bar on a terminal, a line now and then elsewhere.

use indicatif::{ProgressBar, ProgressStyle};
use lacquer::Progress;
use renderer::progress::Moment;
use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::Duration;

/// Time between lines.
const PAUSE: Duration = Duration::from_secs(10);
/// Steps of the bar.
const STEPS: u64 = 1000;

/// Shows how far a rendering is.
pub struct Display {
    kind: Kind,
    /// Of a rendering that ends by time.
    limit: Option<Duration>,
}

enum Kind {
    Bar(ProgressBar),
    /// When the last line was written.
    Lines(Mutex<Duration>),
    Silent,
}

impl Display {
    /// Made for where stderr goes.
    pub fn new(quiet: bool, limit: Option<Duration>) -> Self {
        let kind = match (quiet, std::io::stderr().is_terminal()) {
            (true, _) => Kind::Silent,
            (false, false) => Kind::Lines(Mutex::new(Duration::ZERO)),
            (false, true) => {
                let style = ProgressStyle::with_template("{bar:40} {percent:>3} % {msg} ({eta} left)");
                let style = style.unwrap_or_else(|_| ProgressStyle::default_bar());
                Kind::Bar(ProgressBar::new(STEPS).with_style(style))
            }
        };
        Self { kind, limit }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        if let Kind::Bar(bar) = &self.kind {
            bar.finish_and_clear();
        }
    }
}

impl Progress for Display {
    fn update(&self, moment: Moment) {
        let share = match self.limit {
            Some(limit) => (moment.elapsed.as_secs_f32() / limit.as_secs_f32()).min(1.0),
            None => moment.share,
        };
        let done = match self.limit {
            Some(_) => format!("{} samples", moment.spp),
            None => format!("{}/{} samples", moment.spp, moment.of),
        };
        match &self.kind {
            Kind::Silent => {}
            Kind::Bar(bar) => {
                bar.set_position((share * STEPS as f32) as u64);
                bar.set_message(done);
            }
            Kind::Lines(last) => {
                // Another thread that holds the lock is writing a line.
                let Ok(mut last) = last.try_lock() else { return };
                if moment.elapsed >= *last + PAUSE {
                    *last = moment.elapsed;
                    eprintln!("{:3.0} %, {done}, {:.0} s", share * 100.0, moment.elapsed.as_secs_f32());
                }
            }
        }
    }
}
