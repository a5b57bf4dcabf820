"""What every page has: one file with its style, fonts and script, and nothing from elsewhere."""

from __future__ import annotations

import base64
import hashlib
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from analysis import formatting

TEMPLATES = Path(__file__).parent / "templates"
FONTS = (("regular", 400, "normal"), ("semibold", 600, "normal"), ("italic", 400, "italic"))


def page_environment() -> Environment:
    """Return the templates, with all text from data escaped."""
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(
        number=formatting.number,
        fraction=formatting.fraction,
        p_value=formatting.p_value,
        interval=formatting.interval,
        degrees=formatting.degrees,
        statistic=formatting.statistic,
        equation=formatting.equation,
        effect=formatting.effect,
        effect_symbol=formatting.effect_symbol,
        listed=formatting.listed,
        scorer_name=formatting.scorer_name,
        utc=formatting.utc,
    )
    return environment


def frame(environment: Environment, footer: str, protocol_sha256: str) -> dict[str, Any]:
    """Return what a page's template needs around its content: style, script and policy.

    Args:
        environment: of `page_environment`.
        footer: what the data are, printed on every page; empty for none.
        protocol_sha256: hexadecimal.
    """
    style = environment.get_template("style.css.j2").render(
        fonts=[(name, weight, slant, _font(name)) for name, weight, slant in FONTS],
        footer=footer,
        protocol=_hexadecimal(protocol_sha256)[:12],
    )
    script = (TEMPLATES / "script.js").read_text(encoding="utf-8")
    # Both are our own templates, filled with numbers and hexadecimal digits only.
    return {
        "style": Markup(style),  # noqa: S704
        "script": Markup(script),  # noqa: S704
        "policy": _security_policy(style, script),
    }


def _security_policy(style: str, script: str) -> str:
    """Allow what the page carries itself, by hash, and nothing from anywhere else."""
    return "; ".join(
        [
            "default-src 'none'",
            "img-src data:",
            "font-src data:",
            f"style-src 'sha256-{_digest(style)}'",
            f"script-src 'sha256-{_digest(script)}'",
            "base-uri 'none'",
            "form-action 'none'",
        ]
    )


def _digest(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _font(name: str) -> str:
    content = (TEMPLATES / "fonts" / f"inter-{name}.woff2").read_bytes()
    return f"data:font/woff2;base64,{base64.b64encode(content).decode()}"


def _hexadecimal(text: str) -> str:
    return "".join(letter for letter in text.lower() if letter in "0123456789abcdef")
