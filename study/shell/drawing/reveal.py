"""The reveal of a block's points: every trial as a bar, zero always in view."""

from __future__ import annotations

import math

import pygame

from study.messages import noted
from study.screens import RevealScreen
from study.shell.drawing import chrome, palette
from study.shell.drawing.canvas import Canvas

ACTION = noted("to continue")
CHANCE = noted("Starting places differ between trials, so some ups and downs are chance.")
VALUE_ROOM = 20
"""Design pixels of height for points under a bar that goes down, above the trial's number."""
LEAST_PLOT = 96
"""Design pixels of height under which bars say little: then all is drawn smaller."""
LEAST_PITCH = 26
"""Design pixels between numbers at the axis."""
FEWEST_WHOLE = 10
"""Points under which trials are shown with a decimal."""


def number_text(value: float, decimals: int = 0) -> str:
    """Return a number with a true minus and commas; never a minus before zero."""
    shown = f"{abs(value):,.{decimals}f}"
    zero = float(shown.replace(",", "")) == 0
    return f"−{shown}" if value < 0 and not zero else shown


def axis_ticks(low: float, high: float, most: int = 4) -> list[float]:
    """Return round numbers that enclose ``low`` to ``high``, zero among them, ``most`` or so."""
    span = max(high - low, 1e-9)
    power = 10.0 ** math.floor(math.log10(span / most))
    step = next(f * power for f in (1, 2, 2.5, 5, 10) if f * power >= span / most)
    first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
    return [number * step for number in range(first, last + 1)]


def _button(canvas: Canvas) -> pygame.Rect:
    right = canvas.size[0] - chrome.content_margin(canvas)
    return chrome.button_rect(canvas, canvas.say(ACTION), right, chrome.footer_rect(canvas).centery)


def targets(canvas: Canvas, screen: RevealScreen) -> list[tuple[str, pygame.Rect]]:  # noqa: ARG001
    """Return what can be clicked: the button."""
    return [("confirm", _button(canvas))]


def draw(canvas: Canvas, screen: RevealScreen) -> None:
    """Draw total, bars and what comes next."""
    u, tall = canvas.u, chrome.is_tall(canvas)
    canvas.surface.fill(palette.PAGE)
    chrome.draw_header(canvas, screen.header_left, screen.header_right)
    margin = chrome.content_margin(canvas)
    footer = chrome.draw_footer_ground(canvas)
    top = chrome.header_height(canvas) + u(40 if tall else 20)
    bottom = footer.top - u(32 if tall else 20)
    card = pygame.Rect(margin, top, canvas.size[0] - 2 * margin, bottom - top)
    canvas.box(card, u(10), palette.CARD, palette.LINE, u(1.4))
    left = card.left + u(48)
    y = card.top + u(54 if tall else 40)
    title = canvas.say("Your points in block {number}", number=screen.block)
    canvas.write(title, left, y, u(28), weight="bold", width=card.right - u(48) - left)
    size = u(126 if tall else 96)
    y += round(size * 0.3635) + u(44 if tall else 32)
    total = canvas.write(number_text(screen.total), left, y, size, weight="bold",
                         width=card.width * 0.6)  # fmt: skip
    _draw_what(canvas, screen, total.right + u(38), y, card.right - u(24))
    y += round(size * 0.3635) + u(58 if tall else 44)
    caption = canvas.write(canvas.say("Points in each trial"), left, y, u(22), weight="semibold")
    canvas.write(canvas.say("same scale in every block"), caption.right + u(14), y, u(19),
                 colour=palette.SECONDARY, width=card.right - u(38) - caption.right)  # fmt: skip
    plot = pygame.Rect(card.left + u(112), y + u(40), card.width - u(112) - u(150), 0)
    plot.height = card.bottom - u(76) - plot.top
    if min(0.0, screen.scale_low, *screen.trial_rewards) < 0:
        # A bar may end at the foot of the plot, with its points under it.
        plot.height -= u(VALUE_ROOM)
    _draw_plot(canvas, screen, plot)
    _draw_footer(canvas, screen, margin, footer)


def _draw_what(canvas: Canvas, screen: RevealScreen, x: int, y: int, right: int) -> None:
    u = canvas.u
    lines = (
        canvas.count("points, one robot,", "points, all {n} robots,", screen.robots),
        canvas.count("{n} trial", "{n} trials together", len(screen.trial_rewards)),
    )
    for line, shift in zip(lines, (-18, 18), strict=True):
        canvas.write(line, x, y + u(shift), u(24), colour=palette.SECONDARY, width=right - x)


def _draw_footer(canvas: Canvas, screen: RevealScreen, margin: int, footer: pygame.Rect) -> None:
    u = canvas.u
    button = _button(canvas)
    width = button.left - margin - u(24)
    several = len(screen.trial_rewards) > 1
    apart = u(15) if several and screen.next_hint else 0
    if several:
        canvas.write(
            canvas.say(CHANCE),
            margin,
            footer.centery - apart,
            u(19),
            colour=palette.SECONDARY,
            width=width,
        )
    if screen.next_hint:
        canvas.write(screen.next_hint, margin, footer.centery + apart, u(19), weight="semibold",
                     width=width)  # fmt: skip
    chrome.draw_button(canvas, button, canvas.say(ACTION))


def _draw_plot(canvas: Canvas, screen: RevealScreen, plot: pygame.Rect) -> None:
    u = canvas.u
    rewards = screen.trial_rewards
    ticks = axis_ticks(min(0.0, screen.scale_low, *rewards), max(0.0, screen.scale_high, *rewards))
    low, high = ticks[0], ticks[-1]
    span = max(high - low, 1e-9)

    def height_of(value: float) -> int:
        return round(plot.bottom - (value - low) / span * plot.height)

    if plot.height < u(LEAST_PLOT):
        canvas.no_room("the points of each trial")
    step = ticks[1] - ticks[0] if len(ticks) > 1 else 1.0
    every = max(1, math.ceil(u(LEAST_PITCH) * span / step / max(1, plot.height)))
    for value in ticks:
        y = height_of(value)
        canvas.surface.fill(palette.GRID, (plot.left, y, plot.width, 1))
        if round(value / step) % every:
            continue
        text = number_text(value, 0 if step >= 1 else 1)
        canvas.write(text, plot.left - u(14), y, u(18), colour=palette.SECONDARY, align="right",
                     tabular=True)  # fmt: skip
    zero = height_of(0.0)
    pitch = plot.width / max(1, len(rewards))
    width = min(u(56), round(pitch * 0.6))
    decimals = 0 if max((abs(reward) for reward in rewards), default=0) >= FEWEST_WHOLE else 1
    bars = []
    for number, reward in enumerate(rewards):
        end = height_of(reward)
        bar = pygame.Rect(0, min(zero, end), width, max(1, abs(zero - end)))
        bar.centerx = round(plot.left + (number + 0.5) * pitch)
        canvas.surface.fill(palette.BLUE, bar)
        bars.append(bar)
    average = sum(rewards) / len(rewards) if rewards else 0.0
    taken = pygame.Rect(0, 0, 0, 0)
    if len(rewards) > 1:
        taken = pygame.Rect(plot.left, height_of(average) - u(3), plot.width, u(6))
        _draw_average(canvas, plot, height_of(average), number_text(average, decimals))
    canvas.surface.fill(palette.INK, (plot.left, zero, plot.width, max(1, u(2))))
    labels = max(plot.bottom, zero) + u(22) + (u(VALUE_ROOM) if low < 0 else 0)
    for number, (bar, reward) in enumerate(zip(bars, rewards, strict=True)):
        _draw_value(canvas, bar, taken, reward, number_text(reward, decimals), pitch)
        if pitch >= u(26) or number % 5 == 0:
            canvas.write(str(number + 1), bar.centerx, labels, u(19), weight="semibold",
                         align="centre")  # fmt: skip
    canvas.write(canvas.say("Trial"), plot.centerx, labels + u(30), u(19), colour=palette.SECONDARY,
                 align="centre")  # fmt: skip


def _draw_average(canvas: Canvas, plot: pygame.Rect, y: int, text: str) -> None:
    """Draw a dashed line with a light rim, which shows on bars and between them."""
    u = canvas.u
    line = max(2, u(2.4))
    right = plot.right + u(10)
    canvas.surface.fill(palette.CARD, (plot.left, y - line, right - plot.left, 2 * line + 1))
    for x in range(plot.left, right, u(14)):
        canvas.surface.fill(palette.INK, (x, y - line // 2, min(u(9), right - x), line))
    canvas.write(canvas.say("average"), right + u(8), y - u(13), u(18), colour=palette.SECONDARY,
                 width=u(124))  # fmt: skip
    canvas.write(text, right + u(8), y + u(13), u(22), weight="bold")


def _draw_value(
    canvas: Canvas, bar: pygame.Rect, taken: pygame.Rect, reward: float, text: str, pitch: float
) -> None:
    """Write a bar's points in it or beside it, clear of the average's line.

    Args:
        canvas: to draw on.
        bar: the bar, from zero to its end.
        taken: the line of the average.
        reward: points.
        text: the same in words.
        pitch: distance between bars, pixels.
    """
    u = canvas.u
    size = u(20)
    if canvas.text_width(text, size, "bold") > pitch - 4:
        size = u(15)
    width = canvas.text_width(text, size, "bold")
    if width > pitch - 2:
        return
    foot, end = (bar.bottom, bar.top) if reward >= 0 else (bar.top, bar.bottom)
    up = -1 if reward >= 0 else 1
    places = [(end + up * u(16), palette.INK), (foot - up * u(18), palette.INK)]
    if width <= bar.width - 4 and bar.height >= u(38):
        places = [(foot + up * u(20), palette.CARD), (end - up * u(18), palette.CARD), *places]

    def box_at(y: float) -> pygame.Rect:
        box = pygame.Rect(0, 0, width + u(6), u(22))
        box.center = (bar.centerx, round(y))
        return box

    free = [place for place in places if not box_at(place[0]).colliderect(taken)]
    y, colour = (free or places)[0]
    if colour == palette.INK:
        canvas.surface.fill(palette.CARD, box_at(y))
    canvas.write(text, bar.centerx, y, size, weight="bold", colour=colour, align="centre")
