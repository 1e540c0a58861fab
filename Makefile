# rho-grid: make demo draws a model on the emulated board, make test runs every check.
# Both set up what is missing first, on Debian with make, cc and rustup, and may be repeated.

MODEL ?= teapot
VIEW ?= near-turned
DEMO ?= demo.png
TARGETS := thumbv6m-none-eabi thumbv7m-none-eabi thumbv7em-none-eabihf
RHO := cargo run --quiet --release --package host-tools --bin rho --

.PHONY: demo test bench setup toolchain qemu check gallery

demo: setup
	@mkdir -p target/demo
	$(RHO) bake $(MODEL) -o target/demo/model.rho
	$(RHO) run target/demo/model.rho --view $(VIEW) -o $(DEMO)
	@echo "The picture is in $(DEMO)."

test: setup check
	cargo test

# Formatting and lints, on the host and on every core that the renderer is made for.
check: toolchain
	cargo fmt --all --check
	cargo clippy --all-targets -- -D warnings
	@for target in $(TARGETS); do \
		echo "cargo clippy: rho-grid, rho-viewer on $$target"; \
		cargo clippy --quiet --package rho-grid --package rho-viewer --target $$target -- -D warnings || exit 1; \
	done
	cargo clippy --profile firmware --package rho-mps2-an385 --package rho-peers --target thumbv7m-none-eabi -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --no-deps --quiet

# The tables of docs/bench.md; look at what has changed before it is committed.
bench: setup
	$(RHO) bench --classes -o docs/bench.md

# The pictures of docs/gallery.md, each by the command that stands under it.
gallery: setup
	cargo test --release --package rho-tests --test gallery -- --ignored --nocapture

setup: toolchain qemu

toolchain:
	@command -v rustup > /dev/null || { echo "rustup is missing: see https://rustup.rs"; exit 3; }
	@rustc --version > /dev/null 2>&1 || { \
		echo "Installing the Rust toolchain that rust-toolchain.toml names"; rustup toolchain install; }
	@for target in $(TARGETS); do \
		rustup target list --installed | grep -qx $$target || { \
			echo "Installing the Rust target $$target"; rustup target add $$target || exit 3; }; \
	done
	@for component in rustfmt clippy; do \
		rustup component list --installed | grep -q "^$$component" || { \
			echo "Installing $$component"; rustup component add $$component || exit 3; }; \
	done

qemu:
	@command -v qemu-system-arm > /dev/null || { \
		echo "Installing QEMU for Arm with apt-get (package qemu-system-arm)"; \
		root=; [ "$$(id -u)" = 0 ] || root=sudo; \
		$$root apt-get update -qq && \
		$$root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
			qemu-system-arm > /dev/null || \
		{ echo "QEMU could not be installed: install qemu-system-arm by hand"; exit 3; }; }
	@qemu-system-arm --version | head -n 1
