"""column_twin: what a vehicle does to a steel column, and the ROS 2 messages of its digital twin.

Two distributions share this name. `pip install column-twin` brings the library::

    from column_twin import Column

    result = Column().simulate(vehicle="mid_car", velocity=10.0)

and the ROS 2 package `column_twin` brings the messages::

    from column_twin.msg import ColumnState

Each installs this same file, so that they work alone, in one folder, and in two folders in any order of `sys.path`.
"""

from pkgutil import extend_path

__path__ = extend_path(__path__, __name__)
del extend_path

try:
    from ._library import *
    from ._library import __all__, __version__
except ModuleNotFoundError as missing:
    # The messages without the library; anything else that is missing is a fault of the installation.
    if missing.name != __name__ + "._library":
        raise

    def __getattr__(name: str) -> object:
        raise AttributeError(
            f"module {__name__!r} has no attribute {name!r}: only the ROS 2 messages are installed. "
            "For the library: pip install column-twin"
        )
