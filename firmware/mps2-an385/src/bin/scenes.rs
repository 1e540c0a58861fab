//! The viewer with the presets and shadows of maps of 128 texels a side, in a quarter of a megabyte.
#![no_std]
#![no_main]

use core::mem::MaybeUninit;

use cortex_m_rt::entry;
use rho_grid::mode::MapSize;
use rho_mps2_an385::view;
use rho_viewer::request::MAX_LINE;
use rho_viewer::shadow::Shadow;
use rho_viewer::strips::Strips;

const TEXELS: usize = MapSize::of(128).expect("a size of maps").words();

#[entry]
fn main() -> ! {
    static mut STRIPS: Strips<Shadow<TEXELS>> = Strips::new();
    static mut LINE: [MaybeUninit<u8>; MAX_LINE] = [MaybeUninit::uninit(); MAX_LINE];
    view(STRIPS, LINE)
}
