//! Ctrl-C and its relatives.

use std::io::Write;
use std::sync::{Mutex, PoisonError};

use crate::scan::abandon_outputs;

/// Exit code of a program that was interrupted, by whichever of the signals: what shells give for Ctrl-C.
const INTERRUPTED: i32 = 130;

/// On Ctrl-C, hang-up or a request to end, takes away what is half written and ends at once. On Linux,
/// signals that are ignored already stay so: `nohup` means it.
pub(super) fn install() {
    if let Err(error) = listen() {
        log::debug!("interrupts are not handled: {error}");
    }
}

/// What else is to be ended, in its own way.
static ALSO: Mutex<Option<Box<dyn FnOnce() + Send>>> = Mutex::new(None);

/// Has something done before the program ends for a signal; only the last of several.
pub(super) fn also(end: impl FnOnce() + Send + 'static) {
    *ALSO.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(end));
}

fn end() -> ! {
    abandon_outputs();
    let also = ALSO.lock().unwrap_or_else(PoisonError::into_inner).take();
    if let Some(also) = also {
        also();
    }
    // Nowhere is left to report that standard error is closed.
    let _ = writeln!(
        std::io::stderr(),
        "\nrelievo: interrupted; unfinished outputs are removed"
    );
    std::process::exit(INTERRUPTED);
}

/// A thread of its own waits for the signals, which are held back from all others: those that are begun later
/// inherit that from this one.
#[cfg(unix)]
fn listen() -> Result<(), Box<dyn std::error::Error>> {
    use nix::sys::signal::{SigSet, Signal};

    let ignored = ignored_signals();
    let signals: SigSet = [Signal::SIGINT, Signal::SIGTERM, Signal::SIGHUP]
        .into_iter()
        .filter(|signal| ignored >> (*signal as u32 - 1) & 1 == 0)
        .collect();
    signals.thread_block()?;
    let thread = std::thread::Builder::new().name("interrupts".to_owned());
    let begun = thread.spawn(move || {
        if signals.wait().is_ok() {
            end();
        }
    });
    if let Err(error) = begun {
        signals.thread_unblock()?;
        return Err(error.into());
    }
    Ok(())
}

#[cfg(not(unix))]
fn listen() -> Result<(), Box<dyn std::error::Error>> {
    Ok(ctrlc::set_handler(|| end())?)
}

/// The signals that this process ignores, bit n − 1 for signal n; none where the system does not tell.
#[cfg(unix)]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status
        .lines()
        .find_map(|line| line.strip_prefix("SigIgn:"))
        .and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.unwrap_or(0)
}
