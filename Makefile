# Every target sets itself up: all that is needed is Python >= 3.11 and make.
PYTHON ?= python3
BIN := .venv/bin
THREEJS := reports/engines/threejs/node_modules
SOURCES := pyproject.toml README.md LICENSE $(shell find swimlab sequences metrics -type f -not -path '*/__pycache__/*')

export PIP_CONSTRAINT := $(CURDIR)/constraints.txt
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.PHONY: study test docs clean

study: .venv/installed
	$(BIN)/swimlab study -o runs/study

# The tests run against the installed wheel, never against the source folders.
# A module's tests stay on one worker, so that what they share is made once.
test: .venv/tools .venv/installed | $(THREEJS)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/pytest -n 2 --dist loadscope -rs

# The site, in site/index.html; without network once the tools are there.
docs: .venv/writers .venv/installed
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict --quiet

.venv/builder: pyproject.toml constraints.txt
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet build hatchling
	touch $@

# The wheel of these sources over the last one, then what it depends on and does not find.
.venv/installed: .venv/builder $(SOURCES)
	rm -f .venv/wheels/*
	$(BIN)/python -m build --wheel --no-isolation --outdir .venv/wheels . > .venv/build.log || (cat .venv/build.log; exit 1)
	$(BIN)/pip install --quiet --no-deps --force-reinstall .venv/wheels/*.whl
	$(BIN)/pip install --quiet .venv/wheels/*.whl
	touch $@

# What only the tests need, and the extras that they cover.
.venv/tools: .venv/builder | .venv/installed
	$(BIN)/pip install --quiet "$$(ls .venv/wheels/*.whl)[cluster,dev,docs,flip,notebook,table,video]"
	touch $@

.venv/writers: .venv/builder | .venv/installed
	$(BIN)/pip install --quiet "$$(ls .venv/wheels/*.whl)[docs]"
	touch $@

# three.js for the test of its example, where npm and Chromium are. Without it the test is skipped and says so.
$(THREEJS): reports/engines/threejs/package.json
	if command -v npm > /dev/null && command -v chromium > /dev/null; then npm install --prefix $(@D) --no-audit --no-fund --fetch-retries=1 --fetch-timeout=30000 && touch $@; fi || true

clean:
	rm -rf .venv runs site
