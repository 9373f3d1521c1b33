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
        hot_e = 0.5 * g * thickness * stretch**-1.5
        below = np.cumsum(thickness, axis=0) - thickness
        part = np.clip(0.5 * thickness.sum(axis=0) - below, 0.0, thickness)
        share = np.divide(part, thickness, out=np.zeros_like(part), where=thickness > 0.0)
        bottom = np.cumsum(hot, axis=0) - hot - (share * hot).sum(axis=0)
        inside = 0.5 + np.array(GAUSS_POINTS)
        self.z = bottom + inside[:, None, None] * hot
        lower = (np.arange(layers)[:, None] > np.arange(layers)).astype(float)
        # d z[g, layer] / d hot[k]
        by_hot = (
            lower[None, :, :, None] + inside[:, None, None, None] * np.eye(layers)[None, :, :, None] - share[None, None]
        )
        self.z_by_e = by_hot * hot_e
        self.weight = 0.5 * thickness * ratio[:, None] / len(GAUSS_POINTS)
        self.c, self.c_e = self.weight * stretch, -g * self.weight
        self.unit = unit
        self.constant = 3.0 * len(GAUSS_POINTS) * self.weight.sum(axis=0)
        powers = (np.ones_like(self.z), self.z, self.z**2)
        self.moments = [
            np.einsum("lm,glm,lmi->mi", np.broadcast_to(self.weight, e.shape), power, self.inverse) for power in powers
        ]

    def energy(self, a: np.ndarray, b: np.ndarray) -> Energy:
        """Return the energy and its derivatives at the forms a and b, each (11, 12, 22), shape [m, 3]."""
        D, N, B, V2 = _invariants(a, b)
        M0, M1, M2 = self.moments
        r = 1.0 / (D - self.z * N + self.z**2 * B)
        value = (M0 * a).sum(-1) - 2.0 * (M1 * b).sum(-1) + (M2 * V2).sum(-1) - self.constant
        value = value + (self.c * D * r**2).sum(axis=(0, 1))
        stress = self._stress(a, b, r)
        by_z = 2.0 * self.c * D * r**3 * (N - 2.0 * self.z * B)
        by_q = np.zeros_like(self.unit)
        by_e = (self.c_e * D * r**2).sum(axis=0) + np.einsum("glm,glkm->km", by_z, self.z_by_e)
        for power, V in enumerate((a, -2.0 * b, V2)):
            direct, stacked = self._moment_weights(power)
            by_q += direct[..., None] * np.einsum("lmiq,mi->lmq", self.inverse_by_q, V)
            if power:
                by_e += np.einsum("lkm,lmi,mi->km", stacked, self.inverse, V)
        return Energy(value=value, by_form=stress, by_q=by_q + by_e[..., None] * self.unit)

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
        K = (np.concatenate((identity, zero), axis=1), np.concatenate((zero, -2.0 * identity), axis=1), K2)
        by_e = np.zeros((len(a), 6, len(self.unit)))
        by_q = np.zeros((len(a), 6, *self.unit.shape[::2]))
        for power, tensor in enumerate(K):
            direct, stacked = self._moment_weights(power)
            by_q += np.einsum("mai,lm,lmiq->malq", tensor, direct, self.inverse_by_q, optimize=True)
            if power:
                by_e += np.einsum("mai,lkm,lmi->mak", tensor, stacked, self.inverse, optimize=True)
        z, c, z_e = self.z, self.c, self.z_by_e
        scalars_z = (
            c * r * r_z * (2.0 - 6.0 * D * r),
            2.0 * c * D * r**2 * (r + 3.0 * z * r_z),
            -2.0 * c * D * z * r**2 * (2.0 * r + 3.0 * z * r_z),
        )
        scalars_c = (r**2 - 2.0 * D * r**3, 2.0 * D * z * r**3, -2.0 * D * z**2 * r**3)
        for gradient, of_z, of_c in zip((gD, gN, gB), scalars_z, scalars_c, strict=True):
            change = np.einsum("glm,glkm->mk", of_z, z_e) + (self.c_e * of_c).sum(axis=0).T
            by_e += gradient[:, :, None] * change[:, None, :]
        return by_q + by_e[..., None] * self.unit.swapaxes(0, 1)[:, None]

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

    def _moment_weights(self, power: int) -> tuple[np.ndarray, np.ndarray]:
        """Return weights of d inverse/dq in the moment, [L, m], and of inverse[l] in its change by e[k], [L, L, m]."""
        weight = np.broadcast_to(self.weight, self.unit.shape[:2])
        direct = weight * (self.z**power).sum(axis=0)
        if power == 0:
            return direct, np.empty(0)
        return direct, weight[:, None] * power * np.einsum("glm,glkm->lkm", self.z ** (power - 1), self.z_by_e)


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
