"""column_twin: what a vehicle does to a steel column::

    from column_twin import Column

    result = Column().simulate(vehicle="mid_car", velocity=10.0)

The messages of the digital twin in ROS 2 are the package `column_twin_msgs`.
"""

# First, because it explains why the package does not work on this platform, whatever else is missing there.
from ._loading import native

from ._capacity import Capacity, PushDown
from ._catalogue import Section, Vehicle, sections, vehicles
from ._codes import CRITERIA, Action, Outcome
from ._column import Column
from ._errors import ColumnTwinError, ParameterError, ParameterWarning, SimulationError
from ._evaluation import EVALUATION, Evaluation, to_pandas
from ._map import CriticalVelocity, Map, MapAxis
from ._result import Result
from ._risk import Estimate, Risk

__version__: str = native.VERSION

__all__ = [
    "CRITERIA",
    "EVALUATION",
    "Action",
    "Capacity",
    "Column",
    "ColumnTwinError",
    "CriticalVelocity",
    "Estimate",
    "Evaluation",
    "Map",
    "MapAxis",
    "Outcome",
    "ParameterError",
    "ParameterWarning",
    "PushDown",
    "Result",
    "Risk",
    "Section",
    "SimulationError",
    "Vehicle",
    "__version__",
    "sections",
    "to_pandas",
    "vehicles",
]
