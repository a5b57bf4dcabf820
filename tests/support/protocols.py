"""Variants of the shipped protocols, for tests."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

SHORT_CARTS = (
    ("episodes = 4", "episodes = 1"),
    ("timesteps = 200", "timesteps = 20"),
    ("trials = 2", "trials = 1"),
    ("trial_timesteps = 300", "trial_timesteps = 40"),
    ("epochs = 100", "epochs = 2"),
    ("at_least = 4", "at_least = 2"),
)
"""Changes that make protocols/cart_pole.toml short."""
FASTER_CARTS = ("timesteps_per_second = 10.0", "timesteps_per_second = 20.0")
SHORT_ICE = (
    ("episodes = 4", "episodes = 1"),
    ("timesteps = 200", "timesteps = 5"),
    ("trials = 2", "trials = 1"),
    ("trial_timesteps = 120", "trial_timesteps = 25"),
    ("epochs = 100", "epochs = 2"),
    ("at_least = 4", "at_least = 2"),
)
"""Changes that make protocols/frozen_lake.toml short."""


def variant(folder: Path, *changes: tuple[str, str], base: str = "smoke") -> Path:
    """Write a shipped protocol with texts replaced; each must be there to be replaced."""
    text = (ROOT / "protocols" / f"{base}.toml").read_text()
    for old, new in changes:
        assert old in text, f"{base}.toml has no {old!r}"
        text = text.replace(old, new)
    path = folder / f"{base}_variant.toml"
    path.write_text(text)
    return path


def erratic(folder: Path) -> Path:
    """Write the smoke protocol with two robots on the task that is never twice the same."""
    text = (ROOT / "protocols" / "smoke.toml").read_text()
    start, end = text.index("[task]"), text.index("[policy]")
    text = text[:start] + '[task]\nname = "erratic"\non_end = "reset"\n\n' + text[end:]
    text = text.replace("robots = 12", "robots = 2").replace("robots = 4", "robots = 2")
    path = folder / "erratic.toml"
    path.write_text(text)
    return path


def jetbots(folder: Path, robots_file: Path | None) -> Path:
    """Write the smoke protocol with two JetBots; simulated within the study without a file."""
    text = (ROOT / "protocols" / "smoke.toml").read_text()
    start, end = text.index("[task]"), text.index("[policy]")
    link = f'link = "{robots_file}"\n' if robots_file else ""
    task = '[task]\nname = "jetbot"\non_end = "reset"\n\n[task.parameters]\n'
    task += f"timesteps_per_second = 10.0\nepisode_seconds = 3.0\n{link}\n"
    text = text[:start] + task + text[end:]
    for old, new in [
        ("robots = 12", "robots = 2"),
        ("robots = 4", "robots = 2"),
        ("episodes = 2", "episodes = 1"),
        ("trials = 2\n", "trials = 1\n"),
        ("dwell = 15", "dwell = 5"),
    ]:
        assert old in text, old
        text = text.replace(old, new)
    path = folder / "jetbots.toml"
    path.write_text(text)
    return path


def in_doom(folder: Path, *changes: tuple[str, str], base: str = "smoke") -> Path:
    """Write a shipped protocol on the task navigation, with DOOM in its place."""
    rooms = (('name = "navigation"', 'name = "doom"'), ("noise = 0.03", "noise = 0.0"))
    return variant(folder, *rooms, *changes, base=base)


def lap_study(folder: Path, robots_file: Path | None, *, name: str = "lap_study") -> Path:
    """Write the lap study in a short form: every stage, some twenty seconds of driving.

    Args:
        folder: where it goes.
        robots_file: robots behind the link; None simulates them within the study.
        name: of the file.
    """
    base = "jetbot" if robots_file else "jetbot_simulated"
    text = (ROOT / "protocols" / f"{base}.toml").read_text()
    changes = [
        ("\n[practice]\ntimesteps = 300\n", "\n[practice]\ntimesteps = 20\n"),
        ("episodes = 4\nepisode_timesteps = 500\n", "episodes = 2\nepisode_timesteps = 30\n"),
        ("trials = 4\ntrial_timesteps = 325\n", "trials = 2\ntrial_timesteps = 30\n"),
        ("trials = 5\ntrial_timesteps = 600\n", "trials = 2\ntrial_timesteps = 60\n"),
        ("dwell = 50\n", "dwell = 20\n"),
        ("at_least = 10\n", "at_least = 4\n"),
    ]
    if robots_file:
        changes.append(('link = "robots.toml"', f'link = "{robots_file}"'))
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    path = folder / f"{name}.toml"
    path.write_text(text)
    return path
