//! The names of temporary files: `.NAME.HOST-PROCESS-NUMBER.tmp` becomes `NAME` when it is complete.

use std::ffi::{OsStr, OsString};
use std::sync::OnceLock;

use super::trace::sha256;

/// Digits of the host in names: enough to tell the machines of a network apart.
const DIGITS: usize = 8;

/// What a name tells of a temporary file.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Temporary<'a> {
    /// The name of the output.
    pub(crate) file: &'a str,
    /// Whether it was made on this machine: numbers of processes mean nothing on others.
    pub(crate) is_of_this_host: bool,
    /// The number of the process that made it.
    pub(crate) process: u32,
}

/// The name for an output of this process.
pub(super) fn name(file: &OsStr, number: u32) -> OsString {
    let mut name = OsString::from(".");
    name.push(file);
    name.push(format!(".{}-{}-{number}.tmp", host(), std::process::id()));
    name
}

impl<'a> Temporary<'a> {
    /// `None` for names of other files.
    pub(crate) fn of(name: &'a str) -> Option<Self> {
        let rest = name.strip_prefix('.')?.strip_suffix(".tmp")?;
        let (file, maker) = rest.rsplit_once('.')?;
        let mut parts = maker.split('-');
        let (of_host, process, number) = (parts.next()?, parts.next()?, parts.next()?);
        let is_number = !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
        if file.is_empty() || !is_number || parts.next().is_some() {
            return None;
        }
        Some(Self {
            file,
            is_of_this_host: of_host == host(),
            process: process.parse().ok()?,
        })
    }
}

/// Digits that stand for this machine's name.
fn host() -> &'static str {
    static HOST: OnceLock<String> = OnceLock::new();
    HOST.get_or_init(|| {
        let mut digits = sha256(host_name().as_encoded_bytes());
        digits.truncate(DIGITS);
        digits
    })
}

#[cfg(unix)]
fn host_name() -> OsString {
    // Without a name a machine is like all others that have none.
    nix::unistd::gethostname().unwrap_or_default()
}

#[cfg(not(unix))]
fn host_name() -> OsString {
    std::env::var_os("COMPUTERNAME").unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_output_machine_and_process() {
        let own = name(OsStr::new("a.b.ply"), 12);
        let told = Temporary::of(own.to_str().unwrap()).unwrap();
        let expected = Temporary {
            file: "a.b.ply",
            is_of_this_host: true,
            process: std::process::id(),
        };
        assert_eq!(told, expected);
        let foreign = Temporary::of(".a.ply.elsewhere-7-0.tmp").unwrap();
        assert_eq!((foreign.is_of_this_host, foreign.process), (false, 7));
        for other in [
            "a.ply.00000000-7-0.tmp",
            ".a.ply.00000000-7-x.tmp",
            ".a.ply.00000000-7-.tmp",
            ".a.ply.00000000-x-0.tmp",
            ".a.ply.7-0.tmp",
            ".a.ply.00000000-7-0-1.tmp",
            ".00000000-7-0.tmp",
            "..00000000-7-0.tmp",
            ".a.tmp",
            "a.ply",
        ] {
            assert_eq!(Temporary::of(other), None, "{other}");
        }
    }
}
