"""Plane geometry that the Program's own checks need, without numeric libraries: a Program is a leaf."""

from collections.abc import Iterable, Sequence
from itertools import pairwise

from planner.program.operations import Point

SLACK_MM = 1e-6
"""Points this far outside still count as inside: coordinates are rounded when a plan is written."""


def cross(o: Point, a: Point, b: Point) -> float:
    """Twice the signed area of the triangle o, a, b [mm2], positive counter-clockwise."""
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])


def is_convex(outline: Sequence[Point]) -> bool:
    """Tell whether a closed outline is convex and counter-clockwise (a rectangle, say)."""
    count = len(outline)
    turns = [cross(outline[i - 2], outline[i - 1], outline[i]) for i in range(count)]
    # A star also turns left at every corner: only an outline that winds once has a fan of positive area.
    fan = [cross(outline[0], outline[i], outline[i + 1]) for i in range(1, count - 1)]
    return min(turns) >= 0 and min(fan) >= 0 and sum(fan) > 0


def outside_convex(points: Iterable[Point], outline: Sequence[Point]) -> Point | None:
    """Return the first point outside a convex counter-clockwise outline, or None where all are inside."""
    edges = []
    for a, b in zip(outline, [*outline[1:], outline[0]], strict=True):
        dx, dy = b[0] - a[0], b[1] - a[1]
        length = (dx * dx + dy * dy) ** 0.5
        if length > 0:
            edges.append((-dy / length, dx / length, (-dy * a[0] + dx * a[1]) / length - SLACK_MM))
    for x, y in points:
        for nx, ny, offset in edges:
            if nx * x + ny * y < offset:
                return x, y
    return None


def self_crossing(line: Sequence[Point]) -> Point | None:
    """Return a point where a closed line crosses itself, or None where it is simple."""
    count = len(line)
    edges = [(min(a[0], b[0]), max(a[0], b[0]), i, a, b) for i, (a, b) in enumerate(pairwise([*line, line[0]]))]
    edges.sort(key=lambda edge: edge[0])
    for first, (_, right, i, a, b) in enumerate(edges):
        for left, _, j, c, d in edges[first + 1 :]:
            if left > right:
                break
            if abs(i - j) in (0, 1, count - 1):
                continue
            if max(a[1], b[1]) < min(c[1], d[1]) or max(c[1], d[1]) < min(a[1], b[1]):
                continue  # apart, though they may lie on one line
            if cross(a, b, c) * cross(a, b, d) <= 0 and cross(c, d, a) * cross(c, d, b) <= 0:
                return c
    return None
