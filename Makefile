# The one door: each target does its own set-up, from a fresh clone.
# Needs Python >= 3.11, a Rust toolchain and a C compiler; everything else is installed into .venv.

PYTHON ?= python3
VENV := .venv
TESTS := tests docs README.md
PY := $(VENV)/bin/python
WHEEL_INPUTS := $(shell find rust python -name '*.rs' -o -name '*.py' -o -name '*.pyi' -o -name '*.toml' | grep -v __pycache__) \
	Cargo.toml Cargo.lock pyproject.toml

PIP_INSTALL := -m pip install --quiet --disable-pip-version-check
# What needs nothing but the runtime dependencies, run once with the oldest that are supported.
MINIMUM := $(addprefix tests/test_, backend bottleneck_assignment consistency_test \
	labels linear_sum_assignment mot_metrics nees ospa processes rmse reference)

.PHONY: demo test-peers test test-rust test-python test-minimum lint format bench wheel develop clean

demo: $(VENV)/wheel  ## run the main job
	$(VENV)/bin/trackmetrics demo

test: test-rust test-python test-minimum  ## every test, against the installed wheel, once per backend

test-rust:
	cargo test --workspace --locked --quiet

test-python: $(VENV)/installed
	TRACKMETRICS_BACKEND=native $(PY) -m pytest --pyargs trackmetrics $(TESTS)
	TRACKMETRICS_BACKEND=numpy $(PY) -m pytest --pyargs trackmetrics $(TESTS)

test-peers: $(VENV)/installed  ## the tests of other libraries, on our functions
	$(PY) tools/peer_tests.py

test-minimum: $(VENV)/wheel
	test -d $(VENV)-minimum || $(PYTHON) -m venv $(VENV)-minimum
	$(VENV)-minimum/bin/python $(PIP_INSTALL) numpy==1.26.0 scipy==1.11.1 'pytest>=8' hypothesis
	$(VENV)-minimum/bin/python $(PIP_INSTALL) --force-reinstall --no-deps dist/*.whl
	$(VENV)-minimum/bin/python -m pytest -m 'not peers and not data' $(MINIMUM:=.py)

lint: $(VENV)/installed
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --locked -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked --quiet
	$(VENV)/bin/ruff format --check .
	$(VENV)/bin/ruff check .
	$(VENV)/bin/mypy
	$(PY) tools/check_prose.py
	$(VENV)/bin/codespell
	$(PY) tools/api_index.py --check
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
	$(PY) $(PIP_INSTALL) 'maturin>=1.9.4,<2'
	touch $@

# The release wheel as a user gets it, with the extras that the demo needs.
$(VENV)/wheel: $(VENV)/tools $(WHEEL_INPUTS)
	rm -rf dist
	$(VENV)/bin/maturin build --release --locked --out dist
	$(PY) $(PIP_INSTALL) --force-reinstall --no-deps dist/*.whl
	$(PY) $(PIP_INSTALL) "$$(echo dist/*.whl)[cli,report]"
	touch $@

# And the extras that tests and lints need.
$(VENV)/installed: $(VENV)/wheel
	$(PY) $(PIP_INSTALL) "$$(echo dist/*.whl)[test,peers,lint]"
	touch $@

clean:
	rm -rf target dist $(VENV) $(VENV)-minimum
