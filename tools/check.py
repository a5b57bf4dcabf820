"""Run every static check; say which failed. Part of `make test`."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CHECKS = {
    "ruff check": ["ruff", "check", "."],
    "ruff format": ["ruff", "format", "--check", "."],
    "mypy": ["mypy"],
    "import-linter": ["lint-imports"],
    "pre-commit": ["pre-commit", "validate-config"],
    "reference docs": ["python", "tools/write_reference.py", "--check"],
}


def main() -> int:
    """Run the checks in turn; all of them, so that one run shows every problem."""
    failed = []
    programs = Path(sys.executable).parent
    environment = {**os.environ, "COLUMNS": "100"}
    for name, (program, *arguments) in CHECKS.items():
        print(f"== {name}", flush=True)
        command = [str(programs / program), *arguments]
        if subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode:
            failed.append(name)
    if failed:
        print(f"Failed: {', '.join(failed)}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
