//! What must hold for any bytes.

// The same file is a module of the test that replays seeds and crashes.
include!("promises.rs");
