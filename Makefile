# Two commands on a fresh machine: `make demo` and `make test`. Each makes the private environment
# it needs in .venv, from pinned versions, and nothing outside this folder is changed.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
INSTALLED := $(VENV)/.installed
WEB_READY := web/node_modules/.ready

.PHONY: demo test check docs format page coverage requirements clean

demo: $(INSTALLED)
	$(BIN)/elastomorph demo

# Tests run against the package as people install it, never against the source folder.
test: $(INSTALLED) $(WEB_READY)
	$(BIN)/python -m pytest -n auto

check: $(INSTALLED) docs
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

format: $(READY)
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

# The documentation site, into out/docs: nothing is fetched, and every warning is an error.
docs: $(INSTALLED)
	$(BIN)/sphinx-build -W --keep-going -q -b html docs out/docs

# The viewer page that the package ships, built from web/viewer.
page: $(WEB_READY)
	npm run --silent --prefix web types
	npm run --silent --prefix web build

# Which branches of the code the tests take, the readers' first.
coverage: $(INSTALLED) $(WEB_READY)
	$(BIN)/coverage run -m pytest -n 0
	$(BIN)/coverage combine --quiet
	$(BIN)/coverage report --include '*/elastomorph/io/*' --format=markdown
	$(BIN)/coverage report --format=total

# The environment is rebuilt when the pinned versions or the package's own description change.
$(READY): requirements/dev.txt pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -r requirements/dev.txt
	touch $(READY)

# A wheel is built and installed again whenever the source has changed.
$(INSTALLED): $(READY) $(shell find src -type f -not -path '*/__pycache__/*')
	rm -rf $(VENV)/wheel
	$(BIN)/python -m hatchling build -t wheel -d $(VENV)/wheel >/dev/null
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --force-reinstall \
	  $(VENV)/wheel/*.whl
	touch $(INSTALLED)

# What checks glTF files with other people's software; tests that need it skip without npm.
$(WEB_READY): web/package-lock.json
	if command -v npm >/dev/null; then npm ci --prefix web --no-audit --no-fund --silent; \
	else mkdir -p web/node_modules; fi
	touch $(WEB_READY)

# Pins the newest versions that work together on Python 3.11 to 3.13 (needs uv).
requirements:
	uv pip compile --universal --python-version 3.11 --extra dev --upgrade --no-emit-index-url \
	  --no-header --no-annotate --quiet pyproject.toml --output-file requirements/dev.txt

clean:
	rm -rf $(VENV) web/node_modules out .coverage* .mypy_cache .ruff_cache .pytest_cache .hypothesis
