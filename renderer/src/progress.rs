//! How far a rendering is.

use crate::film::Film;
use std::time::Duration;

/// A moment of a rendering.
#[derive(Clone, Copy, Debug)]
pub struct Moment {
    /// Samples per pixel that are done.
    pub spp: u64,
    /// Samples per pixel that are wanted.
    pub of: u64,
    /// Share of all samples done, 0 to 1.
    pub share: f32,
    /// Time since rendering began.
    pub elapsed: Duration,
}

/// Told about progress. All methods may be called from any thread.
pub trait Progress: Sync {
    /// Some tiles are done.
    fn update(&self, moment: Moment) {
        let _ = moment;
    }

    /// A pass over the whole picture is done.
    fn pass(&self, moment: Moment, film: &Film) {
        let _ = (moment, film);
    }

    /// Whether to stop at the next occasion, with what is there by then.
    fn cancelled(&self) -> bool {
        false
    }
}

/// No one listens.
pub struct Silent;

impl Progress for Silent {}
