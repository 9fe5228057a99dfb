#!/usr/bin/env python3
"""Reads a recording with independent readers and compares every message and value with what was written.

    read_recording.py DIRECTORY EXPECTED

EXPECTED has one line of JSON per message in order of time: topic, type, log_time, publish_time, data (hexadecimal) and
message (its fields; null is a number that JSON cannot write). Started by tests/recording/other_readers.rs.
"""

import json
import math
import subprocess
import sys
from pathlib import Path

import mcap.reader
import mcap_ros2.decoder
import rerun_sdk.rerun_cli
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore


def same(found, expected):
    """Whether a value equals the one that was written."""
    if expected is None:
        return isinstance(found, float) and not math.isfinite(found)
    if isinstance(expected, dict):
        return all(same(getattr(found, name), value) for name, value in expected.items())
    if isinstance(expected, list):
        return len(found) == len(expected) and all(same(float(it) if isinstance(value, float) or value is None else it, value)
                                                   for it, value in zip(found, expected))
    return found == expected


class Comparison:
    """Compares messages one by one with the expected ones."""

    def __init__(self, reader, expected):
        self.reader, self.expected, self.read = reader, expected, 0

    def message(self, topic, type_name, log_time, data, decoded, publish_time=None):
        if self.read >= len(self.expected):
            sys.exit(f"{self.reader}: more than the {len(self.expected)} messages that were written")
        expected = self.expected[self.read]
        pairs = [(topic, expected["topic"]), (type_name, expected["type"]), (log_time, int(expected["log_time"])),
                 (bytes(data).hex(), expected["data"])]
        if publish_time is not None:
            pairs.append((publish_time, int(expected["publish_time"])))
        for found, wanted in pairs:
            if found != wanted:
                sys.exit(f"{self.reader}, message {self.read}: expected {wanted!r}, found {found!r}")
        if not same(decoded, expected["message"]):
            sys.exit(f"{self.reader}, message {self.read} of {topic}: expected {expected['message']}, found {decoded}")
        self.read += 1

    def end(self):
        if self.read != len(self.expected):
            sys.exit(f"{self.reader}: expected {len(self.expected)} messages, found {self.read}")
        print(f"{self.reader}: {self.read} messages")


def with_rosbags(path, expected):
    comparison = Comparison(f"rosbags, {'directory' if path.is_dir() else 'bare file'}", expected)
    # No type is known in advance: the definitions in the recording must suffice.
    with AnyReader([path], default_typestore=get_typestore(Stores.EMPTY)) as reader:
        for connection, log_time, data in reader.messages():
            decoded = reader.deserialize(data, connection.msgtype)
            comparison.message(connection.topic, connection.msgtype, log_time, data, decoded)
    comparison.end()


def metadata_with_rosbags(path, expected):
    """metadata.yaml agrees with the file."""
    with Reader(path) as reader:
        counts = {}
        for message in expected:
            counts[message["topic"]] = counts.get(message["topic"], 0) + 1
        found = {it.topic: it.msgcount for it in reader.connections if it.msgcount}
        if (found, reader.message_count) != (counts, len(expected)):
            sys.exit(f"rosbags, metadata.yaml: expected {counts}, found {found} and {reader.message_count}")
        times = [int(it["log_time"]) for it in expected]
        # The end is the first nanosecond after the last message.
        if (reader.start_time, reader.end_time) != (min(times), max(times) + 1):
            sys.exit(f"rosbags, metadata.yaml: times {reader.start_time} to {reader.end_time}")
        for connection in reader.connections:
            if not connection.digest.startswith("RIHS01_") or len(connection.ext.offered_qos_profiles) != 1:
                sys.exit(f"rosbags, metadata.yaml: {connection}")


def with_mcap(path, expected):
    comparison = Comparison("mcap with mcap-ros2-support", expected)
    with path.open("rb") as stream:
        factory = mcap_ros2.decoder.DecoderFactory()
        reader = mcap.reader.make_reader(stream, validate_crcs=True, decoder_factories=[factory])
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            comparison.message(channel.topic, schema.name, message.log_time, message.data, decoded, message.publish_time)
        statistics = reader.get_summary().statistics
        if statistics.message_count != len(expected):
            sys.exit(f"mcap: statistics say {statistics.message_count} messages, not {len(expected)}")
    comparison.end()


def with_rerun(path):
    program = Path(rerun_sdk.rerun_cli.__file__).parent / "rerun"
    result = subprocess.run([program, "mcap", "check", path], capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(f"rerun mcap check: {result.returncode}\n{result.stdout}{result.stderr}")
    print(f"rerun mcap check: {(result.stdout + result.stderr).strip().splitlines()[-1]}")


def main():
    directory, expected_path = Path(sys.argv[1]), Path(sys.argv[2])
    expected = [json.loads(line) for line in expected_path.read_text().splitlines()]
    file, = directory.glob("*.mcap")
    with_rosbags(directory, expected)
    with_rosbags(file, expected)
    metadata_with_rosbags(directory, expected)
    with_mcap(file, expected)
    with_rerun(file)


if __name__ == "__main__":
    main()
