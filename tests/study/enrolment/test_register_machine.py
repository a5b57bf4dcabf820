"""Whatever happens to sessions, orders stay balanced, and no slot has two holders."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from hypothesis import settings
from hypothesis.stateful import (
    Bundle,
    RuleBasedStateMachine,
    consumes,
    initialize,
    invariant,
    multiple,
    rule,
)

from study.enrolment import editing
from study.enrolment.participants import HOLDING, Participant
from study.enrolment.process_identity import ProcessIdentity
from study.enrolment.register import Register

STUDY = "machine"
AB, BA = ("a", "b"), ("b", "a")
PLANNED = 12
MEMORY = Path("/dev/shm")  # noqa: S108 - a folder of the test's own in it


class Enrolment(RuleBasedStateMachine):
    """Sessions that start, end, crash, are resumed, and participants who are marked.

    ``model`` says what each participant must be, from the rules alone: state and order.
    """

    reserved = Bundle("reserved")
    running = Bundle("running")
    interrupted = Bundle("interrupted")
    complete = Bundle("complete")
    dropped = Bundle("dropped")
    excluded = Bundle("excluded")

    @initialize()
    def make(self) -> None:
        """Begin with an empty register."""
        self.folder = Path(tempfile.mkdtemp(dir=MEMORY if MEMORY.is_dir() else None))
        self.dead: set[int] = set()
        self.pid = 0
        self.model: dict[str, tuple[str, tuple[str, ...]]] = {}
        self.processes: dict[str, int] = {}
        self.before_mark: dict[str, str] = {}
        self.register = self._as(0)

    def _as(self, pid: int) -> Register:
        return Register(
            self.folder,
            me=ProcessIdentity("here", pid, "x"),
            alive=lambda process: process.pid not in self.dead,
        )

    def _conduct(self, pseudonym: str) -> Register:
        """Return the register as the process that conducts a participant's session."""
        return self._as(self.processes[pseudonym])

    def _set(self, pseudonym: str, state: str) -> str:
        self.model[pseudonym] = (state, self.model[pseudonym][1])
        return pseudonym

    def _known(self, pseudonym: str) -> Participant:
        known = self.register.find(STUDY, pseudonym)
        assert known is not None
        return known

    def difference(self) -> int:
        """Return |AB - BA| over those who hold a slot."""
        held = [order for state, order in self.model.values() if state in HOLDING]
        return abs(held.count(AB) - held.count(BA))

    def reserve(self) -> str:
        """Reserve as a new process; the order must mend what there is to mend."""
        # What has no living process is given up by the next reservation.
        for pseudonym, (state, _) in list(self.model.items()):
            if state == "reserved" and self.processes[pseudonym] in self.dead:
                del self.model[pseudonym]
        before = self.difference()
        self.pid += 1
        with self._as(self.pid) as register:
            got = register.reserve(STUDY, [AB, BA])
        assert got.pseudonym not in self.model
        self.model[got.pseudonym] = ("reserved", got.order)
        self.processes[got.pseudonym] = self.pid
        assert self.difference() <= max(1, before - 1)
        return got.pseudonym

    @rule(target=reserved)
    def start(self) -> str:
        """A session is started."""
        return self.reserve()

    @rule(pseudonym=consumes(reserved))
    def crash_before_recording(self, pseudonym: str) -> None:
        """The process dies before anything is recorded."""
        self.dead.add(self.processes[pseudonym])

    @rule(pseudonym=consumes(reserved))
    def decline(self, pseudonym: str) -> None:
        """Consent is not given."""
        with self._conduct(pseudonym) as register:
            register.release(STUDY, pseudonym)
        del self.model[pseudonym]

    @rule(target=running, pseudonym=consumes(reserved))
    def record(self, pseudonym: str) -> str:
        """The recording begins."""
        with self._conduct(pseudonym) as register:
            register.start(STUDY, pseudonym)
        return self._set(pseudonym, "running")

    @rule(target=complete, pseudonym=consumes(running))
    def finish(self, pseudonym: str) -> str:
        """Every stage was passed."""
        with self._conduct(pseudonym) as register:
            register.finish(STUDY, pseudonym, "complete")
        return self._set(pseudonym, "complete")

    @rule(target=dropped, pseudonym=consumes(running))
    def drop_out(self, pseudonym: str) -> str:
        """The participant stops."""
        with self._conduct(pseudonym) as register:
            register.finish(STUDY, pseudonym, "dropped", "stopped by the participant")
        return self._set(pseudonym, "dropped")

    @rule(target=interrupted, pseudonym=consumes(running))
    def crash(self, pseudonym: str) -> str:
        """The process is killed: the session keeps its slot."""
        self.dead.add(self.processes[pseudonym])
        return pseudonym

    @rule(target=running, pseudonym=consumes(interrupted))
    def resume_interrupted(self, pseudonym: str) -> str:
        """The session goes on in its slot and order."""
        return self.resume(pseudonym)

    def resume(self, pseudonym: str) -> str:
        """Take a session up that broke off."""
        before = self._known(pseudonym)
        assert before.interrupted
        self._resume(pseudonym)
        assert self._known(pseudonym).slot == before.slot
        return pseudonym

    @rule(target=running, pseudonym=consumes(dropped))
    def resume_dropped(self, pseudonym: str) -> str:
        """Somebody who stopped goes on after all."""
        self._resume(pseudonym)
        return self._set(pseudonym, "running")

    def _resume(self, pseudonym: str) -> None:
        self.pid += 1
        self.processes[pseudonym] = self.pid
        with self._as(self.pid) as register:
            assert register.resume(STUDY, pseudonym).order == self.model[pseudonym][1]

    @rule(target=excluded, pseudonym=consumes(complete))
    def exclude(self, pseudonym: str) -> str:
        """The experimenter leaves somebody out."""
        return self._exclude(pseudonym)

    @rule(target=excluded, pseudonym=consumes(interrupted))
    def exclude_interrupted(self, pseudonym: str) -> str:
        """The same for a session that broke off."""
        return self._exclude(pseudonym)

    def _exclude(self, pseudonym: str) -> str:
        self.before_mark[pseudonym] = self.model[pseudonym][0]
        editing.mark(self.register, self._known(pseudonym), "excluded", "a reason")
        return self._set(pseudonym, "excluded")

    @rule(target=running, pseudonym=consumes(excluded))
    def take_back(self, pseudonym: str) -> object:
        """And takes it back: as it was before, complete or interrupted, in some slot."""
        now = editing.restore(self.register, self._known(pseudonym))
        assert now.state == self.before_mark[pseudonym]
        self._set(pseudonym, now.state)
        if now.state == "complete":
            return multiple()
        return self.resume(pseudonym)

    @invariant()
    def register_says_so(self) -> None:
        """State and order are what the rules say; each slot has one holder."""
        found = {each.pseudonym: each for each in self.register.participants(STUDY)}
        assert {name: (each.state, each.order) for name, each in found.items()} == self.model
        slots = [each.slot for each in found.values() if each.state in HOLDING]
        assert len(set(slots)) == len(slots)
        for name, each in found.items():
            dead = self.processes[name] in self.dead
            assert each.interrupted == (each.state == "running" and (dead or each.lease is None))

    def teardown(self) -> None:
        """Fill the slots that the plan still has: where they suffice, both orders balance."""
        if not hasattr(self, "register"):
            return
        for pseudonym, (state, _) in list(self.model.items()):
            if state == "reserved" and self.processes[pseudonym] in self.dead:
                del self.model[pseudonym]
        holders = sum(state in HOLDING for state, _ in self.model.values())
        left, difference = max(0, PLANNED - holders), self.difference()
        for _ in range(left):
            self.reserve()
        if left >= difference - 1:
            assert self.difference() <= 1
        self.register.close()
        shutil.rmtree(self.folder)


TestEnrolment = Enrolment.TestCase
TestEnrolment.settings = settings(max_examples=40, stateful_step_count=40)
