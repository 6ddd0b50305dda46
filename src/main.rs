//! The command line of relievo.
fn main() {}
