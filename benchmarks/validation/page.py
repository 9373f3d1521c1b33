"""The page: a summary of all checks, then the sections."""

from collections.abc import Sequence

from benchmarks.validation.section import Section, table

PREFACE = """# Validation

Written by `make validation`; do not edit. The twin against closed forms, balances of force and energy, measurements
by others and what the paper saw. Everything is computed anew through the same code as `lce predict`; nothing is fitted,
and what fails is listed."""


def write_page(sections: Sequence[Section]) -> str:
    """Return the page as Markdown."""
    checks = [check for section in sections for check in section.checks]
    promised = [check for check in checks if check.passed is not None]
    failed = [check for check in promised if not check.passed]
    verdict = f"{len(promised) - len(failed)} of {len(promised)} checks hold."
    if failed:
        verdict += " These do not: " + "; ".join(check.name for check in failed) + "."
    summary = table(
        ("check", "expected", "found", "error", "verdict"),
        [(check.name, check.expected, check.found, check.error, check.verdict) for check in checks],
    )
    parts = [PREFACE, verdict, summary]
    for section in sections:
        parts += [f"## {section.title}", *section.blocks]
    return "\n\n".join(parts) + "\n"
