// Connects to a running node with @foxglove/ws-protocol, as Foxglove does, and uses all that it offers.
//
//     NODE_PATH=$(tests/interop/node_environment.sh) node read_live.js PORT CONTROL
//
// PORT: that of foxglove.address; CONTROL: foxglove.control, true or false. The column is called a3. Prints what was found as JSON.
"use strict";

const { FoxgloveClient } = require("@foxglove/ws-protocol");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader, MessageWriter } = require("@foxglove/rosmsg2-serialization");
const WebSocket = require("ws");

const [port, controlText] = process.argv.slice(2);
const control = controlText === "true";
const address = `ws://127.0.0.1:${port}`;
// The protocol of Foxglove today; the package itself would ask for its predecessor.
const PROTOCOL = "foxglove.sdk.v1";

function fail(text) {
  console.error(`@foxglove/ws-protocol: ${text}`);
  process.exit(1);
}

setTimeout(() => fail("no answer within 60 s"), 60_000).unref();

function expect(condition, text) {
  if (!condition) {
    fail(text);
  }
}

// The next event for which `wanted` gives something.
function next(client, name, wanted = (it) => it) {
  return new Promise((resolve) => {
    const listen = (event) => {
      const found = wanted(event);
      if (found !== undefined && found !== false) {
        client.off(name, listen);
        resolve(found);
      }
    };
    client.on(name, listen);
  });
}

// The status of the answer to a handshake with this origin and host; 101 if it is accepted.
function statusOf(headers) {
  return new Promise((resolve) => {
    const socket = new WebSocket(address, [PROTOCOL], { headers });
    socket.on("open", () => {
      socket.close();
      resolve(101);
    });
    socket.on("unexpected-response", (request, response) => {
      request.destroy();
      resolve(response.statusCode);
    });
    socket.on("error", () => {});
  });
}

async function main() {
  const socket = new WebSocket(address, [PROTOCOL, FoxgloveClient.SUPPORTED_SUBPROTOCOL]);
  const client = new FoxgloveClient({ ws: socket });
  client.on("error", (error) => fail(error));
  const [info, channels, services] = await Promise.all([
    next(client, "serverInfo"),
    next(client, "advertise"),
    next(client, "advertiseServices"),
  ]);
  expect(socket.protocol === PROTOCOL, `the protocol is ${socket.protocol}`);
  expect(info.name === "/column_twin", `the name is ${info.name}`);
  for (const channel of channels) {
    expect(channel.encoding === "cdr" && channel.schemaEncoding === "ros2msg", `the encoding of ${channel.topic}`);
    new MessageReader(parse(channel.schema, { ros2: true }));
  }

  const channel = channels.find((it) => it.topic === "/twin_status");
  const subscription = client.subscribe(channel.id);
  const data = await next(client, "message", (it) => it.subscriptionId === subscription && it.data);
  const status = new MessageReader(parse(channel.schema, { ros2: true })).readMessage(data);
  expect(status.column_id === "a3", `the column is ${status.column_id}`);

  client.getParameters([], "all");
  const all = await next(client, "parameterValues", (it) => it.id === "all" && it.parameters);
  const load = all.find((it) => it.name === "top.load");
  expect(typeof load.value === "number", "top.load is no number");

  const call = async (name, request, callId) => {
    const service = services.find((it) => it.name === name);
    expect(service, `there is no service ${name}`);
    const writer = new MessageWriter(parse(service.request.schema, { ros2: true }));
    client.sendServiceCallRequest({ serviceId: service.id, callId, encoding: "cdr", data: writer.writeMessage(request) });
    const answer = await Promise.race([
      next(client, "serviceCallResponse", (it) => it.callId === callId && it),
      next(client, "serviceCallFailure", (it) => it.callId === callId && fail(it.message)),
    ]);
    return new MessageReader(parse(service.response.schema, { ros2: true })).readMessage(answer.data);
  };
  // NaN takes the value of the parameter.
  const open = { gap: NaN, restitution: NaN, height: NaN, direction: NaN };
  const predicted = await call("/column_twin/predict", { event_id: "what-if", mass: 1500, velocity: 5, ...open }, 1);
  expect(predicted.success, `no prediction: ${predicted.message}`);
  expect(predicted.report.event_id === "what-if", "the prediction is of another event");

  const wanted = 0.5 * load.value + 1;
  client.setParameters([{ name: "top.load", value: wanted }], "set");
  const now = await next(client, "parameterValues", (it) => it.id === "set" && it.parameters[0]);
  expect(now.value === (control ? wanted : load.value), `top.load is ${now.value}`);
  const reset = services.some((it) => it.name === "/column_twin/reset");
  expect(reset === control, "a reset is offered only under control");
  if (control) {
    const answer = await call("/column_twin/reset", {}, 2);
    expect(answer.success, `no reset: ${answer.message}`);
  }

  const stranger = await statusOf({ Origin: "https://evil.example" });
  const rebound = await statusOf({ Host: `evil.example:${port}` });
  const foxglove = await statusOf({ Origin: "https://app.foxglove.dev" });
  expect(stranger === 403 && rebound === 403 && foxglove === 101, `${stranger}, ${rebound}, ${foxglove}`);
  client.close();
  console.log(JSON.stringify({ topics: channels.map((it) => it.topic).sort(), parameters: all.length }));
  process.exit(0);
}

main().catch((error) => fail(error.stack));
