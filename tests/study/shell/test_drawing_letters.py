"""Every letter is seen: those that Inter lacks in another font, and a box for what no font has."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
import pygame
import pytest
from hypothesis import given
from hypothesis import strategies as st

import sample_screens as samples
from fake_shell import FakeShell
from short_study import opened
from study.events.inputs import TextTyped
from study.loading import load_protocol
from study.questionnaire import LONGEST_TEXT
from study.screens import PageScreen, SurveyScreen
from study.shell.drawing import faces, fallback, lettering, palette, survey
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.drawn import Written
from study.shell.drawing.lettering import (
    fitting_end,
    line_ascent,
    line_surface,
    text_width,
    wrap,
)
from study.shell.drawing.renderer import Renderer

pytestmark = pytest.mark.usefixtures("fonts")

SIZE = (1280, 720)
GREETINGS = "Привет שלום مرحبا Ελλάδα Հայ ქართული Việt 你好"
NO_FONT_HAS = "你好ไन𠀀\U0001f680\ue000\U0010fffd"
INK = (0, 0, 0)
WEIGHTS: tuple[faces.Weight, ...] = ("medium", "semibold", "bold")

own_text = st.text(st.sampled_from(sorted(faces._own_letters())), max_size=60)
any_text = st.one_of(
    st.text(max_size=40),
    st.text(st.characters(exclude_categories=()), max_size=40),
    st.text(
        st.sampled_from(
            "a7 é.(Жёяשםًب٣ლἄ\u0301\u0323\u200b\u200c\u200d\u202e\ufe0f你😀\0\n\t\x7f\xad"
        ),
        max_size=40,
    ),
)


@pytest.fixture(scope="module")
def remarks() -> FakeShell:
    """A session that has come to the page of remarks."""
    order = ("manual", "assisted", "suggested", "switched_at_random")
    shell = FakeShell(opened(load_protocol("every_screen"), order=order))
    shell.go_on_until(
        lambda: isinstance(shell.screen, SurveyScreen) and shell.screen.title == "In your own words"
    )
    return shell


class Page:
    """The page of remarks as a window shows it."""

    def __init__(self, shell: FakeShell) -> None:
        self.shell, self.surface, self.renderer = shell, pygame.Surface(SIZE), Renderer(SIZE)
        while self.typed:
            shell.key("backspace")

    @property
    def screen(self) -> SurveyScreen:
        """What the session shows."""
        assert isinstance(self.shell.screen, SurveyScreen)
        return self.shell.screen

    @property
    def typed(self) -> str:
        """What stands in the field."""
        return self.screen.items[0].typed

    def type(self, text: str) -> None:
        """Type letters at once, and draw the page."""
        self.shell.feed(TextTyped(self.shell.later(1_000_000), text))
        self.renderer.draw(self.surface, self.screen, 0)
        assert self.renderer.overflows == []

    def field(self) -> pygame.Rect:
        """The inside of the field, clear of its border."""
        box = survey.card_places(self.renderer.canvas, self.screen)[0].boxes[0]
        return box.inflate(-16, -8)

    def ink(self) -> npt.NDArray[np.float64]:
        """How dark each pixel of the field is, without the caret; its first axis goes right."""
        place = self.field()
        pixels = pygame.surfarray.array3d(self.surface.subsurface(place)).astype(int)
        pixels[(pixels == palette.BLUE_DARK).all(axis=2)] = palette.CARD
        return np.asarray(255 - pixels.mean(axis=2))

    def caret(self) -> int:
        """The caret's left edge, pixels of the window."""
        place = self.field()
        pixels = pygame.surfarray.array3d(self.surface.subsurface(place))
        (columns,) = (pixels == palette.BLUE_DARK).all(axis=2)[:, place.height // 2].nonzero()
        assert columns.size
        return place.left + int(columns[0])

    def line(self) -> Written:
        """What was written last into the field."""
        return next(
            line
            for line in reversed(self.renderer.canvas.written)
            if line.text and self.typed.endswith(line.text)
        )


def test_every_letter_typed_leaves_ink_and_moves_the_caret(remarks: FakeShell) -> None:
    """One after another, in every script; the caret stands right of what is drawn."""
    page = Page(remarks)
    ink, caret = 0.0, 0
    for letter in GREETINGS:
        page.type(letter)
        after, line = page.ink(), page.line()
        if letter != " ":
            assert after.sum() > ink, letter
        # Arabic letters become narrower where the next one joins them.
        assert page.caret() > caret or letter in "مرحبا"
        ink, caret = float(after.sum()), page.caret()
        assert caret == line.place.right + page.renderer.canvas.u(3)
        (columns,) = (after.max(axis=1) > 60).nonzero()
        # Light at the edge of a stroke may lie a pixel beyond.
        assert page.field().left + columns[-1] <= line.place.right
        assert page.field().left + columns[0] >= line.place.left - 1
    assert page.typed == GREETINGS
    size = page.renderer.canvas.u(21)
    assert page.line().place.width == text_width(GREETINGS, "medium", size)


@pytest.mark.parametrize("letter", sorted({*GREETINGS, *"Жيאὧ\u0301ế☺😀🚀√"} - {" "}))
def test_each_letter_alone_is_seen(remarks: FakeShell, letter: str) -> None:
    page = Page(remarks)
    page.type(letter)
    assert page.ink().max() > 120


@pytest.mark.parametrize("word", ["Съешь ещё ", "Ξεσκεπάζω ", "שלום ", "مرحبا ", "你好 "])
def test_a_long_remark_shows_its_end_within_the_field(remarks: FakeShell, word: str) -> None:
    page = Page(remarks)
    page.type(word * LONGEST_TEXT)
    assert len(page.typed) == LONGEST_TEXT
    assert page.typed.endswith(page.line().text)
    field = page.field()
    assert field.left <= page.line().place.left < page.caret() < field.right
    # As much as there is room for.
    size = page.renderer.canvas.u(21)
    more = page.typed[-len(page.line().text) - 1 :]
    room = survey.card_places(page.renderer.canvas, page.screen)[0].boxes[0].width
    assert text_width(more, "medium", size) > room - page.renderer.canvas.u(40)


def test_what_is_typed_is_not_kept(remarks: FakeShell) -> None:
    """Memory does not grow with remarks, whatever letters they are of."""
    page = Page(remarks)
    page.type("Я")
    kept = len(lettering._LINES)
    for number in range(300):
        page.type(chr(ord("а") + number % 32))
    assert len(lettering._LINES) == kept
    assert fallback.stretches.cache_info().currsize <= 64


@pytest.mark.parametrize("weight", WEIGHTS)
def test_what_no_font_has_is_a_box_for_each_character(weight: faces.Weight) -> None:
    line = line_surface(NO_FONT_HAS, weight, 24, INK)
    boxes = pygame.mask.from_surface(line, 100).connected_components()
    assert len(boxes) == len(NO_FONT_HAS)
    assert len({box.count() for box in boxes}) == 1
    assert fallback.lacking(f"a Ж {NO_FONT_HAS}", weight) == set(NO_FONT_HAS)


@pytest.mark.parametrize("weight", WEIGHTS)
@pytest.mark.parametrize("script", ["Съешь ещё этих булок", "Ξεσκεπάζω την ψυχή", "Tiếng Việt"])
def test_long_texts_are_wrapped_by_what_is_drawn(weight: faces.Weight, script: str) -> None:
    text = " ".join([script] * 20)
    lines = wrap(text, weight, 22, 400)
    assert " ".join(lines) == text
    assert len(lines) > 5
    widths = [line_surface(line, weight, 22, INK).get_width() for line in lines]
    assert max(widths) <= 400
    assert min(widths[:-1]) > 200


def test_a_page_of_another_script_fits() -> None:
    """Titles, paragraphs, questions and options are shown whole, as in English."""
    english, kinds = (samples.samples()[name] for name in ("page_text", "survey_kinds"))
    assert isinstance(english, PageScreen)
    assert isinstance(kinds, SurveyScreen)
    page = dataclasses.replace(
        english,
        title="Добро пожаловать",
        paragraphs=("Вы будете управлять роботами. " * 8, "מה צריך לעשות. " * 8, "مرحبا " * 40),
    )
    options = ("Никогда", "Несколько раз в год", "Πάντα", "כל יום", "كل أسبوع")
    items = tuple(
        dataclasses.replace(item, text="Как часто вы играете?", options=item.options and options)
        for item in kinds.items
    )
    for screen in (page, dataclasses.replace(kinds, items=items)):
        renderer = Renderer(SIZE)
        renderer.draw(pygame.Surface(SIZE), screen, 0)
        assert renderer.overflows == []


@pytest.mark.parametrize("tall", ["ẾỄ", "Ж", "שלום", "你", "\u0301\u0301"])
def test_all_stands_on_one_baseline(tall: str) -> None:
    """A letter with two accents is taller than its font: it is not cut, and moves no other."""
    for size in range(12, 60):
        line, alone = (line_surface(text, "bold", size, INK) for text in (f"{tall} H", "H"))
        bottoms = []
        for picture, text in ((line, f"{tall} H"), (alone, "H")):
            width = faces.font("bold", size).size("H")[0]
            letter = picture.subsurface(
                (picture.get_width() - width, 0, width, picture.get_height())
            )
            box = pygame.mask.from_surface(letter, 100).get_bounding_rects()[0]
            bottoms.append(box.bottom - line_ascent(text, "bold", size))
        assert bottoms[0] == bottoms[1]


def test_scripts_from_right_to_left_are_laid_in_their_stretch() -> None:
    """The first letter of a word stands right; what is beside the word stays where it was typed."""
    assert fallback.stretches("a שלום עולם 12 مرحبا, b", "medium") == (
        ("own", "a "), ("Hebr", "שלום עולם"), ("own", " 12 "), ("Arab", "مرحبا,"), ("own", " b"),
    )  # fmt: skip
    if not _joins():
        pytest.skip("pygame was built without HarfBuzz here")
    line, first = (line_surface(text, "medium", 40, INK) for text in ("שי", "ש"))
    right = line.subsurface((line.get_width() - first.get_width(), 0, *first.get_size()))
    apart = np.subtract(*(pygame.surfarray.array_alpha(it).astype(int) for it in (right, first)))
    assert np.abs(apart).mean() < 8


def _joins() -> bool:
    try:
        pygame.font.Font(None, 12).set_script("Arab")
    except pygame.error:
        return False
    return True


def test_without_harfbuzz_letters_from_right_to_left_are_seen_all_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class Plain(pygame.font.Font):
        def set_direction(self, direction: int) -> None:
            raise pygame.error("HarfBuzz is not there")

    monkeypatch.setattr(pygame.font, "Font", Plain)
    line = line_surface("مرحبا שלום", "medium", 30, INK)
    assert line.get_width() == text_width("مرحبا שלום", "medium", 30)
    assert pygame.mask.from_surface(line, 100).count() > 200


def test_a_word_is_written_in_one_font() -> None:
    """An accent becomes one with its letter, or is taken apart from it, as the font has them."""
    assert fallback.stretches("Tiếng cafe\u0301 x", "medium") == (
        ("other", "Tiếng"), ("own", " café x"),
    )  # fmt: skip
    assert fallback.stretches("\u06c0", "bold") == (("Arab", "\u06d5\u0654"),)
    assert fallback.stretches("ok你ok.", "bold") == (("own", "ok"), ("box", "你"), ("own", "ok."))


def test_a_running_number_beside_other_letters_stands_still() -> None:
    """All digits are equally wide there too."""
    widths = {text_width(f"{n} секунд", "bold", 22, tabular=True) for n in range(10, 100)}
    assert len(widths) == 1
    for number in (11, 48):
        text = f"{number} с"
        drawn = line_surface(text, "bold", 22, INK, tabular=True)
        assert drawn.get_width() == text_width(text, "bold", 22, tabular=True)


@pytest.mark.parametrize("weight", WEIGHTS)
def test_the_fonts_have_the_letters_that_their_tables_name(weight: faces.Weight) -> None:
    """Against their pictures: what a font lacks has the same one as a character that is none."""
    own, other = faces.font(weight, 200), faces.other_font(weight, 200)
    for used, letters in ((own, faces._own_letters()), (other, faces.other_letters(weight))):
        (missing,) = used.metrics("\uffff")
        named = [letter for letter in sorted(letters) if letter.isprintable() and letter != " "]
        assert len(named) > 300
        outlines = used.metrics("".join(named))
        assert [one for one, found in zip(named, outlines, strict=True) if found == missing] == []
        others = [c for c in map(chr, range(0x21, 0x3000)) if c not in letters and c != "\xad"]
        assert {tuple(found or ()) for found in used.metrics("".join(others))} == {missing}
    assert faces._own_letters() <= faces.other_letters(weight)


@given(any_text, st.sampled_from(WEIGHTS), st.integers(8, 60), st.booleans())
def test_any_text_is_measured_and_drawn(
    text: str, weight: faces.Weight, size: int, tabular: bool
) -> None:
    """As wide as it was measured; no character stops a picture."""
    width = text_width(text, weight, size, tabular=tabular)
    assert width >= 0
    drawn = line_surface(text, weight, size, INK, tabular=tabular)
    assert drawn.get_width() == width
    assert drawn.get_height() >= line_ascent(text, weight, size) > 0
    assert " ".join(wrap(text, weight, size, 200)).split() == text.split()
    end = fitting_end(text, weight, size, 100)
    assert text.endswith(end)
    assert text_width(end, weight, size) <= 100
    canvas = Canvas((400, 300))
    canvas.write(text, 5, 50, size, weight=weight, width=300, tabular=tabular)
    canvas.paragraph(text, pygame.Rect(5, 80, 300, 200), size, weight=weight)


@given(own_text, st.sampled_from(WEIGHTS), st.integers(8, 60))
def test_lines_of_inter_alone_are_what_the_font_renders(
    text: str, weight: faces.Weight, size: int
) -> None:
    """Pixel by pixel; the end that fits is found as by leaving out one letter after another."""
    used = faces.font(weight, size)
    plain, line = (
        used.render(text, antialias=True, color=INK),
        line_surface(text, weight, size, INK),
    )
    assert pygame.image.tobytes(line, "RGBA") == pygame.image.tobytes(plain, "RGBA")
    assert text_width(text, weight, size) == used.size(text)[0]
    end = text
    while end and used.size(end)[0] > 150:
        end = end[1:]
    assert fitting_end(text, weight, size, 150) == end
