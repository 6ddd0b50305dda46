//! Ctrl-C and its relatives.

use std::io::Write;

use relievo::scan::abandon_outputs;

/// Exit code of a program that was interrupted, as shells give it: 128 and the signal's number.
const INTERRUPTED: i32 = 130;

/// On Ctrl-C, hang-up or a request to end, takes away what is half written and ends at once.
pub(super) fn install() {
    let handled = ctrlc::set_handler(|| {
        abandon_outputs();
        // Nowhere is left to report that standard error is closed.
        let _ = writeln!(
            std::io::stderr(),
            "\nrelievo: interrupted; unfinished outputs are removed"
        );
        std::process::exit(INTERRUPTED);
    });
    if let Err(error) = handled {
        log::debug!("interrupts are not handled: {error}");
    }
}
