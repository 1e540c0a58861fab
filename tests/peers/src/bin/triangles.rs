//! A model's triangles by embedded-3dgfx, with room for the commands of 69,451 triangles.
#![no_std]
#![no_main]

use core::mem::MaybeUninit;

use cortex_m_rt::entry;
use rho_mps2_an385::model;
use rho_peers::triangles::{self, Memory};
use rho_peers::{Buffer, empty, show};
use rho_viewer::request::MAX_LINE;

#[entry]
fn main() -> ! {
    static mut LINE: [MaybeUninit<u8>; MAX_LINE] = [MaybeUninit::uninit(); MAX_LINE];
    static mut FRAME: Buffer = empty();
    static mut MEMORY: Memory<49_152> = Memory::new();
    let mut mesh = triangles::mesh(model());
    show(LINE, FRAME, |scene, frame, watch| {
        triangles::draw(mesh.as_mut(), scene, frame, MEMORY, watch)
    })
}
