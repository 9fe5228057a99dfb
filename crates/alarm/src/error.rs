//! The errors of a start, each with what to do next.

use std::path::PathBuf;

/// Why a template for topics cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs)] // The texts say it.
pub enum TopicFault {
    #[error("the topic is empty; use, for example, column_twin/{{node}}/{{subject}}/{{kind}}")]
    Empty,
    #[error(
        "the topic begins with $, which MQTT keeps for the broker; begin it with another character"
    )]
    Reserved,
    #[error("the topic holds {0:?}, which MQTT does not allow in the name of a topic; remove it")]
    Forbidden(char),
    #[error("the topic has {0} bytes; use at most 16383")]
    TooLong(usize),
    #[error("the topic has the field {{{0}}}; the fields are {{node}}, {{subject}} and {{kind}}")]
    UnknownField(String),
    #[error("the topic lacks {0}, so that different alarms would overwrite one another; add it")]
    Missing(&'static str),
}

/// Why alarms cannot be delivered with these settings.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // The texts say it.
pub enum StartError {
    #[error(transparent)]
    Topic(#[from] TopicFault),
    #[error(
        "{0:?} is not the address of a broker; write mqtts://HOST:PORT, or mqtt://HOST:PORT without TLS"
    )]
    Broker(String),
    #[error("{0:?} is not the address of a webhook; write https://HOST/PATH")]
    Url(String),
    #[error(
        "the address of the webhook has a user or password before @{0}; remove it, because parameters are published and recorded: \
         the receiver knows a message by its signature"
    )]
    UserInUrl(String),
    #[error(
        "{0:?} would send alarms unencrypted to another machine; use https:// (http:// is for this machine only)"
    )]
    Unencrypted(String),
    #[error("TLS files are given, but the broker {0:?} is without TLS; write mqtts://")]
    TlsWithoutTls(String),
    #[error(
        "a password is given, but the broker {0:?} is another machine without TLS; write mqtts://"
    )]
    PasswordWithoutTls(String),
    #[error("a certificate needs its key, and a key its certificate; give both files")]
    HalfAnIdentity,
    #[error("a password needs a user; give both")]
    PasswordWithoutUser,
    #[error("cannot read {path}: {fault}", path = path.display())]
    File {
        path: PathBuf,
        fault: std::io::Error,
    },
    #[error("{path} may be read by others (mode {mode:04o}); run `chmod 600 {path}`", path = path.display())]
    Mode { path: PathBuf, mode: u32 },
    #[error("{path} {what}", path = path.display())]
    Content { path: PathBuf, what: String },
    #[error("TLS: {0}")]
    Tls(String),
    #[error("the spool {path} is in use by another process; give each node a spool of its own", path = path.display())]
    SpoolInUse { path: PathBuf },
    #[error("cannot use the spool {path}: {fault}", path = path.display())]
    Spool {
        path: PathBuf,
        fault: std::io::Error,
    },
    #[error("cannot start the thread {name}: {fault}")]
    Thread {
        name: &'static str,
        fault: std::io::Error,
    },
}
