//! The wish to stop, as a terminal, a shell or a scheduler tells it by a signal: cells stop after
//! their current control step, with all saved. A second signal ends the process at once, unless it
//! comes right after the first: some tell a process and its group, and so the process twice.

use std::{
    fs, io,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::{Duration, Instant},
};

use signal_hook::{
    consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1},
    iterator::Signals,
    low_level::exit,
};

/// Signals that come within this time are one request.
const ONE_REQUEST: Duration = Duration::from_secs(1);

/// Whether to stop, seen by all threads.
#[derive(Clone, Debug, Default)]
pub struct StopSignal(Arc<AtomicBool>);

impl StopSignal {
    /// Told by the signals of this process from now on: Ctrl-C, SIGTERM, SIGUSR1, and SIGHUP unless
    /// the process was begun with that ignored, as by `nohup`.
    ///
    /// # Errors
    /// If the system doesn't let signals be caught.
    pub fn at_signals() -> io::Result<Self> {
        let stop = Self::default();
        let mut caught = vec![SIGINT, SIGTERM, SIGUSR1];
        if !is_ignored(SIGHUP) {
            caught.push(SIGHUP);
        }
        let mut signals = Signals::new(caught)?;
        let told = stop.clone();
        thread::Builder::new().name("signals".into()).spawn(move || {
            let mut first = None;
            for signal in signals.forever() {
                if first.get_or_insert_with(Instant::now).elapsed() > ONE_REQUEST {
                    exit(128 + signal);
                }
                told.0.store(true, Ordering::Relaxed);
            }
        })?;
        Ok(stop)
    }

    /// Told once some time has passed, too; none for never. Finding out which may take its own time.
    ///
    /// # Errors
    /// If the system has no thread for it.
    pub fn after(
        &self,
        time: impl FnOnce() -> Option<Duration> + Send + 'static,
    ) -> io::Result<()> {
        let told = self.clone();
        let wait = move || {
            if let Some(time) = time() {
                thread::sleep(time);
                told.0.store(true, Ordering::Relaxed);
            }
        };
        thread::Builder::new().name("deadline".into()).spawn(wait).map(drop)
    }

    /// Whether someone asked to stop.
    #[must_use]
    pub fn is_requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Whether the process ignores a signal, as far as the system tells.
fn is_ignored(signal: i32) -> bool {
    fs::read_to_string("/proc/self/status")
        .is_ok_and(|status| ignored(&status).is_some_and(|mask| mask >> (signal - 1) & 1 == 1))
}

/// The mask of ignored signals, signal 1 in its lowest bit.
fn ignored(status: &str) -> Option<u64> {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
    u64::from_str_radix(mask.trim(), 16).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ignored_signals_are_read_from_what_the_system_tells() {
        let status = "Name:\titarl\nSigBlk:\t0000000000000000\nSigIgn:\t0000000000001003\n";
        let mask = ignored(status).unwrap();
        let numbers: Vec<_> = (1..=64).filter(|signal| mask >> (signal - 1) & 1 == 1).collect();
        assert_eq!(numbers, [1, 2, 13]);
        assert_eq!(ignored("Name:\titarl\n"), None);
        // Rust's runtime ignores SIGPIPE, which is 13.
        assert!(is_ignored(13) || !std::path::Path::new("/proc/self/status").exists());
    }
}
