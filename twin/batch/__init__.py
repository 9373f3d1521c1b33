"""Batches: many films of one mesh heated together, and films that differ by the noise of the process."""

from twin.batch.heating import heat_films
from twin.batch.noise import ProcessNoise, noisy_films, smooth_field
from twin.batch.together import run_together

__all__ = ["ProcessNoise", "heat_films", "noisy_films", "run_together", "smooth_field"]
