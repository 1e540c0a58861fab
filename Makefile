# Everything a fresh machine needs is set up by these commands (Debian with make, cc and rustup).
.PHONY: test tools

BOARD = -p rho-mps2-an385 --profile firmware --target thumbv7m-none-eabi

test: tools
	cargo fmt --all --check
	cargo clippy --all-targets -- -D warnings
	cargo clippy $(BOARD) -- -D warnings
	cargo test

# The emulator, in which the tests run the firmware.
tools:
	@command -v qemu-system-arm >/dev/null || { \
		apt-get update && apt-get install --yes --no-install-recommends qemu-system-arm; }
