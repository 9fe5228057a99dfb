//! The network's thread: accepts clients, hears their requests, and sends them what is published.

use std::collections::{HashSet, VecDeque};
use std::io::ErrorKind;
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError};
use std::thread::sleep;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use tungstenite::Message as Frame;

use crate::client::{Client, End};
use crate::door::Rules;
use crate::host::{Importance, Notices, Settings};
use crate::protocol::{self, Level, Request, Subscription};
use crate::shared::{Message, Published, Shared};
use crate::worker::{Answer, Job, Task};

/// Most requests that wait for the host, of all clients.
pub(crate) const MAX_JOBS: usize = 256;
/// Most requests of one client that wait for the host.
const MAX_UNANSWERED: usize = 16;
/// Most subscriptions of a client, and most names of parameters that it follows.
const MAX_SUBSCRIPTIONS: usize = 1024;
/// Longest name of a parameter that it follows \[bytes\].
const MAX_NAME: usize = 512;
/// Most clients, most connections that have not said yet what they want, and most that are accepted in one turn.
const MAX_CLIENTS: usize = 64;
/// Most reasons of rejections that are told.
const MAX_TOLD: usize = 32;
/// Wait after a ring, so that what is published at a high rate is sent together.
const BREATH: Duration = Duration::from_millis(2);
/// Wait after a connection that could not be accepted.
const PAUSE: Duration = Duration::from_millis(100);
/// Period of a look at clients that may run out of time.
const LOOK: Timespec = Timespec {
    tv_sec: 1,
    tv_nsec: 0,
};
const AT_ONCE: Timespec = Timespec {
    tv_sec: 0,
    tv_nsec: 0,
};

/// The network's thread.
pub(crate) struct Network {
    listener: TcpListener,
    clients: Vec<Client>,
    next_number: u64,
    rules: Arc<Rules>,
    desk: Desk,
    answers: Receiver<Answer>,
    told: HashSet<String>,
}

/// Where requests of clients go.
struct Desk {
    shared: Arc<Shared>,
    greeting: Vec<Frame>,
    /// How many messages each channel keeps.
    depths: Vec<usize>,
    histories: Vec<VecDeque<Message>>,
    services: usize,
    /// Whether clients control a playback, and its newest state.
    has_playback: bool,
    playback: Option<Frame>,
    jobs: SyncSender<Job>,
    notices: Notices,
    /// Whether subscriptions have changed.
    has_changed: bool,
}

impl Network {
    pub fn new(
        listener: TcpListener,
        settings: &Settings,
        shared: Arc<Shared>,
        (jobs, answers): (SyncSender<Job>, Receiver<Answer>),
        notices: Notices,
    ) -> Self {
        let bound = listener.local_addr();
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        let session = since.unwrap_or_default().as_nanos().to_string();
        let mut greeting = vec![
            protocol::server_info(settings, &session).into(),
            protocol::advertise(&settings.channels).into(),
        ];
        if !settings.services.is_empty() {
            greeting.push(protocol::advertise_services(&settings.services).into());
        }
        Self {
            listener,
            clients: Vec::new(),
            next_number: 0,
            rules: Arc::new(Rules {
                is_of_this_machine: bound.is_ok_and(|it| it.ip().is_loopback()),
                is_this_machine: settings.is_this_machine,
                origins: settings.origins.clone(),
                origins_name: settings.origins_name,
            }),
            desk: Desk {
                shared,
                greeting,
                depths: settings.channels.iter().map(|it| it.history).collect(),
                histories: settings.channels.iter().map(|_| VecDeque::new()).collect(),
                services: settings.services.len(),
                has_playback: settings.playback.is_some(),
                playback: None,
                jobs,
                notices,
                has_changed: false,
            },
            answers,
            told: HashSet::new(),
        }
    }

    /// Serves until the stop.
    pub fn run(mut self) {
        let shared = Arc::clone(&self.desk.shared);
        while !shared.stop.load(Ordering::SeqCst) {
            let ready = self.wait();
            if ready[0].contains(PollFlags::IN) {
                sleep(BREATH);
                shared.bell.heard();
            }
            self.take_answers();
            self.take_published();
            self.attend(&ready[2..]);
            if ready[1].contains(PollFlags::IN) {
                self.accept();
            }
            self.note_wishes();
        }
        self.take_published();
        for client in &mut self.clients {
            let _ = client.write();
            client.close();
        }
    }

    /// Waits until there is something to do: for the bell, for the listener, and for each client.
    fn wait(&self) -> Vec<PollFlags> {
        let mut waiting = vec![
            PollFd::from_borrowed_fd(self.desk.shared.bell.socket(), PollFlags::IN),
            PollFd::new(&self.listener, PollFlags::IN),
        ];
        for client in &self.clients {
            let mut what = PollFlags::IN;
            if client.wants_to_write() {
                what |= PollFlags::OUT;
            }
            if let Some(socket) = client.socket() {
                waiting.push(PollFd::from_borrowed_fd(socket, what));
            }
        }
        let timeout = if self.clients.iter().any(Client::has_more) {
            Some(&AT_ONCE)
        } else if self.clients.iter().any(Client::is_timed) {
            Some(&LOOK)
        } else {
            None
        };
        if let Err(fault) = poll(&mut waiting, timeout) {
            // Interrupted by a signal, or out of memory for a moment.
            if fault != rustix::io::Errno::INTR {
                sleep(PAUSE);
            }
            return vec![PollFlags::empty(); waiting.len()];
        }
        waiting.iter().map(PollFd::revents).collect()
    }

    fn accept(&mut self) {
        // Those who connect again and again do not keep the others waiting.
        for _ in 0..MAX_CLIENTS {
            let (stream, peer) = match self.listener.accept() {
                Ok(accepted) => accepted,
                Err(none) if none.kind() == ErrorKind::WouldBlock => return,
                Err(fault) => {
                    let text = format!("a client could not be accepted: {fault}");
                    self.tell_once(Importance::Warning, text);
                    sleep(PAUSE);
                    return;
                }
            };
            let is_greeted = |it: &Client| !it.is_open();
            let greeted = self.clients.iter().filter(|it| is_greeted(it)).count();
            if greeted >= MAX_CLIENTS
                && let Some(oldest) = self.clients.iter().position(is_greeted)
            {
                // Silent connections keep nobody out.
                self.clients.remove(oldest);
            }
            self.next_number += 1;
            if let Ok(client) = Client::new(self.next_number, stream, peer, &self.rules) {
                self.clients.push(client);
            }
        }
    }

    /// Tells something that strangers can cause only once.
    fn tell_once(&mut self, importance: Importance, text: String) {
        if self.told.len() < MAX_TOLD && self.told.insert(text.clone()) {
            (self.desk.notices)(importance, text);
        }
    }

    fn take_answers(&mut self) {
        while let Ok(Answer { client, messages }) = self.answers.try_recv() {
            let asked = self.clients.iter_mut().find(|it| it.number == client);
            if let Some(asked) = asked {
                asked.unanswered = asked.unanswered.saturating_sub(1);
                for message in messages {
                    asked.answer(message);
                }
            }
        }
    }

    fn take_published(&mut self) {
        // What is published meanwhile rings again.
        for _ in 0..self.desk.shared.published.capacity() {
            match self.desk.shared.published.pop() {
                None => return,
                Some(Published::Message(message)) => self.send(message),
                Some(Published::Playback(state)) => {
                    if state.did_seek {
                        // What was published later in the recording is not the past of a client that connects now.
                        self.desk.histories.iter_mut().for_each(VecDeque::clear);
                    }
                    let frame = Frame::from(protocol::playback_state(&state));
                    for client in self.clients.iter_mut().filter(|it| it.is_open()) {
                        client.answer(frame.clone());
                    }
                    self.desk.playback = Some(frame);
                }
                Some(Published::Time(now)) => {
                    // A client that is behind gets the next one.
                    let frame = Frame::from(protocol::time(now));
                    for client in &mut self.clients {
                        if client.is_open() && !client.wants_to_write() {
                            client.answer(frame.clone());
                        }
                    }
                }
                Some(Published::Parameters(changed)) => {
                    for client in &mut self.clients {
                        let followed = &client.parameters;
                        let is_followed =
                            |name: &String| followed.all || followed.names.contains(name);
                        let of_client: Vec<_> = changed
                            .iter()
                            .filter(|it| is_followed(&it.name))
                            .cloned()
                            .collect();
                        if !of_client.is_empty() {
                            client.answer(protocol::parameter_values(&of_client, None));
                        }
                    }
                }
            }
        }
        self.desk.shared.bell.ring();
    }

    fn send(&mut self, message: Message) {
        let depth = self.desk.depths[message.channel];
        for client in &mut self.clients {
            let before = client.dropped;
            client.send(&message, depth > 0);
            self.desk.note_losses(client, before);
        }
        if depth > 0 {
            let history = &mut self.desk.histories[message.channel];
            if history.len() == depth {
                history.pop_front();
            }
            history.push_back(message);
        }
    }

    /// Does for each client what can be done without waiting.
    fn attend(&mut self, ready: &[PollFlags]) {
        let now = Instant::now();
        let mut open = self.clients.iter().filter(|it| it.is_open()).count();
        let mut ended = Vec::new();
        for (index, client) in self.clients.iter_mut().enumerate() {
            let ready = ready.get(index).copied().unwrap_or(PollFlags::empty());
            let (was_open, is_full) = (client.is_open(), open >= MAX_CLIENTS);
            match self.desk.attend(client, ready, is_full, now) {
                Ok(()) => open += usize::from(client.is_open() && !was_open),
                Err(end) => ended.push((index, end)),
            }
        }
        for (index, end) in ended.into_iter().rev() {
            let client = self.clients.remove(index);
            self.desk.has_changed = true;
            self.part_from(&client, end);
        }
    }

    fn part_from(&mut self, client: &Client, end: End) {
        match end {
            End::Rejected(reason) => {
                let rejected = &self.desk.shared.rejected;
                rejected.fetch_add(1, Ordering::Relaxed);
                let text = format!("a client was rejected: {reason}");
                self.tell_once(Importance::Rejection, text);
            }
            End::Gone(_) if !client.is_open() => {}
            End::Gone(reason) => {
                let lost = match client.dropped {
                    0 => String::new(),
                    lost => format!("; it had lost {lost} messages"),
                };
                let text = format!("the client at {} has gone: {reason}{lost}", client.peer);
                (self.desk.notices)(Importance::Info, text);
            }
        }
    }

    /// Notes which channels are wanted, and how many clients there are.
    fn note_wishes(&mut self) {
        if !std::mem::take(&mut self.desk.has_changed) {
            return;
        }
        let Desk { shared, depths, .. } = &self.desk;
        let channels = self.clients.iter().flat_map(|it| it.subscriptions.values());
        let subscribed: HashSet<_> = channels.copied().collect();
        for (channel, (wanted, depth)) in shared.wanted.iter().zip(depths).enumerate() {
            let is_wanted = *depth > 0 || subscribed.contains(&channel);
            wanted.store(is_wanted, Ordering::Relaxed);
        }
        let open = self.clients.iter().filter(|it| it.is_open()).count();
        shared.clients.store(open as u64, Ordering::Relaxed);
    }
}

impl Desk {
    fn attend(
        &mut self,
        client: &mut Client,
        ready: PollFlags,
        is_full: bool,
        now: Instant,
    ) -> Result<(), End> {
        client.check_time(now)?;
        if !client.is_open() && !ready.is_empty() && client.greet()? {
            if is_full {
                let reason = format!("expected at most {MAX_CLIENTS} clients");
                return Err(End::Rejected(reason));
            }
            self.has_changed = true;
            for frame in self.greeting.iter().chain(&self.playback) {
                client.answer(frame.clone());
            }
        }
        if client.has_more() || !(ready - PollFlags::OUT).is_empty() {
            for frame in client.read()? {
                self.hear(client, &frame);
            }
        }
        if client.wants_to_write() {
            client.write()?;
        }
        Ok(())
    }

    fn hear(&mut self, client: &mut Client, frame: &Frame) {
        match frame {
            Frame::Text(text) => match serde_json::from_str(text.as_str()) {
                Ok(request) => self.carry_out(client, request),
                Err(fault) => {
                    let text = format!("a message cannot be read: {fault}");
                    client.answer(protocol::status(Level::Error, &text));
                }
            },
            Frame::Binary(bytes) if self.has_playback && protocol::is_playback(bytes) => {
                match protocol::read_playback(bytes) {
                    Ok(request) => self.ask(client, Task::Playback(request)),
                    Err(fault) => client.answer(protocol::status(Level::Error, &fault)),
                }
            }
            Frame::Binary(bytes) => match protocol::read_call(bytes) {
                Ok(call) if (call.service as usize) < self.services => {
                    self.ask(client, Task::Call(call));
                }
                Ok(call) => client.answer(protocol::call_failed(
                    &call,
                    "there is no service with this number",
                )),
                Err(fault) => client.answer(protocol::status(Level::Error, &fault)),
            },
            Frame::Ping(_) | Frame::Pong(_) | Frame::Close(_) | Frame::Frame(_) => {}
        }
    }

    fn carry_out(&mut self, client: &mut Client, request: Request) {
        match request {
            Request::Subscribe { subscriptions } => {
                for subscription in subscriptions {
                    self.subscribe(client, &subscription);
                }
            }
            Request::Unsubscribe { subscription_ids } => {
                self.has_changed = true;
                for id in subscription_ids {
                    client.unsubscribe(id);
                }
            }
            Request::GetParameters {
                parameter_names: names,
                id,
            } => self.ask(client, Task::Get { names, id }),
            Request::SetParameters { parameters, id } => {
                self.ask(client, Task::Set { parameters, id });
            }
            Request::SubscribeParameterUpdates { parameter_names } => {
                let followed = &mut client.parameters;
                followed.all |= parameter_names.is_empty();
                let room = MAX_SUBSCRIPTIONS.saturating_sub(followed.names.len());
                let names = parameter_names.into_iter();
                let names = names.filter(|it| it.len() <= MAX_NAME);
                followed.names.extend(names.take(room));
            }
            Request::UnsubscribeParameterUpdates { parameter_names } => {
                let followed = &mut client.parameters;
                if parameter_names.is_empty() {
                    *followed = Default::default();
                }
                for name in parameter_names {
                    followed.names.remove(&name);
                }
            }
            Request::Other => {
                let text = "this server offers topics, parameters and services";
                client.answer(protocol::status(Level::Warning, text));
            }
        }
    }

    fn subscribe(&mut self, client: &mut Client, subscription: &Subscription) {
        let id = subscription.id;
        let channel = usize::try_from(subscription.channel_id).ok();
        let Some(channel) = channel.filter(|it| *it < self.depths.len()) else {
            let text = format!("there is no channel {}", subscription.channel_id);
            return client.answer(protocol::status(Level::Warning, &text));
        };
        if client.subscriptions.contains_key(&id) || client.subscriptions.len() >= MAX_SUBSCRIPTIONS
        {
            let text = format!(
                "subscription {id} exists already, or there are {MAX_SUBSCRIPTIONS} others"
            );
            return client.answer(protocol::status(Level::Warning, &text));
        }
        client.subscriptions.insert(id, channel);
        self.has_changed = true;
        let before = client.dropped;
        for message in &self.histories[channel] {
            client.send_to(id, message, true);
        }
        self.note_losses(client, before);
    }

    /// Counts what a client has lost, of which `before` is known, and tells its first loss.
    fn note_losses(&self, client: &Client, before: u64) {
        let lost = client.dropped - before;
        self.shared.dropped.fetch_add(lost, Ordering::Relaxed);
        if before == 0 && lost > 0 {
            let text = format!(
                "the client at {} reads too slowly and loses its oldest messages",
                client.peer
            );
            (self.notices)(Importance::Warning, text);
        }
    }

    /// Hands a request to the host, unless there are too many.
    fn ask(&self, client: &mut Client, task: Task) {
        let job = Job {
            client: client.number,
            task,
        };
        let rejected = match client.unanswered >= MAX_UNANSWERED {
            true => job,
            false => match self.jobs.try_send(job) {
                Ok(()) => {
                    client.unanswered += 1;
                    return;
                }
                Err(TrySendError::Full(job) | TrySendError::Disconnected(job)) => job,
            },
        };
        let busy = "too many requests wait for an answer; try again later";
        client.answer(match rejected.task {
            Task::Call(call) => protocol::call_failed(&call, busy),
            Task::Get { .. } | Task::Set { .. } | Task::Playback(_) => {
                protocol::status(Level::Error, busy)
            }
        });
    }
}
