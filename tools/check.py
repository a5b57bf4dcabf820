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
    "import-linter": ["import_linter"],
}


def main() -> int:
    """Run the checks in turn; all of them, so that one run shows every problem."""
    failed = []
    for name, (module, *arguments) in CHECKS.items():
        if module == "import_linter":
            command = [str(Path(sys.executable).with_name("lint-imports"))]
        else:
            command = [sys.executable, "-m", module, *arguments]
        print(f"== {name}", flush=True)
        quiet = {**os.environ, "COLUMNS": "100"}
        if subprocess.run(command, cwd=ROOT, env=quiet, check=False).returncode:
            failed.append(name)
    if failed:
        print(f"Failed: {', '.join(failed)}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
