"""Write requirements/lock.txt anew: newest versions that fit pyproject.toml, with hashes.

For all platforms and Pythons from 3.11 on, with the extras, so that their tests can run. Extras
that set-up leaves out unless asked have locks of their own, which agree with it. torch is left to
requirements/torch.txt.
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
REQUIREMENTS = ROOT / "requirements"


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
    status = resolve(wanted, REQUIREMENTS / "lock.txt")
    for name in LEFT_OUT:
        extra = project["project"]["optional-dependencies"][name]
        status = status or resolve(extra, REQUIREMENTS / f"{name}.txt", within="lock.txt")
    return status


def resolve(wanted: list[str], target: Path, within: str = "") -> int:
    """Write a lock of what is wanted, and of all that needs; return uv's exit status.

    Args:
        wanted: requirements.
        target: the file.
        within: another lock, whose versions are kept to.
    """
    options = ["--universal", "--python-version", "3.11", "--generate-hashes", "--quiet"]
    plain = ["--no-header", "--no-annotate", "--upgrade"]
    if within:
        plain += ["--constraint", str(REQUIREMENTS / within)]
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "all.in"
        source.write_text("\n".join(wanted) + "\n")
        command = [sys.executable, "-m", "uv", "pip", "compile", *options, *plain]
        return subprocess.run([*command, str(source), "-o", str(target)], check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
