"""Signals: the first asks for a pause, the second stops at once, but never while a file is written."""

import os
import signal

import pytest

from rig.executor.interrupts import Interrupts, StoppedError


def test_one_signal_asks_for_a_pause_and_two_stop() -> None:
    before = signal.getsignal(signal.SIGINT)  # a shell's background jobs ignore it
    interrupts = Interrupts()
    with interrupts.from_signals():
        os.kill(os.getpid(), signal.SIGINT)
        assert interrupts.wanted == "pause"
        with pytest.raises(StoppedError), interrupts.waiting():
            os.kill(os.getpid(), signal.SIGINT)
    assert interrupts.wanted == "stop"
    assert signal.getsignal(signal.SIGINT) is before


def test_a_stop_waits_until_files_are_written() -> None:
    interrupts = Interrupts()
    with interrupts.from_signals():
        os.kill(os.getpid(), signal.SIGTERM)  # nothing is raised here
        with pytest.raises(StoppedError), interrupts.waiting():
            raise AssertionError("it must not be waited for anything")
