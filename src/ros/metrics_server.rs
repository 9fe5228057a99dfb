//! The port from which Prometheus reads the metrics.

use std::io::{self, Read as _, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use super::node::NodeError;

/// Longest request that is read \[bytes\].
const MAX_REQUEST: usize = 8192;
/// Longest time for a request and its answer: a slow reader holds up other readers of metrics for so long, and nothing else.
const TIMEOUT: Duration = Duration::from_secs(2);
/// Wait after a connection that could not be accepted.
const PAUSE: Duration = Duration::from_millis(100);

/// A server of one page.
pub(super) struct MetricsServer {
    page: Arc<Mutex<Arc<str>>>,
    stop: Arc<AtomicBool>,
    address: SocketAddr,
    thread: Option<JoinHandle<()>>,
}

impl MetricsServer {
    /// Listens on this address; `None` if it is empty.
    pub fn start(address: &str) -> Result<Option<Self>, NodeError> {
        if address.is_empty() {
            return Ok(None);
        }
        let fault = |fault: io::Error| {
            NodeError::Metrics(format!(
                "cannot listen on metrics.address {address:?}: {fault}; give a free address and port, such as 127.0.0.1:9464"
            ))
        };
        let listener = TcpListener::bind(address).map_err(fault)?;
        let bound = listener.local_addr().map_err(fault)?;
        if !bound.ip().is_loopback() {
            tracing::warn!(
                "everybody who reaches {bound} can read the metrics, without a password or encryption"
            );
        }
        let page = Arc::new(Mutex::new(Arc::from("")));
        let stop = Arc::<AtomicBool>::default();
        let (own, ending) = (Arc::clone(&page), Arc::clone(&stop));
        let work = move || serve(&listener, &own, &ending);
        let thread = Builder::new()
            .name("column_twin/met".to_owned())
            .spawn(work);
        Ok(Some(Self {
            page,
            stop,
            address: bound,
            thread: Some(thread.map_err(fault)?),
        }))
    }

    /// Shows this page from now on.
    pub fn show(&self, text: String) {
        *self.page.lock().unwrap_or_else(PoisonError::into_inner) = text.into();
    }
}

impl Drop for MetricsServer {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        // Wakes the thread, which waits for a connection.
        let _ = TcpStream::connect_timeout(&self.address, TIMEOUT);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn serve(listener: &TcpListener, page: &Mutex<Arc<str>>, stop: &AtomicBool) {
    for connection in listener.incoming() {
        if stop.load(Ordering::Acquire) {
            return;
        }
        match connection {
            Ok(connection) => {
                let page = Arc::clone(&page.lock().unwrap_or_else(PoisonError::into_inner));
                if let Err(fault) = answer(connection, &page) {
                    tracing::debug!("a reader of the metrics went away: {fault}");
                }
            }
            Err(fault) => {
                tracing::debug!("a reader of the metrics was not accepted: {fault}");
                std::thread::sleep(PAUSE);
            }
        }
    }
}

/// Answers one request, and closes the connection.
fn answer(mut connection: TcpStream, page: &str) -> io::Result<()> {
    let end = Instant::now() + TIMEOUT;
    connection.set_write_timeout(Some(TIMEOUT))?;
    let mut request = Vec::new();
    let mut chunk = [0; 1024];
    while !request.windows(4).any(|it| it == b"\r\n\r\n") {
        let rest = end.saturating_duration_since(Instant::now());
        if rest.is_zero() || request.len() > MAX_REQUEST {
            return Err(io::ErrorKind::InvalidData.into());
        }
        connection.set_read_timeout(Some(rest))?;
        match connection.read(&mut chunk)? {
            0 => return Ok(()),
            length => request.extend_from_slice(&chunk[..length]),
        }
    }
    let line = request.split(|it| *it == b'\r').next().unwrap_or_default();
    let (status, kind, body) = match line {
        b"GET /metrics HTTP/1.1" | b"GET /metrics HTTP/1.0" => {
            ("200 OK", "text/plain; version=0.0.4; charset=utf-8", page)
        }
        _ => (
            "404 Not Found",
            "text/plain",
            "the metrics are at /metrics\n",
        ),
    };
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
        body.len()
    );
    connection.write_all(head.as_bytes())?;
    connection.write_all(body.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn get(address: SocketAddr, request: &str) -> String {
        let mut connection = TcpStream::connect(address).expect("the server listens");
        connection.write_all(request.as_bytes()).expect("is sent");
        let mut text = String::new();
        connection.read_to_string(&mut text).expect("is answered");
        text
    }

    #[test]
    fn the_page_is_served_and_nothing_else() {
        let server = MetricsServer::start("127.0.0.1:0").expect("a free port");
        let server = server.expect("an address is given");
        server.show("up 1\n".to_owned());
        let page = get(server.address, "GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n");
        assert!(
            page.starts_with("HTTP/1.1 200 OK\r\n") && page.ends_with("\r\n\r\nup 1\n"),
            "{page}"
        );
        let other = get(server.address, "POST /metrics HTTP/1.1\r\n\r\n");
        assert!(other.starts_with("HTTP/1.1 404"), "{other}");
    }

    #[test]
    fn a_port_in_use_is_an_error_at_the_start() {
        let first = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = first.local_addr().expect("is bound").to_string();
        let fault = MetricsServer::start(&address)
            .err()
            .expect("the port is in use");
        assert!(fault.to_string().contains(&address), "{fault}");
        assert!(MetricsServer::start("nonsense").is_err());
        assert!(MetricsServer::start("").expect("is off").is_none());
    }
}
