// Reads a recording with @mcap/core and @foxglove/rosmsg2-serialization, as Foxglove does, and compares every message and
// value with what was written.
//
//     NODE_PATH=$(tests/interop/node_environment.sh) node read_recording.js DIRECTORY EXPECTED
//
// EXPECTED: see read_recording.py.
"use strict";

const fs = require("node:fs");
const path = require("node:path");
const { McapIndexedReader } = require("@mcap/core");
const { FileHandleReadable } = require("@mcap/nodejs");
const { loadDecompressHandlers } = require("@mcap/support");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");

function fail(text) {
  console.error(`@mcap/core: ${text}`);
  process.exit(1);
}

// Foxglove names the parts of a time after ROS 1.
const RENAMED = { nanosec: "nsec" };

function same(found, expected, name) {
  if (expected === null) {
    return typeof found === "number" && !Number.isFinite(found);
  }
  if (Array.isArray(expected)) {
    return found.length === expected.length && expected.every((value, index) => same(found[index], value, name));
  }
  if (typeof expected === "object") {
    return Object.entries(expected).every(([field, value]) => same(found[field in found ? field : RENAMED[field]], value, field));
  }
  return typeof found === "bigint" ? found === BigInt(expected) : found === expected;
}

async function main() {
  const [directory, expectedPath] = process.argv.slice(2);
  const expected = fs.readFileSync(expectedPath, "utf8").trimEnd().split("\n").map((line) => JSON.parse(line));
  const file = fs.readdirSync(directory).find((name) => name.endsWith(".mcap"));
  const handle = await fs.promises.open(path.join(directory, file), "r");
  const reader = await McapIndexedReader.Initialize({
    readable: new FileHandleReadable(handle),
    decompressHandlers: await loadDecompressHandlers(),
  });
  const messageReaders = new Map();
  let read = 0;
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    if (!messageReaders.has(channel.id)) {
      const text = new TextDecoder().decode(schema.data);
      messageReaders.set(channel.id, new MessageReader(parse(text, { ros2: true })));
    }
    const wanted = expected[read] ?? fail(`more than the ${expected.length} messages that were written`);
    const head = [channel.topic, schema.name, String(message.logTime), String(message.publishTime), Buffer.from(message.data).toString("hex")];
    const wantedHead = [wanted.topic, wanted.type, wanted.log_time, wanted.publish_time, wanted.data];
    head.forEach((value, index) => value === wantedHead[index] || fail(`message ${read}: expected ${wantedHead[index]}, found ${value}`));
    const decoded = messageReaders.get(channel.id).readMessage(message.data);
    if (!same(decoded, wanted.message, channel.topic)) {
      fail(`message ${read} of ${channel.topic}: expected ${JSON.stringify(wanted.message)}, found ${decoded}`);
    }
    read += 1;
  }
  await handle.close();
  if (read !== expected.length || Number(reader.statistics.messageCount) !== expected.length) {
    fail(`expected ${expected.length} messages, found ${read}; statistics say ${reader.statistics.messageCount}`);
  }
  console.log(`@mcap/core with @foxglove/rosmsg2-serialization: ${read} messages`);
}

main().catch((error) => fail(error.stack));
