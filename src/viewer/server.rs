//! Serving viewers that connect to this program, on this machine only.

use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::time::{Duration, Instant};

use rerun::{
    MemoryLimit, PlaybackBehavior, RecordingStream, RecordingStreamBuilder, ServerOptions,
};

use super::blueprint::APPLICATION;
use super::film::Film;
use super::item::Item;
use super::{ViewerError, file};
use crate::parameters::Parameters;

/// How long a server may take to listen.
const LISTENS_WITHIN: Duration = Duration::from_secs(2);

/// The address of `viewer.address` and `viewer.port`, which must be of this machine.
///
/// # Errors
/// It is no address, or one that others can reach.
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
            expected: "an address of this machine alone, such as 127.0.0.1",
        }),
    }
}

/// A stream whose server keeps at most `memory_limit` bytes for viewers that come later; the oldest go first.
///
/// # Errors
/// The port is taken, or nothing can listen there.
pub fn stream(address: SocketAddr, memory_limit: u64) -> Result<RecordingStream, ViewerError> {
    let fault = |reason| ViewerError::Serve { address, reason };
    // Rerun's own server says nothing where the port is taken.
    match TcpListener::bind(address) {
        Ok(listener) => drop(listener),
        Err(error) if error.kind() == std::io::ErrorKind::AddrInUse => {
            return Err(ViewerError::PortTaken { address });
        }
        Err(error) => return Err(fault(error)),
    }
    let options = ServerOptions {
        playback_behavior: PlaybackBehavior::OldestFirst,
        memory_limit: MemoryLimit::from_bytes(memory_limit),
        cors_allowed_origins: Vec::new(),
    };
    let stream = RecordingStreamBuilder::new(APPLICATION)
        .enabled(true)
        .batcher_config(super::connection::batches())
        .serve_grpc_opts(address.ip().to_string(), address.port(), options)?;
    let given_up = Instant::now() + LISTENS_WITHIN;
    loop {
        match TcpStream::connect_timeout(&address, LISTENS_WITHIN) {
            Ok(_) => return Ok(stream),
            Err(error) if Instant::now() >= given_up => return Err(fault(error)),
            Err(_) => std::thread::sleep(Duration::from_millis(5)),
        }
    }
}

/// What is served until it is dropped.
pub struct Served {
    address: SocketAddr,
    _film: Film,
}

impl Served {
    /// What a viewer is to be told: `rerun` and this.
    #[must_use]
    pub fn url(&self) -> String {
        url(self.address)
    }
}

/// Serves some items to viewers that connect to the `viewer.address` and `viewer.port` of the parameters, until the value is
/// dropped.
///
/// # Errors
/// The port is taken, or the address is not of this machine.
pub fn serve(parameters: &Arc<Parameters>, items: Vec<Item>) -> Result<Served, ViewerError> {
    let viewer = &parameters.settings().viewer;
    let address = loopback(&viewer.address, viewer.port)?;
    let stream = stream(address, viewer.memory_limit)?;
    let options = file::options(&items, false);
    let mut film = Film::new(stream, Arc::clone(parameters), options)?;
    film.show(items)?;
    Ok(Served {
        address,
        _film: film,
    })
}

/// How a viewer finds a server.
#[must_use]
pub fn url(address: SocketAddr) -> String {
    format!("rerun+http://{address}/proxy")
}

#[cfg(test)]
mod tests {
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

    #[test]
    fn a_port_that_is_taken_is_said() {
        let taken = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
        let address = taken.local_addr().expect("its address");
        let error = stream(address, 1_000_000).map(drop).expect_err("taken");
        assert!(matches!(error, ViewerError::PortTaken { .. }), "{error}");
        assert!(error.to_string().contains(&address.to_string()), "{error}");
    }
}
