"""A conversation with a Grbl controller: lines out as fast as its buffer allows, answers matched to them."""

from collections import deque
from collections.abc import Iterable

from planner.errors import RigError
from rig.dialects import grbl_lines
from rig.dialects.grbl import Alarm, Banner, Error, Event, GrblParser, Message, Ok, Setting, Status, Unknown
from rig.dialects.grbl_codes import alarm_meaning, error_meaning
from rig.transport import Transport

BUFFER_BYTES = 127
"""Bytes in flight that any Grbl takes; one that has more says so when it is identified."""
ASK_S = 0.2
"""Time between two questions for the status [s]; more often would take the controller's time from its motion."""
BRAKING_S = 0.05
"""Time between two such questions while it brakes [s]."""
ANSWER_S = 3.0
UNANSWERED = 3
"""Questions in a row that have to stay without an answer, too: a host that was slow may have answers still to read."""
BANNER_S = 0.7
RESETS = 8


class GrblLine:
    """Counts the bytes in flight, so that the controller's buffer, which loses what does not fit, never overflows."""

    def __init__(self, transport: Transport) -> None:
        self._transport = transport
        self._parser = GrblParser()
        self._queue: deque[bytes] = deque()
        self._sent: deque[bytes] = deque()
        self._asked_s: float | None = None
        self._answered_s = 0.0
        self._unanswered = 0
        self._questions_s: deque[float] = deque()
        self.asked_s = 0.0
        """When the question was asked that the last status answers, at the earliest [s]."""
        self.heard_s = 0.0
        """When the last bytes were read [s]."""
        self.before_s = 0.0
        """When those before them were read, so that these came after that [s]."""
        self._idle_reports = 0
        self.limit_bytes = BUFFER_BYTES
        self.in_flight_bytes = 0
        self.most_in_flight_bytes = 0
        """The most that ever was in flight [bytes]."""
        self.alarmed = False
        """Whether it wants a reset before anything else."""
        self.lost = True
        """Whether it may be wrong about where it is, until it is homed."""

    @property
    def busy(self) -> bool:
        """Whether lines wait to be sent or acknowledged."""
        return bool(self._queue or self._sent)

    def now_s(self) -> float:
        """Return the time of the line's clock [s]."""
        return self._transport.clock.now_s()

    def queue(self, lines: Iterable[bytes]) -> None:
        """Put lines behind those that wait."""
        self._queue += lines

    def exchange(self, timeout_s: float) -> list[Event]:
        """Send what fits, wait for an answer up to a time [s], and return what is no acknowledgement.

        Raises:
            RigError: if the line is gone, a line was refused, or the controller raised an alarm, started anew, said
                something unintelligible or acknowledged what was not sent.
        """
        self._fill()
        data = self._transport.read(timeout_s)
        self.before_s, self.heard_s = self.heard_s, self.now_s()
        told = [event for event in self._parser.feed(data) if self._told(event)]
        self._fill()
        return told

    def command(self, line: bytes, deadline_s: float) -> list[Event]:
        """Send one line with nothing else in flight, wait until it is acknowledged [s], and return what it told.

        Raises:
            RigError: as `exchange`, or if the acknowledgement does not come in time.
        """
        end_s, told = self.now_s() + deadline_s, []
        self.queue([line])
        while self.busy:
            told += self.exchange(max(0.0, end_s - self.now_s()))
            if self.busy and self.now_s() >= end_s:
                raise RigError(
                    f"The stage did not acknowledge {_shown(line)} within {deadline_s:g} s: check the cable, then home."
                )
        return told

    def watch(self, until_s: float) -> Status | None:
        """Exchange until a status arrives, every line is acknowledged or a time has come [s].

        Raises:
            RigError: as `exchange`, if no question is answered for three seconds, or an acknowledgement got lost.
        """
        while self.busy and self.now_s() < until_s:
            self._ask()
            wait = min(until_s, (self._asked_s or 0.0) + ASK_S) - self.now_s()
            for event in self.exchange(max(0.0, wait)):
                if isinstance(event, Status):
                    self._count_idle(event)
                    return event
        return None

    def status(self, deadline_s: float = ANSWER_S) -> Status:
        """Ask for the status and wait for it [s].

        Raises:
            RigError: as `exchange`, or if there is no answer in time.
        """
        end_s = self.now_s() + deadline_s
        while (now_s := self.now_s()) < end_s:
            self._question()
            for event in self.exchange(min(end_s - now_s, 1.0)):
                if isinstance(event, Status):
                    self._answered_s, self._asked_s, self._unanswered = self.now_s(), None, 0
                    return event
        raise RigError(f"The stage did not answer within {deadline_s:g} s: check its supply and the cable, then home.")

    def say_hold(self) -> None:
        """Say that it shall brake, without waiting for that.

        Raises:
            RigError: if the line is gone.
        """
        self._transport.write(grbl_lines.HOLD)

    def hold(self, deadline_s: float) -> None:
        """Brake along the path and wait until the stage stands, at most a time [s]; what it says else is passed over.

        Raises:
            RigError: if the line is gone.
        """
        end_s = self.now_s() + deadline_s
        while self.now_s() < end_s:
            self._transport.write(grbl_lines.HOLD + grbl_lines.STATUS)
            reports = [event for event in self._listen(ASK_S) if isinstance(event, Status)]
            if any(report.state == "Alarm" or (report.state, report.substate) == ("Hold", 0) for report in reports):
                return
            self._transport.clock.sleep(BRAKING_S)

    def reset(self) -> None:
        """Reset the controller, forget all lines, and wait for its banner.

        Half a second after an alarm it swallows resets, and an acknowledgement of the line that was interrupted may
        come before the banner: so this repeats itself, and nothing before the banner counts.

        Raises:
            RigError: if the line is gone or no banner comes.
        """
        self._queue.clear()
        for _ in range(RESETS):
            self._transport.write(grbl_lines.RESET)
            if self.await_banner(BANNER_S):
                self._forget()
                return
        raise RigError("The stage does not answer to a reset: check its port, switch its supply off and on, then home.")

    def await_banner(self, timeout_s: float) -> bool:
        """Wait for a banner [s] and for the silence after it; return whether it came."""
        end_s, seen = self.now_s() + timeout_s, False
        while not seen and self.now_s() < end_s:
            seen = any(isinstance(event, Banner) for event in self._listen(end_s - self.now_s()))
        if seen:
            while self._listen(0.1):
                pass
        return seen

    def ask_identity(self, timeout_s: float) -> list[Message] | Error | None:
        """Ask who is there: what it said, how it refused, or None if nothing that ends an answer came [s]."""
        self._transport.write(grbl_lines.IDENTIFY)
        end_s, said = self.now_s() + timeout_s, []
        while self.now_s() < end_s:
            for event in self._listen(end_s - self.now_s()):
                if isinstance(event, Error):
                    return event
                if isinstance(event, Ok):
                    return said
                if isinstance(event, Message):
                    said.append(event)
        return None

    def close(self) -> None:
        """Give the line back."""
        self._transport.close()

    def _listen(self, timeout_s: float) -> list[Event]:
        """Read without matching answers to lines; alarms are remembered."""
        events = self._parser.feed(self._transport.read(max(0.0, timeout_s)))
        for event in events:
            if isinstance(event, Alarm):
                self.alarmed = self.lost = True
        return events

    def _forget(self) -> None:
        self._queue.clear()
        self._sent.clear()
        self._parser.clear()
        self._questions_s.clear()
        self.in_flight_bytes, self.alarmed, self._asked_s, self._idle_reports = 0, False, None, 0

    def _fill(self) -> None:
        while self._queue and self.in_flight_bytes + len(self._queue[0]) <= self.limit_bytes:
            line = self._queue.popleft()
            self._sent.append(line)
            self.in_flight_bytes += len(line)
            self.most_in_flight_bytes = max(self.most_in_flight_bytes, self.in_flight_bytes)
            self._transport.write(line)

    def _told(self, event: Event) -> bool:
        match event:
            case Ok() if self._sent:
                self.in_flight_bytes -= len(self._sent.popleft())
                self._idle_reports = 0
                return False
            case Ok():
                raise RigError("The stage acknowledged a line that was not sent: check the cable for noise, then home.")
            case Error():
                line = self._sent[0] if self._sent else b""
                raise RigError(f"The stage refused {_shown(line)} ({error_meaning(event.number)}): stop and home.")
            case Alarm():
                self.alarmed = self.lost = True
                raise RigError(f"The stage raised {alarm_meaning(event.number)}: find out why, then home.")
            case Banner():
                self.lost = True
                raise RigError("The stage started anew by itself, its position is lost: check its supply, then home.")
            case Unknown():
                raise RigError(
                    f"The stage said {event.text[:40]!r}, which no Grbl says: check the cable for noise, then home."
                )
            case Status():
                # one that got lost makes the later ones seem older than they are, which is the safe side
                self.asked_s = self._questions_s.popleft() if self._questions_s else self.before_s
                return True
            case Message() | Setting():
                return True

    def _ask(self) -> None:
        now_s = self.now_s()
        if self._asked_s is None:
            self._answered_s = now_s
        elif now_s < self._asked_s + ASK_S:
            return
        elif now_s > self._answered_s + ANSWER_S and self._unanswered >= UNANSWERED:
            raise RigError(f"The stage has not answered for {ANSWER_S:g} s: check its supply and the cable, then home.")
        self._asked_s = now_s
        self._unanswered += 1
        self._question()

    def _question(self) -> None:
        self._questions_s.append(self.now_s())
        self._transport.write(grbl_lines.STATUS)

    def _count_idle(self, status: Status) -> None:
        """Notice a lost acknowledgement: the controller is idle again and again though lines are in flight."""
        self._answered_s, self._unanswered = self.now_s(), 0
        self._idle_reports = self._idle_reports + 1 if status.state == "Idle" else 0
        if self._idle_reports > 3:
            raise RigError(
                f"The stage is idle but did not acknowledge {_shown(self._sent[0])}: check the cable for noise,"
                " then home."
            )


def _shown(line: bytes) -> str:
    return f"line {line.decode('ascii').rstrip()!r}" if line else "a line"
