# Every target sets up what it needs first: `make setup` installs only what is missing.
.PHONY: setup demo test bench docs check clean


setup:
	@tools/setup

check: setup
	@cargo fmt --check
	@cargo clippy --all-targets --all-features -- -D warnings

docs: setup
	@RUSTDOCFLAGS="-D warnings" cargo doc --no-deps

test: setup
	@cargo test --release --no-fail-fast

bench: setup
	@cargo bench --bench peers

demo: setup
	@tools/demo

clean:
	cargo clean
