//! A device that breaks: whatever it does, the host ends, and tells what happened.

use std::fs;
use std::time::Duration;

use host_tools::failure::{Exit, Failure};
use host_tools::firmware::Firmware;
use host_tools::machine::Machine;
use object::{Object, ObjectSegment, ObjectSymbol};
use rho_tests::firmware::{TIMEOUT, ask_of, firmware};

/// The firmware under test with other bytes at an address of its flash.
fn patched(address: u64, bytes: &[u8]) -> Firmware {
    let mut elf = firmware().elf().to_vec();
    let file = object::File::parse(firmware().elf()).unwrap();
    let segment = file
        .segments()
        .find(|s| (s.address()..s.address() + s.size()).contains(&address))
        .unwrap();
    let at = (segment.file_range().0 + address - segment.address()) as usize;
    elf[at..at + bytes.len()].copy_from_slice(bytes);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("patched");
    fs::write(&path, elf).unwrap();
    // The emulator reads it once more.
    let _ = folder.keep();
    Firmware::open(&path, Machine::M3).unwrap()
}

/// Where a function begins.
fn function(name: &str) -> u64 {
    let file = object::File::parse(firmware().elf()).unwrap();
    let symbol = file.symbols().find(|s| s.name() == Ok(name)).unwrap();
    symbol.address() & !1
}

fn failure(firmware: &Firmware, timeout: Duration) -> Failure {
    let failure = ask_of(firmware, "picture=test-card", None, timeout).unwrap_err();
    let _ = fs::remove_dir_all(firmware.path().parent().unwrap());
    assert_eq!(failure.exit, Exit::Device, "{failure}");
    failure
}

/// udf #0: an undefined instruction.
const UNDEFINED: [u8; 2] = [0x00, 0xDE];
/// b . : a branch to itself.
const FOR_EVER: [u8; 2] = [0xFE, 0xE7];

#[test]
fn a_fault_ends_the_device_at_once_and_tells_where() {
    let main = function("main");
    let failure = failure(&patched(main, &UNDEFINED), TIMEOUT);
    assert!(
        failure.message.contains("the processor faulted"),
        "{failure}"
    );
    assert!(
        failure.message.contains(&format!("{main:#010x}")),
        "{failure}"
    );
}

#[test]
fn a_device_that_hangs_is_ended_after_its_time() {
    let hangs = patched(function("main"), &FOR_EVER);
    let failure = failure(&hangs, Duration::from_millis(500));
    assert!(
        failure.message.contains("timed out after 0.5 s"),
        "{failure}"
    );
}

#[test]
fn a_stack_that_overflows_ends_the_device() {
    // Sixteen bytes of stack, and nothing below.
    let failure = failure(&patched(0, &0x2000_0010u32.to_le_bytes()), TIMEOUT);
    assert!(
        failure.message.contains("the processor faulted"),
        "{failure}"
    );
    assert!(
        failure.message.contains("the stack overflowed"),
        "{failure}"
    );
}

#[test]
fn an_image_that_would_not_run_is_refused_before_it_is_tried() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image");
    fs::write(&path, &firmware().elf()[..200]).unwrap();
    assert_eq!(
        Firmware::open(&path, Machine::M3).unwrap_err().exit,
        Exit::Input
    );
    fs::write(&path, b"no image").unwrap();
    assert_eq!(
        Firmware::open(&path, Machine::M3).unwrap_err().exit,
        Exit::Input
    );
}
