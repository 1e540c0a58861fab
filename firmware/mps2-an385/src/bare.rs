//! All that the compiler cannot check: registers, the model's memory, the painted stack, the
//! counted code and the fault handler. The rest of the program is safe.
#![allow(
    unsafe_code,
    reason = "the one module that touches the machine; every block cites what makes it sound"
)]

use core::arch::{asm, naked_asm};

use rho_viewer::count::PROBES;
use rho_viewer::report::Exit;

/// Where the emulator's loader puts the model: the board's PSRAM.
const MODEL: *const u8 = 0x2100_0000 as *const u8;
/// The size of the PSRAM.
const MODEL_BYTES: usize = 16 << 20;

/// What cortex-m-rt paints the stack with before `main`.
const PAINT: u32 = 0xCCCC_CCCC;

unsafe extern "C" {
    /// The top of the stack's memory, by board.x. Only its address means something.
    static _stack_start: u32;
    /// The bottom of the stack's memory, by board.x. Only its address means something.
    static _stack_end: u32;
}

/// A 32-bit device register.
#[derive(Clone, Copy)]
pub(crate) struct Register(usize);

impl Register {
    /// SPI of the panel: frame size and format.
    pub(crate) const SPI_CR0: Self = Self(0x4002_1000);
    /// SPI: on or off.
    pub(crate) const SPI_CR1: Self = Self(0x4002_1004);
    /// SPI: the frame to send, or the one received.
    pub(crate) const SPI_DR: Self = Self(0x4002_1008);
    /// SPI: state of its queues.
    pub(crate) const SPI_SR: Self = Self(0x4002_100C);
    /// SPI: clock divider.
    pub(crate) const SPI_CPSR: Self = Self(0x4002_1010);
    /// The pins of the panel.
    pub(crate) const MISC: Self = Self(0x4002_804C);
    /// UART0: the byte to send.
    pub(crate) const UART_DATA: Self = Self(0x4000_4000);
    /// UART0: state.
    pub(crate) const UART_STATE: Self = Self(0x4000_4004);
    /// UART0: on or off.
    pub(crate) const UART_CTRL: Self = Self(0x4000_4008);
    /// UART0: clock divider.
    pub(crate) const UART_BAUDDIV: Self = Self(0x4000_4010);

    /// Reads the register.
    pub(crate) fn read(self) -> u32 {
        // SAFETY: only the constants above exist; each is an aligned register of this board
        // (application note AN385) which may be read at any time.
        unsafe { (self.0 as *const u32).read_volatile() }
    }

    /// Writes the register.
    pub(crate) fn write(self, value: u32) {
        // SAFETY: only the constants above exist; each is an aligned register of this board
        // (application note AN385), and none of them makes the machine access memory.
        unsafe { (self.0 as *mut u32).write_volatile(value) }
    }
}

/// The memory in which a model may lie.
pub fn model() -> &'static [u8] {
    // SAFETY: the board has 16 MB of memory there, no section of the program lies in it
    // (board.x), and nothing writes to it after the emulator's loader, which ran before reset.
    unsafe { core::slice::from_raw_parts(MODEL, MODEL_BYTES) }
}

/// How deep the stack has been, in bytes.
pub(crate) fn stack_used() -> u32 {
    let (top, bottom) = (&raw const _stack_start, &raw const _stack_end);
    let mut word = bottom;
    // SAFETY: the linker places both symbols at the ends of the stack's memory (board.x),
    // aligned to a word; the loop stays between them, and a volatile read of memory that the
    // program may also use as its stack is a read of initialised bytes: the paint or a value.
    while word < top && unsafe { word.read_volatile() } == PAINT {
        // SAFETY: `word < top`, so the next word is at most one past the end.
        word = unsafe { word.add(1) };
    }
    (top as usize - word as usize) as u32
}

/// The lines that read the 25 MHz counter into a register: three instructions.
#[cfg(not(armv6m))]
macro_rules! read_counter {
    ($r:literal) => {
        concat!(
            "movw ",
            $r,
            ", #0x8018\n movt ",
            $r,
            ", #0x4002\n ldr ",
            $r,
            ", [",
            $r,
            "]"
        )
    };
}

/// The same for a core without long constants: seven instructions.
#[cfg(armv6m)]
macro_rules! read_counter {
    ($r:literal) => {
        concat!(
            "movs ",
            $r,
            ", #0x80\n lsls ",
            $r,
            ", #12\n adds ",
            $r,
            ", #0x50\n lsls ",
            $r,
            ", #8\n adds ",
            $r,
            ", #3\n lsls ",
            $r,
            ", #3\n ldr ",
            $r,
            ", [",
            $r,
            "]"
        )
    };
}

/// Reads the 25 MHz counter.
#[inline(always)]
pub(crate) fn counter() -> u32 {
    let ticks;
    // SAFETY: reads the counter of the FPGAIO block (application note AN385), which has no
    // side effect. Written in assembly so that each reading costs the same; without `nomem`,
    // so that no access to memory moves from one side of a reading to the other.
    unsafe {
        asm!(read_counter!("{t}"), t = out(reg) ticks, options(nostack));
    }
    ticks
}

/// Two readings with code of a known length between, in one piece of assembly: the compiler
/// puts nothing between them.
macro_rules! between_readings {
    ($($line:literal),*) => {{
        let (start, end): (u32, u32);
        // SAFETY: reads the counter as `counter` does, and works in registers declared below.
        unsafe {
            asm!(
                read_counter!("{start}"),
                $($line,)*
                read_counter!("{end}"),
                start = out(reg) start,
                end = out(reg) end,
                out("r2") _,
                options(nostack),
            );
        }
        (start, end)
    }};
}

/// Two readings with nothing between.
pub(crate) fn nothing_counted() -> (u32, u32) {
    between_readings!()
}

/// Code of known lengths: the length and the readings around it.
pub(crate) fn counted_code() -> [(u32, (u32, u32)); PROBES] {
    // What four instructions put into r2.
    const TURNS: u32 = 0x7A12 << 5;
    [
        (0, nothing_counted()),
        (1, between_readings!("nop")),
        (
            7,
            between_readings!("nop", "nop", "nop", "nop", "nop", "nop", "nop"),
        ),
        // Then a subtraction and a branch a turn.
        (
            4 + 2 * TURNS,
            between_readings!(
                "movs r2, #0x7A",
                "lsls r2, r2, #8",
                "adds r2, #0x12",
                "lsls r2, r2, #5",
                "2: subs r2, r2, #1",
                "bne 2b"
            ),
        ),
    ]
}

/// What the processor runs on a fault: takes the stack pointer and the address at fault, and goes
/// on with a fresh stack, since the fault may be that there was none left.
///
/// # Safety
/// Called by the processor only.
#[unsafe(naked)]
// SAFETY: the vector table of cortex-m-rt takes the fault handler by this name.
#[unsafe(no_mangle)]
unsafe extern "C" fn HardFault() -> ! {
    naked_asm!(
        "mov r0, sp",
        // The exception frame: r0 to r3, r12, lr, then the address.
        "ldr r1, [sp, #24]",
        "ldr r2, =_stack_start",
        "mov sp, r2",
        // It does not come back; a plain branch does not reach far on every core.
        "bl {fault}",
        fault = sym fault,
    )
}

/// Ends the emulator: a fault is never waited out.
extern "C" fn fault(stack: u32, address: u32) -> ! {
    let bottom = (&raw const _stack_end).addr() as u32;
    if stack < bottom {
        let beyond = bottom - stack;
        crate::broken(
            Exit::Fault,
            format_args!("the stack overflowed by {beyond} bytes"),
        )
    } else {
        crate::broken(Exit::Fault, format_args!("at {address:#010x}"))
    }
}
