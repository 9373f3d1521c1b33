"""How the energy and the stress of a film answer to the alignment of its layers, in closed form.

The energy per flat area of twin.shell.kernels depends on the alignment vectors q_k = e_k (cos 2 theta, sin 2 theta)
through the layers' metrics and through the heights of the hot stack. With lambda = 1 - g e and |q| = e

    A_k^-1 = m + gamma [[q1, q2], [q2, -q1]],   m = (lambda^-2 + lambda)/2,   gamma = (lambda^-2 - lambda)/(2 e),

both smooth in e; only e = |q| itself has a kink at q = 0, where its derivative is taken as zero.
"""

from dataclasses import dataclass

import numpy as np

from twin.shell.rest import GAUSS_POINTS

TINY = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False)
class Energy:
    """Energy per flat area over mu and its first derivatives, m triangles, L layers."""

    value: np.ndarray
    """[mm], shape [m]."""
    by_form: np.ndarray
    """With respect to (a11, a12, a22, b11, b12, b22), shape [m, 6]."""
    by_q: np.ndarray
    """With respect to the alignment vectors [mm], shape [L, m, 2]."""


class LayerResponse:
    """Energy of a stack of layers as a function of the forms (a, b) and of the alignment vectors."""

    def __init__(
        self,
        q: np.ndarray,
        layer_thickness_mm: np.ndarray,
        *,
        activation: float | np.ndarray = 1.0,
        modulus_ratio: np.ndarray | None = None,
    ) -> None:
        """Work out metrics, heights and their derivatives.

        Args:
            q: alignment vectors, shape [L, m, 2].
            layer_thickness_mm: flat thickness of each layer [mm], shape [L] or [L, m].
            activation: fraction of the full contraction, a number or shape [m].
            modulus_ratio: shear modulus of each layer over the reference, shape [L]; None for 1.
        """
        layers = len(q)
        thickness = np.asarray(layer_thickness_mm, dtype=float).reshape(layers, -1)
        ratio = np.ones(layers) if modulus_ratio is None else np.asarray(modulus_ratio, dtype=float)
        e = np.hypot(q[..., 0], q[..., 1])
        safe = np.maximum(e, TINY)
        unit = q / safe[..., None]
        g = activation
        stretch = 1.0 - g * safe
        along, along_e = stretch**-2.0, 2.0 * g * stretch**-3.0
        gamma = (along - stretch) / (2.0 * safe)
        mean_e, gamma_e = 0.5 * (along_e - g), (0.5 * (along_e + g) - gamma) / safe
        mean = 0.5 * (along + stretch)
        form = np.stack((q[..., 0], 2.0 * q[..., 1], -q[..., 0]), axis=-1)
        self.inverse = gamma[..., None] * form
        self.inverse[..., (0, 2)] += mean[..., None]
        by_e = gamma_e[..., None] * form
        by_e[..., (0, 2)] += mean_e[..., None]
        self.inverse_by_q = by_e[..., None] * unit[..., None, :]
        self.inverse_by_q[..., 0, 0] += gamma
        self.inverse_by_q[..., 1, 1] += 2.0 * gamma
        self.inverse_by_q[..., 2, 0] -= gamma

        hot = thickness * stretch**-0.5
        self._hot_e = 0.5 * g * thickness * stretch**-1.5
        below = np.cumsum(thickness, axis=0) - thickness
        part = np.clip(0.5 * thickness.sum(axis=0) - below, 0.0, thickness)
        self._share = np.divide(part, thickness, out=np.zeros_like(part), where=thickness > 0.0)
        bottom = np.cumsum(hot, axis=0) - hot - (self._share * hot).sum(axis=0)
        self._inside = (0.5 + np.array(GAUSS_POINTS))[:, None, None]
        self.z = bottom + self._inside * hot
        self.weight = 0.5 * thickness * ratio[:, None] / len(GAUSS_POINTS)
        self.c, self.c_e = self.weight * stretch, -g * self.weight
        self.unit = unit
        self.constant = 3.0 * len(GAUSS_POINTS) * self.weight.sum(axis=0)
        powers = (np.ones_like(self.z), self.z, self.z**2)
        self._weights = np.stack([self.weight * power.sum(axis=0) for power in powers])
        """Of the layers in the moments, shape [3, L, m]."""
        self.moments = np.einsum("plm,lmi->pmi", self._weights, self.inverse)

    def energy(self, a: np.ndarray, b: np.ndarray) -> Energy:
        """Return the energy and its derivatives at the forms a and b, each (11, 12, 22), shape [m, 3]."""
        D, N, B, V2 = _invariants(a, b)
        M0, M1, M2 = self.moments
        r = 1.0 / (D - self.z * N + self.z**2 * B)
        value = (M0 * a).sum(-1) - 2.0 * (M1 * b).sum(-1) + (M2 * V2).sum(-1) - self.constant
        value = value + (self.c * D * r**2).sum(axis=(0, 1))
        return Energy(value=value, by_form=self._stress(a, b, r), by_q=self.energy_by_q(a, b))

    def energy_by_q(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """Return the derivative of the energy by the alignment vectors alone [mm], shape [L, m, 2]."""
        D, N, B, V2 = _invariants(a, b)
        r = 1.0 / (D - self.z * N + self.z**2 * B)
        along = (np.einsum("lmi,mi->lm", self.inverse, V) for V in (-2.0 * b, V2))
        by_z = 2.0 * self.c * D * r**3 * (N - 2.0 * self.z * B) + self._moments_by_z(*along)
        by_e = (self.c_e * D * r**2).sum(axis=0) + self._by_contraction(by_z)
        by_inverse = np.einsum("plm,pmi->lmi", self._weights, np.stack((a, -2.0 * b, V2)))
        return np.einsum("lmiq,lmi->lmq", self.inverse_by_q, by_inverse) + by_e[..., None] * self.unit

    def stress_by_q(self, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        """Return the derivative of the stress dW/d(a, b) with respect to q [mm], shape [m, 6, L, 2]."""
        D, N, B, V2 = _invariants(a, b)
        gD, gN, gB = _gradients(a, b)
        r = 1.0 / (D - self.z * N + self.z**2 * B)
        r_z = r**2 * (N - 2.0 * self.z * B)
        identity = np.broadcast_to(np.eye(3), (len(a), 3, 3))
        zero = np.zeros_like(identity)
        inverse_D = (1.0 / D)[:, None, None]
        K2 = inverse_D * (
            _outer(gN, b) - _outer(gD, V2) - _outer(gB, a)
            + np.concatenate((-B[:, None, None] * identity, N[:, None, None] * identity), axis=1)
        )  # fmt: skip
        K = np.concatenate(
            (np.concatenate((identity, zero), axis=1), np.concatenate((zero, -2.0 * identity), axis=1), K2), axis=2
        )
        count, layers = len(a), len(self.unit)
        weighted = (self._weights[..., None, None] * self.inverse_by_q).transpose(2, 0, 3, 1, 4)
        by_q = (K @ weighted.reshape(count, 9, 2 * layers)).reshape(count, 6, layers, 2)
        inverse = self.inverse.transpose(1, 2, 0)
        along = ((K[..., part] @ inverse).transpose(1, 2, 0) for part in (slice(3, 6), slice(6, 9)))
        z, c = self.z, self.c
        scalars_z = (
            c * r * r_z * (2.0 - 6.0 * D * r),
            2.0 * c * D * r**2 * (r + 3.0 * z * r_z),
            -2.0 * c * D * z * r**2 * (2.0 * r + 3.0 * z * r_z),
        )
        scalars_c = (r**2 - 2.0 * D * r**3, 2.0 * D * z * r**3, -2.0 * D * z**2 * r**3)
        gradients = np.stack((gD, gN, gB)).transpose(2, 0, 1)
        by_e = np.einsum("asm,slm->alm", gradients, np.stack([(self.c_e * of_c).sum(axis=0) for of_c in scalars_c]))
        by_e += np.einsum("asm,slm->alm", gradients, np.stack([self._by_contraction(of_z) for of_z in scalars_z]))
        by_e += self._by_contraction(self._moments_by_z(*along))
        return by_q + by_e.transpose(2, 0, 1)[..., None] * self.unit.swapaxes(0, 1)[:, None]

    def _stress(self, a: np.ndarray, b: np.ndarray, r: np.ndarray) -> np.ndarray:
        D, N, B, V2 = _invariants(a, b)
        gD, gN, gB = _gradients(a, b)
        M0, M1, M2 = self.moments
        alpha, beta = (M2 * a).sum(-1), (M2 * b).sum(-1)
        c, z = self.c, self.z
        fD = -(M2 * V2).sum(-1) / D + (c * (r**2 - 2.0 * D * r**3)).sum(axis=(0, 1))
        fN = beta / D + (2.0 * c * D * z * r**3).sum(axis=(0, 1))
        fB = -alpha / D - (2.0 * c * D * z**2 * r**3).sum(axis=(0, 1))
        linear = np.concatenate((M0 - (B / D)[:, None] * M2, -2.0 * M1 + (N / D)[:, None] * M2), axis=1)
        return linear + fD[:, None] * gD + fN[:, None] * gN + fB[:, None] * gB

    def _moments_by_z(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """Return the derivative by the heights, [..., 2, L, m], of what depends on the moments of powers 1 and 2.

        Args:
            first: derivative by what z multiplies in the first moment, for each layer, shape [..., L, m].
            second: the same of the second one.
        """
        return self.weight * (first[..., None, :, :] + 2.0 * self.z * second[..., None, :, :])

    def _by_contraction(self, by_z: np.ndarray) -> np.ndarray:
        """Return the derivative by e, [..., L, m], of what has this one by the heights of Gauss points, [..., 2, L, m].

        With the layers' hot thickness t, dz[g, l] / dt[k] is 1 for k < l, plus the point's own place inside for k = l,
        less the share of layer k that is below the middle.
        """
        whole = by_z.sum(axis=-3)
        above = whole[..., ::-1, :].cumsum(axis=-2)[..., ::-1, :] - whole
        own = (self._inside * by_z).sum(axis=-3)
        return self._hot_e * (above + own - self._share * whole.sum(axis=-2, keepdims=True))


def _invariants(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return D = det a, N = D tr(a^-1 b), B = det b, each [m], and b a^-1 b = (N b - B a)/D, shape [m, 3]."""
    D = a[:, 0] * a[:, 2] - a[:, 1] ** 2
    N = a[:, 2] * b[:, 0] + a[:, 0] * b[:, 2] - 2.0 * a[:, 1] * b[:, 1]
    B = b[:, 0] * b[:, 2] - b[:, 1] ** 2
    return D, N, B, (N[:, None] * b - B[:, None] * a) / D[:, None]


def _gradients(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the gradients of D, N and B with respect to (a, b), each shape [m, 6]."""
    by_a = np.column_stack((a[:, 2], -2.0 * a[:, 1], a[:, 0]))
    by_b = np.column_stack((b[:, 2], -2.0 * b[:, 1], b[:, 0]))
    zero = np.zeros_like(by_a)
    return np.hstack((by_a, zero)), np.hstack((by_b, by_a)), np.hstack((zero, by_b))


def _outer(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return u[:, :, None] * v[:, None, :]
