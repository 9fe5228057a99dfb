"""The catalogues of sections and of vehicles."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from ._loading import native


@dataclass(frozen=True)
class Section:
    """A rolled section of the catalogue: dimensions from EN 10365, and properties that are computed from them with the fillets. Second
    moment and plastic modulus are about the strong axis. All units are SI."""

    name: str
    """Name without spaces, such as HEB220."""
    depth: float
    """h: depth of the section in the plane of bending [m], the parameter `section.height`."""
    width: float
    """b: width of the flanges [m]."""
    web_thickness: float
    """t_w: thickness of the web [m]."""
    flange_thickness: float
    """t_f: thickness of the flanges [m]."""
    root_radius: float
    """r: radius of the fillets between web and flanges [m]."""
    area: float
    """A: area [m^2]."""
    second_moment: float
    """I: second moment of area about the strong axis [m^4]."""
    plastic_modulus: float
    """W_pl: plastic section modulus about the strong axis [m^3]."""
    mass_per_length: float
    """m_l: mass per length [kg/m]."""


@dataclass(frozen=True)
class Vehicle:
    """A deformable vehicle of the catalogue, which the argument `vehicle` and the parameter `vehicle.name` take."""

    name: str
    """Name, such as mid_car."""
    description: str
    """Description in a few words."""
    mass: float
    """Total mass, which an impact has unless another one is given [kg]."""
    data: dict[str, Any]
    """Every number with its source and its tag, as in config/vehicles.json; the names end with the SI unit. The tags are [T] read in the
    source, [C] computed, [M] recalled and not verified, and [A] assumption."""

    def __repr__(self) -> str:
        return f"<Vehicle {self.name}: {self.description}, {self.mass:g} kg>"


def sections() -> dict[str, Section]:
    """The sections that the parameter `section.name` may name, by their names without spaces, family by family with the smallest first.

    >>> sections()["HEB220"].area
    """
    return {name: Section(name, *numbers) for name, numbers in native.sections()}


def vehicles() -> dict[str, Vehicle]:
    """The deformable vehicles that `vehicle` may name, by their names, with the lightest class first. The name `rigid`, which is not
    among them, is a rigid mass without a mass of its own.

    >>> vehicles()["mid_car"].mass
    """
    rows = json.loads(native.VEHICLES_JSON)["vehicles"]
    return {row["name"]: Vehicle(row["name"], row["description"], sum(row["masses"]["kg"]), row) for row in rows}
