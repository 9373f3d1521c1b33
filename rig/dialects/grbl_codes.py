"""What the numbers of Grbl's errors and alarms mean, in words that complete a sentence."""

_ERRORS = {
    1: "a word does not begin with a letter",
    2: "a number is missing or malformed",
    3: "the $ command does not exist",
    4: "a negative value",
    5: "homing is switched off ($22)",
    8: "the $ command needs the machine to be idle",
    9: "the machine is locked until it is homed or unlocked",
    10: "soft limits need homing",
    11: "the line is too long",
    15: "the jog would leave the travel",
    16: "the jog is malformed",
    20: "the command does not exist",
    21: "two commands on one line exclude each other",
    22: "no feed is set",
    25: "a word occurs twice on one line",
    26: "a command lacks its axes",
    28: "a command lacks a word",
    31: "axis words without a motion",
    36: "a word on the line is of no use",
}
_ALARMS = {
    1: "a limit switch tripped, the position is lost",
    2: "a move would leave the travel, the position is kept",
    3: "it was reset in motion, the position is lost",
    6: "homing was reset",
    7: "homing met the open safety door",
    8: "homing could not leave a limit switch",
    9: "homing found no limit switch",
}


def error_meaning(number: int) -> str:
    """Return what `error:N` means."""
    return f"error {number}: {_ERRORS.get(number, 'not in the list of Grbl 1.1')}"


def alarm_meaning(number: int) -> str:
    """Return what `ALARM:N` means."""
    return f"alarm {number}: {_ALARMS.get(number, 'not in the list of Grbl 1.1')}"
