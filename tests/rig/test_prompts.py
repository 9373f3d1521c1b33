"""The operator at a terminal: answers late, twice, wrong and never; and nobody at all."""

import os
import sys
import threading
import tty
from collections.abc import Iterator
from pathlib import Path

import pytest

from benchmarks.reliability.scene import as_run_records
from benchmarks.reliability.small_run import small_program, small_rig
from planner.errors import RigError
from rig.executor.interrupts import Interrupts, PausedError
from rig.executor.prompts import AbsentOperator, TerminalOperator
from rig.executor.session import operator_for, run_session
from rig.machine_file import RigDescription


@pytest.fixture
def keyboard(monkeypatch) -> Iterator[int]:
    """Standard input as a terminal, and the end at which somebody types."""
    master, terminal = os.openpty()
    tty.setcbreak(terminal)
    with os.fdopen(terminal, "r") as stream:
        monkeypatch.setattr(sys, "stdin", stream)
        yield master
    os.close(master)


def typed_later(master: int, *texts: bytes) -> threading.Timer:
    def type_them() -> None:
        for text in texts:
            os.write(master, text)

    timer = threading.Timer(0.15, type_them)
    timer.start()
    return timer


@pytest.mark.parametrize(
    ("texts", "yes"),
    [
        ((b"y\n",), True),
        ((b" YES \n",), True),
        ((b"n\n",), False),
        ((b"\n",), False),
        ((b"maybe\n", b"y\n"), True),
        ((b"yy\n", b"ok\n", b"1\n", b"y\n"), False),
    ],
)
def test_only_a_clear_yes_is_one(keyboard: int, texts: tuple[bytes, ...], yes: bool) -> None:
    timer = typed_later(keyboard, *texts)
    assert TerminalOperator(patience_s=5.0).confirm("Ready?") is yes
    timer.join()


def test_silence_is_no(keyboard: int) -> None:
    assert TerminalOperator(patience_s=0.3).confirm("Ready?") is False


def test_a_stop_ends_a_question(keyboard: int) -> None:
    interrupts = Interrupts()
    interrupts.wanted = "stop"
    assert TerminalOperator(interrupts).confirm("Ready?") is False


def test_ctrl_c_at_a_question_is_no_answer(keyboard: int) -> None:
    interrupts = Interrupts()
    timer = threading.Timer(0.15, interrupts.pause)
    timer.start()
    assert TerminalOperator(interrupts, patience_s=5.0).confirm("Ready?") is False
    timer.join()
    # one that was wished for before is why it is asked
    timer = typed_later(keyboard, b"y\n")
    assert TerminalOperator(interrupts, patience_s=5.0).confirm("Paused. Go on?") is True
    timer.join()


def test_an_answer_given_twice_does_not_answer_the_next_question(keyboard: int) -> None:
    os.write(keyboard, b"y\ny\n")
    assert TerminalOperator(patience_s=0.3).confirm("Is the lamp off?") is False


def test_without_a_terminal_a_real_machine_does_nothing(tmp_path: Path, capsys) -> None:
    rig = small_rig()
    attended = type(rig)(file=rig.file.model_copy(update={"lamp": "operator"}), machine=rig.machine)
    assert isinstance(operator_for(attended, Interrupts()), AbsentOperator)
    with pytest.raises(RigError, match="Nothing was begun"):
        run_session(small_program(), attended, tmp_path / "run")
    assert "this is no terminal: taken for no" in capsys.readouterr().err
    answer = as_run_records(tmp_path / "run")[1]
    assert (answer["record"], answer["yes"], answer["by"]) == ("answer", False, "nobody")


class Listed:
    """Says yes, but to one question, and remembers them all."""

    def __init__(self, no_to: str = "") -> None:
        self.asked: list[str] = []
        self.told: list[str] = []
        self._no_to = no_to

    def confirm(self, question: str) -> bool:
        self.asked.append(question)
        return question != self._no_to

    def tell(self, text: str) -> None:
        self.told.append(text)


def rig_by_hand() -> RigDescription:
    rig = small_rig()
    by_hand = dict.fromkeys(("extruder", "lamp", "hot_air", "hot_plate", "enclosure"), "operator")
    return type(rig)(file=rig.file.model_copy(update=by_hand), machine=rig.machine)


def test_a_machine_whose_peripherals_are_worked_by_hand(tmp_path: Path) -> None:
    operator = Listed()
    run_session(small_program(), rig_by_hand(), tmp_path / "run", operator=operator)
    assert "Does the layer of 0.2 mm lie?" in operator.asked
    assert operator.asked.count("Switch the UV lamp on. Is it on?") == 2
    assert operator.told.count("Switch the UV lamp off.") == 2
    answers = [record for record in as_run_records(tmp_path / "run") if record["record"] == "answer"]
    assert [record["question"] for record in answers] == operator.asked


def test_nothing_follows_before_what_was_switched_by_hand_is_off(tmp_path: Path) -> None:
    operator = Listed(no_to="Is the UV lamp off?")
    with pytest.raises(PausedError, match="Is the UV lamp off"):
        run_session(small_program(), rig_by_hand(), tmp_path / "run", operator=operator)
    assert operator.asked[-1] == "Is the UV lamp off?"
    ended = [record for record in as_run_records(tmp_path / "run") if record["record"] == "operation"]
    assert (ended[-1]["kind"], ended[-1]["outcome"]) == ("cure", "done")
    # the layer is cured: that is not done again
    again = Listed()
    run_session(small_program(), rig_by_hand(), tmp_path / "run", operator=again, resume=True)
    assert again.asked.count("Switch the UV lamp on. Is it on?") == 1
    assert again.asked.count("Is the UV lamp off?") == 1
    off = ("Is the hot air off, and does it point away from the layer?", "Is the hot plate off?")
    for question in off:
        assert question in [*operator.asked, *again.asked], question
