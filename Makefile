# Two commands: `make demo` runs the main job, `make test` passes all the tests. Both need Rust, Python 3.11 or later,
# a C toolchain and the package registries, and make their own Python environment in .venv.
.PHONY: help demo test lint bench validate geometry fuzz wheel clean
.DEFAULT_GOAL := help

PYTHON ?= python3
VENV := .venv
PY := $(VENV)/bin/python
RUST := cargo
DEMO_OUT ?= out/demo

help:
	@echo "make demo      a drum of crosses, steered from Python: pictures, fields and a report in $(DEMO_OUT)"
	@echo "make test      all the tests"
	@echo "make lint      format and lints of Rust and Python"
	@echo "make bench     the workloads on one and two threads (half an hour; settles its beds first)"
	@echo "make geometry  a million random and degenerate pairs of polyhedra against brute force"
	@echo "make fuzz      cargo fuzz on every decoder, SECONDS=60 each (needs nightly Rust and cargo-fuzz)"
	@echo "make wheel     one Python wheel with the client and the daemon, in out/wheels"
	@echo "make validate  cases of closed forms and papers: validation/report.html (TIER=fast: minutes, nightly, release)"

# Made anew when the package's requirements change.
$(VENV)/stamp: clients/python/pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or later is needed, this is %s" % sys.version.split()[0])'
	$(PYTHON) -m venv $(VENV)
	$(PY) -m pip install --quiet --disable-pip-version-check -e 'clients/python[plots,test]'
	touch $@

demo: $(VENV)/stamp
	$(RUST) build --release --locked --workspace
	$(PY) clients/python/examples/drum_demo.py --out $(DEMO_OUT)

# The whole workspace in one go: packages built apart would get other features, and zenoh be compiled twice. The Python
# tests use the daemon that the Rust tests have built.
test: $(VENV)/stamp
	$(RUST) test --release --locked --workspace
	$(PY) -m pytest clients/python

lint: $(VENV)/stamp
	$(RUST) fmt --all --check
	$(RUST) clippy --release --locked --workspace --all-targets -- -D warnings
	$(PY) -m ruff check clients/python
	$(PY) -m ruff format --check clients/python

bench:
	mkdir -p out
	$(RUST) run --release --locked -p sturz-tests --bin bench -- all --threads 1 --json out/bench-1.json
	$(RUST) run --release --locked -p sturz-tests --bin bench -- all --threads 2 --json out/bench-2.json

# What is done is kept in out/validation: a run that was stopped goes on.
TIER ?= fast
validate: $(VENV)/stamp
	$(RUST) build --release --locked --workspace --all-targets
	target/release/validate --tier $(TIER) --report validation/report.html --json out/validation.json --quiet

geometry:
	STURZ_PAIRS=1000000 $(RUST) test --release --locked --workspace --lib generic

# Sound inputs first, by a program of the workspace; then each decoder in turn, on one core and in bounded memory.
SECONDS ?= 60
FUZZ := tests/fuzz
TARGETS ?= request checkpoint bed journal_log snapshot recording settings scene mesh rockable
fuzz:
	$(RUST) build --release --locked --workspace --all-targets
	target/release/decoders --seeds $(FUZZ)/corpus
	$(RUST) +nightly fuzz build --fuzz-dir $(FUZZ)
	for target in $(TARGETS); do \
	    $(RUST) +nightly fuzz run --fuzz-dir $(FUZZ) $$target -- \
	        -max_total_time=$(SECONDS) -max_len=65536 -rss_limit_mb=2048 -timeout=20 -print_final_stats=1 || exit 1; \
	done

wheel: $(VENV)/stamp
	$(PY) -m pip install --quiet --disable-pip-version-check 'maturin>=1.8,<2'
	$(VENV)/bin/maturin build --release --out out/wheels

clean:
	$(RUST) clean
	rm -rf $(VENV) out
