//! The emulator's side: its functions, declared by hand after `qemu-plugin.h` of QEMU 7.2
//! (version 1 of the interface), and what it calls.
#![allow(
    unsafe_code,
    reason = "the one module that talks to the emulator; every block cites what makes it sound"
)]

use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use crate::counts::{Block, Counts};

/// A piece of code that is being translated.
#[repr(C)]
struct TranslationBlock(c_void);

/// One instruction of it.
#[repr(C)]
struct Instruction(c_void);

/// The first operation that the translated code can do by itself: add to 64 bits.
const INLINE_ADD_U64: c_int = 0;
/// A callback that looks at no register.
const NO_REGISTERS: c_int = 0;
/// Loads and stores. QEMU 7.2 takes one for the other when one alone is asked for; nothing
/// stores to the counter.
const ACCESSES: c_int = 3;

unsafe extern "C" {
    fn qemu_plugin_register_vcpu_tb_trans_cb(
        id: u64,
        callback: unsafe extern "C" fn(u64, *mut TranslationBlock),
    );
    fn qemu_plugin_register_vcpu_tb_exec_cb(
        block: *mut TranslationBlock,
        callback: unsafe extern "C" fn(c_uint, *mut c_void),
        flags: c_int,
        data: *mut c_void,
    );
    fn qemu_plugin_register_vcpu_insn_exec_inline(
        instruction: *mut Instruction,
        operation: c_int,
        at: *mut c_void,
        operand: u64,
    );
    fn qemu_plugin_register_vcpu_mem_cb(
        instruction: *mut Instruction,
        callback: unsafe extern "C" fn(c_uint, u32, u64, *mut c_void),
        flags: c_int,
        access: c_int,
        data: *mut c_void,
    );
    fn qemu_plugin_register_atexit_cb(
        id: u64,
        callback: unsafe extern "C" fn(u64, *mut c_void),
        data: *mut c_void,
    );
    fn qemu_plugin_tb_n_insns(block: *const TranslationBlock) -> usize;
    fn qemu_plugin_tb_get_insn(block: *const TranslationBlock, index: usize) -> *mut Instruction;
    fn qemu_plugin_insn_vaddr(instruction: *const Instruction) -> u64;
    fn qemu_plugin_insn_size(instruction: *const Instruction) -> usize;
}

/// The version of the interface.
// SAFETY: the emulator looks for this name and reads an int.
#[unsafe(no_mangle)]
#[allow(
    non_upper_case_globals,
    reason = "the emulator asks for it by this name"
)]
pub(crate) static qemu_plugin_version: c_int = 1;

static COUNTS: Mutex<Counts> = Mutex::new(Counts::new());
static OPTIONS: OnceLock<Options> = OnceLock::new();

/// What stands behind the library's name on the command line.
struct Options {
    /// The register whose readings end the intervals.
    counter: u64,
    /// Where the counts go.
    out: PathBuf,
}

impl Options {
    fn of<'a>(arguments: impl Iterator<Item = &'a str>) -> Option<Self> {
        let (mut counter, mut out) = (None, None);
        for argument in arguments {
            match argument.split_once('=')? {
                ("counter", hex) => counter = u64::from_str_radix(hex, 16).ok(),
                ("out", path) => out = Some(PathBuf::from(path)),
                _ => return None,
            }
        }
        Some(Self {
            counter: counter?,
            out: out?,
        })
    }
}

/// The counts; a panic elsewhere ends the emulator, so that a poisoned lock cannot be seen.
fn counts() -> MutexGuard<'static, Counts> {
    COUNTS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Called once, when the emulator loads the library. Anything but 0 makes it give up.
///
/// # Safety
/// `argv` points to `argc` strings, as `qemu-plugin.h` promises.
// SAFETY: the emulator looks for this name and calls it with the arguments declared here.
#[unsafe(no_mangle)]
unsafe extern "C" fn qemu_plugin_install(
    id: u64,
    _info: *const c_void,
    argc: c_int,
    argv: *const *const c_char,
) -> c_int {
    let arguments = (0..usize::try_from(argc).unwrap_or(0)).map(|i| {
        // SAFETY: by the contract above; the strings live as long as this call.
        unsafe { CStr::from_ptr(*argv.add(i)) }
            .to_str()
            .unwrap_or("")
    });
    let Some(options) = Options::of(arguments) else {
        eprintln!("expected counter=HEX,out=FILE");
        return 1;
    };
    if OPTIONS.set(options).is_err() {
        return 1;
    }
    // SAFETY: the id is the one given, and both functions live as long as the library.
    unsafe {
        qemu_plugin_register_vcpu_tb_trans_cb(id, translate);
        qemu_plugin_register_atexit_cb(id, exit, std::ptr::null_mut());
    }
    0
}

/// A block is translated: each instruction gets its addition, the block its call.
unsafe extern "C" fn translate(_id: u64, block: *mut TranslationBlock) {
    let mut counts = counts();
    // SAFETY: the emulator hands over a block that is valid during this call, and its indices
    // are below its length. Slots and blocks are leaked, so the translated code may use them for
    // ever; an `AtomicU64` is 64 bits in memory, and one processor runs, so that the emulator's
    // plain addition loses nothing.
    unsafe {
        let mut bounds = None;
        for index in 0..qemu_plugin_tb_n_insns(block) {
            let instruction = qemu_plugin_tb_get_insn(block, index);
            let address = qemu_plugin_insn_vaddr(instruction);
            let slot = counts.slot(address);
            qemu_plugin_register_vcpu_insn_exec_inline(
                instruction,
                INLINE_ADD_U64,
                slot.ran.as_ptr().cast(),
                1,
            );
            qemu_plugin_register_vcpu_mem_cb(
                instruction,
                access,
                NO_REGISTERS,
                ACCESSES,
                std::ptr::null_mut(),
            );
            let end = address + qemu_plugin_insn_size(instruction) as u64;
            let (start, ..) = bounds.unwrap_or((address, end, slot));
            bounds = Some((start, end, slot));
        }
        if let Some((start, end, last)) = bounds {
            let entered: &'static Block = Box::leak(Box::new(Block { start, end, last }));
            let data = std::ptr::from_ref(entered).cast_mut().cast();
            qemu_plugin_register_vcpu_tb_exec_cb(block, enter, NO_REGISTERS, data);
        }
    }
}

/// A block begins to run.
unsafe extern "C" fn enter(_processor: c_uint, data: *mut c_void) {
    // SAFETY: `translate` registered this call with a leaked block.
    let block: &'static Block = unsafe { &*data.cast_const().cast() };
    counts().enter(block);
}

/// Memory is read or written.
unsafe extern "C" fn access(_processor: c_uint, _info: u32, address: u64, _data: *mut c_void) {
    if OPTIONS.get().is_some_and(|o| o.counter == address) {
        counts().reading();
    }
}

/// The emulator ends.
unsafe extern "C" fn exit(_id: u64, _data: *mut c_void) {
    if let Some(options) = OPTIONS.get()
        && let Err(error) = std::fs::write(&options.out, counts().lines())
    {
        eprintln!("{}: {error}", options.out.display());
    }
}
