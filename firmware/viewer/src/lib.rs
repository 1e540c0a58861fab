//! What the device does with a rho-grid, whatever the board.
#![no_std]
#![forbid(unsafe_code)]
