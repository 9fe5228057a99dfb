//! The messages of the protocol.
//!
//! Its description is <https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md>. Numbers in binary frames are little endian.

use serde::Deserialize;
use serde_json::json;

use crate::host::{Channel, Parameter, Schema, Service, Settings};
use crate::playback::{PlaybackRequest, PlaybackState};

/// How messages, requests and answers are encoded.
const ENCODING: &str = "cdr";
/// \[ns\]
const NANOS_PER_SECOND: u64 = 1_000_000_000;
/// The number of a request to a playback.
const PLAYBACK_REQUEST: u8 = 3;
/// How their types are described.
const SCHEMA_ENCODING: &str = "ros2msg";

/// What a client asks for.
#[derive(Debug, PartialEq, Deserialize)]
#[serde(tag = "op", rename_all = "camelCase", rename_all_fields = "camelCase")]
pub(crate) enum Request {
    Subscribe {
        subscriptions: Vec<Subscription>,
    },
    Unsubscribe {
        subscription_ids: Vec<u32>,
    },
    GetParameters {
        #[serde(default)]
        parameter_names: Vec<String>,
        id: Option<String>,
    },
    SetParameters {
        parameters: Vec<Parameter>,
        id: Option<String>,
    },
    SubscribeParameterUpdates {
        #[serde(default)]
        parameter_names: Vec<String>,
    },
    UnsubscribeParameterUpdates {
        #[serde(default)]
        parameter_names: Vec<String>,
    },
    /// Something that this server does not offer.
    #[serde(other)]
    Other,
}

#[derive(Debug, PartialEq, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Subscription {
    pub id: u32,
    pub channel_id: u64,
}

/// A request to a service.
#[derive(Debug, PartialEq)]
pub(crate) struct Call {
    pub service: u32,
    pub id: u32,
    pub payload: Vec<u8>,
}

/// How bad something is, as numbers of the protocol.
#[derive(Clone, Copy)]
pub(crate) enum Level {
    Warning = 1,
    Error = 2,
}

/// The first message to a client.
pub(crate) fn server_info(settings: &Settings, session: &str) -> String {
    let mut capabilities = vec!["parameters", "parametersSubscribe"];
    if !settings.services.is_empty() {
        capabilities.push("services");
    }
    if settings.playback.is_some() {
        capabilities.extend(["time", "playbackControl"]);
    }
    let mut info = json!({
        "op": "serverInfo",
        "name": settings.name,
        "capabilities": capabilities,
        "supportedEncodings": [ENCODING],
        "metadata": {},
        "sessionId": session,
    });
    if let Some((first, last)) = settings.playback {
        let instant = |nanos: u64| json!({ "sec": nanos / NANOS_PER_SECOND, "nsec": nanos % NANOS_PER_SECOND });
        info["dataStartTime"] = instant(first);
        info["dataEndTime"] = instant(last);
    }
    info.to_string()
}

/// What can be subscribed to; the number of a channel is its index.
pub(crate) fn advertise(channels: &[Channel]) -> String {
    let channel = |(index, it): (usize, &Channel)| {
        json!({
            "id": index,
            "topic": it.topic,
            "encoding": ENCODING,
            "schemaName": it.schema.name,
            "schema": it.schema.text,
            "schemaEncoding": SCHEMA_ENCODING,
        })
    };
    let channels: Vec<_> = channels.iter().enumerate().map(channel).collect();
    json!({ "op": "advertise", "channels": channels }).to_string()
}

/// What can be called; the number of a service is its index.
pub(crate) fn advertise_services(services: &[Service]) -> String {
    let schema = |it: &Schema| {
        json!({
            "encoding": ENCODING,
            "schemaName": it.name,
            "schemaEncoding": SCHEMA_ENCODING,
            "schema": it.text,
        })
    };
    let service = |(index, it): (usize, &Service)| {
        json!({
            "id": index,
            "name": it.name,
            "type": it.type_name,
            "request": schema(&it.request),
            "response": schema(&it.response),
            // Where clients of `foxglove.websocket.v1` look.
            "requestSchema": it.request.text,
            "responseSchema": it.response.text,
        })
    };
    let services: Vec<_> = services.iter().enumerate().map(service).collect();
    json!({ "op": "advertiseServices", "services": services }).to_string()
}

pub(crate) fn parameter_values(parameters: &[Parameter], id: Option<&str>) -> String {
    let mut message = json!({ "op": "parameterValues", "parameters": parameters });
    if let Some(id) = id {
        message["id"] = id.into();
    }
    message.to_string()
}

pub(crate) fn status(level: Level, message: &str) -> String {
    json!({ "op": "status", "level": level as u8, "message": message }).to_string()
}

pub(crate) fn call_failed(call: &Call, message: &str) -> String {
    json!({
        "op": "serviceCallFailure",
        "serviceId": call.service,
        "callId": call.id,
        "message": message,
    })
    .to_string()
}

/// A message of a channel for a subscription, with its time \[ns since 1970\].
pub(crate) fn message_data(subscription: u32, time: u64, payload: &[u8]) -> Vec<u8> {
    let mut frame = Vec::with_capacity(13 + payload.len());
    frame.push(1);
    frame.extend(subscription.to_le_bytes());
    frame.extend(time.to_le_bytes());
    frame.extend(payload);
    frame
}

/// The answer to a request to a service.
pub(crate) fn call_answered(call: &Call, payload: &[u8]) -> Vec<u8> {
    let mut frame = vec![3];
    frame.extend(call.service.to_le_bytes());
    frame.extend(call.id.to_le_bytes());
    frame.extend((ENCODING.len() as u32).to_le_bytes());
    frame.extend(ENCODING.as_bytes());
    frame.extend(payload);
    frame
}

/// The recorded time that is played \[ns since 1970\].
pub(crate) fn time(now: u64) -> Vec<u8> {
    let mut frame = vec![2];
    frame.extend(now.to_le_bytes());
    frame
}

/// The state of a playback.
pub(crate) fn playback_state(state: &PlaybackState) -> Vec<u8> {
    let PlaybackState {
        status,
        time,
        speed,
        did_seek,
        request,
    } = state;
    let mut frame = vec![5, *status as u8];
    frame.extend(time.to_le_bytes());
    frame.extend(speed.to_le_bytes());
    frame.push(u8::from(*did_seek));
    frame.extend((request.len() as u32).to_le_bytes());
    frame.extend(request.as_bytes());
    frame
}

/// Whether a binary frame of a client is a request to a playback.
pub(crate) fn is_playback(frame: &[u8]) -> bool {
    frame.first() == Some(&PLAYBACK_REQUEST)
}

/// Reads a request to a playback, which [`is_playback`] has recognised.
///
/// # Errors
/// It is too short, or contains what no playback can do.
pub(crate) fn read_playback(frame: &[u8]) -> Result<PlaybackRequest, String> {
    /// Longest name of a request \[bytes\].
    const MAX_ID: usize = 256;
    let too_short = || "a request to the playback is too short".to_owned();
    let bytes = |at: usize| -> Option<[u8; 4]> { frame.get(at..at + 4)?.try_into().ok() };
    let command = frame.get(1).ok_or_else(too_short)?;
    let speed = f32::from_le_bytes(bytes(2).ok_or_else(too_short)?);
    let has_seek = frame.get(6).ok_or_else(too_short)?;
    let seek = frame.get(7..15).and_then(|it| it.try_into().ok());
    let seek = u64::from_le_bytes(seek.ok_or_else(too_short)?);
    let length = u32::from_le_bytes(bytes(15).ok_or_else(too_short)?) as usize;
    let id = frame[19..].get(..length).ok_or_else(too_short)?;
    let play = match command {
        0 => true,
        1 => false,
        other => {
            return Err(format!(
                "expected to play (0) or to pause (1), found {other}"
            ));
        }
    };
    if !(speed.is_finite() && speed > 0.0) {
        return Err(format!("expected a positive speed, found {speed}"));
    }
    let id = std::str::from_utf8(id).ok().filter(|it| it.len() <= MAX_ID);
    let id = id.ok_or_else(|| format!("expected a name of at most {MAX_ID} bytes in UTF-8"))?;
    Ok(PlaybackRequest {
        play,
        speed,
        seek: (*has_seek != 0).then_some(seek),
        id: id.to_owned(),
    })
}

/// Reads a binary frame of a client, which can only be a request to a service.
///
/// # Errors
/// It is something else, or too short.
pub(crate) fn read_call(frame: &[u8]) -> Result<Call, String> {
    let Some((2, rest)) = frame.split_first() else {
        return Err("expected a request to a service (2) in a binary frame".to_owned());
    };
    let too_short = || "a request to a service is too short".to_owned();
    let number = |at: usize| {
        let bytes = rest.get(at..at + 4)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    };
    let (service, id) = number(0).zip(number(4)).ok_or_else(too_short)?;
    let length = number(8).ok_or_else(too_short)? as usize;
    let (encoding, payload) = rest[12..].split_at_checked(length).ok_or_else(too_short)?;
    if encoding != ENCODING.as_bytes() {
        let found = String::from_utf8_lossy(encoding);
        return Err(format!(
            "expected a request in {ENCODING}, found {:?}",
            found.chars().take(50).collect::<String>()
        ));
    }
    Ok(Call {
        service,
        id,
        payload: payload.to_vec(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_read_as_the_protocol_writes_them() {
        let read = |text| serde_json::from_str::<Request>(text).expect("is a request");
        assert_eq!(
            read(r#"{"op":"subscribe","subscriptions":[{"id":7,"channelId":3}]}"#),
            Request::Subscribe {
                subscriptions: vec![Subscription {
                    id: 7,
                    channel_id: 3
                }]
            }
        );
        assert_eq!(
            read(r#"{"op":"getParameters","parameterNames":[],"id":"a"}"#),
            Request::GetParameters {
                parameter_names: vec![],
                id: Some("a".to_owned())
            }
        );
        assert_eq!(
            read(r#"{"op":"setParameters","parameters":[{"name":"x","value":1.5}]}"#),
            Request::SetParameters {
                parameters: vec![Parameter {
                    name: "x".to_owned(),
                    value: 1.5.into(),
                    kind: None
                }],
                id: None
            }
        );
        assert_eq!(read(r#"{"op":"subscribeConnectionGraph"}"#), Request::Other);
    }

    /// The bytes are those of the description.
    #[test]
    fn frames_are_those_of_the_description() {
        assert_eq!(
            message_data(5, 256, &[9, 8]),
            [1, 5, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 9, 8]
        );
        let call = read_call(b"\x02\x01\0\0\0\x02\0\0\0\x03\0\0\0cdr\0\x01").expect("a call");
        let expected = Call {
            service: 1,
            id: 2,
            payload: vec![0, 1],
        };
        assert_eq!(call, expected);
        assert_eq!(
            call_answered(&call, &[7]),
            b"\x03\x01\0\0\0\x02\0\0\0\x03\0\0\0cdr\x07"
        );
    }

    /// The bytes are those that the crate `foxglove` (0.30.3) writes and reads.
    #[test]
    fn frames_of_a_playback_are_those_of_the_sdk() {
        let frame = b"\x03\x00\0\0\0\x3f\x01\x07\0\0\0\0\0\0\0\x02\0\0\0ab";
        assert!(is_playback(frame));
        let expected = PlaybackRequest {
            play: true,
            speed: 0.5,
            seek: Some(7),
            id: "ab".to_owned(),
        };
        assert_eq!(read_playback(frame), Ok(expected));
        for cut in 1..frame.len() {
            assert!(read_playback(&frame[..cut]).is_err(), "{cut}");
        }
        for (at, byte) in [(1, 2), (5, 0xbf), (5, 0x7f), (19, 0xff)] {
            let mut wrong = frame.to_vec();
            wrong[at] = byte;
            wrong[4] = 0x80; // infinite with 0x7f, negative with 0xbf
            assert!(read_playback(&wrong).is_err(), "{at} {byte}");
        }
        let state = PlaybackState {
            status: crate::playback::PlaybackStatus::Ended,
            time: 9,
            speed: 0.5,
            did_seek: true,
            request: "ab".to_owned(),
        };
        assert_eq!(
            playback_state(&state),
            b"\x05\x03\x09\0\0\0\0\0\0\0\0\0\0\x3f\x01\x02\0\0\0ab"
        );
        assert_eq!(time(9), b"\x02\x09\0\0\0\0\0\0\0");
    }

    #[test]
    fn rubbish_is_no_call() {
        for frame in [
            &b""[..],
            b"\x01",
            b"\x02",
            b"\x02\0\0\0\0\0\0\0\0\xff\xff\xff\xffcdr",
            b"\x02\0\0\0\0\0\0\0\0\x04\0\0\0json",
        ] {
            assert!(read_call(frame).is_err(), "{frame:?}");
        }
    }
}
