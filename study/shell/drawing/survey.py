"""A questionnaire: the focus is a ring around a card, an answer is a fill with a tick."""

from __future__ import annotations

import dataclasses
from itertools import pairwise

import pygame

from study.messages import noted
from study.screens import SurveyItem, SurveyScreen
from study.shell.drawing import answers, chrome, marks, palette
from study.shell.drawing.canvas import Canvas

CARD_HEIGHT = 280
SMALLEST_CARD = 160
"""Design pixels of height under which the lines of a question touch one another."""
ACTION = noted("to confirm")


@dataclasses.dataclass(frozen=True, slots=True)
class CardPlace:
    """Where a question's parts go, pixels.

    Attributes:
        card: the whole question.
        question: its sentence.
        boxes: one an answer, from the lowest; of a number its field, then the keys beside it.
        labels: middle of the first line of the words under the boxes.
        status: middle of the line that says what was answered.
    """

    card: pygame.Rect
    question: pygame.Rect
    boxes: tuple[pygame.Rect, ...]
    labels: int
    status: int


def _title_height(canvas: Canvas) -> int:
    return canvas.u(136 if chrome.is_tall(canvas) else 108)


def _gap(canvas: Canvas) -> int:
    return canvas.u(24 if chrome.is_tall(canvas) else 16)


def _card_height(canvas: Canvas, screen: SurveyScreen) -> int:
    """Return the height of each question's card, pixels: smaller where there are many."""
    top = chrome.header_height(canvas) + _title_height(canvas)
    room = chrome.footer_rect(canvas).top - canvas.u(20) - top
    count = max(1, len(screen.items))
    return min(canvas.u(CARD_HEIGHT), (room - _gap(canvas) * (count - 1)) // count)


def _block_top(canvas: Canvas, screen: SurveyScreen) -> int:
    count = len(screen.items)
    cards = count * _card_height(canvas, screen) + max(0, count - 1) * _gap(canvas)
    return chrome.block_top(canvas, _title_height(canvas) + cards + canvas.u(20))


def card_places(canvas: Canvas, screen: SurveyScreen) -> list[CardPlace]:
    """Return the places of the questions, one below the other."""
    margin = chrome.content_margin(canvas)
    top = _block_top(canvas, screen) + _title_height(canvas)
    height, gap = _card_height(canvas, screen), _gap(canvas)
    places = []
    for number, item in enumerate(screen.items):
        card = pygame.Rect(
            margin, top + number * (height + gap), canvas.size[0] - 2 * margin, height
        )
        places.append(_card_place(canvas, item, card))
    return places


def _card_place(canvas: Canvas, item: SurveyItem, card: pygame.Rect) -> CardPlace:
    u = canvas.u
    share = card.height / u(CARD_HEIGHT)
    count = len(answers.values(item))
    row = pygame.Rect(card.left + u(30), 0, card.width - 2 * u(30), 0)
    # Without words under the answers these take the room of them.
    row.height, status = round(u(82) * share), round(u(250) * share)
    if not item.labels:
        row.height, status = round(u(100) * share), round(u(234) * share)
    row.top = card.top + round(u(94) * share)
    pitch = row.width / count
    width = answers.box_width(item, pitch, u(98))
    boxes = tuple(
        pygame.Rect(round(row.left + (place + 0.5) * pitch - width / 2), row.top, width, row.height)
        for place in range(count)
    )
    return CardPlace(
        card=card,
        question=pygame.Rect(
            card.left + u(40), card.top + round(u(20) * share), card.width - 2 * u(40),
            round(u(50) * share),
        ),
        boxes=answers.number_boxes(canvas, row) if item.kind == "number" else boxes,
        labels=card.top + round(u(208) * share),
        status=card.top + status,
    )  # fmt: skip


def _button(canvas: Canvas) -> pygame.Rect:
    right = canvas.size[0] - chrome.content_margin(canvas)
    return chrome.button_rect(canvas, canvas.say(ACTION), right, chrome.footer_rect(canvas).centery)


def targets(canvas: Canvas, screen: SurveyScreen) -> list[tuple[str, pygame.Rect]]:
    """Return what can be clicked: questions, answers and the button."""
    found: list[tuple[str, pygame.Rect]] = []
    for item, place in zip(screen.items, card_places(canvas, screen), strict=True):
        found.append((f"focus:{item.item}", place.card))
        if item.kind == "number":
            found += zip(answers.number_targets(item), place.boxes[1:], strict=True)
        if answers.is_typed(item):
            continue
        found += [
            (f"answer:{item.item}:{value}", box)
            for value, box in zip(answers.values(item), place.boxes, strict=True)
        ]
    return [*found, ("confirm", _button(canvas))]


def draw(canvas: Canvas, screen: SurveyScreen) -> None:
    """Draw the questions."""
    u = canvas.u
    canvas.surface.fill(palette.PAGE)
    chrome.draw_header(canvas, screen.header_left, screen.header_right)
    margin = chrome.content_margin(canvas)
    width = canvas.size[0] - 2 * margin
    tall = chrome.is_tall(canvas)
    top = _block_top(canvas, screen)
    canvas.write(screen.title, margin, top + u(60 if tall else 46), u(36), weight="bold",
                 width=width)  # fmt: skip
    canvas.write(screen.prompt, margin, top + u(101 if tall else 82), u(22),
                 colour=palette.SECONDARY, width=width)  # fmt: skip
    places = card_places(canvas, screen)
    if places and places[0].card.height < u(SMALLEST_CARD):
        canvas.no_room("the questions")
    for number, place in enumerate(places):
        focused = number == screen.focus
        _draw_card(canvas, screen.items[number], place, screen.first + number, focused=focused)
        reminder = screen.reminder if focused else ""
        _draw_status(canvas, screen.items[number], place, reminder, focused=focused)
    _draw_footer(canvas, screen, margin)


def _draw_card(
    canvas: Canvas, item: SurveyItem, place: CardPlace, number: int, *, focused: bool
) -> None:
    u = canvas.u
    edge = palette.BLUE if focused else palette.LINE
    canvas.box(place.card, u(10), palette.CARD, edge, u(3.4) if focused else u(1.4))
    question = place.question
    colour = palette.BLUE_DARK if focused else palette.SECONDARY
    canvas.write(str(number), question.left, question.centery, u(26), weight="bold",
                 colour=colour)  # fmt: skip
    indent = u(32) if number < 10 else u(48)
    _draw_question(canvas, item.text, question, indent)
    if not answers.is_plain(item):
        answers.draw(canvas, item, place.boxes, focused=focused)
        _draw_labels(canvas, item, place)
        return
    middle = place.boxes[0].centery
    canvas.surface.fill(
        palette.EDGE, (place.boxes[0].centerx, middle - 1, place.boxes[-1].centerx
                       - place.boxes[0].centerx, max(1, u(1.5)))
    )  # fmt: skip
    for step, box in enumerate(place.boxes):
        value = answers.values(item)[step]
        _draw_answer(canvas, box, value, chosen=item.value == value, focused=focused)
    _draw_labels(canvas, item, place)


def _draw_question(canvas: Canvas, text: str, place: pygame.Rect, indent: int) -> None:
    """Write a question on one line, or on two smaller ones."""
    size = canvas.u(26)
    room = pygame.Rect(place.left + indent, place.top, place.width - indent, place.height)
    if canvas.text_width(text, size, "semibold") <= room.width:
        canvas.write(text, room.left, room.centery, size, weight="semibold")
        return
    size = canvas.u(21)
    height = canvas.paragraph_height(text, room.width, size, "semibold")
    room.inflate_ip(0, canvas.u(16))
    room.top += max(0, (room.height - height) // 2)
    canvas.paragraph(text, room, size, weight="semibold")


def _draw_answer(
    canvas: Canvas, box: pygame.Rect, value: int, *, chosen: bool, focused: bool
) -> None:
    u = canvas.u
    if chosen and focused:
        ring = box.inflate(2 * u(9), 2 * u(9))
        canvas.box(ring, u(14), palette.CARD, palette.INK, u(4))
    fill = palette.BLUE if chosen else palette.CARD
    edge = palette.BLUE_DARK if chosen else palette.EDGE
    canvas.box(box, u(8), fill, edge, u(2))
    canvas.write(
        str(value), box.centerx, box.centery, min(u(34), box.height * 0.5), weight="bold",
        colour=palette.CARD if chosen else palette.INK, align="centre",
    )  # fmt: skip
    if chosen:
        radius = u(16)
        x, y = box.right - u(2), box.top + u(2)
        marks.ring(canvas, x, y, radius, u(2.4), palette.BLUE_DARK, fill=palette.CARD)
        marks.tick(canvas, x, y, radius * 1.15, palette.BLUE_DARK, radius * 0.19)


def _draw_labels(canvas: Canvas, item: SurveyItem, place: CardPlace) -> None:
    """Write the words of the scale under their answers, wrapped to what room there is."""
    u = canvas.u
    length = place.boxes[-1].centerx - place.boxes[0].centerx
    pitch = length / max(1, len(place.boxes) - 1)
    labelled = sorted(value for value, _ in item.labels)
    steps = [b - a for a, b in pairwise(labelled)]
    room = min([u(300), *(step / item.step * pitch - u(14) for step in steps)])
    for value, words in item.labels:
        if not item.low <= value <= item.high:
            continue
        x = place.boxes[(value - item.low) // item.step].centerx
        width = min(room, 2 * (x - place.card.left - u(8)), 2 * (place.card.right - u(8) - x))
        size = u(19)
        if canvas.text_width(words, size) <= width:
            canvas.write(words, x, place.labels, size, align="centre")
            continue
        area = pygame.Rect(0, place.labels - u(14), int(width), place.status - place.labels + u(4))
        area.centerx = x
        canvas.paragraph(words, area, u(16), align="centre")


def _draw_status(
    canvas: Canvas, item: SurveyItem, place: CardPlace, reminder: str, *, focused: bool
) -> None:
    u = canvas.u
    x, y = place.card.centerx, place.status
    if reminder and item.value is None:
        canvas.write(reminder, x, y, u(19), weight="semibold", colour=palette.VERMILLION_TEXT,
                     align="centre", width=place.card.width - u(40))  # fmt: skip
        return
    if special := answers.status(canvas, item, focused=focused):
        text = special
    elif item.value is not None:
        text = canvas.say("You chose {number}. You can still change it.", number=item.value)
    elif focused:
        text = canvas.say("Press a number from {low} to {high}.", low=item.low, high=item.high)
    else:
        text = canvas.say("Not answered yet")
    # A number that is left although it is none of those allowed.
    wrong = item.kind == "number" and bool(item.typed) and item.value is None and not focused
    colour = palette.VERMILLION_TEXT if wrong else palette.SECONDARY
    canvas.write(text, x, y, u(19), colour=colour, align="centre",
                 width=place.card.width - u(40))  # fmt: skip


def _draw_footer(canvas: Canvas, screen: SurveyScreen, margin: int) -> None:
    u = canvas.u
    footer = chrome.draw_footer_ground(canvas)
    first = screen.items[0]
    hints = [
        (f"{first.low}–{min(first.high, 9)}", canvas.say("answer")),
        ("← →", canvas.say("move")),
    ]
    if answers.is_typed(first):
        hints = []
    if len(screen.items) > 1:
        hints.append(("Tab", canvas.say("next question")))
    tail = canvas.say("or use the mouse") if hints else ""
    right = _button(canvas).left - u(24)
    chrome.draw_hints(canvas, hints, tail, margin, right, footer.centery)
    focus = screen.focus >= len(screen.items)
    chrome.draw_button(
        canvas, _button(canvas), canvas.say(ACTION), ready=screen.complete, focus=focus
    )
