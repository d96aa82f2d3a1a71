# Everything on a fresh machine: `make demo` and `make test` create their own environment.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
# What installs packages; the gate names a quicker one.
INSTALL := $(BIN)/python -m pip install --quiet
# Tests and pages start hundreds of processes; each would compile all that it imports, for seconds.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: demo test test-all test-touched coverage mutation mutation-touched lint types smoke check commits constraints bench docs clean

demo: $(VENV)/.installed .mypy_path/omnimate
	$(BIN)/omnimate demo --out demo-out

# Each file of tests runs in one process, and each process computes in one thread.
PYTEST := $(BIN)/python -m pytest --numprocesses auto --dist loadfile --no-loadscope-reorder

test test-all test-touched: export OMP_NUM_THREADS = 1
test: $(VENV)/.installed-dev
	$(PYTEST) -m "not slow"

# With the slow tests, and with as many examples of each property as hypothesis takes by itself.
test-all: export HYPOTHESIS_PROFILE = nightly
test-all: $(VENV)/.installed-dev
	$(PYTEST)

# The slow tests of the files and pages that differ from the commit BASE; pytest ends with 5 where there is none.
BASE ?= HEAD~1
test-touched: $(VENV)/.installed-dev
	$(PYTEST) -m slow --touched-since $(BASE) || test $$? = 5

# The tests, the slowest of them, and which part of each room they ran; measuring takes a quarter more time.
coverage: export PYTEST_ADDOPTS = --quiet --durations=20 --cov --cov-report=
coverage: test
	$(BIN)/python .ci/coverage_by_room.py

# What the tests of the files in .ci/mutation.toml do not notice; of all, or of FILE.
mutation: $(VENV)/.installed-dev
	$(BIN)/python .ci/mutation.py $(FILE)

# The same of the listed files that differ from the commit BASE, or whose tests do.
MUTATION_SECONDS ?= inf
mutation-touched: $(VENV)/.installed-dev
	$(BIN)/python .ci/mutation.py --touched-since $(BASE) --seconds $(MUTATION_SECONDS)

lint: $(VENV)/.installed-dev .mypy_path/omnimate
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

types: $(VENV)/.installed-dev .mypy_path/omnimate
	$(BIN)/mypy

# Wheel and source distribution, each installed and used outside the checkout.
smoke:
	.ci/smoke $(PYTHON)

check: lint test

# Commits are named `area: what changes` since 0.3.0.
commits:
	$(PYTHON) .ci/check_commits.py --since 7f9a071

# The versions that the gate installs.
constraints: $(VENV)/.installed-dev
	{ head -1 .ci/constraints.txt; $(BIN)/python -m pip freeze --exclude-editable | grep -E '^[A-Za-z0-9_.-]+=='; } > $(VENV)/constraints.txt
	mv $(VENV)/constraints.txt .ci/constraints.txt

bench: $(VENV)/.installed-dev
	$(BIN)/python -m studies.speed

docs: $(VENV)/.installed-docs .mypy_path/omnimate
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

clean:
	rm -rf $(VENV) .mypy_path site demo-out build *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis .coverage

# The rooms are folders here and `omnimate.<room>` to Python; mypy and editors find them under that name through this link.
.mypy_path/omnimate:
	mkdir -p $(@D)
	ln -sfn .. $@

$(VENV)/.installed: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit("Python 3.11 or newer is needed; name it with make PYTHON=python3.12") if sys.version_info < (3, 11) else 0'
	$(PYTHON) -m venv $(VENV)
	$(INSTALL) --editable '.[service]'
	@touch $@

$(VENV)/.installed-dev: $(VENV)/.installed
	$(INSTALL) --editable '.[dev]'
	@touch $@ $(VENV)/.installed-docs

$(VENV)/.installed-docs: $(VENV)/.installed
	$(INSTALL) --editable '.[docs]'
	@touch $@
