#!/usr/bin/env python3
"""Checks the seal of a recording by docs/seal.md, independently of the program.

    check_seal.py FILE.mcap

Prints what the seal covers as one line of JSON: public_key, covered, messages, final. Ends with 1 and a reason if the seal does
not hold. Needs the package mcap, and either the package cryptography or the program openssl.
"""

import base64
import hashlib
import json
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader

BEGIN, SEAL = "rosbag2_mcap/seal_begin", "rosbag2_mcap/seal"


def sha(*parts):
    return hashlib.sha256(b"".join(parts)).digest()


def number(value):
    return struct.pack("<Q", value)


def text(value):
    data = value.encode() if isinstance(value, str) else bytes(value)
    return number(len(data)) + data


def entries(values):
    return number(len(values)) + b"".join(text(key) + text(values[key]) for key in sorted(values))


def is_signed(public_key, data, signature):
    """Whether the Ed25519 signature is valid."""
    try:
        from cryptography.exceptions import InvalidSignature
        from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey
    except ImportError:
        return is_signed_by_openssl(public_key, data, signature)
    try:
        Ed25519PublicKey.from_public_bytes(public_key).verify(signature, data)
    except InvalidSignature:
        return False
    return True


def is_signed_by_openssl(public_key, data, signature):
    der = bytes.fromhex("302a300506032b6570032100") + public_key
    pem = f"-----BEGIN PUBLIC KEY-----\n{base64.b64encode(der).decode()}\n-----END PUBLIC KEY-----\n"
    with tempfile.TemporaryDirectory() as folder:
        files = {name: Path(folder, name) for name in ("key", "data", "signature")}
        for file, content in zip(files.values(), (pem.encode(), data, signature)):
            file.write_bytes(content)
        command = ["openssl", "pkeyutl", "-verify", "-pubin", "-inkey", files["key"], "-rawin", "-in", files["data"],
                   "-sigfile", files["signature"]]
        return subprocess.run(command, capture_output=True).returncode == 0


def topic_hash(channel, schema):
    name, encoding, definition = (schema.name, schema.encoding, schema.data) if schema else ("", "", b"")
    return sha(b"rosbag2_mcap topic 1\n", text(channel.topic), text(name), text(encoding), text(definition),
               text(channel.message_encoding), entries(channel.metadata))


def main():
    schemas, topics, beginning, seal, attachment = {}, {}, None, None, None
    head, messages = sha(b"rosbag2_mcap chain 1\n"), 0
    with open(sys.argv[1], "rb") as stream:
        for record in StreamReader(stream, validate_crcs=True).records:
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                topics[record.id] = topic_hash(record, schemas.get(record.schema_id))
            elif isinstance(record, Message):
                head = sha(head, b"\x01", topics[record.channel_id], struct.pack("<I", record.sequence),
                           number(record.log_time), number(record.publish_time), text(record.data))
                messages += 1
            elif isinstance(record, Metadata) and record.name == SEAL:
                seal = record.metadata
                if (seal["head"], int(seal["messages"])) != (head.hex(), messages):
                    sys.exit(f"the seal after message {seal['messages']} is not about what precedes it")
                key = bytes.fromhex(beginning["public_key"])
                signed = (b"rosbag2_mcap seal 1\n" + key + (b"\x01" if seal["final"] == "true" else b"\x00") + number(messages) + head)
                if not is_signed(key, signed, bytes.fromhex(seal["signature"])):
                    sys.exit(f"the signature after message {messages} is not valid")
            elif isinstance(record, Metadata):
                if record.name == BEGIN:
                    beginning = record.metadata
                head = sha(head, b"\x02", text(record.name), entries(record.metadata))
            elif isinstance(record, Attachment) and record.name == SEAL:
                attachment = json.loads(record.data)
    if seal is None:
        sys.exit("not sealed")
    if attachment is not None and (attachment["head"], attachment["public_key"]) != (seal["head"], beginning["public_key"]):
        sys.exit("the attachment is not that of the last seal")
    print(json.dumps({"public_key": beginning["public_key"], "covered": int(seal["messages"]), "messages": messages,
                      "final": seal["final"] == "true", "attachment": attachment is not None}))


if __name__ == "__main__":
    main()
