#!/usr/bin/env python3
"""Writes a recording in the format of rosbag2 with an independent writer: 500 states of a column at 1 kHz and 100 texts.

    write_recording.py DIRECTORY

Started by tests/evidence/replayed.rs.
"""

import sys
from pathlib import Path

import numpy
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

MESSAGES = Path(__file__).parents[2] / "msg"
START = 1_800_000_000_000_000_000
MILLISECOND = 1_000_000


def main():
    store = get_typestore(Stores.ROS2_JAZZY)
    for path in MESSAGES.glob("*.msg"):
        store.register(get_types_from_msg(path.read_text(), f"column_twin_msgs/msg/{path.stem}"))
    state_type = store.types["column_twin_msgs/msg/ColumnState"]
    header_type = store.types["std_msgs/msg/Header"]
    time_type = store.types["builtin_interfaces/msg/Time"]
    text_type = store.types["std_msgs/msg/String"]

    def state(index):
        nanos = START + index * MILLISECOND
        values = {}
        for name, (kind, detail) in store.get_msgdef("column_twin_msgs/msg/ColumnState").fields:
            base = detail[0] if kind.name == "BASE" else None
            # Of a vehicle of one mass, every sequence has one number.
            one = numpy.array([0.25]) if kind.name == "SEQUENCE" else 0.0
            values[name] = {"string": "", "uint8": 0, "uint64": 0}.get(base, one)
        values["header"] = header_type(stamp=time_type(sec=nanos // 10**9, nanosec=nanos % 10**9), frame_id="column")
        values["column_id"], values["event_id"], values["v1"] = "column", "foreign", 1e-3 * index
        return state_type(**values)

    with Writer(Path(sys.argv[1]), version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        states = writer.add_connection("/column_state", state_type.__msgtype__, typestore=store)
        texts = writer.add_connection("/remarks", text_type.__msgtype__, typestore=store)
        for index in range(500):
            at = START + index * MILLISECOND
            writer.write(states, at, store.serialize_cdr(state(index), state_type.__msgtype__))
            if index % 5 == 0:
                writer.write(texts, at, store.serialize_cdr(text_type(data=f"remark {index}"), text_type.__msgtype__))


if __name__ == "__main__":
    main()
