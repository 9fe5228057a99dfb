//! A client of Foxglove's protocol by hand: the library of Foxglove for JavaScript knows no playback.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Longest wait for what has to come.
const PATIENCE: Duration = Duration::from_secs(30);

pub enum Frame {
    Text(serde_json::Value),
    Binary(Vec<u8>),
}

pub struct Socket(BufReader<TcpStream>);

impl Socket {
    /// Connects as soon as the server listens.
    pub fn connect(port: u16) -> Self {
        let began = Instant::now();
        let mut stream = loop {
            match TcpStream::connect(("127.0.0.1", port)) {
                Ok(stream) => break stream,
                Err(fault) => assert!(began.elapsed() < PATIENCE, "{fault}"),
            }
            std::thread::sleep(Duration::from_millis(20));
        };
        stream.set_read_timeout(Some(PATIENCE)).expect("a socket");
        let request = format!(
            "GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
             Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n"
        );
        stream.write_all(request.as_bytes()).expect("is sent");
        let mut reader = BufReader::new(stream);
        let mut line = String::new();
        reader.read_line(&mut line).expect("an answer");
        assert!(line.starts_with("HTTP/1.1 101"), "{line}");
        while line != "\r\n" {
            line.clear();
            reader.read_line(&mut line).expect("a header");
        }
        Self(reader)
    }

    /// Sends a frame of at most 125 bytes; a mask of zeros changes nothing.
    pub fn send(&mut self, opcode: u8, payload: &[u8]) {
        let length = u8::try_from(payload.len()).expect("a short frame");
        assert!(length < 126);
        let mut frame = vec![0x80 | opcode, 0x80 | length, 0, 0, 0, 0];
        frame.extend(payload);
        self.0.get_mut().write_all(&frame).expect("is sent");
    }

    /// Subscribes to a channel under a number of the client.
    pub fn subscribe(&mut self, id: usize, channel: u64) {
        let wanted = format!(
            r#"{{"op":"subscribe","subscriptions":[{{"id":{id},"channelId":{channel}}}]}}"#
        );
        self.send(1, wanted.as_bytes());
    }

    /// The next text or binary frame.
    pub fn receive(&mut self) -> Frame {
        self.try_receive().expect("something comes")
    }

    /// The same while the server may end.
    pub fn try_receive(&mut self) -> io::Result<Frame> {
        loop {
            let [opcode, length] = self.bytes()?;
            let length = match length {
                126 => u64::from(u16::from_be_bytes(self.bytes()?)),
                127 => u64::from_be_bytes(self.bytes()?),
                short => u64::from(short),
            };
            let mut payload = vec![0; usize::try_from(length).expect("fits")];
            self.0.read_exact(&mut payload)?;
            match opcode & 0xf {
                1 => {
                    let text = serde_json::from_slice(&payload).expect("is JSON");
                    return Ok(Frame::Text(text));
                }
                2 => return Ok(Frame::Binary(payload)),
                8 => return Err(io::ErrorKind::ConnectionReset.into()),
                _ => {}
            }
        }
    }

    fn bytes<const N: usize>(&mut self) -> io::Result<[u8; N]> {
        let mut bytes = [0; N];
        self.0.read_exact(&mut bytes)?;
        Ok(bytes)
    }
}
