"""The twin against closed forms and measurements: `python -m benchmarks.validation` writes docs/validation.md."""
