//! Keeps web pages away from the server for viewers, which belongs to Rerun and answers to any host name (DNS rebinding).

use std::collections::hash_map::RandomState;
use std::hash::BuildHasher as _;
use std::io::{self, Read as _, Write as _};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use super::error::ViewerLogger;
use crate::host_header;
use crate::twin::NoticeLevel;

/// Begins every connection of HTTP/2 without encryption (RFC 9113, 3.4): viewers speak it, and no browser does.
const HTTP_2: &[u8] = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
/// Longest head of a request that is read \[bytes\].
const MAX_HEAD: usize = 8192;
/// Longest time for the head.
const TIMEOUT: Duration = Duration::from_secs(2);
/// Most connections at a time.
const MAX_CONNECTIONS: usize = 64;
/// A connection that has been silent for this long gives its place to a further one when all are taken. Rerun's server closes a
/// connection of HTTP/2 that leaves its pings unanswered, and one of HTTP/1.1 that requests nothing, each after 30 s. What is left is
/// a stream over HTTP/1.1, which nobody pings: as long as there is room, it stays, because a column at rest has nothing to send.
const MAX_SILENCE: Duration = Duration::from_secs(60);
/// Stack of a thread \[bytes\].
const STACK: usize = 128 << 10;
/// Wait after a connection that could not be accepted.
const PAUSE: Duration = Duration::from_millis(100);

const REJECTION: &[u8] =
    b"HTTP/1.1 403 Forbidden\r\nContent-Length: 0\r\nConnection: close\r\n\r\n";

/// Passes connections on to a server, except those that ask for another host than this machine. It ends when dropped; connections
/// end with the server.
pub struct Guard {
    stop: Arc<AtomicBool>,
    address: SocketAddr,
    thread: Option<JoinHandle<()>>,
}

impl Guard {
    /// Guards the server at an address; logs once when there are too many connections.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub fn start(listener: TcpListener, server: SocketAddr, log: ViewerLogger) -> io::Result<Self> {
        Self::with_silence(listener, server, log, MAX_SILENCE)
    }

    fn with_silence(
        listener: TcpListener,
        server: SocketAddr,
        log: ViewerLogger,
        max_silence: Duration,
    ) -> io::Result<Self> {
        let address = listener.local_addr()?;
        let stop = Arc::<AtomicBool>::default();
        let ending = Arc::clone(&stop);
        let places = Arc::new(Places {
            max_silence,
            taken: Mutex::default(),
        });
        let thread = thread().spawn(move || accept(&listener, server, &places, &ending, &log))?;
        Ok(Self {
            stop,
            address,
            thread: Some(thread),
        })
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        // Wakes the thread, which waits for a connection. If that fails, it would be waited for without end.
        let waking = TcpStream::connect_timeout(&self.address, TIMEOUT);
        if let (Some(thread), Ok(_)) = (self.thread.take(), &waking) {
            let _ = thread.join();
        }
    }
}

/// A free address for the server itself. A web page that looks for it has 16 million addresses with 64 thousand ports each.
///
/// # Errors
/// There is none.
pub fn hidden_address() -> io::Result<SocketAddr> {
    let [first, second, third, ..] = RandomState::new().hash_one(0).to_le_bytes();
    let hidden = Ipv4Addr::new(127, first, second, 1 + third % 254);
    // Other systems than Linux have 127.0.0.1 only.
    let listener =
        TcpListener::bind((hidden, 0)).or_else(|_| TcpListener::bind((Ipv4Addr::LOCALHOST, 0)))?;
    listener.local_addr()
}

/// Its stack is small, because a node locks its memory.
fn thread() -> Builder {
    Builder::new()
        .name("column_twin/gua".to_owned())
        .stack_size(STACK)
}

fn accept(
    listener: &TcpListener,
    server: SocketAddr,
    places: &Arc<Places>,
    stop: &AtomicBool,
    log: &ViewerLogger,
) {
    let mut is_told = false;
    loop {
        let accepted = listener.accept();
        if stop.load(Ordering::Acquire) {
            return;
        }
        let Ok((connection, _)) = accepted else {
            std::thread::sleep(PAUSE);
            continue;
        };
        let Some(place) = Place::take(places, connection) else {
            if !std::mem::replace(&mut is_told, true) {
                let text = format!(
                    "{MAX_CONNECTIONS} programs are connected to the server for viewers, which is the maximum; further ones are rejected \
                     until one of them closes its connection or has been silent for {} s",
                    places.max_silence.as_secs()
                );
                log(NoticeLevel::Warning, text);
            }
            continue;
        };
        // Whoever goes away has nobody to tell. Without a thread the connection is closed.
        let _ = thread().spawn(move || pass_on(&place, server));
    }
}

/// The connections that are open.
struct Places {
    max_silence: Duration,
    taken: Mutex<Vec<Arc<Open>>>,
}

/// A connection to a viewer.
struct Open {
    viewer: TcpStream,
    /// When something was last sent or received.
    last: Mutex<Instant>,
    /// Whether another connection has its place.
    is_replaced: AtomicBool,
}

impl Open {
    fn note(&self) {
        *self.last.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
    }

    fn last(&self) -> Instant {
        *self.last.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The place of an open connection, which becomes free when dropped.
struct Place {
    places: Arc<Places>,
    open: Arc<Open>,
}

impl Place {
    /// Takes a free place, or that of the connection that has been silent for the longest time, if that is too long. `None` if all
    /// are in use; the connection is closed.
    fn take(places: &Arc<Places>, viewer: TcpStream) -> Option<Self> {
        let open = Arc::new(Open {
            viewer,
            last: Mutex::new(Instant::now()),
            is_replaced: AtomicBool::new(false),
        });
        let mut taken = places.taken.lock().unwrap_or_else(PoisonError::into_inner);
        if taken.len() >= MAX_CONNECTIONS {
            let (index, last) =
                (taken.iter().map(|it| it.last()).enumerate()).min_by_key(|(_, last)| *last)?;
            if last.elapsed() < places.max_silence {
                return None;
            }
            let silent = taken.swap_remove(index);
            silent.is_replaced.store(true, Ordering::Release);
            // Wakes its threads, which then end.
            let _ = silent.viewer.shutdown(Shutdown::Both);
        }
        taken.push(Arc::clone(&open));
        drop(taken);
        Some(Self {
            places: Arc::clone(places),
            open,
        })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let taken = &self.places.taken;
        let mut taken = taken.lock().unwrap_or_else(PoisonError::into_inner);
        taken.retain(|it| !Arc::ptr_eq(it, &self.open));
    }
}

/// Reads one side of a connection, and notes that it is not silent.
struct Heard<'a> {
    side: &'a TcpStream,
    open: &'a Open,
}

impl io::Read for Heard<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = self.side.read(buffer)?;
        self.open.note();
        Ok(length)
    }
}

/// Looks at the beginning of a connection, and passes it on until one side ends it.
fn pass_on(place: &Place, server: SocketAddr) -> io::Result<()> {
    let open = &place.open;
    let mut viewer = &open.viewer;
    let mut begin = Vec::new();
    if !may_pass(viewer, &mut begin)? {
        return viewer.write_all(REJECTION);
    }
    viewer.set_read_timeout(None)?;
    viewer.set_nodelay(true)?;
    let served = TcpStream::connect_timeout(&server, TIMEOUT)?;
    served.set_nodelay(true)?;
    (&served).write_all(&begin)?;
    let (asking, mut to_server) = (Arc::clone(open), served.try_clone()?);
    let asking = thread().spawn(move || {
        let (side, open) = (&asking.viewer, &*asking);
        let _ = io::copy(&mut Heard { side, open }, &mut to_server);
        // A server may wait with its answer, but not for a viewer whose place is taken.
        let _ = to_server.shutdown(match open.is_replaced.load(Ordering::Acquire) {
            true => Shutdown::Both,
            false => Shutdown::Write,
        });
    })?;
    let side = &served;
    let ended = io::copy(&mut Heard { side, open }, &mut viewer);
    let _ = viewer.shutdown(Shutdown::Both);
    let _ = served.shutdown(Shutdown::Both);
    let _ = asking.join();
    ended.map(drop)
}

/// Reads the beginning of a connection; whether it may be passed on. The first request decides: a browser keeps a connection for one
/// host.
fn may_pass(mut connection: &TcpStream, begin: &mut Vec<u8>) -> io::Result<bool> {
    let deadline = Instant::now() + TIMEOUT;
    let mut chunk = [0; 1024];
    while begin.len() <= MAX_HEAD {
        if begin.starts_with(HTTP_2) {
            return Ok(true);
        }
        let may_be_http_2 = HTTP_2.starts_with(begin);
        if !may_be_http_2 && begin.windows(4).any(|it| it == b"\r\n\r\n") {
            return Ok(host_header::is_this_machine(&String::from_utf8_lossy(
                begin,
            )));
        }
        // Of the whole head: a sender of single bytes would hold the connection for hours.
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(io::ErrorKind::TimedOut.into());
        }
        connection.set_read_timeout(Some(left))?;
        match connection.read(&mut chunk)? {
            0 => return Err(io::ErrorKind::UnexpectedEof.into()),
            length => begin.extend_from_slice(&chunk[..length]),
        }
    }
    Ok(false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    fn silent() -> ViewerLogger {
        Arc::new(|_, _| {})
    }

    /// What a client gets that sends this through a guard, from a server that answers everything with a word.
    fn answer(request: &[u8]) -> String {
        let server = TcpListener::bind(hidden_address().expect("free")).expect("a server");
        let inner = server.local_addr().expect("its address");
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
        let guard = Guard::start(listener, inner, silent()).expect("a guard");
        Builder::new()
            .spawn(move || {
                let (mut served, _) = server.accept().expect("a connection");
                // Only what comes as one piece.
                let _ = served.read(&mut [0; 1024]);
                served.write_all(b"passed on").expect("is sent");
            })
            .expect("a thread");
        let mut connection = TcpStream::connect(guard.address).expect("it listens");
        connection.write_all(request).expect("is sent");
        let mut text = String::new();
        connection.read_to_string(&mut text).expect("is answered");
        text
    }

    /// A web page whose name was made to lead to this machine read the stream with the browser of whoever visited it.
    #[test]
    fn a_foreign_host_gets_nothing_from_the_server_for_viewers() {
        for host in ["column.example", "column.example:9876", "localhost.example"] {
            let request = format!("POST /proxy HTTP/1.1\r\nHost: {host}\r\n\r\n");
            let got = answer(request.as_bytes());
            assert!(got.starts_with("HTTP/1.1 403"), "{host}: {got}");
        }
        for host in ["localhost:9876", "127.0.0.1:9876", "[::1]:9876"] {
            let request = format!("POST /proxy HTTP/1.1\r\nHost: {host}\r\n\r\n");
            assert_eq!(answer(request.as_bytes()), "passed on", "{host}");
        }
        assert_eq!(answer(HTTP_2), "passed on");
    }

    /// Each byte had two seconds of its own.
    #[test]
    fn a_head_that_comes_in_single_bytes_has_one_deadline() {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
        let address = listener.local_addr().expect("its address");
        let slow = Builder::new().spawn(move || {
            let mut connection = TcpStream::connect(address).expect("it listens");
            while connection.write_all(b"x").is_ok() {
                std::thread::sleep(PAUSE);
            }
        });
        let (connection, _) = listener.accept().expect("a connection");
        // It ends before the head is too long, which takes a quarter of an hour.
        let ended = may_pass(&connection, &mut Vec::new());
        let kind = ended.expect_err("too slow").kind();
        let kinds = [io::ErrorKind::TimedOut, io::ErrorKind::WouldBlock];
        assert!(kinds.contains(&kind), "{kind}");
        drop(connection);
        slow.expect("a thread").join().expect("it ends");
    }

    #[test]
    fn too_many_connections_are_told_once() {
        let server = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a server");
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
        let told = Arc::<Mutex<Vec<String>>>::default();
        let lines = Arc::clone(&told);
        let log: ViewerLogger = Arc::new(move |_, text| lines.lock().expect("whole").push(text));
        let inner = server.local_addr().expect("its address");
        let guard = Guard::start(listener, inner, log).expect("a guard");
        // They are passed on, and then idle.
        let connect = |_| {
            let mut connection = TcpStream::connect(guard.address).expect("it listens");
            connection.write_all(HTTP_2).expect("is sent");
            connection
        };
        let idle: Vec<TcpStream> = (0..MAX_CONNECTIONS).map(connect).collect();
        for number in 0..3 {
            // Closed at once.
            let mut further = connect(number);
            let ended = further.read(&mut [0; 1]);
            assert!(!matches!(ended, Ok(1..)), "{ended:?}");
        }
        let lines = told.lock().expect("whole").clone();
        assert_eq!(lines.len(), 1, "{lines:?}");
        assert!(lines[0].contains("64 programs"), "{lines:?}");
        drop(idle);
    }

    /// Whoever filled all places once kept every viewer out until the node ended.
    #[test]
    fn a_further_connection_takes_the_place_of_the_one_that_has_been_silent_for_too_long() {
        let server = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a server");
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
        let inner = server.local_addr().expect("its address");
        let guard = Guard::with_silence(listener, inner, silent(), Duration::ZERO);
        let guard = guard.expect("a guard");
        // Each is passed on before the next one comes, so that it is known which has been silent for the longest time.
        let connect = || {
            let mut connection = TcpStream::connect(guard.address).expect("it listens");
            connection.write_all(HTTP_2).expect("is sent");
            let (mut served, _) = server.accept().expect("it is passed on");
            served
                .read_exact(&mut [0; HTTP_2.len()])
                .expect("the beginning");
            (connection, served)
        };
        let mut open: Vec<_> = (0..MAX_CONNECTIONS).map(|_| connect()).collect();
        // The first one is silent no longer, and the second one has been silent for the longest time.
        let (first, served) = &mut open[0];
        served.write_all(b"x").expect("is sent");
        first.read_exact(&mut [0]).expect("arrives");
        first.write_all(b"y").expect("is sent");
        served.read_exact(&mut [0]).expect("arrives");
        let (mut further, mut its_server) = connect();
        let (second, its_served) = &mut open[1];
        assert!(matches!(second.read(&mut [0]), Ok(0) | Err(_)));
        assert!(matches!(its_served.read(&mut [0]), Ok(0) | Err(_)));
        for (viewer, served) in [(&mut further, &mut its_server), {
            let (first, served) = &mut open[0];
            (first, served)
        }] {
            served.write_all(b"z").expect("is sent");
            viewer.read_exact(&mut [0]).expect("arrives");
        }
    }

    #[test]
    fn a_head_without_end_is_rejected() {
        let mut request = b"POST /proxy HTTP/1.1\r\n".to_vec();
        request.resize(MAX_HEAD + 1, b'x');
        let got = answer(&request);
        assert!(got.starts_with("HTTP/1.1 403"), "{got}");
    }
}
