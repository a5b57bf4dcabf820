"""A tile's plate: number, cue, health, and in a large tile the dwell and a sentence."""

from __future__ import annotations

import dataclasses

import pygame

from study.screens import Tile
from study.shell.drawing import chrome, cues, marks, palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.faces import CAP_HEIGHT
from study.shell.drawing.grid import TilePlace
from study.shell.drawing.palette import Colour

LOW_HEALTH = 30


@dataclasses.dataclass(frozen=True, slots=True)
class PlateLook:
    """What is said of a tile beside its robot's state. Two that are equal look the same.

    Attributes:
        driven: the participant drives this robot.
        suggested: it is suggested, and not driven.
        accept_key: name of the key that accepts a suggestion.
        has_dwell: a ring shows here how much of the dwell is left.
        note: a sentence in the plate of a large tile, or empty.
        key: name of the key that chooses the robot where it is not its number, or empty.
        announced: another robot may be switched to in a moment.
        has_health: the robot has health, which is shown.
        arrows: the four arrow keys drive, which the frame's bar says.
    """

    driven: bool
    suggested: bool
    accept_key: str
    has_dwell: bool
    note: str
    key: str = ""
    announced: bool = False
    has_health: bool = True
    arrows: bool = True


def plate_colour(place: TilePlace, tile: Tile, look: PlateLook) -> Colour:
    """Return the ground of a tile's plate: control first, then the cue."""
    if look.driven and not place.single:
        return palette.BLUE
    tint = cues.STYLES[tile.cue.kind].tint if tile.cue is not None else None
    if tint is not None:
        return tint
    if look.driven:
        return palette.BLUE_TINT
    return palette.ORANGE_TINT if look.suggested else palette.PLATE


@dataclasses.dataclass(frozen=True, slots=True)
class _Measures:
    """Sizes of a corner plate, pixels."""

    pad: int
    text: float
    number: float
    top: float

    @property
    def number_bottom(self) -> float:
        return self.top + CAP_HEIGHT * self.number


def _measure(canvas: Canvas, place: TilePlace) -> _Measures:
    width = place.map.width
    pad = canvas.u(22) if place.single else max(5, round(0.034 * width))
    return _Measures(
        pad=pad,
        text=min(max(15, 0.0585 * width), canvas.u(28)),
        number=min(0.147 * width, 0.40 * place.plate.height, canvas.u(168)),
        top=place.plate.top + pad * 0.9,
    )


@dataclasses.dataclass(frozen=True, slots=True)
class HealthRow:
    """Where a plate shows health.

    Attributes:
        place: of the row, pixels.
        text: size of the number, pixels.
        pad: space at either end, pixels.
    """

    place: pygame.Rect
    text: float
    pad: int


def health_row(canvas: Canvas, place: TilePlace) -> HealthRow:
    """Return where a plate shows health."""
    plate = place.plate
    if not place.has_corner_plate:
        text = _strip_text(canvas, place)
        pad = round(plate.height * 0.3)
        width = round(plate.width * 0.4)
        row = pygame.Rect(plate.right - width - pad // 2, 0, width, round(text * 1.4))
        row.centery = plate.centery
        return HealthRow(row, text, pad // 3)
    measures = _measure(canvas, place)
    inset = round(measures.pad * 0.55)
    row = pygame.Rect(0, 0, plate.width - 2 * inset, round(measures.text * 1.625))
    below = canvas.u(10) if place.single else max(3, round(0.022 * place.map.width))
    row.bottomleft = (plate.left + inset, plate.bottom - below)
    return HealthRow(row, measures.text, measures.pad - inset)


def draw_plate(canvas: Canvas, place: TilePlace, tile: Tile, look: PlateLook) -> None:
    """Write all of a plate but its health and the dwell's ring."""
    if place.has_corner_plate:
        _corner_plate(canvas, place, tile, look)
    else:
        _strip_plate(canvas, place, tile, look)


def draw_dwell(canvas: Canvas, place: TilePlace, robot: int, left: float) -> None:
    """Draw the ring of the dwell, of which a share of 0 to 1 is left."""
    plate = place.plate
    if not place.has_corner_plate:
        pad = round(plate.height * 0.3)
        radius = plate.height * 0.34
        number = canvas.text_width(str(robot + 1), plate.height * 0.78, "bold")
        x, y = plate.left + 2 * pad + number + radius, float(plate.centery)
    elif place.single:
        x, y, radius = _large_ring(canvas, place)
    else:
        measures = _measure(canvas, place)
        radius = max(7, 0.036 * place.map.width)
        x = plate.right - measures.pad - radius
        y = measures.top + radius if place.bar else measures.number_bottom + radius * 1.6
    thickness = radius * (0.26 if place.single else 0.34)
    marks.draining_ring(canvas, x, y, radius, thickness, left)


def _large_ring(canvas: Canvas, place: TilePlace) -> tuple[float, float, float]:
    """Return middle and radius of the ring in a large tile's plate, pixels."""
    pad = _measure(canvas, place).pad
    radius = min(canvas.u(42), 0.12 * place.plate.width)
    x = place.plate.right - pad - max(radius, canvas.u(52))
    return x, place.plate.top + pad + radius, radius


def _number_colour(place: TilePlace, look: PlateLook) -> Colour:
    if not look.driven:
        return palette.INK
    return palette.BLUE_DARK if place.single else palette.CARD


def _corner_plate(canvas: Canvas, place: TilePlace, tile: Tile, look: PlateLook) -> None:
    plate = place.plate
    measures = _measure(canvas, place)
    pad, text = measures.pad, measures.text
    wrote = canvas.write(
        str(tile.robot + 1), plate.left + pad, measures.top + CAP_HEIGHT / 2 * measures.number,
        measures.number, weight="bold", colour=_number_colour(place, look),
    )  # fmt: skip
    health = health_row(canvas, place).place
    roomy = health.top - wrote.bottom > text * 1.7
    if tile.cue is None or roomy:
        _beside_number(canvas, place, wrote, look)
    if tile.cue is not None and not roomy:
        right = plate.right - pad * 0.5
        room = (right - wrote.right - 2) / cues.SIGN_EDGE
        cues.draw_sign(canvas, tile.cue, right, wrote.centery, max(9, min(text, room)))
    elif tile.cue is not None:
        middle = (wrote.bottom + health.top) / 2
        if place.single:
            middle = wrote.bottom + text * 1.5
        room = plate.width - pad * 1.4
        cues.draw_pill(canvas, tile.cue, plate.left + pad, middle, text * 0.96, room)
    if place.single:
        # Where a cue's pill comes is left free, so that the sentence never moves.
        _large_plate(canvas, place, look, wrote.bottom + round(text * 2.3), health.top)


def _beside_number(canvas: Canvas, place: TilePlace, number: pygame.Rect, look: PlateLook) -> None:
    """Write what shares the line with the number: YOU without a bar, or the robot's key."""
    plate, measures = place.plate, _measure(canvas, place)
    pad = measures.pad
    room = plate.right - pad * 1.3 - number.right
    if look.driven and not place.bar:
        # Where even small letters do not fit, frame, floor and shape tell the driven robot.
        if not canvas.fits(canvas.say("YOU"), measures.text, room, "bold"):
            return
        canvas.write(
            canvas.say("YOU"), plate.right - pad * 0.8, number.centery, measures.text,
            weight="bold", colour=palette.CARD, align="right", width=room,
        )  # fmt: skip
    elif look.key and not look.driven:
        cap = max(28, 0.075 * place.map.width)
        name = chrome.key_tokens(look.key)[0]
        left = plate.right - pad * 0.7 - chrome.cap_width(canvas, name, cap)
        if left > number.right + 2:
            chrome.draw_cap(canvas, name, left, number.centery, cap)


def _large_plate(canvas: Canvas, place: TilePlace, look: PlateLook, under: int, above: int) -> None:
    """Add a caption, and a sentence between two heights, to a large tile's plate."""
    plate, pad = place.plate, _measure(canvas, place).pad
    if look.has_dwell:
        x, y, radius = _large_ring(canvas, place)
        canvas.write(
            canvas.say("next switch"), x, y + radius + canvas.u(24), canvas.u(19),
            colour=palette.SECONDARY, align="centre", width=2 * (plate.right - canvas.u(8) - x),
        )  # fmt: skip
    if look.note:
        size, gap = canvas.u(22), canvas.u(8)
        width = plate.width - 2 * pad
        height = canvas.paragraph_height(look.note, width, size)
        top = max(under + gap, above - height - canvas.u(24))
        room = pygame.Rect(plate.left + pad, top, width, above - gap - top)
        used = canvas.paragraph(look.note, room, size, colour=palette.SECONDARY)
        if used > room.height + 1:
            # Never against the edge of what is below: the screen is tried at a smaller scale.
            canvas.no_room(look.note)


def _strip_plate(canvas: Canvas, place: TilePlace, tile: Tile, look: PlateLook) -> None:
    """Write number and cue, left of health, in one row above a map that fills its bounds."""
    plate = place.plate
    text = _strip_text(canvas, place)
    pad = round(plate.height * 0.3)
    wrote = canvas.write(
        str(tile.robot + 1), plate.left + pad, plate.centery, plate.height * 0.78,
        weight="bold", colour=_number_colour(place, look),
    )  # fmt: skip
    health = health_row(canvas, place).place
    left = wrote.right + pad + (round(plate.height * 0.68) + pad if look.has_dwell else 0)
    if tile.cue is not None:
        cues.draw_pill(canvas, tile.cue, left, plate.centery, text * 0.85, health.left - left - 4)
    elif look.driven and not place.bar and not look.has_dwell:
        canvas.write(canvas.say("YOU"), left, plate.centery, text, weight="bold",
                     colour=palette.CARD, width=health.left - left - 4)  # fmt: skip


def _strip_text(canvas: Canvas, place: TilePlace) -> float:
    """Return the size of text in a plate that is one row, pixels."""
    plate = place.plate
    return min(max(canvas.u(15), 0.0585 * plate.width), 0.62 * plate.height, canvas.u(28))


def draw_health(canvas: Canvas, row: HealthRow, tile: Tile, *, boxed: bool) -> None:
    """Draw a health bar and its number; what was just lost is hatched.

    Args:
        canvas: to draw on.
        row: where.
        tile: whose health.
        boxed: whether the row needs a white ground.
    """
    place, text, pad = row.place, row.text, row.pad
    if boxed:
        canvas.box(place, canvas.u(3), palette.CARD)
    number = canvas.text_width("100", text, "semibold", tabular=True)
    shown = f"{max(0.0, tile.health):.0f}"
    right = place.right - pad
    canvas.write(shown, right, place.centery, text, weight="semibold", align="right", tabular=True)
    height = max(canvas.u(9), round(text * 0.66))
    length = right - number - round(text * 0.4) - place.left - pad
    bar = pygame.Rect(place.left + pad, 0, max(8, length), height)
    bar.centery = place.centery
    edge = max(1, round(height * 0.1))
    canvas.box(bar, canvas.u(2), palette.CARD, palette.INK, edge)
    inside = bar.inflate(-2 * edge, -2 * edge)
    # As much as the number says: rows that say the same look the same.
    share = min(1.0, max(0.0, round(tile.health) / 100))
    colour = palette.VERMILLION if tile.health < LOW_HEALTH else palette.GREEN
    filled = round(inside.width * share)
    canvas.surface.fill(colour, (inside.left, inside.top, filled, inside.height))
    if tile.cue is not None and tile.cue.kind == "damage":
        lost = round(inside.width * min(1.0 - share, abs(round(tile.cue.amount, 1)) / 100))
        if lost > 1:
            place = pygame.Rect(inside.left + filled, inside.top, lost, inside.height)
            _lost_health(canvas, place, inside.width)


def _lost_health(canvas: Canvas, place: pygame.Rect, longest: int) -> None:
    """Hatch a piece of a health bar. The longest there may be is painted once, for all pieces."""
    pitch = max(4, round(place.height * 0.5))

    def paint(surface: pygame.Surface, k: float) -> None:
        surface.fill(palette.CARD)
        height = place.height * k
        for x in range(round(-height), round(longest * k), round(pitch * k)):
            marks.thick_line(
                surface, palette.VERMILLION, [(x, height), (x + height, 0)], pitch * 0.45 * k
            )

    sprite = canvas.sprite(("lost", longest, place.height), longest, place.height, paint)
    canvas.surface.blit(sprite, place, (0, 0, *place.size))
