# The Python that .venv is made with:  PYTHON=python3.12 make demo
# Without make, on Windows for example, all of this is:  python tools/setup.py demo
PYTHON ?= python3
TASKS := demo test test-system test-anywhere test-compiled test-long boards clients interpreters firmware physics check conformance mutations bench docs dist compiled clean

.PHONY: help run-env dev-env $(TASKS)

help:
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-14s %s\n", $$1, $$2 }' Makefile

demo: ## Set up and run the demo
test: ## Run the tests that need no other process, terminal or real time
test-system: ## Run the tests with processes, terminals, sockets and real time
test-anywhere: ## Run both in difficult surroundings: another user, odd variables, no network, busy processors
test-compiled: ## Run the tests of the core and the laws over the compiled build
test-long: ## Run the long tests, and all tests over the compiled build
boards: ## Install the tools for building and testing the firmware of boards, and build it
clients: ## Install the EPICS clients for the tests of the motor record
interpreters: ## Unpack the interpreters of other controllers that run translated programs
firmware: ## Build the firmware of boards into build/firmware
physics: ## Print the table of the physics of motors: value, expected, tolerance
check: ## Check style, types, imports, conformance table and documentation
conformance: ## Write the conformance table
mutations: ## Deliberately break the source, and check that a test fails
bench: ## Measure the speed, and write the page about it
docs: ## Build the documentation into build/docs
dist: ## Build wheel and sdist into dist, twice, and compare
compiled: ## Build the compiled core into build/compiled
clean: ## Remove .venv, build products and caches

# The script itself sees in a moment, from its stamps, whether anything is left to do.
$(TASKS):
	@command -v "$(PYTHON)" >/dev/null || { echo "make: no $(PYTHON) here; name another: PYTHON=python3.12 make ..." >&2; exit 1; }
	@"$(PYTHON)" tools/setup.py $@

run-env dev-env:
	@command -v "$(PYTHON)" >/dev/null || { echo "make: no $(PYTHON) here; name another: PYTHON=python3.12 make ..." >&2; exit 1; }
	@"$(PYTHON)" tools/setup.py $(@:-env=)
