//! What shows only when the parts run together: see `tests/`.
//!
//! Here is what those tests share: the firmware under test, pictures kept beside the tests, and
//! a small model.

pub mod firmware;
pub mod model;
pub mod snapshot;
