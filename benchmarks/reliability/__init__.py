"""What a run survives: every fault at every stage of a small run, checked against the simulated machine's truth."""
