//! The key expressions of rmw_zenoh: topics and services, and the liveliness tokens by which endpoints announce themselves
//! (<https://github.com/ros2/rmw_zenoh/blob/rolling/docs/design.md>).

use std::fmt;

use ros2_client::Gid;
use ros2_client::qos::{Durability, History, QosProfile, Reliability};
use rustdds::GUID;
use xxhash_rust::xxh3::xxh3_128;

use crate::ros::qos::package_and_type;

use super::type_hashes::type_hash;

/// What all liveliness tokens begin with.
const ADMIN_SPACE: &str = "@ros2_lv";

/// The depth that a token does not tell, because it is the default of rmw_zenoh.
const DEFAULT_DEPTH: usize = 42;

/// What a liveliness token announces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Node,
    Publisher,
    Subscription,
    Server,
    Client,
}

impl Kind {
    const ALL: [Self; 5] = [
        Self::Node,
        Self::Publisher,
        Self::Subscription,
        Self::Server,
        Self::Client,
    ];

    fn code(self) -> &'static str {
        match self {
            Self::Node => "NN",
            Self::Publisher => "MP",
            Self::Subscription => "MS",
            Self::Server => "SS",
            Self::Client => "SC",
        }
    }
}

/// A topic or a service with its type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct TypedName {
    /// Full name, with a leading slash.
    pub name: String,
    /// Name of the type in DDS.
    pub dds_type: String,
    /// `RIHS01_` and 64 digits.
    pub hash: String,
}

impl TypedName {
    /// With the type hash that this program computes, or else `recorded`, that of a recording.
    ///
    /// # Errors
    /// The definition of the type is unknown.
    pub fn new(name: &str, type_name: &str, recorded: Option<&str>) -> Result<Self, String> {
        let (package, bare) = package_and_type(type_name);
        let folder = match type_name.contains("/srv/") {
            true => "srv",
            false => "msg",
        };
        let computed = type_hash(type_name).map(|it| it.to_string());
        let hash = computed.or(recorded.map(str::to_owned)).ok_or_else(|| {
            format!(
                "Zenoh needs the hash of the type {type_name}, and this program does not have its definition; use --transport dds"
            )
        })?;
        Ok(Self {
            name: name.to_owned(),
            dds_type: format!("{package}::{folder}::dds_::{bare}_"),
            hash,
        })
    }

    /// The key of its messages or requests.
    pub fn key(&self, domain_id: u16) -> String {
        let Self {
            name,
            dds_type,
            hash,
        } = self;
        format!("{domain_id}/{}/{dds_type}/{hash}", name.trim_matches('/'))
    }
}

/// An endpoint or a node, as its liveliness token announces it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Token {
    pub domain_id: u16,
    /// The identifier of the session as hexadecimal digits.
    pub session: String,
    pub node_id: u32,
    pub id: u32,
    pub kind: Kind,
    /// Namespace of the node, with a leading slash.
    pub namespace: String,
    pub node: String,
    /// Of an endpoint: its topic or service, and its quality of service as [`qos_code`] writes it.
    pub endpoint: Option<(TypedName, String)>,
}

impl fmt::Display for Token {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            domain_id,
            session,
            node_id,
            id,
            kind,
            namespace,
            node,
            endpoint,
        } = self;
        let kind = kind.code();
        // The enclave is that of a process without one.
        write!(
            f,
            "{ADMIN_SPACE}/{domain_id}/{session}/{node_id}/{id}/{kind}/%/{}/{node}",
            mangled(namespace)
        )?;
        let Some((topic, qos)) = endpoint else {
            return Ok(());
        };
        let TypedName {
            name,
            dds_type,
            hash,
        } = topic;
        write!(f, "/{}/{dds_type}/{hash}/{qos}", mangled(name))
    }
}

impl Token {
    /// Reads a token; `None` if it is not one of rmw_zenoh.
    pub fn parse(key: &str) -> Option<Self> {
        let mut parts = key.split('/');
        let mut part = || parts.next().filter(|it| !it.is_empty());
        if part()? != ADMIN_SPACE {
            return None;
        }
        let domain_id = part()?.parse().ok()?;
        let session = part()?.to_owned();
        let (node_id, id) = (part()?.parse().ok()?, part()?.parse().ok()?);
        let code = part()?;
        let kind = Kind::ALL.into_iter().find(|it| it.code() == code)?;
        let _enclave = part()?;
        let namespace = part()?.replace('%', "/");
        let node = part()?.to_owned();
        let endpoint = match kind {
            Kind::Node => None,
            _ => {
                let topic = TypedName {
                    name: part()?.replace('%', "/"),
                    dds_type: part()?.to_owned(),
                    hash: part()?.to_owned(),
                };
                Some((topic, part()?.to_owned()))
            }
        };
        Some(Self {
            domain_id,
            session,
            node_id,
            id,
            kind,
            namespace,
            node,
            endpoint,
        })
    }

    /// The endpoint as this program knows endpoints: the prefix stands for the session. `None` if the session has no valid identifier.
    pub fn guid(&self) -> Option<GUID> {
        let session = u128::from_str_radix(&self.session, 16).ok()?;
        let mut bytes = session.to_le_bytes();
        bytes[12..].copy_from_slice(&self.id.to_be_bytes());
        Some(GUID::from_bytes(bytes))
    }
}

/// The identifier that the messages of an endpoint carry: the hash of its token.
pub(super) fn gid(token: &str) -> Gid {
    Gid::from(xxh3_128(token.as_bytes()).to_le_bytes())
}

/// All tokens of a domain.
pub(super) fn all_tokens(domain_id: u16) -> String {
    format!("{ADMIN_SPACE}/{domain_id}/**")
}

fn mangled(name: &str) -> String {
    match name {
        "" => "%".to_owned(),
        name => name.replace('/', "%"),
    }
}

/// The quality of service as tokens tell it: reliability, durability, history and depth, deadline, lifespan, liveliness. What is a
/// default of rmw_zenoh is left out.
pub(super) fn qos_code(qos: &QosProfile) -> String {
    let reliability = match qos.reliability {
        Reliability::Reliable { .. } => "",
        Reliability::BestEffort => "2",
    };
    let durability = match qos.durability {
        Durability::TransientLocal => "1",
        Durability::Volatile => "",
    };
    let history = match qos.history {
        History::KeepLast {
            depth: DEFAULT_DEPTH,
        } => ",".to_owned(),
        History::KeepLast { depth } => format!(",{depth}"),
        History::KeepAll => "2,".to_owned(),
    };
    let lifespan = qos.lifespan.map_or_else(
        || ",".to_owned(),
        |it| format!("{},{}", it.as_secs(), it.subsec_nanos()),
    );
    format!("{reliability}:{durability}:{history}:,:{lifespan}:,,")
}

#[cfg(test)]
mod tests {
    use super::*;

    const STRING: &str = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18";

    fn chatter() -> TypedName {
        TypedName::new("/chatter", "std_msgs/msg/String", None).expect("known")
    }

    /// The examples of the design document of rmw_zenoh.
    #[test]
    fn keys_and_tokens_are_those_of_rmw_zenoh() {
        let key = format!("0/chatter/std_msgs::msg::dds_::String_/{STRING}");
        assert_eq!(chatter().key(0), key);
        let robot = TypedName {
            name: "/robot1/chatter".to_owned(),
            ..chatter()
        };
        assert_eq!(
            robot.key(3),
            format!("3/robot1/chatter/std_msgs::msg::dds_::String_/{STRING}")
        );
        let listener = format!(
            "@ros2_lv/0/aac3178e146ba6f1fc6e6a4085e77f21/0/10/MS/%/%/listener/%chatter/std_msgs::msg::dds_::String_/{STRING}/::,10:,:,:,,"
        );
        let token = Token::parse(&listener).expect("a token");
        assert_eq!(token.to_string(), listener);
        assert_eq!(
            (token.kind, token.id, &*token.namespace),
            (Kind::Subscription, 10, "/")
        );
        assert_eq!(token.endpoint, Some((chatter(), "::,10:,:,:,,".to_owned())));
        let node = "@ros2_lv/2/aac3178e146ba6f1fc6e6a4085e77f21/0/0/NN/%/%/listener";
        assert_eq!(Token::parse(node).expect("a node").to_string(), node);
    }

    #[test]
    fn what_is_no_token_is_ignored() {
        for wrong in [
            "",
            "@ros2_lv",
            "@ros2_lv/0/1/2/3/XX/%/%/listener",
            "@ros2_lv/0/1/2/3/MS/%/%/listener",
            "@ros2_lv/-1/1/2/3/NN/%/%/listener",
            "0/chatter/String/RIHS01_0",
        ] {
            assert_eq!(Token::parse(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn qualities_of_service_leave_defaults_out() {
        use crate::ros::qos::{Qos, ROSOUT, TWIN_STATUS};
        assert_eq!(qos_code(&TWIN_STATUS.qos.profile()), ":1:,1:,:,:,,");
        assert_eq!(qos_code(&ROSOUT.qos.profile()), ":1:,1000:,:10,0:,,");
        let sensors = Qos {
            reliable: false,
            transient_local: false,
            depth: 42,
            lifespan: None,
        };
        assert_eq!(qos_code(&sensors.profile()), "2::,:,:,:,,");
    }

    #[test]
    fn all_endpoints_of_a_session_have_one_prefix() {
        let token = |id: u32| {
            let text = format!("@ros2_lv/0/a1b2/0/{id}/NN/%/%/one");
            Token::parse(&text).expect("a token")
        };
        let [one, other] = [token(1), token(2)].map(|it| it.guid().expect("valid"));
        assert!(one.prefix == other.prefix && one != other);
        assert_eq!(&one.to_bytes()[..3], [0xb2, 0xa1, 0]);
        assert_ne!(gid("@ros2_lv/0/a1b2/0/1"), gid("@ros2_lv/0/a1b2/0/2"));
    }
}
