//! Every vertex of a model as a dot.
#![no_std]
#![no_main]

use core::mem::MaybeUninit;

use cortex_m_rt::entry;
use rho_mps2_an385::model;
use rho_peers::points::{self, Memory};
use rho_peers::{Buffer, empty, show};
use rho_viewer::request::MAX_LINE;

#[entry]
fn main() -> ! {
    static mut LINE: [MaybeUninit<u8>; MAX_LINE] = [MaybeUninit::uninit(); MAX_LINE];
    static mut FRAME: Buffer = empty();
    static mut MEMORY: Memory = Memory::new();
    let list = points::points(model());
    show(LINE, FRAME, |scene, frame, watch| {
        points::draw(list, scene, frame, MEMORY, watch)
    })
}
