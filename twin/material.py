"""The liquid crystal elastomer: how far it contracts at a temperature, how stiff and heavy it is."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from planner.errors import InputError

GRAVITY_MM_S2 = 9810.0

ACTIVATION_TABLE = (
    (25.0, 0.0),
    (40.0, 0.024),
    (50.0, 0.039),
    (60.0, 0.065),
    (70.0, 0.110),
    (80.0, 0.139),
    (90.0, 0.238),
    (100.0, 0.354),
    (110.0, 0.823),
    (120.0, 1.0),
)
"""(temperature [C], fraction of the full contraction) of a main-chain LCE whose nematic-isotropic transition is at
85 C by calorimetry: free contraction along the director measured by Korpas et al., doi 10.1021/acsami.1c07327,
over its largest value. Another ink has another table."""

TABLE_TRANSITION_C = 85.0


@dataclass(frozen=True, kw_only=True)
class Material:
    """Constants of the hot elastomer. None of them is measured for the paper's ink: set your own."""

    modulus_mpa: float = 0.5
    """Young's modulus when hot [MPa]; literature 0.2 to 2. Incompressible, so the shear modulus is a third."""
    density_kg_m3: float = 1200.0
    """Density [kg/m^3]."""
    transition_c: float = TABLE_TRANSITION_C
    """Nematic-isotropic temperature [C]; shifts the activation table."""

    def __post_init__(self) -> None:
        problems = [
            f"material: {name} is {value:g}, allowed is {allowed}; {hint}."
            for name, value, fine, allowed, hint in (
                ("modulus_mpa", self.modulus_mpa, self.modulus_mpa > 0, "a positive modulus", "the default is 0.5 MPa"),
                ("density_kg_m3", self.density_kg_m3, self.density_kg_m3 >= 0, "0 or more", "the default is 1200"),
                (
                    "transition_c",
                    self.transition_c,
                    -50 < self.transition_c < 150,
                    "-50 to 150 C",
                    "the default is 85 C",
                ),
            )
            if not (fine and np.isfinite(value))
        ]
        if problems:
            raise InputError(problems)

    @property
    def shear_modulus_mpa(self) -> float:
        """Shear modulus mu = E / 3 [MPa]."""
        return self.modulus_mpa / 3.0

    @property
    def weight_n_mm3(self) -> float:
        """Weight density rho g [N/mm^3]."""
        return self.density_kg_m3 * 1e-9 * GRAVITY_MM_S2 * 1e-3

    def activation(self, temperature_c: float | np.ndarray) -> np.ndarray:
        """Return the fraction g of the full contraction at a temperature [C]; 0 when cold, 1 when hot."""
        temperature, fraction = np.array(ACTIVATION_TABLE).T
        shifted = np.asarray(temperature_c) - (self.transition_c - TABLE_TRANSITION_C)
        return np.asarray(PchipInterpolator(temperature, fraction)(np.clip(shifted, temperature[0], temperature[-1])))

    def temperature_c(self, activation: float | np.ndarray) -> np.ndarray:
        """Return the lowest temperature [C] at which the fraction `activation` is reached."""
        fine = np.linspace(ACTIVATION_TABLE[0][0], ACTIVATION_TABLE[-1][0], 2001)
        shift = self.transition_c - TABLE_TRANSITION_C
        return np.asarray(np.interp(activation, self.activation(fine + shift), fine)) + shift
