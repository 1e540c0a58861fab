//! A plugin of QEMU that counts how often each instruction runs, interval by interval.
//!
//! `-plugin file=LIBRARY,counter=ADDRESS,out=FILE`: an interval ends with each reading of the
//! 32-bit register at ADDRESS, which is the firmware's own counter, so that what is counted here
//! and what the firmware reports of itself have the same bounds, and a firmware needs no marks.
//! FILE then holds, for each interval that a reading ended, a line for each address that ran, in
//! ascending order,
//!
//! ```text
//! 000004f2 1024 17
//! ```
//!
//! (the address in hexadecimal, how often it ran, how often another instruction than the next
//! one followed) and a line `reading`.
//!
//! Counting is an addition in the translated code, and a call for each block of it; a frame takes
//! three times as long as without.

mod counts;
mod qemu;
