# Everything that a newcomer needs: `make demo` and `make test` set up what they use by themselves.
PYTHON ?= python3
HOST ?= 127.0.0.1
ARGS ?=
BIN := .venv/bin
PY := $(BIN)/python

# Packages are installed without bytecode, so the bytecode of their first import must be kept.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help setup kernels demo demo-check test test-short test-short-behind test-real test-real-time test-browser \
  test-fast test-long test-virtual test-faults soak-maps lint lint-style lint-types lint-imports lint-web format web bench soak soak-kill mutants maps peers odometry-peers lock extras oracle generators lighthouse \
  camera cluster tracing training video workshop sbom docs clean

help:
	@echo "make demo    set up and run a campus on this machine (HOST=0.0.0.0 serves a phone on the LAN);"
	@echo "             scripts/first-minutes measures how long that takes in a fresh clone"
	@echo "make test    set up and run the tests; make test-long the ones that take minutes"
	@echo "make lint    format check, lint, types, import contracts"
	@echo "make bench   short form of every benchmark, refreshes benchmarks/README.md"
	@echo "make soak    long and random campaigns, with their seeds printed"
	@echo "make soak-maps  rides in real time while maps are published and rolled back"
	@echo "make soak-kill  SIGKILL of server, agent, database and broker, again and again (N=500)"
	@echo "make mutants do the short tests notice wrong changes? (ROOM=guard SAMPLE=50 SEED=1)"
	@echo "make extras  install everything that is optional, but for PyTorch (CI does)"
	@echo "make oracle  install what a test compares the path planner with (CI does)"
	@echo "make lighthouse  install Lighthouse, for python -m benchmarks.web"
	@echo "make generators  install what tests check the specifications with (CI does)"
	@echo "make cluster     install Dask, for --cluster (CI does)"
	@echo "make tracing     install what sends traces of rides, for OTEL_EXPORTER_OTLP_ENDPOINT (CI does)"
	@echo "make workshop    install what reads ROS bags and GNSS receivers (CI does)"
	@echo "make camera      install OpenCV, by which the NUS stack finds people in pictures (CI does)"
	@echo "make video       install PyAV, which records the cameras of vehicles (CI does)"
	@echo "make training    install PyTorch, for campusloop workshop train-detector"
	@echo "make sbom    what the server and the pages consist of, in CycloneDX (var/sbom)"
	@echo "make docs    build the documentation as a site (var/docs/html); a broken link is an error (CI does)"
	@echo "make web     build the pages; make maps rebuilds the shipped maps"
	@echo "make odometry-peers  KISS-ICP to compare with (python -m benchmarks.odometry --peers)"
	@echo "make peers   open planners to compare with (python -m benchmarks.peers)"

# Everything at once: packages beside the pages, kernels as soon as numba is there.
setup:
	@$(MAKE) --no-print-directory -j$(CORES) .venv/installed web/dist/built kernels

CORES := $(shell $(PYTHON) -c 'import os; print(max(2, os.cpu_count() or 2))' 2>/dev/null || echo 2)
# Packages are compiled where they are imported, which most of their files never are.
PIP_INSTALL := pip install --quiet --disable-pip-version-check --no-compile --no-deps
INSTALL := $(BIN)/$(PIP_INSTALL)

# What a campus needs to run; `make demo` waits for nothing else.
.venv/running: requirements/run.txt pyproject.toml sdk/python/pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "Campusloop needs Python 3.11 or newer; set PYTHON=/path/to/python3.11"; exit 1; }
	@echo "installing Python packages (.venv)"
	@test -x $(PY) || $(PYTHON) -m venv .venv || \
	  { echo "Python's venv module is missing (Debian: apt-get install python3-venv)"; exit 1; }
	@$(INSTALL) --require-hashes -r requirements/run.txt
	@$(INSTALL) --no-build-isolation -e . -e sdk/python
	@touch $@

# What its tests and linters need as well.
.venv/installed: .venv/running requirements/lock.txt
	@echo "installing what tests and linters need"
	@$(INSTALL) --require-hashes -r requirements/lock.txt
	@touch $@

web/dist/built: $(shell find web/src web/public web/*.html web/*.ts web/*.json -type f 2>/dev/null)
	@command -v npm >/dev/null || { echo "Campusloop's pages need Node.js with npm (20 or newer)"; exit 1; }
	@echo "building the pages (web/dist)"
	@cd web && npm ci --no-audit --no-fund --loglevel=error >/dev/null && npm run --silent build >/dev/null
	@touch $@

web/tools/node_modules/installed: web/tools/package-lock.json
	@cd web/tools && npm ci --no-audit --no-fund --loglevel=error >/dev/null
	@touch $@

# What `python -m benchmarks.web` asks of the passenger page; a folder of its own, for it is larger than the linters.
lighthouse: web/tools/lighthouse/node_modules/installed

web/tools/lighthouse/node_modules/installed: web/tools/lighthouse/package-lock.json
	@cd web/tools/lighthouse && npm ci --no-audit --no-fund --loglevel=error >/dev/null
	@touch $@

# Every numba kernel, for tests time what they drive. It looks for itself what is compiled already.
kernels: .venv/running
	@$(PY) -m campusloop warm

web: web/dist/built

# Only what a running campus needs; it compiles the kernels of its own stack and says so.
demo:
	@$(MAKE) --no-print-directory -j$(CORES) .venv/running web/dist/built
	$(BIN)/campusloop demo --host $(HOST) $(ARGS)

demo-check: .venv/running
	$(BIN)/campusloop demo --headless --rides 2 --seed 1

# With FAULTS=1 also rides whose processes are killed. What runs in real time mostly waits: it is beside the short
# tests then, and comes first to a core all the same, for a vehicle that is starved of its clock stops, as it should.
test: setup
	@scripts/browser
	@$(MAKE) --no-print-directory \
	  $(if $(FAULTS),-j2 --output-sync=target test-short-behind test-real-time,test-short test-real)
	@$(MAKE) --no-print-directory test-browser

test-short-behind:
	nice -n 5 $(MAKE) --no-print-directory test-short

test-real-time:
	@$(MAKE) --no-print-directory test-real
	@$(MAKE) --no-print-directory test-faults

DURATIONS ?= 25
SHORT := not real and not browser and not faults and not long
# The files that have tests with this mark. Collecting all files takes longer than some of these tests.
marked = $(shell grep -rl --include='test_*.py' 'mark\.$(1)\b' tests)

# In the order of tests/conftest.py: reordered by their number of tests, files of few and long ones would come
# last, and one of two processes would wait for the other.
test-short:
	cd web && npm test --silent
	$(PY) -m pytest -n 2 --dist loadfile --no-loadscope-reorder --durations $(DURATIONS) -m "$(SHORT)"

test-real:
	$(PY) -m pytest -m "real and not browser and not faults" $(call marked,real)

# Each file has a server and a browser of its own.
test-browser:
	$(PY) -m pytest -n 2 --dist loadfile -m browser $(call marked,browser)

# Whole rides among people, in virtual time, beside rides in real time whose processes are killed.
test-long: setup
	@$(MAKE) --no-print-directory -j2 --output-sync=target test-virtual test-faults

test-virtual:
	nice -n 19 $(PY) -m pytest -n 2 --dist load --maxschedchunk 1 -m "long and not real" $(call marked,long)

# Rides on two maps in real time take three minutes more than the rest of CI leaves: `make soak-maps`.
MAPS := tests/faults/test_map_change.py tests/faults/test_localization_map_change.py

test-faults:
	@scripts/services
	$(PY) -m pytest -m faults $(filter-out $(MAPS),$(call marked,faults))

test-fast: .venv/installed kernels
	$(PY) -m pytest -n 2 --dist loadfile --no-loadscope-reorder -m "$(SHORT)" -x

lint: setup
	@$(MAKE) --no-print-directory lint-style lint-imports lint-web lint-types

lint-style:
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

lint-types:
	$(BIN)/mypy

lint-imports:
	$(BIN)/lint-imports

lint-web:
	cd web && npm run --silent lint

format: .venv/installed
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

bench: setup
	$(PY) -m benchmarks

soak: setup .venv/mutants-installed
	$(PY) -m tests.soak $(ARGS)

soak-maps: setup
	$(PY) -m pytest -m faults $(MAPS)

N ?= 500
soak-kill: setup
	$(PY) -m benchmarks.kills --kills $(N) $(ARGS)

# Wrong changes, one at a time in a copy of the tree, and whether the short tests notice (benchmarks/mutants).
SAMPLE ?= 300
SEED ?= 1
MUTANTS_ARGS = --sample $(SAMPLE) --seed $(SEED) $(if $(ROOM),--room $(ROOM))

mutants: kernels .venv/mutants-installed
	$(PY) -m benchmarks.mutants $(MUTANTS_ARGS) $(ARGS)

.venv/mutants-installed: .venv/installed requirements/mutants.txt
	$(INSTALL) --require-hashes -r requirements/mutants.txt
	@touch $@

maps: .venv/installed
	$(BIN)/campusloop map import maps/shanghai-university/shanghai-university-baoshan.osm.pbf \
	  --out maps/shanghai-university/map.json --campus-id shu-baoshan --name "Shanghai University, Baoshan" \
	  --timezone Asia/Shanghai --bounds 31.3126,121.3809,31.3239,121.3964 \
	  --names maps/shanghai-university/names.csv
	$(BIN)/campusloop map schematic --out maps/snow-lion/map.json

# Open Frenet planners for `python -m benchmarks.peers`: their libraries' versions clash with ours.
peers: var/peers/installed

var/peers/installed: requirements/peers.txt
	$(PYTHON) -m venv var/peers
	var/peers/bin/pip install --quiet --disable-pip-version-check -r requirements/peers.txt
	@touch $@

# KISS-ICP for `python -m benchmarks.odometry --peers`.
odometry-peers: var/odometry-peers/installed

var/odometry-peers/installed: requirements/odometry-peers.txt
	$(PYTHON) -m venv var/odometry-peers
	var/odometry-peers/bin/$(PIP_INSTALL) --require-hashes -r requirements/odometry-peers.txt
	@touch $@

# What other people's tools say of the specifications, in tests/server/api/specifications: linters in web/tools, and
# the Python generator of clients, whose libraries clash with ours.
generators: var/generators/installed web/tools/node_modules/installed

# What a running campus consists of, in CycloneDX: of Python what run.txt locks, of the pages what is in them.
sbom: var/sbom/installed
	var/sbom/bin/cyclonedx-py requirements requirements/run.txt --pyproject pyproject.toml --of JSON \
	  -o var/sbom/python.cdx.json
	cd web && npm sbom --omit dev --package-lock-only --sbom-format cyclonedx > ../var/sbom/web.cdx.json
	@ls -l var/sbom/*.cdx.json

# Every page, with search. What Sphinx warns of (a link that leads nowhere) ends it.
docs: var/docs/installed
	var/docs/environment/bin/python -m docs.site.build

var/docs/installed: requirements/docs.txt
	$(PYTHON) -m venv var/docs/environment
	var/docs/environment/bin/$(PIP_INSTALL) --require-hashes -r requirements/docs.txt
	@touch $@

var/sbom/installed: requirements/sbom.txt
	$(PYTHON) -m venv var/sbom
	var/sbom/bin/$(PIP_INSTALL) --require-hashes -r requirements/sbom.txt
	@touch $@

# All that follow at once, as CI has them.
EXTRAS := camera cluster mutants oracle tracing video workshop

extras: .venv/installed
	$(INSTALL) --require-hashes $(EXTRAS:%=-r requirements/%.txt)
	@touch .venv/mutants-installed

# Dask, for --cluster.
cluster: .venv/installed
	$(INSTALL) --require-hashes -r requirements/cluster.txt

# OpenTelemetry, for traces of rides.
tracing: .venv/installed
	$(INSTALL) --require-hashes -r requirements/tracing.txt

# OpenCV, to find people in pictures.
camera: .venv/installed
	$(INSTALL) --require-hashes -r requirements/camera.txt

# PyAV, to record and read video.
video: .venv/installed
	$(INSTALL) --require-hashes -r requirements/video.txt

# PyTorch, for `campusloop workshop train-detector`: the version whose Linux build for processors only is known to
# do. A detector that is trained already needs none of it.
training: .venv/installed
	$(BIN)/pip install --quiet --disable-pip-version-check torch==2.13.0 onnx

# rosbags, pynmeagps and pyubx2: ROS bags, and what GNSS receivers say.
workshop: .venv/installed
	$(INSTALL) --require-hashes -r requirements/workshop.txt

var/generators/installed: requirements/generators.txt
	$(PYTHON) -m venv var/generators
	var/generators/bin/$(PIP_INSTALL) --require-hashes -r requirements/generators.txt
	@touch $@

# run.txt is what running a campus takes, lock.txt all that setting up installs; oracle.txt, mutants.txt and so on
# are what those extras need besides; tracing.txt goes with run.txt.
COMPILE = $(PY) -m uv pip compile --universal --python-version 3.11 --generate-hashes --quiet --no-header \
  --no-annotate
LOCKED = $(COMPILE) pyproject.toml

lock: .venv/installed
	$(PY) -m uv --version >/dev/null 2>&1 || $(BIN)/pip install --quiet uv
	$(LOCKED) --extra dev -o requirements/lock.txt
	$(LOCKED) --extra install -c requirements/lock.txt -o requirements/run.txt
	for tool in docs generators odometry-peers sbom; do $(COMPILE) requirements/$$tool.in -o requirements/$$tool.txt || exit 1; done
	for extra in camera cluster oracle mutants video workshop; do $(LOCKED) --extra dev --extra $$extra -c requirements/lock.txt \
	  -o requirements/$$extra.txt \
	  $$(sed -n 's/^\([A-Za-z0-9._-]*\)==.*/--no-emit-package \1/p' requirements/lock.txt) || exit 1; done
	$(LOCKED) --extra tracing -c requirements/lock.txt -o requirements/tracing.txt \
	  $$(sed -n 's/^\([A-Za-z0-9._-]*\)==.*/--no-emit-package \1/p' requirements/run.txt)

# gtsam (110 MB), by which a test and `benchmarks.planner --oracle` find the path's optimum a second time.
oracle: .venv/installed
	$(INSTALL) --require-hashes -r requirements/oracle.txt

clean:
	rm -rf .venv web/node_modules web/tools/node_modules web/tools/lighthouse/node_modules web/dist var .mypy_cache .ruff_cache .pytest_cache
