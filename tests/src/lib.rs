//! What shows only when the parts run together: see `tests/`.
