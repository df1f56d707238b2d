# Two commands do everything: `make demo` and `make test`. Both need only Python 3.11+, make and pip.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
PYTEST_ARGS ?= -n 2 --dist loadgroup
FUZZ_COUNT ?= 10000
FUZZ_SEED ?= 0
MUTANT_COUNT ?= 500
MUTANT_SEED ?= 0
ORDER_SEED ?= 0
PIP_INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt

.PHONY: demo test test-all test-shuffled fuzz mutants lint typecheck soundness bench docs site clean

demo: $(VENV)/.runtime  ## verify, compare and report on a UR5; results/demo/report.html
	$(BIN)/asmc-pin demo
	@echo "asmc-pin is in $(BIN); to have it at hand: . $(BIN)/activate"

test: $(VENV)/.dev  ## all tests but the long ones; some minutes
	$(BIN)/python -m pytest $(PYTEST_ARGS)

test-all: test  ## these, and then the long ones; some half an hour more
	$(BIN)/python -m pytest -m long $(PYTEST_ARGS)

fuzz: $(VENV)/.dev  ## FUZZ_COUNT hostile files of each kind through the command line; some hours
	PYTHONPATH=tests:tests/support $(BIN)/python -m fuzz --count $(FUZZ_COUNT) --seed $(FUZZ_SEED)

mutants: $(VENV)/.mutants  ## small faults in the package, of which each must fail a test; half an hour
	PYTHONPATH=tests:tests/support $(BIN)/python -m mutants --count $(MUTANT_COUNT) --seed $(MUTANT_SEED)

test-shuffled: $(VENV)/.mutants  ## as `test`, in an order drawn by ORDER_SEED
	$(BIN)/python -m pytest --random-order --random-order-seed=$(ORDER_SEED) $(PYTEST_ARGS)

lint: $(VENV)/.dev
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

typecheck: $(VENV)/.dev
	$(BIN)/mypy

soundness: $(VENV)/.dev  ## thousands of random arms: no certificate is ever contradicted by search
	$(BIN)/python -m pytest -m soundness $(PYTEST_ARGS)

bench: $(VENV)/.dev  ## ratios, measured in one run
	for file in benchmarks/*.py; do $(BIN)/python $$file || exit 1; done

docs: $(VENV)/.dev  ## the generated parts of README.md and docs/
	$(BIN)/python docs/generate.py

site: $(VENV)/.docs  ## the documentation as a site, results/site; a warning is an error
	$(BIN)/python -m sphinx -c docs -j auto --fail-on-warning --keep-going --quiet . results/site
	@echo "results/site/index.html"

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit("asmc_pin needs Python 3.11 or newer, and $(PYTHON) is %d.%d: run make PYTHON=python3.11" % sys.version_info[:2] if sys.version_info < (3, 11) else 0)'
	$(PYTHON) -m venv $(VENV)

$(VENV)/.runtime: $(BIN)/python pyproject.toml constraints.txt
	@echo "Setting up $(VENV) (once, a few minutes)"
	$(PIP_INSTALL) --editable .
	$(BIN)/python -m asmc_pin.cli.precompile
	@touch $@

$(VENV)/.dev: $(VENV)/.runtime
	$(PIP_INSTALL) --editable '.[dev]'
	@touch $@

$(VENV)/.docs: $(VENV)/.dev
	$(PIP_INSTALL) --editable '.[dev,docs]'
	@touch $@

$(VENV)/.mutants: $(VENV)/.dev
	$(PIP_INSTALL) --editable '.[dev,mutants]'
	@touch $@

clean:
	rm -rf $(VENV) build dist results .pytest_cache .mypy_cache .ruff_cache .hypothesis
