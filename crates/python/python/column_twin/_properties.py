"""What a column consists of, with every number that follows from others."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ColumnProperties:
    """The numbers with which a column is computed: as given, or as they follow from section, steel and supports. SI units."""

    section: str
    """Name in the catalogue; empty for a user-defined section."""
    steel: str
    """Grade; empty for a user-defined steel."""
    height: float
    """L_a + L_b [m]."""
    impact_height: float
    """L_a: height of the impact point above the base [m]."""
    area: float
    """A [m2]."""
    second_moment: float
    """I about the axis of bending [m4]."""
    mass_per_length: float
    """m_l [kg/m]."""
    young_modulus: float
    """E [Pa]."""
    yield_strength: float
    """f_y [Pa]."""
    axial_rigidity: float
    """EA [N]."""
    bending_stiffness: float
    """EI [N m2]."""
    resistance_moment: float
    """M^p: plastic moment [N m]."""
    resistance_axial: float
    """N^p: squash load [N]."""
    load: float
    """P: load at the top [N]."""
    step: float
    """Length of a time step [s]."""
