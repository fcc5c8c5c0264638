# The one door: each target does its own set-up, from a fresh clone.
# Needs Python >= 3.11, a Rust toolchain and a C compiler; everything else is installed into .venv.

PYTHON ?= python3
VENV := .venv
TESTS := tests docs README.md
PY := $(VENV)/bin/python
WHEEL_INPUTS := $(shell find rust python -name '*.rs' -o -name '*.py' -o -name '*.pyi' -o -name '*.toml' | grep -v __pycache__) \
	Cargo.toml Cargo.lock pyproject.toml

.PHONY: demo test test-rust test-python lint format bench wheel develop clean

demo: $(VENV)/installed  ## run the main job
	$(VENV)/bin/trackmetrics demo

test: test-rust test-python  ## every test, against the installed wheel, once per backend

test-rust:
	cargo test --workspace --locked --quiet

test-python: $(VENV)/installed
	TRACKMETRICS_BACKEND=native $(PY) -m pytest --pyargs trackmetrics $(TESTS)
	TRACKMETRICS_BACKEND=numpy $(PY) -m pytest --pyargs trackmetrics $(TESTS)

lint: $(VENV)/installed
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --locked -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked --quiet
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/ruff check .
	$(VENV)/bin/mypy
	$(PY) -m mypy.stubtest trackmetrics._native --allowlist tests/stubtest-allowlist.txt

format: $(VENV)/installed
	cargo fmt --all
	$(VENV)/bin/ruff format .
	$(VENV)/bin/ruff check --fix .

# One after the other, on a machine that does nothing else.
bench: $(VENV)/installed  ## every comparison with the peers; writes docs/performance.md
	for bench in benches/bench_*.py; do $(PY) $$bench --save || exit 1; done
	$(PY) benches/table.py

wheel: $(VENV)/tools  ## the release wheel, in dist/
	$(VENV)/bin/maturin build --release --locked --out dist

develop: $(VENV)/tools  ## an editable install with a faster build
	$(VENV)/bin/maturin develop --profile develop

$(VENV)/tools: pyproject.toml
	test -x $(PY) || $(PYTHON) -m venv $(VENV)
	$(PY) -m pip install --quiet --disable-pip-version-check 'maturin>=1.9.4,<2'
	touch $@

# The wheel as a user gets it, with the extras that tests and lints need.
$(VENV)/installed: $(VENV)/tools $(WHEEL_INPUTS)
	rm -rf dist
	$(VENV)/bin/maturin build --release --locked --out dist
	$(PY) -m pip install --quiet --disable-pip-version-check --force-reinstall --no-deps dist/*.whl
	$(PY) -m pip install --quiet --disable-pip-version-check "$$(echo dist/*.whl)[test,peers,lint]"
	touch $@

clean:
	rm -rf target dist $(VENV)
