//! What the device does with a rho-grid, whatever the board.
//!
//! A board hands over its screen, its counter and a painter with its memory ([`flow::Device`]) and
//! the text that the host sent; [`flow::run`] reads the [`request`], draws, shows the picture and
//! returns the [`report`]. From the top:
//!
//! | layer | modules |
//! | --- | --- |
//! | what a board calls | [`flow`] |
//! | where it is drawn | [`painter`]: [`picture`] in a whole frame, [`strips`] strip by strip |
//! | what is drawn | [`picture`] (a model), [`test_card`], [`message`] (an error, as text) |
//! | what goes in and out | [`request`], [`report`] |
//! | what a board supplies | [`count`] (a counter), [`panel`] (a screen, from embedded-hal) |
//!
//! Nothing here allocates, panics on what a host sends, or knows a board. All of it builds and
//! is tested on the host.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod count;
pub mod flow;
mod instances;
pub mod message;
pub mod painter;
pub mod panel;
pub mod picture;
pub mod report;
pub mod request;
pub mod shadow;
pub mod size;
pub mod strips;
pub mod test_card;
