# Rust, Python 3.10 or later with venv, and make: the rest comes from crates.io and PyPI into target/ and .venv/.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip --quiet --disable-pip-version-check
# Versions of the packages for work on gearbow.
LOCK := tools/constraints.txt

# Where the wheel for this machine is built that is tested; `make wheel` builds the one for users into dist/.
WHEELS := $(VENV)/wheels
# The environment of the tools that build and check a release.
TOOLS := target/release-tools
# A wheel for Linux is linked with zig, which knows the symbols of old versions of glibc.
LINUX := $(if $(filter Linux,$(shell uname -s)),--zig --compatibility manylinux2014)

SOURCES := Cargo.toml Cargo.lock pyproject.toml $(shell find src -name '*.rs') $(shell find python -name '*.py' -o -name '*.pyi')
FIGURE := examples/output/bowed_train.png
# The interpreter that the bindings are checked against; a built wheel fits every one from 3.10 on.
export PYO3_PYTHON := $(abspath $(BIN)/python)

# Tests and wheel have one profile, so that dependencies are compiled once. The setting adds checks of integer overflow
# to the code of gearbow in the tests; it leaves the wheel and the dependencies unchanged.
CARGO_TEST := cargo test --release --locked --config profile.release.package.gearbow.overflow-checks=true

# Two or more tests run at the same time; a free process takes tests from a busy one.
PYTEST_PARALLEL := -n logical --dist worksteal

.PHONY: help demo test quick check docs web random fuzz mutants bench bench-check bench-accept compare fleet fmt wheel release-check deny licences readme figures study measure accuracy lock structure clean test-rust test-python lint lint-rust lint-python lint-files types documents
.DELETE_ON_ERROR:

help:
	@echo "make demo          run examples/bowed_train.py: tables, and a figure"
	@echo "make test          all tests, Rust and Python, the latter on the installed wheel"
	@echo "make quick         build gearbow into the sources for work on it: a changed line takes less than a minute"
	@echo "make random        check general properties on 2,000 new random scenes, and run all examples and the slow cells of the fleet"
	@echo "make fuzz          parse a million randomly changed descriptions, 10,000 damaged REXS files, and 28,000 damaged files of all kinds"
	@echo "make mutants       change one place of the program at a time: what share of 120 changes do the tests notice? (about an hour)"
	@echo "make check         the tests, and everything else that must hold before a change is merged"
	@echo "make docs          build the documentation site into site/; open site/index.html"
	@echo "make web           build target/web/try.html, a page that runs gearbow in a browser, and test it"
	@echo "make bench         what a step costs"
	@echo "make bench-check   instructions of kernels and runs under Valgrind, held against those stored"
	@echo "make bench-accept  store the instructions as they are now"
	@echo "make compare       gearbow beside SciPy and ROSS: the same work, with the error of each"
	@echo "make fleet         CPU times of the machines of examples/machines beside SciPy, and their tables in the documents"
	@echo "make fmt           format Rust and Python"
	@echo "make wheel         build the wheel for users into dist/, on Linux for glibc 2.17 or later"
	@echo "make release-check build wheel and source distribution, check both, use them on the oldest and the newest Python"
	@echo "make deny          check licences and sources of the dependencies, and crates in two versions (cargo-deny)"
	@echo "make licences      collect the licences of the compiled dependencies (needs cargo-about)"
	@echo "make readme        print the tables of the documents anew"
	@echo "make figures       draw the figures of the documents anew"
	@echo "make study         run the bow study, for docs/study.md, then make measure"
	@echo "make measure       measure anew what accuracy costs: tables and figures of docs/tradeoff.md and docs/comparison.md"
	@echo "make accuracy      measure the total error of the accuracy levels on twelve scenes"
	@echo "make lock          choose the newest versions of the packages for work on gearbow, and store them in $(LOCK)"
	@echo "make structure     report import cycles, long files, long functions and large structs"
	@echo "make clean         remove whatever was built"

demo: $(VENV)/.plot
	$(BIN)/python examples/bowed_train.py

test: test-rust test-python

test-rust:
	$(CARGO_TEST) --no-fail-fast

test-python: $(VENV)/.dev
	$(BIN)/python -m pytest $(PYTEST_PARALLEL) --pyargs gearbow tests/python tests/extremes README.md docs

# Changes in python/ are then active at once. It builds no wheel, which takes minutes after each change.
quick: $(BIN)/maturin
	MATURIN_PEP517_ARGS="--locked --profile quick" $(PIP) install --no-build-isolation --no-deps --editable .
	$(PIP) install --group dev --constraint $(LOCK)

# New random cases in each call; `make test` always takes the same cases.
random: $(VENV)/.dev
	GEARBOW_CASES=10 $(BIN)/python -m pytest tests/python/runs/test_random_scenes.py tests/python/runs/test_random_run_up.py \
		tests/python/linear/test_structured_solver.py tests/python/runs/test_accuracy_of_random_trains.py \
		tests/python/bearings/test_equilibrium_residuals.py tests/python/package/test_examples.py \
		tests/python/linear/test_random_excitations.py
	GEARBOW_CASES=5 $(BIN)/python -m pytest tests/python/identification -k "truth or predicted"
	GEARBOW_CASES=10 $(BIN)/python -m pytest tests/python/bearings/test_films.py -k random
	$(BIN)/python -m pytest tests/python/package/test_fleet.py -m slow

fuzz: $(VENV)/.dev
	GEARBOW_CASES=350 $(CARGO_TEST) --test rust fuzz::
	GEARBOW_CASES=50 $(BIN)/python -m pytest tests/python/scene/test_fuzz.py tests/python/files/test_rexs.py tests/python/files/test_damaged_files.py \
		tests/python/runs/test_random_run_up.py -k "every"

# All mutants are compiled into one program. It goes on where an earlier call ended.
mutants: $(VENV)/.mutants
	$(BIN)/python tools/mutants.py --seed 1

check: lint types documents docs test

lint: lint-rust lint-python lint-files

lint-rust: $(BIN)/python
	cargo fmt --check
	cargo clippy --locked --all-targets --features python -- -D warnings
	cargo clippy --locked --manifest-path web/Cargo.toml --target-dir target -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --locked --no-deps --document-private-items --all-features

lint-python: $(VENV)/.dev
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/python tools/docstrings.py

# Schemas of workflows, forms and metadata are part of check-jsonschema.
lint-files: $(VENV)/.dev
	$(BIN)/check-jsonschema --builtin-schema vendor.github-workflows .github/workflows/*.yml
	$(BIN)/check-jsonschema --builtin-schema vendor.github-issue-forms .github/ISSUE_TEMPLATE/[!c]*.yml
	$(BIN)/check-jsonschema --builtin-schema vendor.github-issue-config .github/ISSUE_TEMPLATE/config.yml
	$(BIN)/check-jsonschema --builtin-schema vendor.dependabot .github/dependabot.yml
	$(BIN)/check-jsonschema --builtin-schema vendor.citation-file-format CITATION.cff
	$(BIN)/python tools/metadata.py

types: $(VENV)/.dev
	$(BIN)/mypy
	$(BIN)/python -m mypy.stubtest gearbow._core

documents: $(VENV)/.dev
	$(BIN)/python docs/printed.py --check

# Warnings and broken links are errors. Examples, notebooks and pages are kept in target/docs-site.
docs: $(VENV)/.docs
	$(BIN)/python docs/site/build.py

# The site takes the page over. The build says what it needs where something is missing.
web: $(VENV)/.dev
	$(PIP) install -q plotly playwright
	$(BIN)/python web/build.py target/web/try.html
	$(BIN)/pytest -q tests/python/package/test_web_page.py

readme: $(VENV)/.dev
	$(BIN)/python docs/printed.py

# A palette of 32 colours makes the figure of the demo small enough to be kept.
figures: demo
	$(BIN)/python examples/figures.py
	$(BIN)/python examples/frequency.py
	$(BIN)/python examples/gearbox.py
	$(BIN)/python examples/signals.py
	$(BIN)/python examples/gear_noise.py
	$(BIN)/python examples/mesh_models.py
	$(BIN)/python examples/resonance_sweep.py
	$(BIN)/python examples/map.py
	$(BIN)/python -c "from PIL import Image; \
	Image.open('$(FIGURE)').convert('RGB').quantize(32).save('docs/bowed_train.png', optimize=True)"

# Runs that are kept in examples/output/study are not made again.
study: $(VENV)/.dev
	$(BIN)/python examples/bow_study/study.py --out examples/output/study
	cp examples/output/study/study_*.png docs/figures/
	$(BIN)/python docs/printed.py --studied
	$(MAKE) measure

measure: $(VENV)/.dev $(VENV)/.compare
	$(BIN)/python docs/printed.py --measured
	$(BIN)/python docs/printed.py README.md

# The references have elements of high degree: this takes most of an hour on two cores.
accuracy: $(VENV)/.dev
	$(BIN)/python benches/accuracy/measure.py
	$(BIN)/python docs/printed.py

bench:
	cargo bench --locked --bench engine

# Counted under Valgrind; where it is not there, this says so and succeeds.
bench-check:
	cargo bench --locked --bench instructions

bench-accept:
	cargo bench --locked --bench instructions -- --accept

compare: $(VENV)/.compare
	$(BIN)/python benches/compare.py

fleet: $(VENV)/.compare
	$(BIN)/python benches/fleet.py
	$(BIN)/python docs/printed.py docs/comparison.md README.md

# The file names no index. It holds the versions for every Python from 3.10 on, on every system.
lock: $(VENV)/.wheel
	$(PIP) install uv
	$(BIN)/uv pip compile --group dev --group docs --group learn --group mutants --upgrade --universal --python-version 3.10 \
		--no-annotate --find-links $(WHEELS) --no-emit-find-links --no-emit-package gearbow \
		--custom-compile-command "make lock" --quiet --output-file $(LOCK)

fmt: $(VENV)/.dev
	cargo fmt
	$(BIN)/ruff check --fix
	$(BIN)/ruff format

structure:
	$(PYTHON) tools/structure.py

wheel release-check: export PYO3_PYTHON := $(abspath $(TOOLS)/bin/python)
wheel release-check: export PATH := $(abspath $(TOOLS)/bin):$(PATH)
wheel: $(TOOLS)/.installed
	rm -f dist/gearbow-*.whl
	$(TOOLS)/bin/maturin build --release --locked $(LINUX) --interpreter $(PYO3_PYTHON) --out dist

# Needs no environment but its own. It compiles gearbow for the wheel, and once more for each Python.
release-check: $(TOOLS)/.installed
	CARGO_TARGET_DIR=$(abspath target) $(TOOLS)/bin/python tools/release_check.py

# The advisories change every day: the public workflow checks them.
deny: target/tools/bin/cargo-deny
	PATH="$(abspath target/tools/bin):$$PATH" cargo deny --locked check bans licenses sources

licences:
	cargo about generate --locked --features python --config tools/about.toml --output-file LICENSES-DEPENDENCIES.txt tools/about.hbs

clean:
	cargo clean
	rm -rf $(VENV) dist site examples/output .hypothesis .mypy_cache .pytest_cache .ruff_cache

$(BIN)/python:
	$(PYTHON) -m venv $(VENV)

# The groups of pyproject.toml need a newer pip than Python 3.10 has.
$(VENV)/.pip: | $(BIN)/python
	$(PIP) install --upgrade "pip>=25.1"
	touch $@

$(BIN)/maturin: | $(VENV)/.pip
	$(PIP) install "maturin>=1.9.4,<2"

$(VENV)/.wheel: $(SOURCES) | $(BIN)/maturin
	rm -f $(WHEELS)/gearbow-*.whl
	$(BIN)/maturin build --release --locked --interpreter $(BIN)/python --out $(WHEELS)
	$(PIP) install --force-reinstall --no-deps $(WHEELS)/gearbow-*.whl
	touch $@

$(TOOLS)/.installed: pyproject.toml
	$(PYTHON) -m venv $(TOOLS)
	$(TOOLS)/bin/python -m pip install --quiet --disable-pip-version-check --upgrade "pip>=25.1"
	$(TOOLS)/bin/python -m pip install --quiet --group release
	touch $@

target/tools/bin/cargo-deny:
	cargo install --locked --root target/tools cargo-deny@0.20.2

# ROSS is optional: where it cannot be installed, the tables say so.
$(VENV)/.compare: $(VENV)/.wheel
	$(PIP) install --group compare || { echo "ROSS cannot be installed."; $(PIP) install --group test; }
	touch $@

# One installation at a time.
$(VENV)/.docs: $(VENV)/.dev

# The demo needs an extra of the wheel, all other targets a group of pyproject.toml, such as dev or docs.
$(VENV)/.plot: $(VENV)/.wheel
	$(PIP) install "$$(echo $(WHEELS)/gearbow-*.whl)[plot]" --constraint $(LOCK)
	touch $@

$(VENV)/.%: $(VENV)/.wheel
	$(PIP) install --group $* --constraint $(LOCK)
	touch $@
