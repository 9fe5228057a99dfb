//! A server for viewers on this machine.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rerun::{
    MemoryLimit, PlaybackBehavior, RecordingStream, RecordingStreamBuilder, ServerOptions,
};

use super::blueprint::APPLICATION;
use super::error::{ViewerError, ViewerLogger};
use super::file;
use super::guard::{self, Guard};
use super::item::ViewerItem;
use super::rerun_types::batching;
use super::stream::ViewerStream;
use crate::parameters::Parameters;

/// How long the server may take until it listens.
const LISTEN_TIMEOUT: Duration = Duration::from_secs(2);

/// The loopback address given by `viewer.address` and `viewer.port`.
///
/// # Errors
/// The address is invalid, or other machines can reach it.
pub fn loopback(address: &str, port: u16) -> Result<SocketAddr, ViewerError> {
    let ip = if address == "localhost" {
        Some(IpAddr::V4(Ipv4Addr::LOCALHOST))
    } else {
        address.parse::<IpAddr>().ok()
    };
    match ip {
        Some(ip) if ip.is_loopback() => Ok(SocketAddr::new(ip, port)),
        _ => Err(ViewerError::Address {
            found: address.to_owned(),
            expected: "an address of this machine that no other machine can reach, such as 127.0.0.1",
        }),
    }
}

/// A stream with a server that keeps at most `memory_limit` bytes for viewers that connect later; the oldest data are dropped
/// first. Viewers reach it as long as the guard lives.
///
/// # Errors
/// The port is in use, or the server cannot listen.
pub fn stream(
    address: SocketAddr,
    memory_limit: u64,
    log: &ViewerLogger,
) -> Result<(RecordingStream, Guard), ViewerError> {
    let fault = |reason| ViewerError::Serve { address, reason };
    let listener = match TcpListener::bind(address) {
        Ok(listener) => listener,
        Err(error) if error.kind() == std::io::ErrorKind::AddrInUse => {
            return Err(ViewerError::PortTaken { address });
        }
        Err(error) => return Err(fault(error)),
    };
    let hidden = guard::hidden_address().map_err(fault)?;
    let options = ServerOptions {
        playback_behavior: PlaybackBehavior::OldestFirst,
        memory_limit: MemoryLimit::from_bytes(memory_limit),
        cors_allowed_origins: Vec::new(),
    };
    let stream = RecordingStreamBuilder::new(APPLICATION)
        .enabled(true)
        .batcher_config(batching())
        .serve_grpc_opts(hidden.ip().to_string(), hidden.port(), options)?;
    // Rerun's own server fails silently if it cannot listen.
    let deadline = Instant::now() + LISTEN_TIMEOUT;
    loop {
        match TcpStream::connect_timeout(&hidden, LISTEN_TIMEOUT) {
            Ok(_) => {
                let guard = Guard::start(listener, hidden, Arc::clone(log)).map_err(fault)?;
                return Ok((stream, guard));
            }
            Err(error) if Instant::now() >= deadline => return Err(fault(error)),
            Err(_) => std::thread::sleep(Duration::from_millis(5)),
        }
    }
}

/// A server that runs until it is dropped.
pub struct Served {
    address: SocketAddr,
    _guard: Guard,
    _stream: ViewerStream,
}

impl Served {
    /// The address for the viewer: `rerun URL`.
    #[must_use]
    pub fn url(&self) -> String {
        url(self.address)
    }
}

/// Serves some items to viewers that connect to `viewer.address` and `viewer.port`, until the returned value is dropped.
///
/// # Errors
/// The port is in use, or the address does not belong to this machine.
pub fn serve(
    parameters: &Arc<Parameters>,
    items: Vec<ViewerItem>,
    log: &ViewerLogger,
) -> Result<Served, ViewerError> {
    let viewer = &parameters.settings().viewer;
    let address = loopback(&viewer.address, viewer.port)?;
    let (stream, guard) = stream(address, viewer.memory_limit, log)?;
    let options = file::options(&items, false);
    let mut stream = ViewerStream::new(stream, Arc::clone(parameters), options)?;
    stream.show(items)?;
    Ok(Served {
        address,
        _guard: guard,
        _stream: stream,
    })
}

/// The address of a server in the form that the viewer expects.
#[must_use]
pub fn url(address: SocketAddr) -> String {
    format!("rerun+http://{address}/proxy")
}

#[cfg(test)]
mod tests {
    use std::io::{Read as _, Write as _};

    use super::*;

    #[test]
    fn only_this_machine_is_served() {
        let right = ["127.0.0.1", "localhost", "::1", "127.0.0.2"];
        assert!(right.iter().all(|it| loopback(it, 9876).is_ok()));
        for wrong in ["0.0.0.0", "192.168.0.1", "viewer", "", "::"] {
            let error = loopback(wrong, 9876).expect_err(wrong).to_string();
            assert!(
                error.contains("expected an address of this machine"),
                "{error}"
            );
        }
    }

    fn silent() -> ViewerLogger {
        Arc::new(|_, _| {})
    }

    /// Rerun's server answered both.
    #[test]
    fn the_server_for_viewers_rejects_a_foreign_host() {
        let free = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
        let address = free.local_addr().expect("its address");
        drop(free);
        let (_stream, _guard) = stream(address, 1_000_000, &silent()).expect("it serves");
        for (host, is_rejected) in [("column.example", true), ("localhost", false)] {
            let mut connection = TcpStream::connect(address).expect("it listens");
            let request = format!("GET / HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
            connection.write_all(request.as_bytes()).expect("is sent");
            let mut answer = Vec::new();
            connection.read_to_end(&mut answer).expect("is answered");
            let text = String::from_utf8_lossy(&answer);
            assert!(text.starts_with("HTTP/1.1 "), "{host}: {text}");
            assert_eq!(
                text.starts_with("HTTP/1.1 403"),
                is_rejected,
                "{host}: {text}"
            );
        }
    }

    #[test]
    fn a_port_in_use_is_reported() {
        let taken = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
        let address = taken.local_addr().expect("its address");
        let error = stream(address, 1_000_000, &silent())
            .map(drop)
            .expect_err("taken");
        assert!(matches!(error, ViewerError::PortTaken { .. }), "{error}");
        assert!(error.to_string().contains(&address.to_string()), "{error}");
    }
}
