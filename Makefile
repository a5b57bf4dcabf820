# Thin: every target is one command that the README also shows for machines without make.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
LOCK := requirements/lock.txt requirements/torch.txt
STAMP := $(VENV)/.set-up

.PHONY: doom jetbot demo test check acceptance lock clean

# TASK=doom, TASK=jetbot (robots that are simulated) or another protocol; see `study validate`.
EXTRA_doom := doom
EXTRA_jetbot := jetbot
EXTRA_jetbot_simulated := jetbot
PROTOCOL = $(if $(filter jetbot,$(TASK)),jetbot_simulated,$(TASK))

demo: $(STAMP) $(EXTRA_$(TASK))
	$(BIN)/study demo $(if $(TASK),--protocol $(PROTOCOL))

test: $(STAMP)
	$(BIN)/python tools/check.py
	$(BIN)/python -m pytest -n 2 -m "not acceptance"

check: $(STAMP)
	$(BIN)/python tools/check.py

acceptance: $(STAMP)
	$(BIN)/python -m pytest -m acceptance

# Extras that set-up leaves out, each from a lock of its own.
doom: $(STAMP)
	$(PYTHON) tools/set_up.py doom

jetbot: $(STAMP)
	$(PYTHON) tools/set_up.py jetbot

# Set up anew only when the lock or the package's own metadata change.
$(STAMP): $(LOCK) pyproject.toml tools/set_up.py
	$(PYTHON) tools/set_up.py

lock: $(STAMP)
	$(BIN)/python tools/lock.py

clean:
	rm -rf $(VENV) .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
