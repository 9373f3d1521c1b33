"""What errors of the process are expected to cost, in words."""

KINDS = {
    "strain": "strain of the whole film",
    "layer_strain": "strain of the layers",
    "registration": "registration",
    "direction": "direction",
}
MOST = 0.5
"""Expected costs of more similarity than this say only that the film is soft."""
NEAR = 0.9
"""Similarity below which the costs are overstated: their quadratic form holds near the target."""


def costs_in_words(costs: dict[str, float], ssim: float) -> str:
    """Return a sentence about what each kind of error costs a film of this similarity, the dearest first."""
    total = sum(costs.values())
    if total > MOST:
        return "to first order they cost more than half of the similarity: the film is very soft, or near a snap"
    dearest = sorted(costs, key=costs.__getitem__, reverse=True)
    parts = ", ".join(f"{KINDS[kind]} {costs[kind]:.3f}" for kind in dearest)
    far = "" if ssim >= NEAR else " (overstated, since the film is far from its target; their shares hold)"
    return f"to first order they cost {total:.3f} of similarity: {parts}{far}"
