# Two commands on a fresh machine: `make demo` and `make test`. Each adds what it needs, at pinned
# versions, to a private environment in .venv, and nothing outside this folder is changed.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# What is never imported is never compiled: half the time.
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile
DEMO_READY := $(VENV)/.demo
DEV_READY := $(VENV)/.dev
INSTALLED := $(VENV)/.installed
WEB_READY := web/node_modules/.ready
PYTEST := $(BIN)/python -m pytest -n auto --dist worksteal
HEAVY := browser or photographs or documentation or hostile or players or cluster or slow or realdata

.PHONY: demo test test-all check count processors docs format page coverage blender test-blender requirements clean
# One environment, which no two installations may change at once.
.NOTPARALLEL:

demo: $(INSTALLED)
	$(BIN)/elastomorph demo

# Tests run against the package as people install it, never against the source folder. These are of
# numbers, files and verbs, in minutes.
test: $(DEV_READY) $(INSTALLED) $(WEB_READY)
	$(PYTEST) -m "not ($(HEAVY))"

# The rest: what takes long, and what needs real data, a browser, rendered photographs, executed pages,
# damaged files by the hundred, other programs, a cluster, or Blender.
test-all: test-blender $(DEV_READY) $(INSTALLED) $(WEB_READY)
	$(PYTEST) -m "$(HEAVY)"

check: docs
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache --no-logo

# How large the house is.
count: $(DEV_READY)
	$(BIN)/python tools/count.py

# The tests of numerical code, as other processors round.
processors: $(DEV_READY) $(INSTALLED)
	$(BIN)/python tools/processors.py -n auto

format: $(DEV_READY)
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

# The documentation site, into out/docs: nothing is fetched, and every warning is an error.
docs: $(DEV_READY) $(INSTALLED)
	$(BIN)/sphinx-build -W --keep-going -q -b html docs out/docs

# The pages that the package ships: the viewer, and where landmarks are placed.
page: $(WEB_READY)
	npm run --silent --prefix web types
	npm run --silent --prefix web build
	npm run --silent --prefix web build:landmarks
	npm run --silent --prefix web build:report

# Which branches of the code the tests take, the readers' first.
coverage: $(DEV_READY) $(INSTALLED) $(WEB_READY)
	$(BIN)/coverage run -m pytest -n 0 --timeout 1200
	$(BIN)/coverage combine --quiet
	$(BIN)/coverage report --include '*/elastomorph/io/*' --format=markdown
	$(BIN)/coverage report --format=total

# The extension for Blender, one .zip for all systems that build.py names, into out/blender: Blender installs it from disk.
blender: $(DEMO_READY)
	$(BIN)/python integrations/blender/build.py

# It is tested in Blender as a Python module, in an environment of its own.
test-blender:
	integrations/blender/test.sh

# What the demo needs, in an environment made anew when any pinned version changes.
$(DEMO_READY): requirements/demo.txt requirements/dev.txt
	$(PYTHON) -m venv --clear $(VENV)
	$(PIP) -r requirements/demo.txt
	touch $@

# What tests, checks and documentation need beside it.
$(DEV_READY): $(DEMO_READY)
	$(PIP) -r requirements/dev.txt
	touch $@

# A wheel is built and installed again whenever the source has changed.
$(INSTALLED): $(DEMO_READY) pyproject.toml $(shell find src -type f -not -path '*/__pycache__/*')
	rm -rf $(VENV)/wheel
	$(BIN)/python -m hatchling build -t wheel -d $(VENV)/wheel >/dev/null
	$(PIP) --no-deps --force-reinstall $(VENV)/wheel/*.whl
	touch $@

# What checks glTF files with other people's software; tests that need it skip without npm.
$(WEB_READY): web/package-lock.json
	if command -v npm >/dev/null; then npm ci --prefix web --no-audit --no-fund --silent; \
	else mkdir -p web/node_modules; fi
	touch $@

# Pins the newest versions that work together on Python 3.11 to 3.13 (needs uv). The demo has a part
# of them: what draws and writes GLB, what builds the wheel, and no encoder of movies.
COMPILE := uv pip compile --universal --python-version 3.11 --upgrade --no-emit-index-url \
  --no-header --no-annotate --quiet
requirements:
	$(COMPILE) --extra dev pyproject.toml --output-file requirements/dev.txt
	echo hatchling | $(COMPILE) --extra demo --no-emit-package imageio-ffmpeg \
	  --constraints requirements/dev.txt pyproject.toml - --output-file requirements/demo.txt

clean:
	rm -rf $(VENV) .venv-blender web/node_modules out .coverage* .mypy_cache .ruff_cache .pytest_cache .hypothesis
