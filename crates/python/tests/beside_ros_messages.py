"""The library and the ROS 2 messages in one process; run by wheels.sh with the folders in which `column_twin` and `column_twin_msgs`
must be found."""

import sys

import column_twin
import column_twin_msgs.msg
from column_twin import Column
from column_twin_msgs.msg import ColumnState
from column_twin_msgs.srv import PredictImpact

library, messages = sys.argv[1:]
assert (column_twin.__file__ or "").startswith(library + "/"), column_twin.__file__
assert (column_twin_msgs.msg.__file__ or "").startswith(messages + "/"), column_twin_msgs.msg.__file__

state = ColumnState()
state.v1 = Column().evaluate("mid_car", velocity=5.0).max_v1
assert 0.0 < state.v1 < 0.1, state.v1
assert PredictImpact.Request() is not None
print("the library and the messages work; they are in", library, "and", messages)
