"""The numbers with which a column is computed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ColumnProperties:
    """The numbers with which a column is computed: as they are given, or as they follow from section, steel and supports.
    `Column.properties` makes it. All units are SI; docs/theory.md explains the symbols."""

    section: str
    """Name of the section in the catalogue; empty for a user-defined section."""
    steel: str
    """Grade of the steel; empty for user-defined steel."""
    height: float
    """L_a + L_b: height of the column [m]."""
    impact_height: float
    """L_a: height of the impact point above the base [m]. Where `geometry.height` gives the column, a vehicle that a call names strikes
    at its own height instead."""
    area: float
    """A: area of the section [m^2]."""
    second_moment: float
    """I: second moment of area about the axis of bending [m^4]."""
    mass_per_length: float
    """m_l: mass per length [kg/m]."""
    young_modulus: float
    """E: Young's modulus [Pa]."""
    yield_strength: float
    """f_y: yield strength [Pa]."""
    axial_rigidity: float
    """EA: axial rigidity [N]."""
    bending_stiffness: float
    """EI: bending stiffness [N m^2]."""
    resistance_moment: float
    """M^p: plastic moment resistance without normal force [N m]."""
    resistance_axial: float
    """N^p: plastic axial resistance, the squash load [N]."""
    load: float
    """P: constant vertical load at the top, positive in compression [N]."""
    step: float
    """Length of a time step of the two bars [s]."""
