//! The port from which Prometheus reads the metrics.

use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use super::node::NodeError;
use crate::host_header;

/// Longest request that is read \[bytes\].
const MAX_REQUEST: usize = 8192;
/// Longest time for a request, and for its answer.
const TIMEOUT: Duration = Duration::from_secs(2);
/// Most readers at a time: a further one takes the place of the oldest, so that silent ones keep nobody out.
const MAX_READERS: usize = 64;
/// Wait between two looks at the readers, while there are any.
const LOOK: Duration = Duration::from_millis(5);
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
        Self::start_with(address, TIMEOUT)
    }

    fn start_with(address: &str, timeout: Duration) -> Result<Option<Self>, NodeError> {
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
        let service = Service {
            page: Arc::clone(&page),
            is_of_this_machine: bound.ip().is_loopback(),
            timeout,
        };
        let ending = Arc::clone(&stop);
        let work = move || service.serve(&listener, &ending);
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

/// What every reader gets.
struct Service {
    page: Arc<Mutex<Arc<str>>>,
    /// Whether it listens for this machine only.
    is_of_this_machine: bool,
    timeout: Duration,
}

impl Service {
    fn serve(&self, listener: &TcpListener, stop: &AtomicBool) {
        let mut readers: VecDeque<Reader> = VecDeque::new();
        while !stop.load(Ordering::Acquire) {
            match next(listener, readers.is_empty()) {
                Ok(Some(connection)) => {
                    if readers.len() == MAX_READERS {
                        readers.pop_front();
                    }
                    readers.push_back(Reader::new(connection, self.timeout));
                }
                Ok(None) => std::thread::sleep(LOOK),
                Err(fault) => {
                    tracing::debug!("a reader of the metrics was not accepted: {fault}");
                    std::thread::sleep(PAUSE);
                }
            }
            readers.retain_mut(|reader| match reader.advance(self) {
                Ok(is_done) => !is_done,
                Err(fault) => {
                    tracing::debug!("a reader of the metrics went away: {fault}");
                    false
                }
            });
        }
    }

    /// The answer to a whole request.
    fn answer(&self, request: &[u8]) -> Answer {
        let request = String::from_utf8_lossy(request);
        let path = request.split("\r\n").next().and_then(path_of_get);
        if path != Some("/metrics") {
            return Answer::new("404 Not Found", "text/plain", NOT_FOUND.into());
        }
        if self.is_of_this_machine && !host_header::is_this_machine(&request) {
            return Answer::new("403 Forbidden", "text/plain", FOREIGN_HOST.into());
        }
        let page = Arc::clone(&self.page.lock().unwrap_or_else(PoisonError::into_inner));
        let kind = "text/plain; version=0.0.4; charset=utf-8";
        Answer::new("200 OK", kind, page)
    }
}

const NOT_FOUND: &str = "the metrics are at /metrics\n";
const FOREIGN_HOST: &str =
    "the metrics are for this machine only: ask for them with the host localhost or 127.0.0.1\n";

/// The next connection; `None` if it would have to be waited for, and must not be.
fn next(listener: &TcpListener, may_wait: bool) -> io::Result<Option<TcpStream>> {
    listener.set_nonblocking(!may_wait)?;
    match listener.accept() {
        Ok((connection, _)) => {
            connection.set_nonblocking(true)?;
            Ok(Some(connection))
        }
        Err(none) if none.kind() == ErrorKind::WouldBlock => Ok(None),
        Err(fault) => Err(fault),
    }
}

/// The path of the first line of a GET, without its query.
fn path_of_get(line: &str) -> Option<&str> {
    let target = line.strip_prefix("GET ")?;
    let target = target
        .strip_suffix(" HTTP/1.1")
        .or_else(|| target.strip_suffix(" HTTP/1.0"))?;
    target.split('?').next()
}

/// What a reader gets.
struct Answer {
    head: String,
    body: Arc<str>,
    /// How much of both is sent \[bytes\].
    sent: usize,
}

impl Answer {
    fn new(status: &str, kind: &str, body: Arc<str>) -> Self {
        let head = format!(
            "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
            body.len()
        );
        Self {
            head,
            body,
            sent: 0,
        }
    }

    /// What is still to be sent; empty at the end.
    fn rest(&self) -> &[u8] {
        match self.head.as_bytes().get(self.sent..) {
            Some(head) if !head.is_empty() => head,
            _ => &self.body.as_bytes()[self.sent - self.head.len()..],
        }
    }
}

/// A connection that asks for one page.
struct Reader {
    connection: TcpStream,
    /// When it has had its time.
    end: Instant,
    request: Vec<u8>,
    /// Known when the request is whole.
    answer: Option<Answer>,
}

impl Reader {
    fn new(connection: TcpStream, timeout: Duration) -> Self {
        Self {
            connection,
            end: Instant::now() + timeout,
            request: Vec::new(),
            answer: None,
        }
    }

    /// Reads and writes as much as is possible without waiting; whether the connection is to be closed.
    fn advance(&mut self, service: &Service) -> io::Result<bool> {
        match self.try_advance(service) {
            Err(fault) if fault.kind() == ErrorKind::WouldBlock => Ok(Instant::now() >= self.end),
            ended => ended.map(|()| true),
        }
    }

    /// Reads the request and writes the answer; [`ErrorKind::WouldBlock`] if it has to go on later.
    fn try_advance(&mut self, service: &Service) -> io::Result<()> {
        let mut chunk = [0; 1024];
        while self.answer.is_none() {
            if self.request.windows(4).any(|it| it == b"\r\n\r\n") {
                self.answer = Some(service.answer(&self.request));
                self.end = Instant::now() + service.timeout;
            } else if self.request.len() > MAX_REQUEST {
                return Err(ErrorKind::InvalidData.into());
            } else {
                match self.connection.read(&mut chunk)? {
                    0 => return Ok(()),
                    length => self.request.extend_from_slice(&chunk[..length]),
                }
            }
        }
        if let Some(answer) = &mut self.answer {
            while !answer.rest().is_empty() {
                match self.connection.write(answer.rest())? {
                    0 => return Err(ErrorKind::WriteZero.into()),
                    length => answer.sent += length,
                }
            }
        }
        Ok(())
    }
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
        for target in ["/metrics", "/metrics?x=1"] {
            let page = get(server.address, &format!("GET {target} HTTP/1.1\r\n\r\n"));
            assert!(
                page.starts_with("HTTP/1.1 200 OK\r\n") && page.ends_with("\r\n\r\nup 1\n"),
                "{page}"
            );
        }
        let other = get(server.address, "POST /metrics HTTP/1.1\r\n\r\n");
        assert!(other.starts_with("HTTP/1.1 404"), "{other}");
    }

    /// Six of them, served one after another for their whole time, were enough that a scrape failed.
    #[test]
    fn silent_connections_keep_no_reader_out() {
        let hour = Duration::from_secs(3600);
        let server = MetricsServer::start_with("127.0.0.1:0", hour).expect("a free port");
        let server = server.expect("an address is given");
        server.show("up 1\n".to_owned());
        let connect = |_| TcpStream::connect(server.address).expect("the server listens");
        let mut silent: Vec<_> = (0..=MAX_READERS).map(connect).collect();
        let page = get(server.address, "GET /metrics HTTP/1.1\r\n\r\n");
        assert!(page.ends_with("up 1\n"), "{page}");
        // The oldest had to go.
        let read = silent[0].read(&mut [0]);
        assert!(!read.is_ok_and(|length| length > 0));
    }

    /// A web page whose name was made to lead to this machine read the metrics with the browser of whoever visited it.
    #[test]
    fn a_foreign_host_gets_no_metrics_of_this_machine() {
        let server = MetricsServer::start("127.0.0.1:0").expect("a free port");
        let server = server.expect("an address is given");
        server.show("up 1\n".to_owned());
        for (host, status) in [
            ("Host: localhost:9464", "200"),
            ("host:127.0.0.1", "200"),
            ("Host: [::1]:9464", "200"),
            ("Host: column.example:9464", "403"),
            ("Host: localhost.column.example", "403"),
            ("Host: 127.0.0.1\r\nHost: column.example", "403"),
            ("Host:", "403"),
        ] {
            let request = format!("GET /metrics HTTP/1.1\r\n{host}\r\n\r\n");
            let page = get(server.address, &request);
            assert!(
                page.starts_with(&format!("HTTP/1.1 {status} ")),
                "{host}: {page}"
            );
            assert_eq!(page.contains("up 1"), status == "200", "{host}: {page}");
        }
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
