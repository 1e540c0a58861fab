//! What shows only when the parts run together: see `tests/`.
//!
//! Here is what those tests share: the firmware under test, pictures kept beside the tests, a scan and
//! a small model with their blobs, and seeded views.

pub mod firmware;
pub mod model;
pub mod random;
pub mod scan;
pub mod snapshot;
