# Every target sets up what it needs first; `make setup` installs only what is missing.
.PHONY: setup demo test explore fuzz bench docs check clean

setup:
	@tools/setup

demo: setup
	@tools/demo

test: setup
	@cargo test --release --no-fail-fast

# The laws over other random inputs, and more of them: `make explore SEED=7 CASES=2000`.
SEED ?= $(shell date +%s)
CASES ?= 1000
explore: setup
	@echo "PROPTEST_RNG_SEED=$(SEED) PROPTEST_CASES=$(CASES)"
	@PROPTEST_RNG_SEED=$(SEED) PROPTEST_CASES=$(CASES) cargo test --release --no-fail-fast

# Arbitrary files for the readers of volumes, ten minutes each: `make fuzz FORMAT=nrrd SECONDS=60`.
SECONDS ?= 600
fuzz: setup
	@tools/fuzz/run "$(FORMAT)" "$(SECONDS)"

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
