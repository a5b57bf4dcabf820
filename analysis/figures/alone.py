"""Figures on a page of their own, in the report's style: for those that no report has."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from analysis.figures.svg import Drawing
from analysis.files import make_folder, write_text
from analysis.page import frame, page_environment


def write_page(
    path: Path, title: str, figures: Iterable[tuple[Drawing, str]], footer: str = ""
) -> None:
    """Write figures as one HTML file, private to its owner; a file of that name is replaced.

    Args:
        path: of the file.
        title: of the page.
        figures: each drawing with a caption; their names must differ.
        footer: what the data are, printed under every page; empty for none.

    Raises:
        StudyError: it cannot be written.
    """
    environment = page_environment()
    template = environment.get_template("figures.html.j2")
    make_folder(path.parent)
    drawn = [(drawing.markup(), caption) for drawing, caption in figures]
    around = frame(environment, footer, "")
    write_text(path, template.render(title=title, figures=drawn, footer=footer, **around))
