"""Write requirements/lock.txt anew: newest versions that fit pyproject.toml, with hashes.

For all platforms and Pythons from 3.11 on, with the extras, so that their tests can run.
torch is left to requirements/torch.txt.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LEFT_OUT = ("doom", "jetbot")
"""Extras that set-up leaves out: DOOM's engine may not be used commercially, MuJoCo is large."""


def main() -> int:
    """Resolve and write."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    wanted = [
        *(item for item in project["project"]["dependencies"] if not item.startswith("torch")),
        # Set-up installs the extras too: small, and the tests need them.
        *(
            item
            for name, extra in project["project"]["optional-dependencies"].items()
            if name not in LEFT_OUT
            for item in extra
        ),
        *project["dependency-groups"]["dev"],
        *(ROOT / "requirements" / "lock.in").read_text().splitlines(),
    ]
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "all.in"
        source.write_text("\n".join(wanted) + "\n")
        options = ["--universal", "--python-version", "3.11", "--generate-hashes", "--quiet"]
        plain = ["--no-header", "--no-annotate", "--upgrade"]
        target = str(ROOT / "requirements" / "lock.txt")
        command = [sys.executable, "-m", "uv", "pip", "compile", *options, *plain]
        return subprocess.run([*command, str(source), "-o", target], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
