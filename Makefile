# Every target sets up what it needs first; `make setup` installs only what is missing.
.PHONY: setup demo test bench docs check clean

setup:
	@tools/setup

demo: setup
	@tools/demo

test: setup
	@cargo test --release --no-fail-fast

bench: setup
	@target/deps/vtk/bin/python tools/peers/volumes.py >/dev/null
	@cargo bench --bench peers

docs: setup
	@RUSTDOCFLAGS="-D warnings" cargo doc --no-deps

check: setup
	@cargo fmt --check
	@cargo clippy --release --all-targets -- -D warnings

clean:
	@cargo clean
