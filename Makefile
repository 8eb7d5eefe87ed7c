# Needs make and Python 3.11 or newer; everything else is installed into .venv.

PYTHON ?= $(shell for python in python3.11 python3.12 python3.13 python3.14 python3 python; do \
	$$python -c 'import ensurepip, sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1 && echo $$python && break; done)

unexport PYTHONDONTWRITEBYTECODE     # or each process would compile what it imports

VENV := .venv
BIN := $(VENV)/bin
PYTEST := $(BIN)/python -m pytest --numprocesses=auto --maxprocesses=4 --dist=worksteal
BUILT := $(VENV)/.build
WHEEL_READY := $(VENV)/.wheel
READY := $(VENV)/.ready
DOCS_READY := $(VENV)/.docs
PIP := $(BIN)/python -m pip --disable-pip-version-check --quiet

.DEFAULT_GOAL := help
.PHONY: help demo gallery docs playground kernels test test-jit test-wheel test-cuda deep check format wheel wheels lock clean

help:
	@echo "make demo    the picture of the README and seven others, in out/"
	@echo "make gallery every picture of the gallery, in out/"
	@echo "make docs    the site, in out/site"
	@echo "make playground  a page that runs Conicoid itself, in out/playground; PYODIDE=folder takes Pyodide from there"
	@echo "make test    the fast test suite"
	@echo "make test-jit    the tests of kernels that Numba compiles at run time"
	@echo "make test-wheel  the fast test suite, on the wheel in a clean environment"
	@echo "make test-cuda   a GPU against the CPU, from wheels: equality and rates"
	@echo "make deep    the long test suite"
	@echo "make check   formatting, lint, types, layers"
	@echo "make format  let ruff format and fix"
	@echo "make wheel   the wheel for this machine, in dist/"
	@echo "make wheels  the wheels for all systems, and the source archive, in dist/"
	@echo "make lock    take the newest development packages"
	@echo "make clean   remove everything that make made"

demo: $(BUILT)
	@$(BIN)/python -m native.build --in-place || echo "Kernels are compiled as they are called."
	@$(BIN)/python examples/gallery.py out 1 demo
	@du -sh $(VENV) | awk '{print "$(VENV) takes " $$1 "; make clean removes it."}'

gallery: kernels
	$(BIN)/python examples/gallery.py

docs: $(DOCS_READY) kernels
	$(BIN)/python -m docs.tools.live out/extra
	$(BIN)/python -m sphinx --fail-on-warning --keep-going --quiet --fresh-env --doctree-dir out/doctrees docs out/site
	$(BIN)/python -m docs.tools.links out/site
	@echo "The site is $(CURDIR)/out/site/index.html"

playground: kernels
	$(BIN)/python -m native.playground $(if $(PYODIDE),--pyodide $(PYODIDE))

# Kernels as machine code for this processor: sooner than compiling each as it is called. Not a must.
kernels: $(READY)
	@$(BIN)/python -m native.build --in-place && $(BIN)/python -m native.page || echo "Kernels are compiled as they are called."

test: kernels
	$(PYTEST)

# In one process: each would compile anew.
test-jit: $(READY)
	CONICOID_JIT=own $(BIN)/python -m pytest tests/test_jit.py tests/native/test_digest.py tests/engine/test_assembly.py \
		tests/engine/test_targets.py tests/test_forks.py tests/test_interrupts.py tests/integrators/test_whitted.py

test-wheel: $(READY)
	$(BIN)/python .ci/wheel.py --whole

test-cuda: $(WHEEL_READY)
	$(BIN)/python .ci/gpu.py

deep: kernels
	$(PYTEST) -m "deep or not deep"

check: $(READY)
	$(BIN)/ruff format --check
	$(BIN)/ruff check
	$(BIN)/mypy
	$(BIN)/lint-imports

format: $(READY)
	$(BIN)/ruff format
	$(BIN)/ruff check --fix

wheel: $(WHEEL_READY)
	@$(BIN)/python -m native.wheels host

wheels: $(WHEEL_READY)
	@$(BIN)/python -m native.wheels

# One environment serves every target, a demonstration with part of it; stamps keep it until its inputs change.
# Most of what is installed is never imported, so Python compiles modules at their first import instead.
$(BUILT): pyproject.toml requirements-dev.lock
	@test -n "$(PYTHON)" || { echo "Conicoid needs Python 3.11 or newer with its venv module (Debian: apt-get install python3-venv);" \
		"none was found. Set PYTHON=/path/to/python if it is elsewhere." >&2; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo "Conicoid needs Python 3.11 or newer;" \
		"$(PYTHON) is `$(PYTHON) --version`." >&2; exit 1; }
	@echo "Installing into $(VENV) ..."
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@$(PIP) install --no-compile --constraint requirements-dev.lock --upgrade pip hatchling
	@$(PIP) install --no-compile --constraint requirements-dev.lock --no-build-isolation --editable . --group build
	@touch $@

$(WHEEL_READY): $(BUILT)
	@$(PIP) install --constraint requirements-dev.lock --group wheel
	@touch $@

$(READY): $(BUILT)
	@echo "Installing what tests and checks need into $(VENV) ..."
	@$(PIP) install --constraint requirements-dev.lock --group dev
	@touch $@
	@du -sh $(VENV) | awk '{print "$(VENV) takes " $$1 "; make clean removes it."}'

$(DOCS_READY): $(READY)
	@echo "Installing what makes the site into $(VENV) ..."
	@$(PIP) install --constraint requirements-dev.lock --group docs
	@touch $@

lock:
	rm -rf $(VENV)/lock
	$(PYTHON) -m venv $(VENV)/lock
	$(VENV)/lock/bin/python -m pip install --quiet --upgrade pip hatchling
	$(VENV)/lock/bin/python -m pip install --quiet --no-build-isolation --editable . --group build --group dev --group docs
	{ echo "# Exact versions for development, made by \`make lock\`."; \
		$(VENV)/lock/bin/python -m pip freeze --all --exclude-editable --exclude setuptools; } > requirements-dev.lock
	rm -rf $(VENV)/lock

clean:
	rm -rf $(VENV) out dist conicoid/_kernels.* conicoid/viewer/engine.wasm .mypy_cache .pytest_cache .ruff_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
