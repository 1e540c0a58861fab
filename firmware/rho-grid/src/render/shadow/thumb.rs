//! The loop over the splats of a parent in assembly, for ARMv7-M.
//!
//! [`Caster::cast`](super::Caster) has the same in Rust, and is what fills the map without the feature
//! `asm`, on other cores, for splats of other sizes and cells divided otherwise; the bits are the same.
//!
//! # Safety
//!
//! The assembly reads and writes through the pointers of [`Splats`] and that of the words, and nothing
//! else:
//!
//! * *displacements*: 27, by the number of a bit of `mask`, of which [`Splats::lay`] takes 27.
//! * *words*: one for each bit; the slice is compared with their number.
//! * *moved*: seven bits of a word, and three; the table has as many entries.
//! * *map*: u and v have `bits` bits each, and a splat's last texel lies a row and a texel on;
//!   [`Splats::new`] compares that with the map's length.

#![allow(unsafe_code, reason = "assembly")]

use core::arch::global_asm;

use super::map::ShadowMap;
use super::moved::Moved;

/// What the assembly reads, in this order.
#[repr(C)]
pub(super) struct Splats<'a> {
    displacements: &'a [u32; 27],
    moved: *const u32,
    map: *mut u16,
    /// 32 less the bits of u and of v.
    beyond: u32,
    /// Bytes of a row.
    row: u32,
}

unsafe extern "C" {
    fn rho_grid_splats(splats: *const Splats<'_>, place: u32, mask: u32, words: *const u16);
}

impl<'a> Splats<'a> {
    /// For splats of two texels; `None` when words have normals at other bits than the assembly knows,
    /// cells are not divided by 3, or the map is too short.
    pub(super) fn new(
        displacements: &'a [u32],
        moved: &'a Moved,
        map: &'a mut ShadowMap<'_>,
    ) -> Option<Self> {
        let bits = map.size().bits();
        let side = 1 << bits;
        let map = map.all();
        if map.len() < (side + 1) * side + 1 {
            return None;
        }
        Some(Self {
            displacements: displacements.first_chunk()?,
            moved: moved.table()?.as_ptr().cast(),
            map: map.as_mut_ptr(),
            beyond: 32 - bits,
            row: 2 << bits,
        })
    }

    /// Lays the splats of a parent's subcells: `mask` names them, and `words` are theirs.
    pub(super) fn lay(&self, place: u32, mask: u32, words: &[u16]) {
        let mask = mask & 0x07FF_FFFF;
        if mask == 0 || words.len() < mask.count_ones() as usize {
            return;
        }
        // SAFETY: the module's argument; what is pointed to is borrowed by `self`.
        unsafe { rho_grid_splats(self, place, mask, words.as_ptr()) }
    }
}

global_asm!(
    ".syntax unified",
    ".section .text.rho_grid_splats,\"ax\",%progbits",
    ".global rho_grid_splats",
    ".type rho_grid_splats,%function",
    ".thumb_func",
    "rho_grid_splats:",
    "push {{r4-r11, lr}}",
    "ldm r0, {{r4, r5, r6, r7, r11}}",
    "1:",
    "rbit r8, r2",
    "clz r8, r8", // the subcell
    "sub r9, r2, #1",
    "and r2, r2, r9",
    "ldrh r10, [r3], #2", // its word
    "ldr r8, [r4, r8, lsl #2]",
    "lsr r9, r10, #9",
    "and r10, r10, #7",
    "add r9, r5, r9, lsl #5",
    "ldr r9, [r9, r10, lsl #2]",
    "add r8, r8, r1",
    "add r8, r8, r9", // the splat's place
    "lsl r10, r8, #10",
    "lsr r10, r10, r7", // v
    "lsl r9, r8, #21",
    "lsr r9, r9, r7", // u
    "mla r10, r10, r11, r6",
    "add r10, r10, r9, lsl #1",
    "lsr r8, r8, #22", // its depth
    "ldrh r9, [r10]",
    "ldrh r12, [r10, #2]",
    "cmp r8, r9",
    "it lo",
    "strhlo r8, [r10]",
    "cmp r8, r12",
    "it lo",
    "strhlo r8, [r10, #2]",
    "add r10, r10, r11",
    "ldrh r9, [r10]",
    "ldrh r12, [r10, #2]",
    "cmp r8, r9",
    "it lo",
    "strhlo r8, [r10]",
    "cmp r8, r12",
    "it lo",
    "strhlo r8, [r10, #2]",
    "cmp r2, #0",
    "bne 1b",
    "pop {{r4-r11, pc}}",
    ".size rho_grid_splats, . - rho_grid_splats",
);
