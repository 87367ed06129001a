# The Python that .venv is made with:  PYTHON=python3.12 make demo
PYTHON ?= python3

.PHONY: help demo test test-long check conformance mutations bench docs clean run-env dev-env

help:
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-12s %s\n", $$1, $$2 }' Makefile

demo: run-env ## Set up what the demo needs, and run it
	@.venv/bin/slewline demo

# Tests start Python some hundred times: keep what it has compiled, in build/, whatever the environment says of it.
test test-long: export PYTHONDONTWRITEBYTECODE :=
test test-long: export PYTHONPYCACHEPREFIX := $(CURDIR)/build/bytecode

test: dev-env ## Run the tests, except the long ones
	.venv/bin/python -m pytest -n 2

test-long: dev-env ## Run the long tests
	.venv/bin/python -m pytest -n 2 -m long

check: dev-env ## Check style, types, imports, conformance table and documentation
	.venv/bin/ruff check
	.venv/bin/ruff format --check
	.venv/bin/mypy
	.venv/bin/lint-imports
	.venv/bin/python tools/conformance.py --check
	.venv/bin/python tools/describe_docs.py --check
	.venv/bin/python tools/stubs.py --check
	.venv/bin/python -m pytest -m docs tests/docs

conformance: dev-env ## Write the conformance table
	.venv/bin/python tools/conformance.py

mutations: dev-env ## Break the source on purpose, and see that a test notices
	.venv/bin/python tools/mutations.py

bench: dev-env ## Measure the speed, and write the page about it
	.venv/bin/python benchmarks/run.py --long --page docs/reference/performance.md

docs: dev-env ## Build the documentation into build/docs
	.venv/bin/sphinx-build -W docs build/docs

clean: ## Remove .venv, build products and caches
	rm -rf .venv build dist .coverage .hypothesis .import_linter_cache .mypy_cache .pytest_cache .ruff_cache
	find src tests tools benchmarks docs -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true

# Always run: the script itself sees in a moment, from its stamps, whether anything is left to do.
run-env dev-env:
	@command -v "$(PYTHON)" >/dev/null || { echo "make: no $(PYTHON) here; name another: PYTHON=python3.12 make ..." >&2; exit 1; }
	@"$(PYTHON)" tools/setup.py $(@:-env=)
