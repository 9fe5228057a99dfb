//! The server with clients that are strangers, slow, killed, or send rubbish.
// A test may start an unnamed thread: it ends with the test.
#![allow(clippy::disallowed_methods)]

use std::io::{ErrorKind, Read as _, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use foxglove_live::{
    Channel, Handler, Importance, Notices, Parameter, PlaybackRequest, PlaybackState,
    PlaybackStatus, Schema, Server, Service, Settings,
};
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::error::Error;
use tungstenite::{Message, WebSocket};

/// Longest wait for what has to come.
const PATIENCE: Duration = Duration::from_secs(30);

/// The index of the channel without a history.
const STATE: usize = 0;
/// The index of the channel with a history.
const REPORT: usize = 1;

fn schema(name: &str) -> Schema {
    Schema {
        name: name.to_owned(),
        text: "string data\n".to_owned(),
    }
}

fn settings(address: &str, control: bool) -> Settings {
    let channel = |topic: &str, history| Channel {
        topic: topic.to_owned(),
        schema: schema("std_msgs/msg/String"),
        history,
    };
    Settings {
        name: "/host".to_owned(),
        address: address.to_owned(),
        origins: vec!["https://viewer.example".to_owned()],
        origins_name: "the list of this test",
        is_this_machine: |host| matches!(host.split(':').next(), Some("localhost" | "127.0.0.1")),
        control,
        channels: vec![channel("/state", 0), channel("/report", 2)],
        services: vec![Service {
            name: "/host/echo".to_owned(),
            type_name: "test/srv/Echo".to_owned(),
            request: schema("test/srv/Echo_Request"),
            response: schema("test/srv/Echo_Response"),
        }],
        playback: None,
    }
}

/// A host with one parameter and a service that returns its request.
#[derive(Clone)]
struct Host(Arc<Mutex<f64>>);

impl Handler for Host {
    fn parameters(&mut self, names: &[String]) -> Vec<Parameter> {
        let is_asked = names.is_empty() || names.iter().any(|it| it == "load");
        let load = Parameter {
            name: "load".to_owned(),
            value: (*self.0.lock().unwrap()).into(),
            kind: Some("float64".to_owned()),
        };
        is_asked.then_some(load).into_iter().collect()
    }

    fn set_parameters(&mut self, given: &[Parameter]) -> Result<(), String> {
        match given {
            [Parameter { name, value, .. }] if name == "load" => {
                let value = value.as_f64().ok_or("load: expected a number")?;
                *self.0.lock().unwrap() = value;
                Ok(())
            }
            _ => Err("expected load".to_owned()),
        }
    }

    fn call(&mut self, _: usize, request: &[u8]) -> Result<Vec<u8>, String> {
        match request {
            b"no" => Err("no answer".to_owned()),
            _ => Ok(request.to_vec()),
        }
    }

    fn playback(&mut self, request: PlaybackRequest) {
        *self.0.lock().unwrap() = f64::from(request.speed);
    }
}

struct Running {
    server: Server,
    host: Host,
    notices: Receiver<(Importance, String)>,
}

fn running(control: bool) -> Running {
    running_with(settings("127.0.0.1:0", control))
}

fn running_with(settings: Settings) -> Running {
    let host = Host(Arc::new(Mutex::new(1.5)));
    let (teller, notices) = channel();
    let teller = Mutex::new(teller);
    let tell: Notices = Arc::new(move |importance, text| {
        let _ = teller.lock().unwrap().send((importance, text));
    });
    let server = Server::start(settings, host.clone(), tell);
    Running {
        server: server.expect("a free port"),
        host,
        notices,
    }
}

impl Running {
    fn publish(&self, channel: usize, time: u64, length: usize) {
        let bytes: Arc<[u8]> = vec![0; length].into();
        self.server.publish(channel, time, &bytes);
    }

    /// Publishes until something comes: a subscription takes effect some time after it was sent.
    fn publish_until_heard(&self, client: &mut Client) {
        client.socket.get_ref().set_nonblocking(true).unwrap();
        let began = Instant::now();
        loop {
            self.publish(STATE, 1, 10);
            match client.socket.read() {
                Err(Error::Io(fault)) if fault.kind() == ErrorKind::WouldBlock => {}
                Ok(_) => break,
                Err(fault) => panic!("{fault}"),
            }
            assert!(began.elapsed() < PATIENCE, "nothing comes");
            std::thread::sleep(Duration::from_millis(1));
        }
        client.socket.get_ref().set_nonblocking(false).unwrap();
    }

    fn until(&self, what: impl Fn(&Running) -> bool) {
        let began = Instant::now();
        while !what(self) {
            assert!(began.elapsed() < PATIENCE, "it does not happen");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    fn client(&self) -> Client {
        Client::connect(self.server.address(), &[]).expect("may connect")
    }
}

struct Client {
    socket: WebSocket<TcpStream>,
}

impl Client {
    fn connect(address: SocketAddr, headers: &[(&'static str, &str)]) -> Result<Self, u16> {
        let mut request = format!("ws://{address}/").into_client_request().unwrap();
        let protocol = "foxglove.sdk.v1".parse().unwrap();
        request
            .headers_mut()
            .insert("sec-websocket-protocol", protocol);
        for (name, value) in headers {
            request.headers_mut().insert(*name, value.parse().unwrap());
        }
        let stream = TcpStream::connect(address).expect("the server listens");
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        match tungstenite::client(request, stream) {
            Ok((socket, response)) => {
                let chosen = &response.headers()["sec-websocket-protocol"];
                assert_eq!(chosen, "foxglove.sdk.v1");
                Ok(Self { socket })
            }
            Err(tungstenite::HandshakeError::Failure(Error::Http(response))) => {
                Err(response.status().as_u16())
            }
            Err(fault) => panic!("{fault}"),
        }
    }

    fn ask(&mut self, request: &Value) {
        self.socket
            .send(request.to_string().into())
            .expect("is sent");
    }

    fn subscribe(&mut self, id: u32, channel: usize) {
        let wanted = json!({ "id": id, "channelId": channel });
        self.ask(&json!({ "op": "subscribe", "subscriptions": [wanted] }));
    }

    /// The next text message with this `op`.
    fn told(&mut self, op: &str) -> Value {
        loop {
            if let Message::Text(text) = self.socket.read().expect("something comes") {
                let message: Value = serde_json::from_str(text.as_str()).expect("is JSON");
                if message["op"] == op {
                    return message;
                }
            }
        }
    }

    /// The next binary message.
    fn frame(&mut self) -> Vec<u8> {
        loop {
            if let Message::Binary(bytes) = self.socket.read().expect("something comes") {
                return bytes.to_vec();
            }
        }
    }

    /// Subscription and time of the next message.
    fn message(&mut self) -> (u32, u64) {
        let frame = self.frame();
        assert_eq!(frame[0], 1, "a message");
        let subscription = u32::from_le_bytes(frame[1..5].try_into().unwrap());
        let time = u64::from_le_bytes(frame[5..13].try_into().unwrap());
        (subscription, time)
    }
}

#[test]
fn a_client_hears_what_there_is_and_what_it_subscribes_to() {
    let running = running(false);
    let mut client = running.client();
    let info = client.told("serverInfo");
    assert_eq!(info["name"], "/host");
    let channels = client.told("advertise");
    let report = &channels["channels"][REPORT];
    assert_eq!(report["topic"], "/report");
    assert_eq!(report["encoding"], "cdr");
    assert_eq!(report["schemaEncoding"], "ros2msg");
    assert_eq!(report["schema"], "string data\n");
    let services = client.told("advertiseServices");
    assert_eq!(services["services"][0]["request"]["encoding"], "cdr");
    client.subscribe(7, STATE);
    running.publish_until_heard(&mut client);
    running.publish(STATE, 5, 10);
    while client.message() != (7, 5) {}
}

#[test]
fn a_late_client_gets_the_history_of_a_channel() {
    let running = running(false);
    for time in 1..=3 {
        running.publish(REPORT, time, 10);
    }
    let mut client = running.client();
    client.subscribe(1, REPORT);
    assert_eq!([client.message(), client.message()], [(1, 2), (1, 3)]);
}

#[test]
fn a_client_controls_the_playback_and_a_late_one_is_told_its_state() {
    let running = running_with(Settings {
        playback: Some((1_500_000_000, 3_000_000_000)),
        ..settings("127.0.0.1:0", false)
    });
    let mut client = running.client();
    let info = client.told("serverInfo");
    let capabilities = info["capabilities"].as_array().unwrap();
    assert!(capabilities.contains(&json!("playbackControl")), "{info}");
    assert_eq!(
        info["dataStartTime"],
        json!({ "sec": 1, "nsec": 500_000_000 })
    );
    assert_eq!(info["dataEndTime"], json!({ "sec": 3, "nsec": 0 }));
    // Play at half the speed, without seeking.
    let request = b"\x03\0\0\0\0\x3f\0\0\0\0\0\0\0\0\0\x01\0\0\0a";
    client
        .socket
        .send(Message::binary(request.to_vec()))
        .unwrap();
    running.until(|it| *it.host.0.lock().unwrap() == 0.5);
    for time in 1..=2 {
        running.publish(REPORT, time, 10);
    }
    let state = |time, did_seek| PlaybackState {
        status: PlaybackStatus::Playing,
        time,
        speed: 0.5,
        did_seek,
        request: "a".to_owned(),
    };
    running.server.playback(state(7, true));
    running.publish(REPORT, 7, 10);
    let frame = client.frame();
    assert_eq!(frame[..10], [5, 0, 7, 0, 0, 0, 0, 0, 0, 0]);
    // A late client hears the state, and only what was published since the jump.
    let mut late = running.client();
    assert_eq!(late.frame(), frame);
    late.subscribe(1, REPORT);
    assert_eq!(late.message(), (1, 7));
}

#[test]
fn live_topics_have_no_playback() {
    let running = running(false);
    let mut client = running.client();
    let info = client.told("serverInfo");
    let capabilities = info["capabilities"].as_array().unwrap();
    assert!(!capabilities.contains(&json!("playbackControl")), "{info}");
    let request = b"\x03\0\0\0\0\x3f\0\0\0\0\0\0\0\0\0\x01\0\0\0a";
    client
        .socket
        .send(Message::binary(request.to_vec()))
        .unwrap();
    assert_eq!(client.told("status")["level"], 2);
}

/// A web page can open a socket to this machine, also under a name that was made to lead here.
#[test]
fn pages_of_strangers_are_rejected_and_told_once() {
    let running = running(false);
    let connect = |headers: &[_]| Client::connect(running.server.address(), headers).map(|_| ());
    assert_eq!(connect(&[("origin", "https://evil.example")]), Err(403));
    assert_eq!(connect(&[("origin", "https://evil.example")]), Err(403));
    assert_eq!(connect(&[("host", "evil.example:8765")]), Err(403));
    let other = ("sec-websocket-protocol", "mqtt");
    assert_eq!(connect(&[other]), Err(400));
    assert_eq!(connect(&[("origin", "https://viewer.example")]), Ok(()));
    assert_eq!(connect(&[("origin", "http://localhost:8080")]), Ok(()));
    running.until(|it| it.server.statistics().rejected == 4);
    let told = running.notices.try_iter();
    let told = told.filter(|it| it.0 == Importance::Rejection);
    let told: Vec<_> = told.map(|it| it.1).collect();
    assert_eq!(told.len(), 3);
    // The list helps nobody else.
    let mut listed = told.iter().filter(|it| it.contains("the list of"));
    assert!(listed.next().is_some_and(|it| it.contains("evil.example")));
    assert_eq!(listed.next(), None, "{told:?}");
}

#[test]
fn parameters_are_read_and_set_only_under_control() {
    let (limited, free) = (running(false), running(true));
    let set = json!({
        "op": "setParameters",
        "parameters": [{ "name": "load", "value": 3 }],
        "id": "s",
    });
    let mut client = limited.client();
    client.ask(&json!({ "op": "getParameters", "parameterNames": [], "id": "g" }));
    let found = client.told("parameterValues");
    let parameter = json!({ "name": "load", "value": 1.5, "type": "float64" });
    assert_eq!(found["id"], "g");
    assert_eq!(found["parameters"], json!([parameter]));
    client.ask(&set);
    let found = client.told("parameterValues");
    assert_eq!(found["parameters"][0]["value"], 1.5, "nothing was set");
    let fault = client.told("status");
    assert_eq!(fault["level"], 2);
    assert_eq!(*limited.host.0.lock().unwrap(), 1.5);

    let mut client = free.client();
    client.ask(&set);
    let found = client.told("parameterValues");
    assert_eq!(found["parameters"][0]["value"], 3.0);
    client.ask(&json!({ "op": "subscribeParameterUpdates", "parameterNames": ["load"] }));
    // Requests are handled in their order.
    client.ask(&json!({ "op": "getParameters", "parameterNames": ["load"], "id": "g" }));
    client.told("parameterValues");
    let changed = Parameter {
        name: "load".to_owned(),
        value: 4.0.into(),
        kind: None,
    };
    free.server.parameters_changed(vec![changed]);
    let update = client.told("parameterValues");
    assert_eq!(update["parameters"][0]["value"], 4.0);
    assert_eq!(update["id"], Value::Null);
}

/// They would fill the memory.
#[test]
fn names_that_are_too_long_for_a_parameter_are_not_followed() {
    let running = running(false);
    let mut client = running.client();
    let long = "a".repeat(1000);
    client.ask(&json!({ "op": "subscribeParameterUpdates", "parameterNames": [long, "load"] }));
    // Requests are handled in their order.
    client.ask(&json!({ "op": "getParameters", "parameterNames": ["load"], "id": "g" }));
    client.told("parameterValues");
    for name in [long.as_str(), "load"] {
        let changed = Parameter {
            name: name.to_owned(),
            value: 4.0.into(),
            kind: None,
        };
        running.server.parameters_changed(vec![changed]);
    }
    let update = client.told("parameterValues");
    assert_eq!(update["parameters"][0]["name"], "load");
}

fn call(service: u8, payload: &[u8]) -> Message {
    let head = [2, service, 0, 0, 0, 9, 0, 0, 0, 3, 0, 0, 0];
    Message::from([&head[..], b"cdr", payload].concat())
}

#[test]
fn services_are_answered_or_say_why_not() {
    let running = running(false);
    let mut client = running.client();
    client.socket.send(call(0, b"hello")).unwrap();
    let expected = [&[3, 0, 0, 0, 0, 9, 0, 0, 0, 3, 0, 0, 0][..], b"cdrhello"];
    assert_eq!(client.frame(), expected.concat());
    client.socket.send(call(0, b"no")).unwrap();
    let failure = client.told("serviceCallFailure");
    assert_eq!(failure["message"], "no answer");
    assert_eq!(failure["callId"], 9);
    client.socket.send(call(1, b"")).unwrap();
    client.told("serviceCallFailure");
}

#[test]
fn rubbish_and_giant_frames_harm_nobody_else() {
    let running = running(false);
    let mut other = running.client();
    other.subscribe(1, STATE);
    running.publish_until_heard(&mut other);

    let mut client = running.client();
    for text in ["", "{", "[]", r#"{"op":3}"#, r#"{"op":"subscribe"}"#] {
        client.socket.send(text.into()).unwrap();
        assert_eq!(client.told("status")["level"], 2, "{text}");
    }
    client.socket.send(vec![9_u8; 100].into()).unwrap();
    client.told("status");
    client.subscribe(1, 99);
    client.told("status");

    // A frame that announces 2^40 bytes: the server closes, and allocates nothing for it.
    let stream = client.socket.get_mut();
    stream.write_all(&[0x82, 0xff]).unwrap();
    stream.write_all(&(1_u64 << 40).to_be_bytes()).unwrap();
    stream.write_all(&[0; 4]).unwrap();
    while client.socket.read().is_ok() {}

    // What is no WebSocket at all.
    let mut stream = TcpStream::connect(running.server.address()).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let _ = stream.write_all(&[0xff; 100_000]);
    let _ = stream.read_to_end(&mut Vec::new());

    running.publish(STATE, 5, 10);
    while other.message() != (1, 5) {}
}

#[test]
fn a_killed_client_is_forgotten() {
    let running = running(false);
    let (mut killed, mut other) = (running.client(), running.client());
    for client in [&mut killed, &mut other] {
        client.subscribe(1, STATE);
        running.publish_until_heard(client);
    }
    running.until(|it| it.server.statistics().clients == 2);
    // Without a word: no close frame.
    drop(killed);
    running.until(|it| it.server.statistics().clients == 1);
    running.publish(STATE, 5, 10);
    while other.message() != (1, 5) {}
}

/// Answers are as long as requests, or longer.
#[test]
fn a_client_that_does_not_read_long_answers_goes_before_they_fill_the_memory() {
    let running = running(false);
    let mut client = running.client();
    // Fewer than the answers that may wait, whatever their length.
    for _ in 0..250 {
        if client.socket.send(call(0, &[0; 250_000])).is_err() {
            break;
        }
        // Slower than the answers, of which only a few may be on their way.
        std::thread::sleep(Duration::from_millis(10));
    }
    running.until(|it| {
        let mut told = it.notices.try_iter();
        told.any(|it| it.1.contains("does not read its answers"))
    });
}

#[test]
fn what_a_history_is_too_long_for_is_counted_and_told() {
    let running = running(false);
    for time in 1..=2 {
        running.publish(REPORT, time, 5_000_000);
    }
    let mut client = running.client();
    client.subscribe(1, REPORT);
    assert_eq!(client.message(), (1, 2), "the newest is kept");
    assert_eq!(running.server.statistics().dropped, 1);
    let mut told = running.notices.try_iter();
    assert!(told.any(|it| it.0 == Importance::Warning));
}

/// The host never waits, and each client loses only its own messages: the oldest states, never a report.
#[test]
fn twenty_slow_clients_lose_their_own_oldest_messages_and_hold_nobody_up() {
    const STATES: u64 = 4000;
    let running = running(false);
    running.publish(REPORT, 1, 1000);
    let mut slow: Vec<_> = (0..20).map(|_| running.client()).collect();
    for client in &mut slow {
        client.subscribe(2, REPORT);
        assert_eq!(client.message(), (2, 1));
        client.subscribe(1, STATE);
        running.publish_until_heard(client);
    }
    let mut fast = running.client();
    fast.subscribe(1, STATE);
    running.publish_until_heard(&mut fast);
    let reader = std::thread::spawn(move || while fast.message() != (1, STATES + 9) {});
    // More than the sockets and the queues of all slow clients hold.
    for time in 10..10 + STATES {
        running.publish(STATE, time, 10_000);
        if time == 20 {
            running.publish(REPORT, 2, 1000);
        }
        // A high rate, but not faster than the thread of the network.
        std::thread::sleep(Duration::from_micros(200));
    }
    reader.join().expect("the fast client hears the last state");
    running.until(|it| it.server.statistics().dropped > 0);
    let warnings = running.notices.try_iter();
    let warnings = warnings.filter(|it| it.0 == Importance::Warning).count();
    assert!(
        (1..=20).contains(&warnings),
        "each is told once: {warnings}"
    );
    for client in &mut slow {
        let (mut times, mut reports) = (Vec::new(), 0);
        while times.last() != Some(&(STATES + 9)) {
            match client.message() {
                (2, _) => reports += 1,
                (_, time) => times.push(time),
            }
        }
        assert!((times.len() as u64) < STATES, "it lost nothing");
        assert!(times.is_sorted(), "the order is kept");
        assert_eq!(reports, 1, "a report was lost");
    }
}

#[test]
fn a_port_in_use_is_an_error_and_a_stop_frees_it() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let host = Host(Arc::default());
    let silent: Notices = Arc::new(|_, _| {});
    assert!(Server::start(settings(&address, false), host, silent).is_err());

    let running = running(false);
    let mut client = running.client();
    client.told("advertiseServices");
    let address = running.server.address();
    drop(running);
    while client.socket.read().is_ok() {}
    assert!(TcpStream::connect(address).is_err());
}
