"""The session: inputs in, events and effects out. Nothing else: no clock, no file, no task.

The same inputs give the same events, byte for byte, on any machine.
"""

from __future__ import annotations

from study.errors import RecordingError
from study.events.codes import Phase
from study.events.events import (
    Deviation,
    Paused,
    Resumed,
    SessionEnded,
    SessionStarted,
    StageEntered,
    TrialEnded,
    TrialStarted,
)
from study.events.experimenter_records import ExperimenterCommanded, ExperimenterNoted
from study.events.inputs import (
    FitCompleted,
    FitFailed,
    FitTimedOut,
    FocusChanged,
    Input,
    KeyChanged,
    PointerPressed,
    QuitRequested,
    RecordingInterrupted,
    RecordingRestored,
    RobotReported,
    SessionOpened,
    SessionResumed,
    TimestepDue,
    WindowChanged,
)
from study.events.participant_events import ConsentGiven
from study.events.task_description import TaskDescription
from study.messages import Messages
from study.protocol import parse_protocol
from study.screens import Screen
from study.seat_settings import ConsentPart
from study.session.consent import consent_sha256
from study.session.context import Context, Knowledge, Outbox, Step
from study.session.effects import (
    EnsureDurable,
    EraseRecording,
    Finish,
    SetPace,
    Show,
    moves_the_screen,
)
from study.session.fitting import take_preparation
from study.session.opening import questionnaires_of, texts_of
from study.session.plan import FitPlan, PagesPlan, StagePlan
from study.session.robot_reports import take_report
from study.session.rules import STALLS_TOLD, TRIAL_OF_END
from study.session.sequence import stage_plans
from study.session.stage import Stage
from study.session.stages import make_stage
from study.session.standstill import Standstill


class Session:
    """A participant's visit as a state machine.

    Args:
        messages: the texts of the participant's language; those of the protocol's if None.
    """

    def __init__(self, messages: Messages | None = None) -> None:
        self._messages = messages
        self._context: Context | None = None
        self._plans: tuple[StagePlan, ...] = ()
        self._index = -1
        self._stage: Stage | None = None
        self._still = Standstill()
        self._trial_id = -1
        self.finished = False
        self.complete = False

    def handle(self, given: Input) -> Step:
        """Take in one input.

        Args:
            given: the first must be SessionOpened.

        Returns:
            What happened and what is asked for.

        Raises:
            RecordingError: the first input is another, or opens what is no session.
        """
        out = Outbox()
        if self._context is None:
            if not isinstance(given, SessionOpened):
                raise RecordingError(
                    f"the first input is {type(given).__name__}, not SessionOpened"
                )
            self._open(given, out)
        elif not self.finished:
            self._route(given, self._context, out)
        for event in out.events:
            if isinstance(event, TrialStarted):
                self._trial_id = event.trial_id
            elif isinstance(event, TrialEnded):
                self._trial_id = -1
        return Step(tuple(out.events), tuple(out.effects))

    @property
    def screen(self) -> Screen | None:
        """What is to be seen now; None before the session is open."""
        if self._context is not None and self._still.on:
            return self._still.screen(self._context)
        return self._stage.screen() if self._stage else None

    @property
    def shared(self) -> dict[int, object]:
        """What a fork takes instead of a deep copy, by identity; see `study.session.forking`."""
        shared = self._context.shared if self._context else {}
        return {**shared, id(self._plans): self._plans}

    def _open(self, given: SessionOpened, out: Outbox) -> None:
        protocol = parse_protocol(given.protocol_toml, "the recorded protocol")
        names = [condition.name for condition in protocol.conditions]
        if sorted(given.order) != sorted(names):
            raise RecordingError(
                f"the order opened with is {', '.join(given.order)}; "
                f"the protocol's conditions are {', '.join(names)}"
            )
        questionnaires = questionnaires_of(given.questionnaires_json)
        missing = {use.name for use in protocol.questionnaires} - questionnaires.keys()
        if missing:
            raise RecordingError(f"no questionnaire {', '.join(sorted(missing))} was opened with")
        self._context = Context(
            protocol=protocol,
            description=TaskDescription.from_json(given.task_json),
            questionnaires=questionnaires,
            participant=given.participant,
            seed=given.seed,
            order=given.order,
            knowledge=Knowledge(),
            messages=self._messages or texts_of(protocol.study.language),
            rules=given.rules,
        )
        self._plans = stage_plans(protocol, given.order, given.rules)
        out.events.append(
            SessionStarted(given.t_ns, given.participant, given.order, len(self._plans))
        )
        self._consented(given, protocol.consent, out)
        out.effects.append(EnsureDurable())
        self._next_stage(given.t_ns, out)

    def _consented(self, given: SessionOpened, part: ConsentPart | None, out: Outbox) -> None:
        """Say in the first events what was agreed to. Simulated participants are not asked."""
        if part is None or given.operator_kind != "person":
            return
        if given.consent_sha256 != consent_sha256(part):
            raise RecordingError(
                f'the session was opened with consent to "{given.consent_sha256 or "nothing"}"; '
                f"the protocol's text has the SHA-256 {consent_sha256(part)}"
            )
        out.events.append(ConsentGiven(given.t_ns, given.consent_sha256, given.consented_utc))

    def _route(self, given: Input, context: Context, out: Outbox) -> None:
        still = self._still
        if isinstance(given, QuitRequested):
            self._end_early(given.t_ns, given.reason, out)
        elif isinstance(given, ExperimenterCommanded):
            self._experimenter(given, out)
        elif isinstance(given, FocusChanged):
            if not given.focused and not still.on and self._can_pause():
                self._pause(given.t_ns, "focus lost", out)
        elif isinstance(given, WindowChanged):
            if given.change != "restored" and not still.on and self._can_pause():
                self._pause(given.t_ns, f"window {given.change}", out)
        elif isinstance(given, RecordingInterrupted):
            self._recording_interrupted(given, out)
        elif isinstance(given, RecordingRestored):
            self._recording_restored(given, context, out)
        elif isinstance(given, SessionResumed):
            # Its robots were connected anew.
            context.knowledge.held_robots.clear()
            self._go_back(given, out)
        elif isinstance(given, RobotReported):
            take_report(given, context, self._trial_id, out)
            if self._stage and self._trial_id >= 0:
                # The fleet's answer may be long in coming: its robots are marked at once.
                out.effects.append(Show(self._stage.screen()))
        elif still.on and isinstance(given, KeyChanged | PointerPressed | TimestepDue):
            self._while_paused(given, context, out)
        elif (
            isinstance(given, KeyChanged)
            and given.down
            and given.key == context.protocol.keys.pause
            and self._can_pause()
        ):
            self._pause(given.t_ns, "operator", out)
        elif isinstance(given, FitCompleted | FitFailed | FitTimedOut) and take_preparation(
            given, context
        ):
            pass
        elif self._stage and self._stage.handle(given, out):
            if context.knowledge.stop_reason:
                self._end_early(given.t_ns, context.knowledge.stop_reason, out)
            else:
                self._next_stage(given.t_ns, out)
        if still.on:
            # An answer of the fleet may arrive in a pause; the pause screen stays.
            kept = [effect for effect in out.effects if not moves_the_screen(effect)]
            out.effects = [*kept, Show(still.screen(context))]

    def _can_pause(self) -> bool:
        plan = self._plans[self._index]
        if isinstance(plan, FitPlan):
            return False
        # Where the robots drive on their own, and on the last screen, there is nothing to pause.
        return plan.place.phase != Phase.FOUR or plan.name in ("survey", "debrief")

    def _pause(self, t_ns: int, reason: str, out: Outbox) -> None:
        self._still.begin(t_ns)
        if self._stage:
            self._stage.pause(out)
        out.events.append(Paused(t_ns, reason))

    def _experimenter(self, given: ExperimenterCommanded, out: Outbox) -> None:
        """Do what the experimenter asks for; unlike the participant's, a pause holds anywhere."""
        still = self._still
        if given.command == "annotate" and given.text:
            noted = ExperimenterNoted(given.t_ns, given.text, self._trial_id, self._index)
            out.events.append(noted)
        elif given.command == "pause" and not still.held:
            text = "the experimenter paused the session"
            out.events.append(Deviation(given.t_ns, "experimenter_paused", text, self._trial_id))
            if still.on:
                still.hold()
            else:
                self._pause(given.t_ns, "experimenter", out)
                still.hold(alone=True)
        elif given.command == "resume" and still.held:
            if still.release():
                self._resume(given.t_ns, out)
        elif given.command == "end":
            reason = given.text or "no reason given"
            self._end_early(given.t_ns, f"ended by the experimenter: {reason}", out)

    def _recording_interrupted(self, given: RecordingInterrupted, out: Outbox) -> None:
        """Stand still, wherever the session is: what happens now might not be recorded."""
        if not self._still.on:
            self._pause(given.t_ns, "recording interrupted", out)
        self._still.interrupt(given.t_ns, given.reason)

    def _recording_restored(self, given: RecordingRestored, context: Context, out: Outbox) -> None:
        """Leave it to the participant to go on."""
        told = context.rules >= STALLS_TOLD
        text = self._still.restore(given.t_ns, given.part, tells_stalls=told)
        if text:
            out.events.append(Deviation(given.t_ns, "recording_interrupted", text, self._trial_id))

    def _go_back(self, given: SessionResumed, out: Outbox) -> None:
        """Begin the stage anew that was entered last; what came after was never seen here.

        A trial gets a new id and keeps its start states, which are keyed by its place.
        """
        if self._still.on:
            out.events.append(Resumed(given.t_ns, self._still.end(given.t_ns)))
        self._still.part = given.part
        plan = self._plans[self._index]
        text = (
            f"part {given.part} goes on after {given.gap_seconds:.1f} s "
            f"at {plan.name}, phase {int(plan.place.phase)}"
        )
        out.events.append(Deviation(given.t_ns, "resumed", text, -1))
        out.effects.append(EnsureDurable())
        self._index -= 1
        self._next_stage(given.t_ns, out)

    def _while_paused(
        self, given: KeyChanged | PointerPressed | TimestepDue, context: Context, out: Outbox
    ) -> None:
        keys = context.protocol.keys
        if isinstance(given, PointerPressed):
            word = given.target
        elif isinstance(given, KeyChanged) and given.down:
            words = {keys.confirm: "continue", keys.pause: "continue", "q": "stop", "y": "yes"}
            words |= {"e": "erase"} if context.rules >= 1 else {}
            word = words.get(given.key, "")
        else:
            return
        asked = self._still.take(word, can_erase=context.rules >= 1)
        if asked == "continue":
            self._resume(given.t_ns, out)
        elif asked == "stop":
            self._end_early(given.t_ns, "stopped by the participant", out)
        elif asked == "erase":
            out.effects.append(EraseRecording())
            self._end_early(given.t_ns, "erased by the participant", out)

    def _resume(self, t_ns: int, out: Outbox) -> None:
        out.events.append(Resumed(t_ns, self._still.end(t_ns)))
        if self._stage:
            self._stage.resume(t_ns, out)
            out.effects.append(Show(self._stage.screen()))

    def _next_stage(self, t_ns: int, out: Outbox) -> None:
        assert self._context is not None  # noqa: S101 - stages exist only in an open session
        while True:
            self._index += 1
            if self._index == len(self._plans):
                self._finish(t_ns, "complete", out, complete=True)
                return
            plan = self._plans[self._index]
            self._stage = make_stage(plan, self._context)
            out.events.append(
                StageEntered(
                    t_ns=t_ns,
                    stage=self._index,
                    kind=self._stage.kind,
                    name=plan.name,
                    phase=plan.place.phase,
                    block=plan.place.block,
                    condition=plan.place.condition,
                )
            )
            if not self._stage.enter(t_ns, out):
                break
            if self._context.knowledge.stop_reason:
                self._end_early(t_ns, self._context.knowledge.stop_reason, out)
                return
        out.effects.append(Show(self._stage.screen()))

    def _end_early(self, t_ns: int, reason: str, out: Outbox) -> None:
        plan, context = self._plans[self._index], self._context
        if isinstance(plan, PagesPlan) and plan.name == "thanks":
            self._finish(t_ns, "complete", out, complete=True)
            return
        if self._stage:
            self._stage.break_off(t_ns, out)
        trial_id = self._trial_id if context and context.rules >= TRIAL_OF_END else -1
        where = f"{plan.name}, phase {int(plan.place.phase)}"
        out.events.append(Deviation(t_ns, "ended_early", f"{reason}; at stage {where}", trial_id))
        self._finish(t_ns, reason, out, complete=False)

    def _finish(self, t_ns: int, reason: str, out: Outbox, *, complete: bool) -> None:
        self.finished = True
        self.complete = complete
        out.events.append(SessionEnded(t_ns, complete, reason))
        out.effects += [SetPace(0.0), EnsureDurable(), Finish()]
