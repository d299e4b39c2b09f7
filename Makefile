# Each target does its own set-up on a bare Debian machine with Rust, then runs.

PACKAGES := g++ pkg-config libbullet-dev libclang-dev

# What opens reports, which has to have a font.
BROWSER := chromium fonts-dejavu-core

# What the viewer is bundled from: https://threejs.org, and what bundles it.
THREE := three@0.187.0
ESBUILD := esbuild@0.28.2

# Sequences of random calls for the sanitizer, and for valgrind, which is slower.
ASAN_SEQUENCES ?= 5000
VALGRIND_SEQUENCES ?= 1500

.PHONY: help demo test builds-test browser-test contributing-test docs man crash-test import-oracles workers-test \
  cluster-test examples-test dist dist-test deb lockstep-test verify-lockstep lint bench bench-mujoco \
  bench-pybullet python-test notebook tensorboard-test asan valgrind contact-sheet three setup

help:
	@echo "make demo      train Svenja for some minutes, and show what came out"
	@echo "make test      the tests"
	@echo "make builds-test  tests of other builds: double precision, without Bullet, optimised"
	@echo "make browser-test  reports and replays as a browser shows them"
	@echo "make contributing-test  what CONTRIBUTING.md adds, built and tested in a copy"
	@echo "make docs      the tables of settings in docs/, from the code that reads them"
	@echo "make crash-test  training killed at 200 random moments"
	@echo "make workers-test  64 workers at the same moment, 100 times; 200 killed; 10,000 cells"
	@echo "make cluster-test  workers on a Slurm cluster of two nodes on this machine (as root)"
	@echo "make examples-test  what docs/clusters.md shows for Snakemake and GNU parallel"
	@echo "make dist      an archive of the program that runs on any x86-64 Linux"
	@echo "make dist-test that archive in an empty root and in an older Debian (as root)"
	@echo "make deb       a Debian package of the program"
	@echo "make lockstep-test  lanes against Bullet's own solver, longer than in make test"
	@echo "make verify-lockstep  the same with Svenja, 100,000 steps a lane (half an hour or more)"
	@echo "make import-oracles  imported robots against MuJoCo and PyBullet (needs python3-venv)"
	@echo "make contact-sheet  pictures of the robots in ROBOTS on one page"
	@echo "make lint      formatting and clippy, as strict as CI"
	@echo "make bench     what things cost, beside plain code that does the same"
	@echo "make bench-mujoco  a physics step of Svenja beside MuJoCo's"
	@echo "make bench-pybullet  steps a second of Svenja beside PyBullet's"
	@echo "make python-test  the package for Python: built, installed and tested"
	@echo "make notebook  docs/notebook.ipynb, executed anew"
	@echo "make tensorboard-test  exported event files, read by TensorBoard"
	@echo "make asan      fuzzing with the C++ shim under AddressSanitizer"
	@echo "make valgrind  the bullet crate's tests under valgrind"
	@echo "make three     bundle three.js for the viewer again (needs npm)"

# The program first, so that its build doesn't run into its progress bars.
demo: setup
	cargo build --release --bin itarl
	@code=0; target/release/itarl train experiments/quick.toml --out runs/quick || code=$$?; \
	  test $$code -eq 75 && echo "stopped; the same command goes on"; exit $$code
	target/release/itarl summary runs/quick
	target/release/itarl plot runs/quick
	@echo "next: target/release/itarl rollout runs/quick/cells/xi=0.75/seed=1"
	target/release/itarl report runs/quick
	@echo "the report: open $(CURDIR)/runs/quick/report.html in a browser"

test: setup
	cargo test --workspace

# What else the crates can be built as: with Bullet in double precision, without Bullet, and optimised,
# since the compiler's choices mustn't change a bit.
builds-test: setup
	cargo test -p bullet --features float64
	LOCKSTEP_STEPS=60 cargo test -p svenja --features float64 --test lockstep --test spawn
	cargo test -p svenja --no-default-features
	cargo test --release -p crbm -p gpomdp -p infotheory

browser-test: PACKAGES += $(BROWSER)
browser-test: setup
	cargo test -p runner --test report

# What CONTRIBUTING.md adds is built in a copy of the repository.
contributing-test: setup
	cargo test -p runner --test contributions

# Without WRITE_DOCS this test says whether the tables are those of the code.
docs: setup
	WRITE_DOCS=1 cargo test -p runner --lib the_tables_of_the_page_are_those_of_the_code

# Killed at 200 random moments, and the same bytes in the end.
crash-test: setup
	CRASHES=200 cargo test --release -p runner --test program crash::

workers-test: setup
	STARTS=100 CRASHES=200 CELLS=10000 cargo test --release -p runner --test program workers::

# munged, slurmctld and two slurmd, all with their files in a temporary folder and on the loopback.
cluster-test: PACKAGES += slurm-wlm munge
cluster-test: setup
	cargo build --release --bin itarl
	tests/cluster/cluster.sh target/release/itarl

examples-test: PACKAGES += parallel snakemake
examples-test: setup
	cargo build --release --bin itarl
	tests/cluster/examples.sh target/release/itarl

ARCHIVE = target/dist/itarl-$(shell sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml)-x86_64-linux.tar.gz
dist: setup
	cargo build --release --bin itarl
	dist/pack.sh target/release/itarl $(ARCHIVE)

# Manual pages, for the Debian package.
man: setup
	cargo build --release --bin itarl
	target/release/itarl man --out target/man

# Debian 11 has glibc 2.31, from 2020.
OLDER := target/dist/bullseye
dist-test: PACKAGES += debootstrap
dist-test: dist
	test -e $(OLDER)/etc/debian_version || debootstrap --variant=minbase bullseye $(OLDER)
	dist/test.sh target/release/itarl $(ARCHIVE) $(OLDER)

# For the Debian that it's built on, whose Bullet it needs.
deb: man
	command -v cargo-deb >/dev/null || cargo install --locked cargo-deb
	dist/licences.sh target/licences
	cargo deb --package runner --locked --strip

# What others make of the same files. They're installed in a folder of their own, from PyPI.
ORACLES := target/oracles
import-oracles: PACKAGES += python3-venv
import-oracles: setup
	test -x $(ORACLES)/bin/pip || python3 -m venv $(ORACLES)
	$(ORACLES)/bin/pip install --quiet mujoco pybullet
	cargo test -p formats --test oracles -- --nocapture

# To be looked at: no legs torn off, feet where they belong.
ROBOTS ?= models tests/robots
SHEET := target/robots
contact-sheet: setup
	cargo build --release --bin itarl
	tests/contact-sheet.sh target/release/itarl $(SHEET) $(ROBOTS)
	@echo "the contact sheet: open $(CURDIR)/$(SHEET)/index.html in a browser"

# Every model for 20 s of its life, random robots and scenes by the thousand, in both precisions.
lockstep-test: setup
	LOCKSTEP_STEPS=2000 cargo test --release -p svenja --test lockstep
	LOCKSTEP_STEPS=2000 cargo test --release -p svenja --features float64 --test lockstep
	PROPTEST_CASES=5000 cargo test --release -p bullet --test lockstep
	PROPTEST_CASES=5000 cargo test --release -p bullet --features float64 --test lockstep

# Prints how many steps were compared, and what became of them.
VERIFY_STEPS ?= 100000
verify-lockstep: setup
	LOCKSTEP_STEPS=$(VERIFY_STEPS) cargo test --release -p svenja --test lockstep -- \
	  --exact svenja --nocapture

# Warnings of our C++ are errors here and in CI alone: another compiler's mustn't keep anyone from
# building.
lint: export CXXFLAGS := $(strip $(filter-out -Werror,$(CXXFLAGS)) -Werror)
lint: setup
	cargo fmt --all --check
	cargo clippy --workspace --all-targets -- -D warnings
	cargo clippy -p bullet --all-targets --features float64 -- -D warnings
	cargo clippy -p svenja --all-targets --no-default-features -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps

bench: setup
	cargo bench --workspace

# MuJoCo comes from PyPI, into a folder of its own below target/.
bench-mujoco: PACKAGES += python3-venv
bench-mujoco: setup
	cargo build --release --bin itarl
	test -x target/mujoco/bin/python || python3 -m venv target/mujoco
	target/mujoco/bin/pip install -q mujoco
	target/mujoco/bin/python python/benches/mujoco_step.py models/svenja.toml target/release/itarl

# The package for Python, built by pip where the workspace is built, so that they share what both need,
# and installed into an environment below target/.
PYTHON := target/python
PIP_INSTALL = test -x $(PYTHON)/bin/pip || python3 -m venv $(PYTHON); \
	CARGO_TARGET_DIR=$(CURDIR)/target $(PYTHON)/bin/pip install --quiet

python-test: PACKAGES += python3-venv
python-test: setup
	cargo build --bin itarl
	$(PIP_INSTALL) --config-settings build-args="--profile dev" './python[test]'
	$(PYTHON)/bin/python -m pytest -q python/tests

bench-pybullet: PACKAGES += python3-venv
bench-pybullet: setup
	$(PIP_INSTALL) pybullet './python[test]'
	$(PYTHON)/bin/python python/benches/pybullet_step.py models/svenja.toml

# The run that it reads is one of experiments/results, so that it takes seconds.
notebook: PACKAGES += python3-venv
notebook: setup
	$(PIP_INSTALL) nbconvert ipykernel matplotlib './python[test]'
	$(PYTHON)/bin/python -m jupyter nbconvert --to notebook --inplace --execute \
	  --ExecutePreprocessor.record_timing=False docs/notebook.ipynb

# TensorBoard comes from PyPI, into a folder of its own below target/.
tensorboard-test: PACKAGES += python3-venv
tensorboard-test: setup
	cargo build --bin itarl
	test -x target/tensorboard/bin/python || python3 -m venv target/tensorboard
	target/tensorboard/bin/pip install -q tensorboard 'setuptools<81'
	for run in experiments/results/*; do \
	  target/debug/itarl export $$run --tensorboard target/tensorboard/events/$$run && \
	  target/tensorboard/bin/python tests/event_files.py $$run target/tensorboard/events/$$run || exit 1; \
	done

# --target keeps the flags away from build scripts; the library must be the first one loaded.
SANITIZED = CARGO_TARGET_DIR=target/asan UBSAN_OPTIONS=print_stacktrace=1 \
	FUZZ_SEQUENCES=$(ASAN_SEQUENCES) \
	CXXFLAGS="-fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer" \
	RUSTFLAGS="-Clink-arg=-Wl,--no-as-needed -Clink-arg=-lasan -Clink-arg=-lubsan" \
	cargo test -p bullet --test fuzz --test refusals --test lockstep \
	  --target $$(rustc -vV | sed -n 's/^host: //p') \
	  --config "target.'cfg(all())'.runner=['env', 'LD_PRELOAD=$$(g++ -print-file-name=libasan.so)']"

asan: setup
	$(SANITIZED)
	$(SANITIZED) --features float64

VALGRIND = cargo test -p bullet --tests --config \
	"target.'cfg(all())'.runner=['valgrind', '-q', '--error-exitcode=9', '--leak-check=full', '--show-leak-kinds=definite', '--errors-for-leak-kinds=definite']"

valgrind: PACKAGES += valgrind
valgrind: setup
	FUZZ_SEQUENCES=$(VALGRIND_SEQUENCES) $(VALGRIND)
	FUZZ_SEQUENCES=$(VALGRIND_SEQUENCES) $(VALGRIND) --features float64

# The bundle is in the repository, so that nothing else needs npm.
ASSETS := crates/scenes/assets/three
three:
	@command -v npm >/dev/null || { echo "make three needs npm (Debian's package of that name)"; exit 1; }
	rm -rf target/three && mkdir -p target/three
	cp $(ASSETS)/three.js target/three/
	cd target/three && npm init -y >/dev/null && npm install --no-save $(THREE) $(ESBUILD)
	cd target/three && npx esbuild three.js --bundle --minify --format=iife --global-name=THREE \
	  --legal-comments=inline --outfile=three.min.js \
	  --banner:js='/* $(THREE), https://threejs.org, MIT: see LICENSE beside this file */'
	cp target/three/three.min.js target/three/node_modules/three/LICENSE $(ASSETS)/

# Installs what is missing, and asks for no password if nothing is. A machine that has just started
# updates itself, so another apt may hold a lock, which apt waits for with some locks only.
APT_ATTEMPTS ?= 60
APT_PAUSE ?= 10
setup:
	@missing=""; \
	for package in $(PACKAGES); do \
	  dpkg-query -W -f='$${Status}' $$package 2>/dev/null | grep -q "ok installed" \
	    || missing="$$missing $$package"; \
	done; \
	if [ -z "$$missing" ]; then exit 0; fi; \
	if ! command -v apt-get >/dev/null; then \
	  echo "itarl needs$$missing (names of Debian's packages)"; exit 1; \
	fi; \
	if [ "$$(id -u)" = 0 ]; then sudo=""; \
	elif command -v sudo >/dev/null; then sudo="sudo"; \
	else echo "itarl needs: apt-get install$$missing (as root)"; exit 1; fi; \
	echo "installing$$missing"; \
	log=$$(mktemp); trap 'rm -f "$$log"' EXIT; \
	apt() { \
	  for attempt in $$(seq $(APT_ATTEMPTS)); do \
	    code=0; $$sudo env DEBIAN_FRONTEND=noninteractive LC_ALL=C apt-get "$$@" 2>"$$log" || code=$$?; \
	    cat "$$log" >&2; \
	    test $$code -ne 0 && grep -q "Could not get lock" "$$log" || return $$code; \
	    echo "another apt is at work; waiting for it"; sleep $(APT_PAUSE); \
	  done; \
	  return $$code; \
	}; \
	apt update -q && apt install -q -y --no-install-recommends $$missing
