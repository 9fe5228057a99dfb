//! The programs of other makes, which end with the test.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::fmt::Write as _;
use std::fs;
use std::io::{BufRead as _, BufReader};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};

use super::PATIENCE;

#[path = "free_port.rs"]
mod free_port;
pub use free_port::free_port;

/// A process that is killed at the end.
pub struct Running(pub Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The lines that a process prints.
pub struct Lines {
    _process: Running,
    lines: Receiver<String>,
    /// Lines that came before the greeting.
    earlier: RefCell<VecDeque<String>>,
}

impl Lines {
    pub fn of(command: &mut Command) -> Self {
        let mut child = command
            .stdout(Stdio::piped())
            .spawn()
            .expect("the program is installed");
        let output = BufReader::new(child.stdout.take().unwrap());
        let (sent, lines) = sync_channel(100_000);
        let read = move || {
            output
                .lines()
                .map_while(Result::ok)
                .try_for_each(|it| sent.send(it))
                .ok()
        };
        std::thread::Builder::new().spawn(read).unwrap();
        Self {
            _process: Running(child),
            lines,
            earlier: RefCell::default(),
        }
    }

    pub fn next(&self) -> String {
        if let Some(line) = self.earlier.borrow_mut().pop_front() {
            return line;
        }
        self.lines
            .recv_timeout(PATIENCE)
            .expect("the program prints another line")
    }

    /// Whether a greeting comes within a moment; what came before stays.
    fn greeted(&self) -> bool {
        let began = Instant::now();
        while began.elapsed() < Duration::from_millis(500) {
            match self.lines.recv_timeout(Duration::from_millis(500)) {
                Ok(line) if line.starts_with("hello ") => return true,
                Ok(line) => self.earlier.borrow_mut().push_back(line),
                Err(_) => {}
            }
        }
        false
    }

    /// A further line, if one comes within a moment.
    pub fn next_soon(&self) -> Option<String> {
        self.lines.recv_timeout(Duration::from_millis(500)).ok()
    }
}

/// The broker, on a port of its own.
pub struct Mosquitto {
    pub port: u16,
    process: Option<Running>,
    configuration: std::path::PathBuf,
}

impl Mosquitto {
    /// Writes the configuration; nothing runs yet.
    pub fn new(folder: &Path, more: &str) -> Self {
        let port = free_port();
        let mut text = format!(
            "listener {port} 127.0.0.1\npersistence true\npersistence_location {}/\nmax_queued_messages 0\nuser root\n",
            folder.display()
        );
        let _ = writeln!(
            text,
            "{}\n{more}",
            if more.contains("allow_anonymous") {
                ""
            } else {
                "allow_anonymous true"
            }
        );
        let configuration = folder.join("mosquitto.conf");
        fs::write(&configuration, text).unwrap();
        Self {
            port,
            process: None,
            configuration,
        }
    }

    pub fn started(folder: &Path, more: &str) -> Self {
        // Somebody may take the port before the broker does.
        for _ in 0..3 {
            let mut broker = Self::new(folder, more);
            match broker.try_start() {
                Ok(()) => return broker,
                Err(reason) => eprintln!("{reason}"),
            }
        }
        panic!("mosquitto did not start on any of three ports");
    }

    pub fn start(&mut self) {
        self.try_start().unwrap_or_else(|reason| panic!("{reason}"));
    }

    /// Starts it, and waits until its port answers; an error if it ends, with what it printed.
    fn try_start(&mut self) -> Result<(), String> {
        let program = if Path::new("/usr/sbin/mosquitto").exists() {
            "/usr/sbin/mosquitto"
        } else {
            "mosquitto"
        };
        let printed = self.printed();
        let child = Command::new(program)
            .arg("-c")
            .arg(&self.configuration)
            .stdout(Stdio::null())
            .stderr(fs::File::create(&printed).unwrap())
            .spawn()
            .expect("Debian's package mosquitto is installed");
        let broker = &mut self.process.insert(Running(child)).0;
        let began = Instant::now();
        loop {
            let said = fs::read_to_string(&printed).unwrap();
            if let Some(ended) = broker.try_wait().unwrap() {
                return Err(format!("mosquitto ended with {ended:?}:\n{said}"));
            }
            // An answer alone could be that of somebody else on this port.
            if said.contains(" running") && TcpStream::connect(("127.0.0.1", self.port)).is_ok() {
                return Ok(());
            }
            assert!(
                began.elapsed() < PATIENCE,
                "mosquitto does not listen:\n{said}"
            );
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Ends it in order, so that it keeps what it has acknowledged.
    pub fn stop(&mut self) {
        if let Some(mut running) = self.process.take() {
            let pid = running.0.id().to_string();
            assert!(Command::new("kill").arg(pid).status().unwrap().success());
            running.0.wait().unwrap();
        }
    }

    /// The file of what it prints.
    fn printed(&self) -> std::path::PathBuf {
        self.configuration.with_extension("log")
    }

    pub fn address(&self) -> String {
        format!("mqtt://127.0.0.1:{}", self.port)
    }

    /// A subscriber to everything that keeps its session: prints topic, whether retained, and payload.
    pub fn subscriber(&self) -> Lines {
        self.subscribe(&["-i", "subscriber", "-c", "-x", "3600"])
    }

    /// A subscriber that has never been there.
    pub fn subscriber_afresh(&self) -> Lines {
        self.subscribe(&["-i", "late"])
    }

    fn subscribe(&self, session: &[&str]) -> Lines {
        let port = self.port.to_string();
        let lines = Lines::of(
            Command::new("mosquitto_sub")
                .args(["-V", "5", "-h", "127.0.0.1", "-p", &port, "-q", "1"])
                .args(["-t", "#", "-F", "%t %r %p"])
                .args(session),
        );
        // It has subscribed when it hears of itself.
        let began = Instant::now();
        loop {
            assert!(
                began.elapsed() < PATIENCE,
                "the subscriber does not subscribe; the broker says: {}",
                fs::read_to_string(self.printed()).unwrap_or_default()
            );
            let mut hello = Command::new("mosquitto_pub");
            hello.args(["-h", "127.0.0.1", "-p", &port, "-t", "hello", "-m", "{}"]);
            let sent = hello.status().expect("mosquitto-clients is installed");
            if sent.success() && lines.greeted() {
                return lines;
            }
        }
    }
}
