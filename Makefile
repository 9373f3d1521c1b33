# Two commands are enough on a fresh machine with Python 3.11+ and make: `make demo` and `make test`.
PYTHON ?= python3
BIN := .venv/bin
INSTALLED := .venv/installed
DOCS_INSTALLED := .venv/docs-installed
SPHINX := $(BIN)/sphinx-build --builder html --jobs 2 --nitpicky --fail-on-warning --keep-going --quiet \
	--doctree-dir out/docs-doctrees docs out/docs

.PHONY: demo test test-slow lint docs docs-slow bench validation clean

demo: $(INSTALLED)
	$(BIN)/lce demo --out out/demo

# A file's tests stay in one process: they share what they have made.
test: $(INSTALLED)
	$(BIN)/python -m pytest -n auto --dist loadfile

test-slow: $(INSTALLED)
	$(BIN)/python -m pytest -m slow

lint: $(INSTALLED)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright
	$(BIN)/lint-imports

# The site, into out/docs, without the network; warnings are errors. Its last line tries every link inside it.
docs: $(DOCS_INSTALLED)
	$(SPHINX)
	$(BIN)/python -m pytest -q -m site tests/docs

# The same with those examples run, too, that take minutes.
docs-slow: $(DOCS_INSTALLED)
	$(SPHINX) -D sphinx_gallery_conf.filename_pattern='[.]py$$'
	$(BIN)/python -m pytest -q -m site tests/docs

bench: $(INSTALLED)
	$(BIN)/python -m benchmarks startup
	$(BIN)/python -m benchmarks face
	$(BIN)/python -m benchmarks growth

validation: $(INSTALLED)
	$(BIN)/python -m benchmarks.validation

# constraints.txt: the versions that the expected numbers and help texts were made with
$(INSTALLED): pyproject.toml constraints.txt
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[dev]'
	touch $@

$(DOCS_INSTALLED): $(INSTALLED)
	$(BIN)/python -m pip install --quiet --constraint constraints.txt --editable '.[docs]'
	touch $@

clean:
	rm -rf .venv out build dist *.egg-info docs/gallery docs/api/generated examples/out
