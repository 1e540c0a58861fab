# Everything a fresh machine needs is set up by these commands (Debian with make, cc and rustup).
.PHONY: test

test:
	cargo fmt --all --check
	cargo clippy --all-targets -- -D warnings
	cargo test
