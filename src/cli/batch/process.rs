//! A process of a scan, seen from the batch.

use std::ffi::OsString;
use std::io::{self, Read, Write};
use std::process::{Child, ChildStderr, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

use super::memory::of_process;
use super::protocol::{Answer, Order};

/// As much of what a process says on standard error is kept: the end of it, in bytes.
const MOST_KEPT: usize = 4096;
/// How long it takes at most until the end of a process is noticed.
const NOTICED: Duration = Duration::from_millis(2);

/// Why the batch has ended a process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stop {
    /// The scan is done again when no others are.
    Again,
    /// It needs more memory than there may be, in bytes.
    Memory(u64),
    /// It took too long.
    Timeout,
    /// The batch itself is to end.
    Interrupted,
}

/// What became of a process.
#[derive(Debug)]
pub(super) enum Ended {
    Answered(Box<Answer>),
    Stopped(Stop),
    /// Without an answer; a sentence says how.
    Broken(String),
}

/// A process of a scan.
#[derive(Debug, Default)]
pub(super) struct Process {
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    child: Option<Child>,
    /// The process ends when this is closed.
    stdin: Option<ChildStdin>,
    stopped: Option<Stop>,
    peak: u64,
}

impl Process {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does an order in a process of its own, and waits for its end.
    pub(super) fn run(&self, order: &Order) -> Ended {
        match self.attempt(order) {
            Ok(ended) => ended,
            Err(error) => {
                self.end();
                Ended::Broken(format!("its process cannot be started or heard: {error}"))
            }
        }
    }

    fn attempt(&self, order: &Order) -> io::Result<Ended> {
        let mut child = command()?.spawn()?;
        let (stdin, stdout, stderr) =
            (child.stdin.take(), child.stdout.take(), child.stderr.take());
        {
            let mut state = self.state();
            state.child = Some(child);
            if state.stopped.is_some() {
                drop(state);
                self.kill();
            } else {
                state.stdin = stdin;
            }
        }
        let thread = || std::thread::Builder::new().name("messages".to_owned());
        let said = stderr.map(|stderr| thread().spawn(move || end_of(stderr)));
        let said = said.transpose()?;
        self.tell(order)?;
        let mut answer = String::new();
        if let Some(mut stdout) = stdout {
            // What is no text is no answer.
            let _ = stdout.read_to_string(&mut answer);
        }
        let status = self.wait()?;
        let said = said
            .and_then(|thread| thread.join().ok())
            .unwrap_or_default();
        if let Some(stop) = self.state().stopped {
            return Ok(Ended::Stopped(stop));
        }
        Ok(match serde_json::from_str(&answer) {
            Ok(answer) if status.success() => Ended::Answered(answer),
            _ => Ended::Broken(in_words(status, &said)),
        })
    }

    /// A process that has ended already hears nothing; its status tells. An error if there is nothing to be heard.
    fn tell(&self, order: &Order) -> io::Result<()> {
        let mut line = serde_json::to_string(order).map_err(|error| {
            let why = "names of folders that are not valid Unicode cannot be told: rename them";
            io::Error::other(format!("{why} ({error})"))
        })?;
        line.push('\n');
        let stdin = self.state().stdin.take();
        if let Some(mut stdin) = stdin {
            let _ = stdin.write_all(line.as_bytes());
            self.state().stdin = Some(stdin);
        }
        Ok(())
    }

    /// Ends it, if it has begun, and waits for that.
    pub(super) fn end(&self) {
        self.stop(Stop::Interrupted);
        let _ = self.wait();
    }

    /// Ends it at once; the first reason stays.
    pub(super) fn stop(&self, why: Stop) {
        self.state().stopped.get_or_insert(why);
        self.kill();
    }

    fn kill(&self) {
        let mut state = self.state();
        state.stdin = None;
        if let Some(child) = &mut state.child {
            // One that has ended cannot be.
            let _ = child.kill();
        }
    }

    /// Whether it is to end, or has.
    pub(super) fn is_stopped(&self) -> bool {
        self.state().stopped.is_some()
    }

    pub(super) fn wait(&self) -> io::Result<ExitStatus> {
        loop {
            // Not locked while it waits, so that it can be ended.
            let ended = match &mut self.state().child {
                Some(child) => child.try_wait()?,
                None => return Err(io::ErrorKind::NotFound.into()),
            };
            match ended {
                Some(status) => return Ok(status),
                None => std::thread::sleep(NOTICED),
            }
        }
    }

    /// Its number, once it has begun.
    pub(super) fn id(&self) -> Option<u32> {
        self.state().child.as_ref().map(Child::id)
    }

    /// Memory that it has now, in bytes; 0 where the system does not tell.
    pub(super) fn memory(&self) -> u64 {
        let resident = self
            .id()
            .and_then(|id| of_process(&id.to_string(), "VmRSS"))
            .unwrap_or(0);
        let mut state = self.state();
        state.peak = state.peak.max(resident);
        resident
    }

    /// Most memory that was seen, in bytes, if any was.
    pub(super) fn peak(&self) -> Option<u64> {
        Some(self.state().peak).filter(|peak| *peak > 0)
    }
}

/// How the command line is called again, where it is no program of its own.
static AGAIN: OnceLock<Vec<OsString>> = OnceLock::new();

/// Tells how this command line is called again where it is not a program of its own, as the words before the
/// subcommand: `relievo batch` calls it for each scan. Only the first call counts.
pub fn called_again_by(words: Vec<OsString>) {
    let _ = AGAIN.set(words);
}

/// This very program, in a group of its own: what is typed at the terminal ends the batch, which ends the others.
fn command() -> io::Result<Command> {
    let own = || -> io::Result<Vec<OsString>> {
        Ok(vec![if cfg!(target_os = "linux") {
            // Also if the file was replaced meanwhile.
            "/proc/self/exe".into()
        } else {
            std::env::current_exe()?.into()
        }])
    };
    let words = match AGAIN.get() {
        Some(words) => words.clone(),
        None => own()?,
    };
    let [program, arguments @ ..] = words.as_slice() else {
        return Err(io::ErrorKind::NotFound.into());
    };
    let mut command = Command::new(program);
    command
        .args(arguments)
        .arg(super::CHILD)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    Ok(command)
}

/// All that is said, and the end of it.
fn end_of(mut stderr: ChildStderr) -> String {
    let mut kept = Vec::new();
    let mut buffer = [0; 1024];
    while let Ok(count @ 1..) = stderr.read(&mut buffer) {
        kept.extend_from_slice(&buffer[..count]);
        kept.drain(..kept.len().saturating_sub(MOST_KEPT));
    }
    String::from_utf8_lossy(&kept).into_owned()
}

fn in_words(status: ExitStatus, said: &str) -> String {
    let last = said.lines().rfind(|line| !line.trim().is_empty());
    if said.contains("memory allocation of") {
        return "its process ran out of memory: give it less to do, or more memory".to_owned();
    }
    if said.contains("has overflowed its stack") {
        return "its process ended by a stack overflow, a mistake in relievo: please report it"
            .to_owned();
    }
    let how = ended_by(status);
    match last {
        Some(last) => format!("its process ended {how}: {}", last.trim()),
        None => format!("its process ended {how}"),
    }
}

#[cfg(unix)]
fn ended_by(status: ExitStatus) -> String {
    use nix::sys::signal::Signal;
    use std::os::unix::process::ExitStatusExt;
    let Some(number) = status.signal() else {
        return format!("with the code {}", status.code().unwrap_or(-1));
    };
    let name =
        Signal::try_from(number).map_or_else(|_| number.to_string(), |signal| signal.to_string());
    if number == Signal::SIGKILL as i32 {
        format!("by {name}, as the system ends processes when memory runs out")
    } else {
        format!("by {name}")
    }
}

#[cfg(not(unix))]
fn ended_by(status: ExitStatus) -> String {
    format!("with the code {}", status.code().unwrap_or(-1))
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;
    use std::os::unix::process::ExitStatusExt;

    #[test]
    fn the_end_of_a_process_is_told_in_a_sentence() {
        let killed = ExitStatus::from_raw(9);
        assert!(in_words(killed, "").contains("SIGKILL"));
        let aborted = ExitStatus::from_raw(6);
        assert_eq!(
            in_words(aborted, "x\ny \n\n"),
            "its process ended by SIGABRT: y"
        );
        let allocation = "memory allocation of 123 bytes failed";
        assert!(in_words(aborted, allocation).contains("out of memory"));
        let overflow = "thread 'main' has overflowed its stack";
        assert!(in_words(aborted, overflow).contains("stack overflow"));
        let code = ExitStatus::from_raw(7 << 8);
        assert_eq!(in_words(code, ""), "its process ended with the code 7");
    }
}
