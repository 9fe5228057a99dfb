"""The library and the ROS 2 messages, which have one import name, in one process; run by wheels.sh with the folder in which
`column_twin` and the one in which `column_twin.msg` must be found."""

import sys

import column_twin
import column_twin.msg
from column_twin import Column
from column_twin.msg import ColumnState
from column_twin.srv import PredictImpact

package, messages = sys.argv[1:]
assert (column_twin.__file__ or "").startswith(package), column_twin.__file__
assert (column_twin.msg.__file__ or "").startswith(messages), column_twin.msg.__file__

state = ColumnState()
state.v1 = Column().screen("mid_car", velocity=5.0).max_v1
assert 0.0 < state.v1 < 0.1, state.v1
assert PredictImpact.Request() is not None
print("the library and the messages work;", "column_twin is in", column_twin.__path__)
