"""Write the summary of an experiment's results into docs/results.

python tools/write_results.py RESULTS [--command COMMAND] [--wall-time WORDS]
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from analysis.experiment.frames import load_experiment
from analysis.experiment.summary import markdown
from study.errors import StudyError

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "results"


def main(arguments: list[str]) -> int:
    """Write one page; say where."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path, help="folder of the results")
    parser.add_argument("--command", default="", help="what ran them, if not the default")
    parser.add_argument("--wall-time", default="not noted", help="how long the run took, in words")
    given = parser.parse_args(arguments)
    try:
        experiment = load_experiment(given.results)
    except StudyError as error:
        print(error, file=sys.stderr)
        return error.exit_status
    name = str(experiment.protocol["experiment"]["name"])
    development = experiment.results.head.seeds == "development"
    command = given.command or f"study experiment {name}" + " --development" * development
    FOLDER.mkdir(exist_ok=True)
    path = FOLDER / f"{name}{'-development' * development}.md"
    path.write_text(markdown(experiment, command, given.wall_time), encoding="utf-8")
    _list_pages()
    print(path)
    return 0


def _list_pages() -> None:
    """Bring the list of pages in the folder's README up to date."""
    readme = FOLDER / "README.md"
    kept = [
        line
        for line in readme.read_text(encoding="utf-8").splitlines()
        if not line.startswith("- ")
    ]
    pages = sorted(path.name for path in FOLDER.glob("*.md") if path != readme)
    lines = [f"- [{name.removesuffix('.md')}]({name})" for name in pages]
    readme.write_text("\n".join([*kept, *lines]).rstrip() + "\n", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
