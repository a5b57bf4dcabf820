"""The pages stage: text to read, forwards and backwards; also the last screen."""

from __future__ import annotations

from study.events.inputs import Input, KeyChanged, PointerPressed
from study.screens import EndScreen, PageScreen, Screen
from study.session.context import Context, Outbox
from study.session.effects import Show
from study.session.page_texts import pages
from study.session.plan import PagesPlan
from study.session.stage import QuietStage


class PagesStage(QuietStage):
    """One or more pages."""

    kind = "pages"

    def __init__(self, plan: PagesPlan, context: Context) -> None:
        self._plan = plan
        self._context = context
        self._pages = pages(plan, context)
        self._index = 0

    def enter(self, t_ns: int, out: Outbox) -> bool:  # noqa: ARG002 - stages are entered alike
        """Show the first page; there may be nothing to explain."""
        return not self._pages

    def handle(self, given: Input, out: Outbox) -> bool:
        """Turn pages."""
        keys = self._context.protocol.keys
        if isinstance(given, KeyChanged) and given.down:
            # The session cannot pause on its last screen: there the pause key closes it.
            forward = given.key == keys.confirm or (
                given.key == keys.pause and self._plan.name == "thanks"
            )
            back = given.key == keys.back
        elif isinstance(given, PointerPressed):
            forward = given.target == "confirm"
            back = given.target == "back"
        else:
            return False
        if forward:
            self._index += 1
        elif back and self._index > 0:
            self._index -= 1
        else:
            return False
        if self._index == len(self._pages):
            return True
        out.effects.append(Show(self.screen()))
        return False

    def screen(self) -> Screen:
        """Return the page."""
        page = self._pages[min(self._index, len(self._pages) - 1)]
        if self._plan.name == "thanks":
            return EndScreen(title=page.title, text=page.subtitle)
        count = len(self._pages)
        description = self._context.description
        return PageScreen(
            header_left=page.header,
            header_right=self._context.say(
                "Page {page} of {pages}", page=self._index + 1, pages=count
            )
            if count > 1
            else "",
            title=page.title,
            subtitle=page.subtitle,
            paragraphs=page.paragraphs,
            figure=page.figure,
            scene=description.scene if page.figure else None,
            rewards=description.rewards if page.figure == "map" else (),
            timesteps_per_second=self._context.protocol.timing.timesteps_per_second,
            robots=page.robots,
            can_go_back=self._index > 0,
            next_hint=page.next_hint,
            action=page.action,
            robot_keys=self._context.protocol.keys.robots[: page.robots],
            has_health=description.health_field >= 0,
        )
