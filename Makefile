# The front door: each target fetches its own uv into .tools and makes the locked environment in .venv.
.DEFAULT_GOAL := help
UV := .tools/bin/uv
RUN := .venv/bin
export UV_PYTHON_DOWNLOADS := never
# bytecode is kept: each of the many processes that the tests start would compile the package anew
export PYTHONDONTWRITEBYTECODE :=

.PHONY: help setup figures lint style types kernels bytecode objects wheel test test-page test-rest validate coverage bench atlas docs screenshots clean
help:  ## list the targets
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 12

# --target leaves the system's Python alone, so pip allows it where that Python is "externally managed";
# --upgrade replaces what an interrupted attempt may have left there.
$(UV):
	python3 -m pip install --quiet --disable-pip-version-check --upgrade --target .tools "uv>=0.8"

# without --compile-bytecode: of all that is installed a tenth is ever imported, and its bytecode is kept then
.venv/.made: pyproject.toml uv.lock | $(UV)
	$(UV) sync --quiet --locked --all-extras
	@touch $@

setup: .venv/.made  ## make the environment

figures: setup  ## reproduce the paper into figures/, and draw the validity map
	$(RUN)/springpot reproduce all --out figures
	$(RUN)/springpot validity --out figures

lint: style types  ## style, types, spelling

style: setup
	$(RUN)/ruff check .
	$(RUN)/codespell

types: setup
	$(RUN)/mypy

# kernels and bytecode before tests, for each of the processes that test would make them; else all beside each other,
# since the page's tests often wait for the browser, others for a signal or a worker, and mypy has one thread
test: style  ## style, types, spelling and the everyday tests
	@$(MAKE) --no-print-directory --jobs=3 types test-page test-rest

kernels: setup
	@$(RUN)/python -m tests.kernels

# of tests that are new here, which each of the processes that test would make for itself: ten seconds
bytecode: setup
	@$(RUN)/pytest --quiet --quiet --collect-only > /dev/null

objects: setup  ## make the compiled code that the wheel brings
	@$(RUN)/python -m springpot.simulation.kernel.make_objects

wheel: objects  ## build what is released, into dist/
	$(UV) build --quiet --wheel

test-page: kernels bytecode
	$(RUN)/pytest --quiet -m "not validation" tests/explorer

test-rest: kernels bytecode
	$(RUN)/pytest -m "not validation" --ignore=tests/explorer --numprocesses=2 --dist=worksteal

validate: setup  ## the tests that take longer
	$(RUN)/pytest -m validation

# the page's tests, which start processes of their own, left out
coverage: kernels  ## which lines and branches the everyday tests reach, what Numba compiles left out
	$(RUN)/pytest -m "not validation" --ignore=tests/explorer --numprocesses=2 --dist=worksteal \
		-p pytest_cov --cov --cov-report=term:skip-covered

# an environment of its own, for the programs to compare with are large
bench: export UV_PROJECT_ENVIRONMENT := .tools/bench
bench: | $(UV)  ## measure the speed, and write docs/performance.md
	$(UV) sync --quiet --locked --all-extras --compile-bytecode --no-default-groups --group bench
	.tools/bench/bin/python -m benchmarks

# an environment of its own, so that the everyday one stays small
# two hours on two cores; stopped, it goes on where it was
ATLAS := .atlas
atlas: export UV_PROJECT_ENVIRONMENT := .tools/atlas
atlas: | $(UV)  ## simulate and fit the atlas anew, into src/springpot/evidence/atlases/atlas.npz
	$(UV) sync --quiet --locked --all-extras --compile-bytecode --no-default-groups --group atlas
	for part in elastic lossy losses; do \
		.tools/atlas/bin/springpot study run atlas/$$part.toml --store $(ATLAS)/$$part.store || exit; \
	done
	.tools/atlas/bin/python atlas/make.py $(ATLAS) src/springpot/evidence/atlases/atlas.npz

docs: export UV_PROJECT_ENVIRONMENT := .tools/docs
docs: | $(UV)  ## build the documentation into docs/_build/html, running every example; a warning is an error
	$(UV) sync --quiet --locked --all-extras --compile-bytecode --no-default-groups --group docs
	rm -rf docs/_build docs/api/generated docs/auto_gallery
	.tools/docs/bin/sphinx-build -W --keep-going -n -b html docs docs/_build/html

screenshots: setup  ## pictures of the page, into docs/images (needs a Chromium)
	$(RUN)/python -m tests.explorer.screenshots docs/images

clean:  ## forget the environment and the tools
	rm -rf .venv .tools
