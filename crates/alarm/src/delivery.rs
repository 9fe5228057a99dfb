//! The delivery: threads that take conditions, spool what is an alarm, and send it.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use crate::bell::Bell;
use crate::channel::{Channel, aside};
use crate::condition::Condition;
use crate::error::StartError;
use crate::message::State;
use crate::mqtt::{Broker, MqttSettings};
use crate::notice::{Importance, Notices};
use crate::sender::{SendFault, Sender, time_of_day};
use crate::statistics::Statistics;
use crate::webhook::{Webhook, WebhookSettings};

/// Most conditions between the host and the disk. One more is dropped and counted, because the host never waits.
pub const MAX_QUEUED: usize = 16_384;
/// Most conditions that are written to the disk at once.
const MAX_BATCH: usize = 1024;
/// How often a thread is asked at the end whether it is done.
const ASKED_EVERY: Duration = Duration::from_millis(10);

/// What is delivered, how, and where it is kept until then.
#[derive(Debug, Clone, Default)]
pub struct Settings {
    /// The name of this node in its messages.
    pub node: String,
    /// The folder of the spool. Only one process at a time may use it.
    pub spool: PathBuf,
    /// The time between two heartbeats; none without.
    pub heartbeat: Option<Duration>,
    /// Delivery by MQTT 5.
    pub mqtt: Option<MqttSettings>,
    /// Delivery by webhook.
    pub webhook: Option<WebhookSettings>,
}

/// The running delivery.
pub struct Alarms {
    queue: Option<SyncSender<Condition>>,
    dropped: Arc<AtomicU64>,
    signs_of_life: Arc<AtomicU64>,
    ending: Arc<AtomicBool>,
    outlets: Vec<Outlet>,
    spooler: Option<JoinHandle<()>>,
    senders: Vec<JoinHandle<()>>,
    notices: Notices,
}

#[derive(Clone)]
struct Outlet {
    channel: Arc<Mutex<Channel>>,
    bell: Bell,
}

impl Outlet {
    fn with<T>(&self, act: impl FnOnce(&mut Channel) -> T) -> T {
        act(&mut self.channel.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Alarms {
    /// Checks the settings and starts the delivery. A receiver need not be there yet.
    ///
    /// # Errors
    ///
    /// If an address, a topic or a file cannot be used, or the spool not be opened.
    pub fn start(settings: &Settings, notices: Notices) -> Result<Self, StartError> {
        let mut alarms = Self {
            queue: None,
            dropped: Arc::default(),
            signs_of_life: Arc::default(),
            ending: Arc::default(),
            outlets: Vec::new(),
            spooler: None,
            senders: Vec::new(),
            notices: Arc::clone(&notices),
        };
        let broker = settings.mqtt.as_ref();
        let broker = broker.map(|it| Ok::<_, StartError>((Broker::new(it)?, &it.rules)));
        let webhook = settings.webhook.as_ref();
        let webhook = webhook.map(|it| Ok::<_, StartError>((Webhook::new(it)?, &it.rules)));
        let (broker, webhook) = (broker.transpose()?, webhook.transpose()?);
        let mut open = |name, rules: &crate::rules::Rules| {
            let (node, folder, rules) = (&settings.node, &settings.spool, rules.clone());
            let opened = Channel::open(
                name,
                node,
                folder,
                rules,
                Arc::clone(&notices),
                time_of_day(),
            )?;
            let outlet = Outlet {
                channel: Arc::new(Mutex::new(opened)),
                bell: Bell::new(),
            };
            let sender = Sender {
                channel: Arc::clone(&outlet.channel),
                bell: outlet.bell.clone(),
                ending: Arc::clone(&alarms.ending),
                heartbeat: settings.heartbeat,
                signs_of_life: Arc::clone(&alarms.signs_of_life),
                began: Instant::now(),
            };
            alarms.outlets.push(outlet);
            Ok::<Sender, StartError>(sender)
        };
        let broker = broker.map(|(it, rules)| Ok::<_, StartError>((it, open("mqtt", rules)?)));
        let broker = broker.transpose()?;
        let webhook = webhook.map(|(it, rules)| Ok::<_, StartError>((it, open("webhook", rules)?)));
        let webhook = webhook.transpose()?;
        if let Some((broker, sender)) = broker {
            let name = "alarm_mqtt";
            let runtime = runtime().map_err(|fault| StartError::Thread { name, fault })?;
            let work = move || runtime.block_on(broker.run(&sender));
            alarms.senders.push(thread(name, work)?);
        }
        if let Some((webhook, sender)) = webhook {
            let work = move || webhook.run(&sender);
            alarms.senders.push(thread("alarm_webhook", work)?);
        }
        let (queue, conditions) = sync_channel(MAX_QUEUED);
        let outlets = alarms.outlets.clone();
        alarms.spooler = Some(thread("alarm_spool", move || spool(&conditions, &outlets))?);
        alarms.queue = Some(queue);
        Ok(alarms)
    }

    /// Takes the present condition of something. Never waits: if the queue is full, the condition is dropped, counted and
    /// told as an error, and the result is false.
    pub fn observe(&self, condition: Condition) -> bool {
        let queue = self.queue.as_ref();
        let is_taken = queue.is_some_and(|it| it.try_send(condition).is_ok());
        if !is_taken {
            let dropped = self.dropped.fetch_add(1, Ordering::Relaxed) + 1;
            // 1, 2, 4, 8, ...: a flood must not fill the log.
            if dropped.is_power_of_two() {
                (self.notices)(
                    Importance::Error,
                    format!(
                        "alarms: lost {dropped} conditions since the start, because more than {MAX_QUEUED} waited for the disk"
                    ),
                );
            }
        }
        is_taken
    }

    /// The host lives: without this, no heartbeat is sent.
    pub fn sign_of_life(&self) {
        self.signs_of_life.fetch_add(1, Ordering::Relaxed);
    }

    /// What became of the messages.
    pub fn statistics(&self) -> Statistics {
        Statistics {
            dropped: self.dropped.load(Ordering::Relaxed),
            channels: self
                .outlets
                .iter()
                .map(|it| it.with(|channel| channel.statistics()))
                .collect(),
        }
    }

    /// Says that the node stops, for this reason, and delivers what waits, for at most so long. What remains is delivered
    /// after the next start.
    pub fn stop(mut self, reason: &str, at_most: Duration) {
        self.close();
        for outlet in &self.outlets {
            outlet.with(|channel| channel.stops(reason, time_of_day()));
        }
        self.end();
        let began = Instant::now();
        while began.elapsed() < at_most && !self.senders.iter().all(JoinHandle::is_finished) {
            std::thread::sleep(ASKED_EVERY);
        }
        for outlet in &self.outlets {
            let (name, waiting) = outlet.with(|channel| {
                let it = channel.statistics();
                (it.name, it.waiting)
            });
            if waiting > 0 {
                (self.notices)(
                    Importance::Warning,
                    format!(
                        "alarm by {name}: {waiting} messages wait in the spool for the next start"
                    ),
                );
            }
        }
    }

    /// Spools everything that was observed.
    fn close(&mut self) {
        self.queue = None;
        if let Some(spooler) = self.spooler.take() {
            let _ = spooler.join();
        }
    }

    fn end(&self) {
        self.ending.store(true, Ordering::Release);
        for outlet in &self.outlets {
            outlet.bell.ring();
        }
    }
}

impl Drop for Alarms {
    fn drop(&mut self) {
        self.close();
        self.end();
    }
}

fn thread(
    name: &'static str,
    work: impl FnOnce() + Send + 'static,
) -> Result<JoinHandle<()>, StartError> {
    let spawned = Builder::new().name(name.to_owned()).spawn(work);
    spawned.map_err(|fault| StartError::Thread { name, fault })
}

/// Takes conditions until the host is gone. What arrives together is written together.
fn spool(conditions: &Receiver<Condition>, outlets: &[Outlet]) {
    while let Ok(first) = conditions.recv() {
        let mut batch = vec![first];
        batch.extend(conditions.try_iter().take(MAX_BATCH - 1));
        for outlet in outlets {
            if outlet.with(|channel| channel.observe(&batch)) {
                outlet.bell.ring();
            }
        }
    }
}

fn runtime() -> std::io::Result<tokio::runtime::Runtime> {
    tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
}

/// What became of a message that was tried: the name of the way, and why it failed.
pub type Tried = (&'static str, Result<(), String>);

/// Sends one message of the state `test` by each way, past the spool and beside a running node.
///
/// # Errors
///
/// If the settings cannot be used.
pub fn try_out(settings: &Settings) -> Result<Vec<Tried>, StartError> {
    let now = time_of_day();
    let reason = "Somebody tries whether alarms arrive. No action is required.";
    let message = aside("test", State::Test, &settings.node, reason, now);
    let in_words = |result: Result<(), SendFault>| {
        result.map_err(|fault| match fault {
            SendFault::Away(why, _) | SendFault::Rejected(why) => why,
        })
    };
    let mut results = Vec::new();
    if let Some(mqtt) = &settings.mqtt {
        let broker = Broker::new(mqtt)?;
        let name = "alarm_test";
        let runtime = runtime().map_err(|fault| StartError::Thread { name, fault })?;
        results.push(("mqtt", in_words(runtime.block_on(broker.try_out(&message)))));
    }
    if let Some(webhook) = &settings.webhook {
        let webhook = Webhook::new(webhook)?;
        results.push(("webhook", in_words(webhook.post(&message, now))));
    }
    Ok(results)
}
