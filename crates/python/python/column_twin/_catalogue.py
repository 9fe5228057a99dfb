"""The catalogues of sections and of vehicles."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from typing import Any

from ._loading import native


@dataclass(frozen=True)
class Section:
    """A rolled section of EN 10365, computed with its fillets; bending is about the strong axis. SI units."""

    name: str
    """Such as HEB220."""
    depth: float
    """h [m]."""
    width: float
    """b [m]."""
    web_thickness: float
    """t_w [m]."""
    flange_thickness: float
    """t_f [m]."""
    root_radius: float
    """r [m]."""
    area: float
    """A [m2]."""
    second_moment: float
    """I [m4]."""
    plastic_modulus: float
    """W_pl [m3]."""
    mass_per_length: float
    """[kg/m]"""


@dataclass(frozen=True)
class Vehicle:
    """A vehicle of the catalogue."""

    name: str
    """Such as mid_car."""
    description: str
    """A few words about it."""
    mass: float
    """Total mass [kg]."""
    data: dict[str, Any]
    """Every number with its tag ([T] read in the source, [C] computed, [M] recalled and not verified, [A] assumption) and its
    source, as in config/vehicles.json."""

    def __repr__(self) -> str:
        return f"<Vehicle {self.name}: {self.description}, {self.mass:g} kg>"


@cache
def sections() -> dict[str, Section]:
    """Every section that the parameter `section.name` knows, family by family, smallest first."""
    return {name: Section(name, *numbers) for name, numbers in native.sections()}


@cache
def vehicles() -> dict[str, Vehicle]:
    """Every deformable vehicle that `vehicle` may name, lightest class first; `rigid` is the paper's rigid mass."""
    rows = json.loads(native.VEHICLES_JSON)["vehicles"]
    return {row["name"]: Vehicle(row["name"], row["description"], sum(row["masses"]["kg"]), row) for row in rows}
