//! Frames of tones in assembly: clearing, asking what is covered, and looking for what to fill.
//!
//! # Safety
//!
//! Each function compares the bytes that it will reach with the slice that it is given.

use core::arch::asm;
use core::ops::Range;

/// Bytes from row to row of the frames that the assembly knows.
pub(in crate::render) const STRIDE: usize = 240;

/// Sets all words to 0.
pub(in crate::render) fn clear(words: &mut [u32]) {
    let (chunks, rest) = words.as_chunks_mut::<32>();
    // SAFETY: chunks of 32 words.
    unsafe { set(chunks.as_mut_ptr_range(), 0) };
    rest.fill(0);
}

/// Sets all halves to ones.
pub(in crate::render) fn set_ones(halves: &mut [u16]) {
    // To a multiple of four bytes.
    let odd = (halves.as_ptr().addr() / 2) % 2;
    let (first, halves) = halves.split_at_mut(odd.min(halves.len()));
    let (chunks, rest) = halves.as_chunks_mut::<64>();
    // SAFETY: chunks of 64 halves, the first at a multiple of four bytes.
    unsafe { set(chunks.as_mut_ptr_range(), u32::MAX) };
    first.fill(u16::MAX);
    rest.fill(u16::MAX);
}

/// Sets all words of these chunks, eight an instruction.
///
/// # Safety
///
/// The range is that of a slice of whole numbers' chunks, each of 128 bytes, and begins at a multiple of four.
unsafe fn set<T>(chunks: Range<*mut T>, word: u32) {
    const { assert!(size_of::<T>() == 128) };
    if chunks.is_empty() {
        return;
    }
    // SAFETY: four times eight words a round, from the first chunk to the end of the last.
    unsafe {
        asm!(
            "1:",
            "stm {at}!, {{r2, r3, r4, r5, r8, r9, r10, r12}}",
            "stm {at}!, {{r2, r3, r4, r5, r8, r9, r10, r12}}",
            "stm {at}!, {{r2, r3, r4, r5, r8, r9, r10, r12}}",
            "stm {at}!, {{r2, r3, r4, r5, r8, r9, r10, r12}}",
            "cmp {at}, {end}",
            "bne 1b",
            at = inout(reg) chunks.start => _,
            end = in(reg) chunks.end,
            in("r2") word, in("r3") word, in("r4") word, in("r5") word,
            in("r8") word, in("r9") word, in("r10") word, in("r12") word,
            options(nostack),
        );
    }
}

/// Whether all pixels are covered of `rows` rows of `count` from `from` on, `stride` apart; both at least 1 and 8.
pub(in crate::render) fn is_covered(
    pixels: &[u8],
    stride: usize,
    from: usize,
    count: usize,
    rows: usize,
) -> bool {
    let last = from + rows.saturating_sub(1) * stride + count;
    if count < 8 || rows == 0 || last > pixels.len() {
        return false;
    }
    let mut left = rows;
    // SAFETY: reads of `count` bytes of each row, as words: eight at a time from its first, and its
    // last eight; the last row's end was compared with the pixels'.
    unsafe {
        asm!(
            "2:",
            "add {p}, {at}, {count}",
            "ldr {a}, [{p}, #-4]",
            "ldr {b}, [{p}, #-8]",
            "lsr {n}, {count}, #3",
            "and {all}, {a}, {b}",
            "mov {p}, {at}",
            "3:",
            "ldr {a}, [{p}], #4",
            "ldr {b}, [{p}], #4",
            "and {all}, {all}, {a}",
            "and {all}, {all}, {b}",
            "subs {n}, {n}, #1",
            "bne 3b",
            "bics {all}, {bits}, {all}",
            "bne 4f",
            "add {at}, {at}, {stride}",
            "subs {left}, {left}, #1",
            "bne 2b",
            "4:",
            at = inout(reg) pixels.as_ptr().wrapping_add(from) => _,
            count = in(reg) count,
            stride = in(reg) stride,
            left = inout(reg) left,
            bits = in(reg) 0x0101_0101,
            all = out(reg) _,
            n = out(reg) _,
            p = out(reg) _,
            a = out(reg) _,
            b = out(reg) _,
            options(nostack, readonly),
        );
    }
    left == 0
}

/// Of each four pixels from `from` on, a multiple of four, the first of the next four in which an open
/// pixel has three or four covered neighbours; `end` or more when there are none before that.
pub(in crate::render) fn next_to_fill(pixels: &[u8], from: usize, end: usize) -> usize {
    // A row and a pixel before, a row and four words after.
    if from < STRIDE + 1 || end + STRIDE + 20 > pixels.len() || from >= end {
        return end;
    }
    let start = pixels.as_ptr();
    let mut at = start.wrapping_add(from);
    // SAFETY: reads of the words within a row, a pixel and sixteen bytes of `at`, which goes from
    // `from` to `end`; words at other places than multiples of four are read one by one.
    unsafe {
        asm!(
            ".macro RHO_FOUR word, at",
            "ands r9, \\word, r2",
            "bne 5f",
            "ldrb r10, [{at}, #\\at - 1]",
            "lsls r10, r10, #31",
            "beq 4f",
            "5:",
            "cmp r9, r2",
            "beq 4f",
            "ldr r10, [{at}, #\\at - 1]",
            "and r10, r10, r2",
            "ldr r12, [{at}, #\\at + 1]",
            "and r12, r12, r2",
            "add r10, r10, r12",
            "ldr r12, [{at}, #\\at - 240]",
            "and r12, r12, r2",
            "add r10, r10, r12",
            "ldr r12, [{at}, #\\at + 240]",
            "and r12, r12, r2",
            "add r10, r10, r12",
            "add r10, r10, r2",
            "lsr r10, r10, #2",
            "bic r10, r10, r9",
            "tst r10, r2",
            "itt ne",
            "addne {at}, #\\at",
            "bne 9f",
            "4:",
            ".endm",
            "1:",
            "ldm {at}, {{r3, r4, r5, r8}}",
            "orr r9, r3, r4",
            "orr r9, r9, r5",
            "orr r9, r9, r8",
            "tst r9, r2",
            "bne 2f",
            "ldrb r10, [{at}, #-1]",
            "lsls r10, r10, #31",
            "beq 3f",
            "2:",
            "and r9, r3, r4",
            "and r9, r9, r5",
            "and r9, r9, r8",
            "bics r9, r2, r9",
            "beq 3f",
            "RHO_FOUR r3, 0",
            "RHO_FOUR r4, 4",
            "RHO_FOUR r5, 8",
            "RHO_FOUR r8, 12",
            "3:",
            "add {at}, #16",
            "cmp {at}, {end}",
            "blo 1b",
            "9:",
            ".purgem RHO_FOUR",
            at = inout(reg) at,
            end = in(reg) start.wrapping_add(end),
            in("r2") 0x0101_0101,
            out("r3") _, out("r4") _, out("r5") _, out("r8") _, out("r9") _, out("r10") _,
            out("r12") _,
            options(nostack, readonly),
        );
    }
    at.addr() - start.addr()
}
