"""A film whose temperature is not that of the plate everywhere, for the same ramps as a uniform one."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from twin.equilibrium import Equilibrium, Newton
from twin.film import Film
from twin.material import Material
from twin.shell import Loads, Shell
from twin.temperature.field import ROOM_C, TemperatureField, field_activation
from twin.temperature.settle import settle_activation


def plate_temperature_c(share: ArrayLike, material: Material, temperature_c: float) -> np.ndarray:
    """Return the plate's temperature at a share of the heating, from the room's at 0 to `temperature_c` at 1 [C].

    Equal steps take equal steps of temperature and of activation, each counting half: lifted film goes on contracting
    where the film on the plate has long done so.
    """
    temperature, shares = _heating(material, temperature_c)
    return np.interp(np.asarray(share, dtype=float), shares, temperature)


def plate_share(plate_c: ArrayLike, material: Material, temperature_c: float) -> np.ndarray:
    """Return the share of a heating to `temperature_c` at which the plate has a temperature [C]."""
    temperature, shares = _heating(material, temperature_c)
    return np.interp(np.asarray(plate_c, dtype=float), temperature, shares)


def _heating(material: Material, temperature_c: float) -> tuple[np.ndarray, np.ndarray]:
    """Return temperatures of the plate from the room's on [C], and the share of the heating at each, both ascending."""
    temperature = np.linspace(ROOM_C, temperature_c, 2001)
    activation = material.activation(temperature)
    done = np.linspace(0.0, 1.0, 2001) + activation / max(float(activation[-1]), 1e-300)
    return temperature, done / done[-1]


class FieldShell(Shell):
    """A shell in a temperature field: a ramp prescribes the share of the heating instead of the activation."""

    def __init__(
        self,
        film: Film,
        *,
        field: TemperatureField,
        material: Material,
        temperature_c: float,
        loads: Loads | None = None,
        device: str = "cpu",
    ) -> None:
        """Prepare the film, cold.

        Args:
            film: the film.
            field: temperature of each triangle from shape and plate.
            material: activation from temperature.
            temperature_c: temperature of the plate at the end of the heating [C].
            loads: weight and plate.
            device: device that the kernels run on.
        """
        self.field, self._material, self._end_c = field, material, temperature_c
        self._shape = np.column_stack((film.flat_mm, np.zeros(len(film.flat_mm))))
        self.plate_c = ROOM_C
        super().__init__(film, loads=loads, device=device)

    def set_activation(self, activation: float | np.ndarray) -> None:
        """Prescribe the share of the heating (a number), or the activation of each triangle (shape [m])."""
        if np.ndim(activation) == 0:
            self.plate_c = float(plate_temperature_c(activation, self._material, self._end_c))
            activation = self.activation_of(self._shape)
        super().set_activation(activation)

    def activation_of(self, vertices_mm: np.ndarray) -> np.ndarray:
        """Return the activation that belongs to a shape [n, 3] at the present temperature of the plate, shape [m].

        From then on a share of the heating means this shape.
        """
        self._shape = vertices_mm
        return field_activation(self.field, self._material, self.film, vertices_mm, self.plate_c)


class FieldNewton(Newton):
    """Newton's method for shape and temperature together.

    Stability is that of the shape at its temperatures: a film that cools where it rises is stable then, too.
    """

    def prescribe(self, activation: float, vertices_mm: np.ndarray) -> None:
        """Prescribe a share of the heating, with the temperatures that belong to a shape [mm], shape [n, 3]."""
        shell = self._field_shell()
        shell.set_activation(activation)
        shell.set_activation(shell.activation_of(vertices_mm))

    def solve(self, start_mm: np.ndarray, *, force_scale: float, tolerance: float) -> Equilibrium:
        """Descend from `start_mm` [n, 3] to a stable equilibrium with the temperatures that belong to it.

        Raises:
            SolverError: if no equilibrium is found, or shape and temperature do not settle.
        """
        shell = self._field_shell()
        if not shell.field.follows_shape:
            shell.set_activation(shell.activation_of(start_mm))
            return super().solve(start_mm, force_scale=force_scale, tolerance=tolerance)
        rounds: list[Equilibrium] = []

        def follow(activation: np.ndarray) -> np.ndarray:
            shell.set_activation(activation)
            start = rounds[-1].vertices_mm if rounds else start_mm
            rounds.append(super(FieldNewton, self).solve(start, force_scale=force_scale, tolerance=tolerance))
            return shell.activation_of(rounds[-1].vertices_mm)

        settle_activation(follow, shell.activation_of(start_mm))
        return replace(rounds[-1], iterations=sum(found.iterations for found in rounds))

    def _field_shell(self) -> FieldShell:
        if not isinstance(self.shell, FieldShell):
            raise TypeError("FieldNewton needs a FieldShell")
        return self.shell
