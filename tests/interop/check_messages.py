#!/usr/bin/env python3
"""Checks msg/ and srv/, and the golden data generated from them, against ROS 2.

Run by the Python of tests/interop/environment.sh:

    check_messages.py           compares; exit code 1 with a list of what differs
    check_messages.py --write   rewrites tests/data/messages/golden.json, then compares
    check_messages.py --kilted  compares with the environment of `environment.sh kilted`, where the comments of ROS's own
                                definitions may be others than in msg/deps/, which are those of Jazzy

For every type golden.json holds a filled message, its bytes as `rosbags` writes them (which shares no code with ROS 2 or
with column_twin) and its type hash as rosidl wrote it. The fast tests of the Rust side read that file; this script
checks that `rclpy` (rosidl's type support, Fast CDR) writes the same bytes and reads them back, that the hashes are those
of the installed packages, and that msg/deps/ holds the installed definitions, byte by byte.
"""

import importlib
import itertools
import json
import sys
from pathlib import Path

from rclpy.serialization import deserialize_message, serialize_message
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

REPOSITORY = Path(__file__).resolve().parents[2]
GOLDEN = REPOSITORY / "tests/data/messages/golden.json"
# The hidden byte, always zero, that rosidl sends for a type without fields.
PLACEHOLDER = "structure_needs_at_least_one_member"
# RTPS pads a payload to a multiple of four bytes.
LONGEST_PADDING = 3
SHARE = Path(sys.prefix) / "share"
OURS = "column_twin_msgs"


def definition_files():
    """(package, file) of every definition in the repository."""
    for path in sorted([*REPOSITORY.glob("msg/*.msg"), *REPOSITORY.glob("srv/*.srv")]):
        yield OURS, path
    for path in sorted([*REPOSITORY.glob("msg/deps/*/*.msg"), *REPOSITORY.glob("msg/deps/*/*.srv")]):
        yield path.parent.name, path


def definitions():
    """(package, msg or srv, type name, text) of every message and of both halves of every service."""
    for package, path in definition_files():
        text = path.read_text()
        if path.suffix == ".msg":
            yield package, "msg", path.stem, text
        else:
            request, response = ("\n" + text).split("\n---\n")
            yield package, "srv", f"{path.stem}_Request", request
            yield package, "srv", f"{path.stem}_Response", response


def rosbags_name(package, name):
    """rosbags supports only messages, so the halves of a service are treated as messages."""
    return f"{package}/msg/{name}"


class Writer:
    """Fills and writes messages with rosbags, using only our definitions."""

    def __init__(self):
        self.store = get_typestore(Stores.EMPTY)
        for package, _, name, text in definitions():
            known = rosbags_name(package, name)
            if not any(line.split("#")[0].strip() for line in text.splitlines()):
                text = f"uint8 {PLACEHOLDER}"
            types = get_types_from_msg(text, known)
            if known not in self.store.fielddefs:
                self.store.register({known: types[known]})

    def sample(self, name):
        """A message with distinct values, so that swapped fields are detected."""
        return self._fill(name, itertools.count(1))

    def write(self, name, sample):
        return bytes(self.store.serialize_cdr(self._message(name, sample), name, little_endian=True))

    def rewrite(self, name, cdr):
        """The same message with other padding: Fast CDR leaves the contents of memory in padding bytes."""
        return bytes(self.store.serialize_cdr(self.store.deserialize_cdr(cdr, name), name, little_endian=True))

    def _fill(self, name, numbers):
        return {field: self._value(field, kind, numbers) for field, kind in self.store.fielddefs[name][1]}

    def _value(self, field, kind, numbers):
        node, detail = kind
        if node == Nodetype.NAME:
            return self._fill(detail, numbers)
        if node == Nodetype.ARRAY:
            element, length = detail
            return [self._value(field, element, numbers) for _ in range(length)]
        if node == Nodetype.SEQUENCE:
            element, _ = detail
            return [self._value(field, element, numbers) for _ in range(3)]
        return base_value(detail[0], field, next(numbers))

    def _message(self, name, sample):
        fields = {field: self._read(kind, sample[field]) for field, kind in self.store.fielddefs[name][1]}
        return self.store.types[name](**fields)

    def _read(self, kind, value):
        node, detail = kind
        if node == Nodetype.NAME:
            return self._message(detail, value)
        if node in (Nodetype.ARRAY, Nodetype.SEQUENCE):
            values = [self._read(detail[0], element) for element in value]
            return numpy_array(detail[0], values)
        return value


def base_value(base, field, number):
    """A value of a base type; fractions are exact in binary, so that every JSON reader gets the same bits."""
    if field == PLACEHOLDER:
        return 0
    if base == "string":
        # Lengths cover all residues modulo eight; some characters have two or three bytes.
        return f"{field} {'ü€' * (number % 4)}{'x' * (number % 7)}"
    if base == "bool":
        return True
    if base in ("float32", "float64"):
        return (-1) ** number * (number + 0.3125)
    if base == "int32":
        return -70000 * number
    if base == "int64":
        return -5_000_000_000 * number
    if base == "uint16":
        return 50_000 + number
    if base == "uint32":
        return 4_000_000_000 + number
    if base == "uint64":
        return 2**63 + number
    if base in ("uint8", "char"):
        return 128 + number % 128
    if base == "byte":
        # rosbags reads it as signed, rosidl as unsigned.
        return number % 128
    raise ValueError(f"expected a base type that a definition uses, found {base}; add a sample value for it")


def numpy_array(element, values):
    """rosbags expects arrays of numbers as numpy arrays, all others as lists."""
    import numpy

    node, detail = element
    if node != Nodetype.BASE or detail[0] == "string":
        return values
    return numpy.array(values, dtype={"char": "uint8"}.get(detail[0], detail[0]))


def rclpy_class(package, folder, name):
    module = importlib.import_module(f"{package}.{folder}")
    if folder == "msg":
        return getattr(module, name)
    service, half = name.rsplit("_", 1)
    return getattr(getattr(module, service), half)


def rclpy_message(kind, sample):
    """The sample as a message of rclpy."""
    message = kind()
    for field, value in sample.items():
        if field == PLACEHOLDER:
            continue
        present = getattr(message, field)
        if isinstance(value, dict):
            value = rclpy_message(type(present), value)
        elif isinstance(present, bytes):
            value = bytes([value])
        elif kind.get_fields_and_field_types()[field] == "sequence<octet>":
            value = [bytes([each]) for each in value]
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            element = element_class(kind, field)
            value = [rclpy_message(element, each) for each in value]
        setattr(message, field, value)
    return message


def element_class(kind, field):
    """The class of the elements of a sequence of messages."""
    spelt = kind.get_fields_and_field_types()[field]
    package, name = spelt.removeprefix("sequence<").removesuffix(">").split(",")[0].split("/")
    return rclpy_class(package, "msg", name)


def installed_hash(package, folder, name):
    """The type hash written by rosidl."""
    stem = name if folder == "msg" else name.rsplit("_", 1)[0]
    hashes = json.loads((SHARE / package / folder / f"{stem}.json").read_text())["type_hashes"]
    return next(entry["hash_string"] for entry in hashes if entry["type_name"] == f"{package}/{folder}/{name}")


def make_golden(writer):
    golden = {}
    for package, folder, name, _ in definitions():
        known = rosbags_name(package, name)
        sample = writer.sample(known)
        golden[f"{package}/{folder}/{name}"] = {
            "type_hash": installed_hash(package, folder, name),
            "cdr": writer.write(known, sample).hex(),
            "sample": sample,
        }
    return golden


def without_comments(text):
    """What a definition says to a program."""
    lines = (line.split("#")[0].split() for line in text.splitlines())
    return [" ".join(line) for line in lines if line]


def same_text(path, installed, comments_count):
    if comments_count:
        return installed.read_bytes() == path.read_bytes()
    return without_comments(installed.read_text()) == without_comments(path.read_text())


def differences(golden, comments_count):
    """Lines that describe the differences between golden.json, the repository and the installed ROS 2."""
    writer = Writer()
    fresh = make_golden(writer)
    if fresh.keys() != golden.keys():
        yield f"types: expected {sorted(fresh)}, found {sorted(golden)}; run with --write"
    for ros_name, entry in fresh.items():
        if golden.get(ros_name) != entry:
            yield f"{ros_name}: golden.json differs from the output of rosbags and rosidl; run with --write and review the change"
        package, folder, name = ros_name.split("/")
        known = rosbags_name(package, name)
        kind = rclpy_class(package, folder, name)
        message = rclpy_message(kind, entry["sample"])
        expected = bytes.fromhex(entry["cdr"])
        found = serialize_message(message)
        if not 0 <= len(found) - len(expected) <= LONGEST_PADDING or writer.rewrite(known, found) != expected:
            yield f"{ros_name}: expected {expected.hex()} as rosbags writes it, found {found.hex()} from rclpy"
        if deserialize_message(expected, kind) != message:
            yield f"{ros_name}: rclpy reads {deserialize_message(expected, kind)}, expected {message}"
    for package, path in definition_files():
        installed = SHARE / package / path.suffix[1:] / path.name
        if not same_text(path, installed, comments_count or package == OURS):
            yield f"{path.relative_to(REPOSITORY)}: expected the text of {installed}, found another"


def main():
    if sys.argv[1:] == ["--write"]:
        GOLDEN.parent.mkdir(parents=True, exist_ok=True)
        GOLDEN.write_text(json.dumps(make_golden(Writer()), indent=1, ensure_ascii=False) + "\n")
    elif sys.argv[1:] not in ([], ["--kilted"]):
        sys.exit(f"expected no argument, --write or --kilted, found {sys.argv[1:]}")
    golden = json.loads(GOLDEN.read_text())
    found = list(differences(golden, comments_count="--kilted" not in sys.argv))
    for line in found:
        print(line, file=sys.stderr)
    if found:
        sys.exit(1)
    print(f"{len(golden)} types agree with rosidl, rclpy and rosbags")


if __name__ == "__main__":
    main()
