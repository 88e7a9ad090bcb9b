# `make demo` and `make test` are all that a newcomer needs; both install what is missing.

.DEFAULT_GOAL := help
SHELL := /bin/sh
.PHONY: help demo venv llvm test test-all test-lowest sbom check fuzz soak mutants mutants-all mutants-map mutants-fresh mutants-changed bench docs site checks proof clean

BIN := .venv/bin
SCENARIO := examples/harbour_survey.yaml
READY := .venv/ready
DEVICE := .venv/device
LOWEST := .venv-lowest/ready

help: ## Show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-16s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

demo: venv llvm ## Survey a harbour; ends by saying where the results lie
	$(BIN)/pelagos run $(SCENARIO)

venv: $(READY) ## Build .venv with everything that tests and examples need

$(READY): pyproject.toml scripts/venv.sh
	@sh scripts/venv.sh .venv
	@touch $@

llvm: $(DEVICE) ## Install libLLVM 19 through apt when no usable one is installed

$(DEVICE): $(READY) scripts/llvm.sh
	@sh scripts/llvm.sh
	@touch $@

test: venv llvm ## Run the tests
	$(BIN)/python -m pytest -n 2 -m "not slow" --durations=10

test-all: venv llvm ## Run the tests, the slow ones too; those of the page in Chromium, of ROS 2's wire with Fast DDS and tshark
	@sh scripts/chromium.sh
	@sh scripts/peers.sh
	PELAGOS_LANES=8 $(BIN)/python -m pytest -n 2

check: venv llvm ## Everything that CI runs: format, lint, types, layers, schema, tests
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/pelagos schema --check schema/scenario.schema.json
	$(BIN)/python scripts/reference.py --check
	$(BIN)/python scripts/site --quick
	$(BIN)/python -m pytest -n 2 -m "not slow" --durations=10

# Packages of today warn the old ones of what will go. The schema's text is that of the newest pydantic.
test-lowest: llvm $(LOWEST) ## Run TESTS="tests/unit tests/compat" with the lowest versions of all dependencies, in .venv-lowest
	.venv-lowest/bin/python -m pytest -n 2 -m "not slow" -p no:cacheprovider -o filterwarnings=ignore::DeprecationWarning \
	    --deselect tests/unit/test_cli_commands.py::test_committed_schema_is_that_of_the_program \
	    $(or $(TESTS),tests/unit tests/compat)

$(LOWEST): pyproject.toml scripts/lowest.sh
	@sh scripts/lowest.sh .venv-lowest
	@touch $@

sbom: venv ## Write the bill of materials of what is installed: build/sbom.json (CycloneDX)
	@python3 -m venv --clear build/sbom-tool
	@build/sbom-tool/bin/pip install --quiet --disable-pip-version-check cyclonedx-bom
	build/sbom-tool/bin/cyclonedx-py environment .venv --output-file build/sbom.json

fuzz: venv llvm ## Fuzz the readers for SECONDS=300 each: scenarios, texts, recordings, world files, packets
	PELAGOS_FUZZ_SECONDS=$(or $(SECONDS),300) $(BIN)/python -m pytest -s tests/fuzz

soak: venv llvm ## Long runs, to see that memory stays flat: SHARE=1 is a week of simulated time
	$(BIN)/python scripts/soak.py --share $(or $(SHARE),0.01)

mutants: venv llvm ## Put COUNT=300 listed mistakes into copies of the source, SEED=0 draws which, and see that a test notices each
	$(BIN)/python scripts/mutants --some $(or $(COUNT),300) --seed $(or $(SEED),0)

mutants-all: venv llvm ## All that are listed, thousands: hours; LISTS="contact hydro" some lists
	$(BIN)/python scripts/mutants $(LISTS)

mutants-map: venv llvm ## Write down which test runs which line, for mutants-fresh: some 40 minutes
	@mkdir -p build
	COVERAGE_FILE=build/tests_by_line.coverage $(BIN)/python -m pytest -n 2 -m "not slow" --cov=pelagos --cov-context=test --cov-report= \
	    --durations=0 -vv > build/tests_by_line.txt

mutants-fresh: venv llvm ## Some that are in no list, drawn at random: COUNT=50 SEED=1, of conditions and branches DECISIONS=1
	$(BIN)/python scripts/mutants --fresh $(or $(COUNT),50) --seed $(or $(SEED),1) $(and $(DECISIONS),--decisions)

mutants-changed: venv llvm ## The same for the files that differ from REF=origin/main
	$(BIN)/python scripts/mutants --changed $(or $(REF),origin/main)

bench: venv llvm ## Measure speed and refresh bench/RESULTS.md
	$(BIN)/pelagos bench --write bench/RESULTS.md

docs: venv ## Renew the files that are generated: the schema, the scenario reference, the vehicles' pages
	$(BIN)/pelagos schema --write schema/scenario.schema.json
	$(BIN)/python scripts/reference.py
	$(BIN)/python -m pelagos.vehicles.page docs/vehicles

site: venv llvm ## Build the documentation's site into build/site
	$(BIN)/python scripts/site

checks: venv llvm ## Renew docs/checks.json: every numeric comparison of the tests, with its deviation
	PYTHONPATH=scripts/site $(BIN)/python -m pytest -p proof_plugin -o enable_assertion_pass_hook=true -p no:xdist $(or $(FILES),tests/verification tests/cross_code)

proof: venv llvm ## Compare with recordings of real vehicles and seas in the folder DATA: docs/proof.md
	$(BIN)/python scripts/proof $(if $(DATA),--data $(DATA))

clean: ## Remove what was built (results stay)
	rm -rf .venv .mypy_cache .ruff_cache .pytest_cache .import_linter_cache build dist
