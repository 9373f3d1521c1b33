"""What errors of the process are expected to cost, in words."""

from twin.inverse import TOGETHER

KINDS = {
    "strain": "strain of the whole film",
    "layer_strain": "strain of the layers",
    "registration": "registration",
    "direction": "direction",
    TOGETHER: "all together",
}
MOST = 0.5
"""Expected costs of more similarity than this say only that the film is soft."""


def costs_in_words(costs: dict[str, float]) -> str:
    """Return a sentence about what errors cost a film on average, and each kind alone, the dearest first."""
    if costs[TOGETHER] > MOST:
        return "to first order they cost more than half of the similarity: the film is very soft, or near a snap"
    dearest = sorted((kind for kind in costs if kind != TOGETHER), key=costs.__getitem__, reverse=True)
    parts = ", ".join(f"{KINDS[kind]} {costs[kind]:.3f}" for kind in dearest)
    return f"to first order they cost {costs[TOGETHER]:.3f} of similarity together; alone: {parts}"
