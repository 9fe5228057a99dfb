//! The server as its host sees it.

use std::io;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::sync_channel;
use std::thread::{Builder, JoinHandle};

use crossbeam_queue::ArrayQueue;

use crate::bell::Bell;
use crate::host::{Handler, Notices, Parameter, Settings, Statistics};
use crate::network::{MAX_JOBS, Network};
use crate::playback::PlaybackState;
use crate::shared::{Message, Published, Shared};
use crate::worker;

/// Most messages that wait for the network's thread.
const MAX_PUBLISHED: usize = 4096;

/// A running server. It ends when it is dropped.
pub struct Server {
    shared: Arc<Shared>,
    address: SocketAddr,
    threads: Vec<JoinHandle<()>>,
}

impl Server {
    /// Listens and serves.
    ///
    /// # Errors
    /// The address cannot be listened on, or a thread cannot be started.
    pub fn start(settings: Settings, handler: impl Handler, notices: Notices) -> io::Result<Self> {
        let listener = TcpListener::bind(&settings.address)?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let channels = settings.channels.iter();
        let shared = Arc::new(Shared {
            published: ArrayQueue::new(MAX_PUBLISHED),
            wanted: channels.map(|it| AtomicBool::new(it.history > 0)).collect(),
            bell: Bell::new()?,
            stop: AtomicBool::new(false),
            clients: AtomicU64::new(0),
            rejected: AtomicU64::new(0),
            dropped: AtomicU64::new(0),
        });
        let (jobs, waiting) = sync_channel(MAX_JOBS);
        // The network's thread never waits for a place among the jobs, so that it always takes the answers.
        let (answers, answered) = sync_channel(MAX_JOBS);
        let (control, bell) = (settings.control, Arc::clone(&shared));
        let work = move || worker::run(&waiting, &answers, &bell.bell, handler, control);
        let network = Network::new(
            listener,
            &settings,
            Arc::clone(&shared),
            (jobs, answered),
            notices,
        );
        let mut server = Self {
            shared,
            address,
            threads: Vec::new(),
        };
        // Dropped on an error, it ends the thread that runs already.
        let spawn = |name: &str, run: Box<dyn FnOnce() + Send>| {
            Builder::new().name(name.to_owned()).spawn(run)
        };
        let network = spawn("foxglove/net", Box::new(move || network.run()))?;
        server.threads.push(network);
        server.threads.push(spawn("foxglove/work", Box::new(work))?);
        Ok(server)
    }

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Sends a message of the channel with this index to its subscribers; `time` is in nanoseconds since 1970. Never waits.
    pub fn publish(&self, channel: usize, time: u64, bytes: &Arc<[u8]>) {
        let wanted = self.shared.wanted.get(channel);
        if wanted.is_some_and(|it| it.load(Ordering::Relaxed)) {
            self.hand_over(Published::Message(Message {
                channel,
                time,
                bytes: Arc::clone(bytes),
            }));
        }
    }

    /// Tells clients that follow them the new values of parameters. Never waits.
    pub fn parameters_changed(&self, changed: Vec<Parameter>) {
        self.hand_over(Published::Parameters(changed));
    }

    /// Tells all clients the state of the playback, and those that connect later the newest one. Never waits.
    pub fn playback(&self, state: PlaybackState) {
        self.hand_over(Published::Playback(state));
    }

    /// Tells the clients of a playback which recorded time is played now \[ns since 1970\]. Never waits.
    pub fn time(&self, now: u64) {
        self.hand_over(Published::Time(now));
    }

    fn hand_over(&self, published: Published) {
        if self.shared.published.force_push(published).is_some() {
            self.shared.dropped.fetch_add(1, Ordering::Relaxed);
        }
        self.shared.bell.ring();
    }

    /// Counts since the start.
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        let Shared {
            clients,
            rejected,
            dropped,
            ..
        } = &*self.shared;
        let [clients, rejected, dropped] =
            [clients, rejected, dropped].map(|it| it.load(Ordering::Relaxed));
        Statistics {
            clients,
            rejected,
            dropped,
        }
    }
}

impl Drop for Server {
    /// Sends what was published before, as far as the connections take it at once, and ends the threads; one that answers a request
    /// ends when it has answered.
    fn drop(&mut self) {
        self.shared.stop.store(true, Ordering::SeqCst);
        self.shared.bell.ring();
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}
