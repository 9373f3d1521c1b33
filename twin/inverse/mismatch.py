"""How far a hot shape is from its target, as one number with its gradient and curvature.

The number is (1 - ssim_eq4) + (rms^2 + outline^2 / 2) / mm^2: the headline score and the distances beside it. With the
windows' weights a = 1/(mu_r^2 + mu_s^2) and b = 1/(var_r + var_s) the index of one window is

    (1 - a (mean d)^2) (1 - b var d),      d = sample - reference,

exactly; freezing a and b and dropping the product of both small terms leaves a quadratic form in d, which is what
the Gauss-Newton steps use.
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from scipy.ndimage import uniform_filter
from scipy.spatial import KDTree

from planner.target import Target
from twin.film import boundary_edges
from twin.scan import (
    SHAPE_PX,
    RigidTransform,
    depth_image,
    grey_image,
    pixel_weights,
    register,
    target_depth_image,
)
from twin.score import ssim_eq4

WINDOW = 9
PER_MM2 = 1.0
OUTLINE_SHARE = 0.5
LEAST_DEVIATION_GREY = 0.5
"""Windows flatter than this are weighed as if they had this deviation: less is below the mesh's own facets."""
OUTLINE_STEP_MM = 0.1


@dataclass(frozen=True, kw_only=True, eq=False)
class Measured:
    """The mismatch of one shape and its quadratic model."""

    value: float
    ssim: float
    rms_mm: float
    """Root mean square distance along the normals, over the pixels where both are."""
    outline_mm: float
    """Root mean square distance of the film's rim from the target's outline, seen from above."""
    transform: RigidTransform
    model: "QuadraticModel"

    @property
    def gradient(self) -> np.ndarray:
        """With respect to the vertices of the top face, in the film's frame [1/mm], shape [n, 3]."""
        return self.model.gradient()

    def curve(self, displacement_mm: np.ndarray) -> np.ndarray:
        """Return the positive semi-definite curvature of the model times a displacement, shape [n, 3]."""
        return self.model.curve(displacement_mm)


class Mismatch:
    """Measures shapes against one target."""

    def __init__(self, target: Target, triangles: np.ndarray) -> None:
        """Prepare the target's image and outline for shapes with the given triangles, shape [m, 3]."""
        self._target, self._triangles = target, triangles
        depth = target_depth_image(target)
        self._lowest, self._highest = float(np.nanmin(target.z_mm)), float(np.nanmax(target.z_mm))
        self._reference = grey_image(depth, self._lowest, self._highest)
        self._outline_points, self._outline_normals = _dense_outline(target.outline_mm)
        self._outline_tree = KDTree(self._outline_points)
        self._rim = boundary_edges(triangles)

    def register(self, top_mm: np.ndarray, near: RigidTransform | None = None) -> RigidTransform:
        """Lay a top face [n, 3] over the target as the score does, starting from a motion if one is known."""
        return register(top_mm, self._target, triangles=self._triangles, coarse=False, near=near)

    def measure(self, top_mm: np.ndarray, near: RigidTransform | None = None) -> Measured:
        """Register a top face [mm], shape [n, 3], and measure it."""
        transform = self.register(top_mm, near)
        moved = transform.apply(top_mm)
        width, height = SHAPE_PX
        pixel, triangle, weights = pixel_weights(moved, self._triangles, self._target.bounds_mm)
        corners = self._triangles[triangle]
        look = sp.csr_matrix(
            (weights.ravel(), (np.repeat(pixel, 3), corners.ravel())), shape=(width * height, len(top_mm))
        )
        normal, area = _normals(moved, self._triangles)
        steep = np.zeros((width * height, 3))
        facing = np.where(np.abs(normal[triangle, 2:]) > 0.05, normal[triangle, 2:], 0.05)
        steep[pixel] = normal[triangle] / facing
        z = np.full(width * height, np.nan)
        z[pixel] = (weights * moved[corners, 2]).sum(axis=1)
        sample = grey_image(z.reshape(height, width), self._lowest, self._highest)
        reference = self._reference
        both = (reference != 0.0) & (sample != 0.0)
        grey_per_mm = 254.0 / (self._highest - self._lowest)

        mean_r, mean_s = _windows(reference), _windows(sample)
        spread = _windows(reference**2) - mean_r**2 + _windows(sample**2) - mean_s**2
        seen = (_windows((reference != 0.0).astype(float)) > 1e-9) & (_windows((sample != 0.0).astype(float)) > 1e-9)
        counted = seen / max(int(seen.sum()), 1)
        bright = counted / np.maximum(mean_r**2 + mean_s**2, 1.0)
        rough = counted / np.maximum(spread, 2.0 * LEAST_DEVIATION_GREY**2)

        difference = np.where(both, (sample - reference) / grey_per_mm, 0.0).ravel()
        # a height difference counts along the normal, and a pixel sees more surface where it is steep
        cosine = 1.0 / np.maximum(np.linalg.norm(steep, axis=1), 1.0)
        share = np.where(both.ravel(), cosine, 0.0)
        share /= max(float((np.where(both.ravel(), 1.0 / cosine, 0.0)).sum()), 1e-300)
        rms = float(np.sqrt((share * difference**2).sum()))

        rim = self._rim
        start, end = moved[rim[:, 0], :2], moved[rim[:, 1], :2]
        length = np.linalg.norm(end - start, axis=1)
        weight = np.bincount(rim[:, 0], length, len(moved)) + np.bincount(rim[:, 1], length, len(moved))
        weight /= weight.sum()
        on_rim = np.flatnonzero(weight)
        nearest = self._outline_tree.query(moved[on_rim, :2])[1]
        outward = self._outline_normals[nearest]
        off = ((moved[on_rim, :2] - self._outline_points[nearest]) * outward).sum(axis=1)
        outline = float(np.sqrt(weight[on_rim] @ off**2))

        model = QuadraticModel(
            look=look,
            steep=np.where(both.ravel()[:, None], steep, 0.0),
            grey_per_mm=grey_per_mm,
            bright=bright,
            rough=rough,
            share=PER_MM2 * share,
            rim=on_rim,
            outward=outward,
            rim_weight=PER_MM2 * OUTLINE_SHARE * weight[on_rim],
            rotation=transform.rotation,
            project=_RigidProjection(moved, normal, area, self._triangles),
            difference_grey=(sample - reference).ravel(),
            height_mm=difference,
            off_mm=off,
        )
        ssim = ssim_eq4(reference, sample)
        return Measured(
            value=1.0 - ssim + PER_MM2 * (rms**2 + OUTLINE_SHARE * outline**2),
            ssim=ssim,
            rms_mm=rms,
            outline_mm=outline,
            transform=transform,
            model=model,
        )

    def similarity(self, moved_mm: np.ndarray) -> float:
        """Return `ssim_eq4` of a top face that lies over the target as it should [mm], shape [n, 3]."""
        depth = depth_image(moved_mm, self._triangles, self._target.bounds_mm)
        return ssim_eq4(self._reference, grey_image(depth, self._lowest, self._highest))


@dataclass(frozen=True, kw_only=True, eq=False)
class QuadraticModel:
    """The mismatch near one shape, as a quadratic form of small displacements."""

    look: sp.csr_matrix
    steep: np.ndarray
    grey_per_mm: float
    bright: np.ndarray
    rough: np.ndarray
    share: np.ndarray
    rim: np.ndarray
    outward: np.ndarray
    rim_weight: np.ndarray
    rotation: np.ndarray
    project: "_RigidProjection"
    difference_grey: np.ndarray
    height_mm: np.ndarray
    off_mm: np.ndarray

    def weighed(self, *, heights: float, outline: float) -> "QuadraticModel":
        """Return the model with factors on rms^2 and on outline^2/2, beside the similarity.

        Only pixels that show both surfaces count, so that the model is the square of something and never far below
        what it models: it can be minimised by itself. The outline's term stands for the others.
        """
        return replace(
            self,
            share=heights * self.share,
            rim_weight=outline * self.rim_weight,
            difference_grey=self.grey_per_mm * self.height_mm,
        )

    def gradient(self) -> np.ndarray:
        """Return the gradient at the shape itself [1/mm], shape [n, 3]."""
        return self.back(
            self.image_curve(self.difference_grey) * self.grey_per_mm + 2.0 * self.share * self.height_mm,
            2.0 * self.rim_weight * self.off_mm,
        )

    def aligned(self, displacement_mm: np.ndarray) -> np.ndarray:
        """Return what registration leaves of a displacement, in the target's frame [mm], shape [n, 3]."""
        return self.project.apply(displacement_mm @ self.rotation.T)

    def curve(self, displacement_mm: np.ndarray) -> np.ndarray:
        """Return the curvature times a displacement, shape [n, 3]."""
        moved = self.aligned(displacement_mm)
        z = ((self.look @ moved) * self.steep).sum(axis=1)
        image = self.image_curve(self.grey_per_mm * z) * self.grey_per_mm + 2.0 * self.share * z
        off = (moved[self.rim, :2] * self.outward).sum(axis=1)
        return self.back(image, 2.0 * self.rim_weight * off)

    def back(self, by_height: np.ndarray, by_rim: np.ndarray) -> np.ndarray:
        """Return the gradient by vertices in the film's frame from those by pixel heights and rim distances."""
        total = self.look.T @ (by_height[:, None] * self.steep)
        total[self.rim, :2] += by_rim[:, None] * self.outward
        return self.project.transposed(total) @ self.rotation

    def image_curve(self, grey: np.ndarray) -> np.ndarray:
        """Return the derivative of the windows' quadratic form with respect to the grey difference, shape [px]."""
        width, height = SHAPE_PX
        image = grey.reshape(height, width)
        mean = _windows(image)
        spread = _windows_back((self.bright - self.rough) * mean) + image * _windows_back(self.rough)
        return 2.0 * spread.ravel()


class _RigidProjection:
    """Takes the rigid motion out of a displacement that registration would take out: least squares along normals."""

    def __init__(self, points: np.ndarray, normal: np.ndarray, area: np.ndarray, triangles: np.ndarray) -> None:
        weight = np.bincount(triangles.ravel(), np.repeat(area, 3), len(points))
        direction = np.stack(
            [np.bincount(triangles.ravel(), np.repeat(area * part, 3), len(points)) for part in normal.T], axis=1
        )
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        self._arm = points - points.mean(axis=0)
        motions = np.hstack((direction, np.cross(self._arm, direction)))
        self._fit = np.linalg.pinv(motions.T @ (weight[:, None] * motions), rcond=1e-8) @ (weight[:, None] * motions).T
        self._normal = direction

    def apply(self, displacement: np.ndarray) -> np.ndarray:
        motion = self._fit @ (displacement * self._normal).sum(axis=1)
        return displacement - motion[:3] - np.cross(motion[3:], self._arm)

    def transposed(self, gradient: np.ndarray) -> np.ndarray:
        by_motion = np.concatenate((gradient.sum(axis=0), np.cross(self._arm, gradient).sum(axis=0)))
        return gradient - (self._fit.T @ by_motion)[:, None] * self._normal


def _windows(image: np.ndarray) -> np.ndarray:
    """Return the mean over each whole window, shape [h, w] -> [h - 8, w - 8]."""
    margin = WINDOW // 2
    return uniform_filter(image, WINDOW, mode="constant")[margin:-margin, margin:-margin]


def _windows_back(values: np.ndarray) -> np.ndarray:
    """Transpose of `_windows`, shape [h - 8, w - 8] -> [h, w]."""
    return uniform_filter(np.pad(values, WINDOW // 2), WINDOW, mode="constant")


def _normals(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return unit normal and area of each triangle."""
    corners = points[triangles]
    vector = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(vector, axis=1)
    return vector / np.maximum(length, 1e-300)[:, None], 0.5 * length


def _dense_outline(outline_mm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return points along a closed counter-clockwise line and their outward normals, each [k, 2]."""
    closed = np.vstack((outline_mm, outline_mm[:1]))
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))))
    place = np.arange(0.0, along[-1], OUTLINE_STEP_MM)
    points = np.column_stack([np.interp(place, along, part) for part in closed.T])
    tangent = np.roll(points, -1, axis=0) - np.roll(points, 1, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    return points, np.column_stack((tangent[:, 1], -tangent[:, 0]))
