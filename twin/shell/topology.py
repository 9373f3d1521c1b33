"""Who neighbours whom: stencils of the triangles and the sparse pattern of the Hessian."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True, eq=False)
class Stencils:
    """For each triangle its own three vertices and the three across its edges (edge i opposite vertex i)."""

    vertices: np.ndarray
    """Vertex of each slot, -1 where there is none, shape [m, 6], int32."""
    across: np.ndarray
    """Triangle across each edge, -1 at the boundary, shape [m, 3], int32."""
    across_slot: np.ndarray
    """Slot in that triangle of its vertex off the edge, shape [m, 3], int32."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Gather:
    """For each vertex the (triangle, slot) pairs whose stencil it belongs to, as offsets into two lists."""

    start: np.ndarray
    triangle: np.ndarray
    slot: np.ndarray


@dataclass(frozen=True, kw_only=True, eq=False)
class Pattern:
    """Upper triangle of the Hessian in CSR form, and for each 3x3 block what adds to it and where it goes."""

    indptr: np.ndarray
    indices: np.ndarray
    start: np.ndarray
    """Offsets of each block's contributions, shape [blocks + 1]."""
    contribution: np.ndarray
    """(triangle, slot k, slot l), shape [contributions, 3]."""
    target: np.ndarray
    """Place of each block row's first value, shape [blocks, 3]."""
    diagonal: np.ndarray
    """1 for blocks on the diagonal, shape [blocks]."""
    diagonal_place: np.ndarray
    """Place of each degree of freedom's diagonal value, shape [3 n]."""


def stencils(triangles: np.ndarray) -> Stencils:
    """Find the triangle across each edge.

    Raises:
        ValueError: if an edge has more than two triangles or two triangles disagree in orientation.
    """
    count = len(triangles)
    ends = triangles[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2)
    size = int(triangles.max()) + 1
    directed = ends[:, 0].astype(np.int64) * size + ends[:, 1]
    order = np.argsort(directed)
    if np.any(np.diff(directed[order]) == 0):
        raise ValueError("an edge is used twice in the same direction: the mesh is non-manifold or badly oriented")
    reverse = ends[:, 1].astype(np.int64) * size + ends[:, 0]
    place = np.clip(np.searchsorted(directed, reverse, sorter=order), 0, len(order) - 1)
    found = directed[order[place]] == reverse
    partner = np.where(found, order[place], -1)
    across = np.where(found, partner // 3, -1)
    slot = np.where(found, partner % 3, 0)
    opposite = np.where(found, triangles[np.maximum(across, 0), slot], -1)
    return Stencils(
        vertices=np.hstack((triangles, opposite.reshape(count, 3))).astype(np.int32),
        across=across.reshape(count, 3).astype(np.int32),
        across_slot=slot.reshape(count, 3).astype(np.int32),
    )


def gather(stencil: np.ndarray, vertex_count: int) -> Gather:
    """List for each vertex the stencil slots that it fills, shape of `stencil` [m, 6]."""
    triangle, slot = np.nonzero(stencil >= 0)
    vertex = stencil[triangle, slot]
    order = np.argsort(vertex, kind="stable")
    start = np.searchsorted(vertex[order], np.arange(vertex_count + 1))
    return Gather(
        start=start.astype(np.int32),
        triangle=triangle[order].astype(np.int32),
        slot=slot[order].astype(np.int32),
    )


def hessian_pattern(stencil: np.ndarray, vertex_count: int) -> Pattern:
    """Lay out the upper triangle of the Hessian, three rows a vertex."""
    upper = np.triu_indices(6)
    rows, columns = stencil[:, upper[0]], stencil[:, upper[1]]
    triangle, pair = np.nonzero((rows >= 0) & (columns >= 0))
    i, j = rows[triangle, pair], columns[triangle, pair]
    left, right = upper[0][pair], upper[1][pair]
    swap = i > j
    i, j = np.where(swap, j, i), np.where(swap, i, j)
    left, right = np.where(swap, right, left), np.where(swap, left, right)
    # a vertex that fills two slots of one stencil meets itself: both orders add to its diagonal block
    twice = (i == j) & (left != right)
    triangle = np.concatenate((triangle, triangle[twice]))
    i, j = np.concatenate((i, i[twice])), np.concatenate((j, j[twice]))
    left, right = np.concatenate((left, right[twice])), np.concatenate((right, left[twice]))

    key = i.astype(np.int64) * vertex_count + j
    order = np.argsort(key, kind="stable")
    blocks, first = np.unique(key[order], return_index=True)
    block_row, block_column = blocks // vertex_count, blocks % vertex_count
    row_start = np.searchsorted(block_row, np.arange(vertex_count + 1))
    per_row = np.diff(row_start)
    lengths = 3 * per_row[:, None] - np.arange(3)
    indptr = np.concatenate(([0], np.cumsum(lengths.ravel())))
    rank = np.arange(len(blocks)) - row_start[block_row]
    r = np.arange(3)
    on_diagonal = rank == 0
    target = indptr[3 * block_row[:, None] + r] + np.where(on_diagonal[:, None], 0, 3 * rank[:, None] - r)
    indices = np.empty(indptr[-1], dtype=np.int32)
    for row in range(3):
        for column in range(3):
            keep = ~on_diagonal | (column >= row)
            shift = np.where(on_diagonal, column - row, column)
            indices[(target[:, row] + shift)[keep]] = (3 * block_column + column)[keep]
    return Pattern(
        indptr=indptr.astype(np.int32),
        indices=indices,
        start=np.concatenate((first, [len(key)])).astype(np.int32),
        contribution=np.stack((triangle, left, right), axis=1)[order].astype(np.int32),
        target=target.astype(np.int32),
        diagonal=on_diagonal.astype(np.int32),
        diagonal_place=indptr[:-1].astype(np.int32),
    )
