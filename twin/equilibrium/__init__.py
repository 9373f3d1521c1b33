"""Equilibria: sparse direct solves, Newton's method, and the ramp of temperatures from the flat film."""
