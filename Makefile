# Every target does its own set-up: the first run makes the virtual environment, later runs find it.

# The Python to build on: 3.11 first, the newest that has a wheel of PyBullet. make PYTHON=... takes
# another one.
ifndef PYTHON
PYTHON := $(shell for name in python3.11 python3.10 python3 python; do \
	"$$name" -c 'import sys; sys.exit(sys.version_info < (3, 10))' 2>/dev/null \
	&& command -v "$$name" && break; done)
endif
VENV ?= .venv
# Further arguments of `lagrangian_ff demo` and of pytest, e.g. make test ARGS=test/kernels
ARGS ?=
# Tests of processes that talk to each other. Some may come late: one after the other, they share the
# processors with the numerics. The others are kept from those. What takes longest comes first.
PATIENT = test/nodes/test_your_robot.py test/nodes/test_ros_rig.py \
	test/nodes/test_feedforward_action.py test/demo test/workbench/test_investigate_live.py \
	test/nodes/test_familiar.py test/nodes/test_other_arm.py \
	test/nodes/test_identify_services.py test/nodes/test_job_work.py
# The soak keeps a processor busy: beside it comes what is least in a hurry.
BEFORE = test/nodes/test_soak.py test/nodes/test_identify_node.py test/nodes/test_fault_table.py
PROMPT = $(BEFORE) test/workbench/test_live_page.py \
	$(filter-out $(PATIENT) $(BEFORE),$(wildcard test/nodes/test_*.py))
# What the environment holds beside the requirements; extras of setup.py.
EXTRAS = ros,arm,bags,threads
# Without these limits a worker that crashed, or a test that hangs, leaves pytest waiting for ever.
SIDE_BY_SIDE = --dist loadfile --max-worker-restart 0 --timeout 900 --durations 12

BIN = $(VENV)/bin
SOURCES = lagrangian_ff test benchmark launch tools docs/conf.py setup.py
# A ROS that is sourced in this shell belongs to another Python, and would be found before our own.
ifdef ROS_DISTRO
unexport PYTHONPATH LD_LIBRARY_PATH AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH
endif
unexport _ROS_WHEELS_BOOTSTRAP_COMPLETE
# Containers often forbid bytecode: each of hundreds of processes would compile NumPy and SciPy again.
unexport PYTHONDONTWRITEBYTECODE
export RMW_IMPLEMENTATION = rmw_fastrtps_cpp

define environment
@test -n "$(PYTHON)" || { \
	echo "No Python 3.10 or newer found. Install Python 3.11, or name one:" >&2; \
	echo "make $@ PYTHON=/path/to/python3.11" >&2; exit 2; }
@"$(PYTHON)" tools/environment.py "$(VENV)" --extras
endef

.DEFAULT_GOAL := help
.PHONY: help demo workbench test test-oldest wheels lint types interfaces format fuzz soak benchmark docs docs-output install clean

help:  ## list the targets
	@echo "make TARGET, where TARGET is one of"
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  %-12s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

demo:  ## record, identify and drive the simulated arm over ROS 2; pictures in out/
	$(environment) $(EXTRAS)
	@$(BIN)/lagrangian_ff demo $(ARGS)

workbench:  ## the page: a simulated arm hides an effect, ready to be found
	$(environment) $(EXTRAS)
	@$(BIN)/lagrangian_ff workbench --try --session out/workbench $(ARGS)

test:  ## everything CI checks: style, types, then all tests
	@$(MAKE) --no-print-directory --jobs 3 lint types interfaces
ifdef ARGS
	@$(BIN)/python -m pytest $(ARGS)
else
	@$(BIN)/python -m pytest $(SIDE_BY_SIDE) --numprocesses 3 $(addprefix --one-worker=,$(PATIENT)) \
		$(PATIENT) test/studies test $(addprefix --ignore=,$(PROMPT))
	@$(BIN)/python -m pytest $(SIDE_BY_SIDE) --numprocesses 2 $(PROMPT)
endif

test-oldest:  ## the tests with the oldest supported libraries, those of Ubuntu 24.04
	@$(MAKE) --no-print-directory VENV=.venv-oldest install CONSTRAINTS=constraints-ubuntu-24.04.txt
	@.venv-oldest/bin/python -m pytest $(ARGS)

wheels:  ## build the wheel with every Python from 3.10 to 3.13 here, and use it outside the sources
	@"$(PYTHON)" tools/wheels.py $(ARGS)

docs:  ## the documentation as a site, in out/docs; warnings are errors
	$(environment) $(EXTRAS),docs
	@$(BIN)/python -m sphinx -q -b html -W --keep-going -n docs out/docs
	@echo "out/docs/index.html"

docs-output:  ## run every command of the documentation, write the outputs that it shows
	$(environment) $(EXTRAS),test,docs
	@$(BIN)/python tools/doc_commands.py $(ARGS)

install:  ## only make the environment
	$(environment) $(EXTRAS),test,docs $(addprefix --constraints ,$(CONSTRAINTS))

lint: install  ## check style
	@$(BIN)/ruff check $(SOURCES)
	@$(BIN)/ruff format --check $(SOURCES)

types: install  ## check types
	@$(BIN)/mypy

interfaces: install
	@$(BIN)/python test/nodes/built_interfaces.py

format: install  ## put the sources into the one format
	@$(BIN)/ruff check --fix $(SOURCES)
	@$(BIN)/ruff format $(SOURCES)

fuzz:  ## damaged files for readers, random messages for nodes; ARGS="--seconds 900", ARGS="csv model"
	$(environment) $(EXTRAS),test
	@$(BIN)/python -c 'import atheris' 2>/dev/null || $(BIN)/python -m pip install --quiet \
		--only-binary :all: 'atheris >=2.3, <4' 2>/dev/null || \
		echo "There is no wheel of atheris for this Python: hypothesis searches without coverage."
	@PYTHONPATH=tools $(BIN)/python -m fuzz $(ARGS)
ifndef ARGS
	@RANDOM_MESSAGES=10000 $(BIN)/python -m pytest -q test/nodes/test_random_messages.py
endif

soak:  ## all nodes for half an hour: memory, files, lateness and what was lost, in out/soak
	$(environment) $(EXTRAS)
	@$(BIN)/python tools/soak.py $(ARGS)

benchmark:  ## measure speed against named yardsticks
	$(environment) ros,benchmark
	@for script in $(filter-out %/timing.py %/held_out.py %/alarm.py,$(wildcard benchmark/*.py)); do echo "== $$script"; $(BIN)/python "$$script" || exit 1; done

clean:  ## remove what the build and the tests left; keeps .venv, the loops and out/
	rm -rf build install log dist .pytest_cache .mypy_cache .ruff_cache .hypothesis .coverage
	rm -rf lagrangian_ff.egg-info docs/reference
	find lagrangian_ff test benchmark tools launch -name __pycache__ -prune -exec rm -rf {} + 2>/dev/null || true
