"""The impact of a vehicle on a steel column: response, residual capacity, required action, damage maps and risk::

    from column_twin import Column

    result = Column().simulate("mid_car", velocity=10.0)
    print(result.action, result.max_v1)  # the action, and the peak displacement [m]

All quantities are in SI units. docs/python.md in the repository describes the library, and docs/assessment.md and docs/validation.md
its limits. The messages of the digital twin in ROS 2 are the package `column_twin_msgs`.
"""

# First, because it explains why the package does not work on this platform, whatever else is missing there.
from ._loading import native

from ._capacity import Capacity, PushDown
from ._catalogue import Section, Vehicle, sections, vehicles
from ._codes import CRITERIA, Action, Outcome
from ._column import Column
from ._errors import ColumnTwinError, IncompleteWarning, ParameterError, ParameterWarning, ProgramError, SimulationError
from ._evaluation import EVALUATION, Evaluation, to_pandas
from ._map import CriticalVelocity, Map, MapAxis, RefinedMap
from ._program import read_recording, recording_info, run_program
from ._properties import ColumnProperties
from ._range import Range
from ._result import Result
from ._risk import Estimate, Risk
from ._sensors import ImpactEstimate, Readings

__version__: str = native.VERSION
"""The version of the library, which is also that of the program `column-twin`."""

__all__ = [
    "CRITERIA",
    "EVALUATION",
    "Action",
    "Capacity",
    "Column",
    "ColumnProperties",
    "ColumnTwinError",
    "CriticalVelocity",
    "Estimate",
    "Evaluation",
    "ImpactEstimate",
    "IncompleteWarning",
    "Map",
    "MapAxis",
    "Outcome",
    "ParameterError",
    "ParameterWarning",
    "ProgramError",
    "PushDown",
    "Range",
    "Readings",
    "RefinedMap",
    "Result",
    "Risk",
    "Section",
    "SimulationError",
    "Vehicle",
    "__version__",
    "read_recording",
    "recording_info",
    "run_program",
    "sections",
    "to_pandas",
    "vehicles",
]
