//! The session of a process: its configuration, its connection to a router, and its nodes.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use futures::Stream;
use ros2_client::Message;
use ros2_client::qos::QosProfile;
use rustdds::GUID;
use serde::Serialize;
use serde::de::DeserializeOwned;
use zenoh::config::{Config, WhatAmI};
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Subscriber;
use zenoh::sample::SampleKind;
use zenoh::session::{TransportEvent, TransportEventsListener};
use zenoh::{Session, Wait};

use ros_node::environment::{Environment, ZenohVariables};
use ros_node::matches::{Discovered, Matches};
use ros_node::names::Names;

use super::endpoints::{Place, ZenohPublisher, ZenohServer, ZenohSubscription};
use super::graph::Graph;
use super::keys::{Kind, Token, TypedName, all_tokens, gid, qos_code};

/// The configuration of rmw_zenoh where it differs from that of Zenoh. Messages of more than 8 MiB are not put together.
const DEFAULTS: &[(&str, &str)] = &[
    ("mode", r#""peer""#),
    ("connect/endpoints", r#"["tcp/localhost:7447"]"#),
    ("listen/endpoints", r#"["tcp/localhost:0"]"#),
    ("scouting/multicast/enabled", "false"),
    (
        "scouting/gossip/target",
        r#"{ router: ["router", "peer"], peer: ["router"] }"#,
    ),
    (
        "scouting/gossip/autoconnect_strategy",
        r#"{ peer: { to_router: "always", to_peer: "greater-zid" } }"#,
    ),
    // The history for late joiners needs the time of each message.
    (
        "timestamping/enabled",
        "{ router: true, peer: true, client: true }",
    ),
    ("transport/link/rx/max_message_size", "8388608"),
];

/// Checks whether the configuration that the environment asks for can be read.
pub(in crate::ros) fn check_zenoh(environment: &Environment) -> Result<(), String> {
    config(&environment.zenoh).map(drop)
}

/// A session, which the nodes of a process share.
#[derive(Clone)]
pub(in crate::ros) struct ZenohSession(Arc<Shared>);

struct Shared {
    domain_id: u16,
    /// The identifier of the session as hexadecimal digits.
    id: String,
    next_id: AtomicU32,
    graph: Arc<Graph>,
    matches: Arc<Matches>,
    // Dropped in this order.
    _tokens: Subscriber<()>,
    _routers: TransportEventsListener<()>,
    session: Session,
}

impl ZenohSession {
    /// Opens a session. Without a router it goes on, and connects as soon as there is one.
    ///
    /// # Errors
    /// The configuration cannot be read, or cannot be used.
    pub fn open(environment: &Environment, matches: &Arc<Matches>) -> Result<Self, String> {
        let variables = &environment.zenoh;
        let config = config(variables)?;
        let opened = Self::opened(config, environment, matches);
        opened.map_err(|error| {
            let from = match &variables.session_config {
                Some(path) => format!("the configuration {path} (ZENOH_SESSION_CONFIG_URI)"),
                None => "the default configuration".to_owned(),
            };
            format!(
                "cannot open a Zenoh session with {from}: {error}; check its endpoints and certificates"
            )
        })
    }

    fn opened(
        config: Config,
        environment: &Environment,
        matches: &Arc<Matches>,
    ) -> zenoh::Result<Self> {
        let domain_id = environment.domain_id;
        let session = zenoh::open(config).wait()?;
        let id = session.info().zid().wait().to_string();
        let graph = Arc::new(Graph::new(id.clone(), Arc::clone(matches)));
        let told = Arc::clone(&graph);
        let tokens = session
            .liveliness()
            .declare_subscriber(all_tokens(domain_id))
            .history(true)
            .callback(move |sample| {
                let key = sample.key_expr().as_str();
                match sample.kind() {
                    SampleKind::Put => told.appeared(key),
                    SampleKind::Delete => told.gone(key),
                }
            })
            .wait()?;
        let routers = session
            .info()
            .transport_events_listener()
            .history(true)
            .callback(|event| tell_of_router(&event))
            .wait()?;
        let checks = environment.zenoh.router_check_attempts.as_deref();
        let is_router_expected = !checks.is_some_and(|it| it.starts_with('-'));
        if is_router_expected && session.info().routers_zid().wait().next().is_none() {
            tracing::warn!(
                "no Zenoh router is connected; the session connects as soon as there is one. Start one with `ros2 run rmw_zenoh_cpp \
                 rmw_zenohd` or zenohd, name its address in ZENOH_SESSION_CONFIG_URI, or set ZENOH_ROUTER_CHECK_ATTEMPTS=-1 where \
                 none is needed"
            );
        }
        Ok(Self(Arc::new(Shared {
            domain_id,
            id,
            next_id: AtomicU32::new(0),
            graph,
            matches: Arc::clone(matches),
            _tokens: tokens,
            _routers: routers,
            session,
        })))
    }

    /// A node with these names.
    ///
    /// # Errors
    /// It cannot be announced.
    pub fn node(&self, names: &Names) -> Result<ZenohNode, String> {
        let id = self.0.next_id();
        let token = Token {
            domain_id: self.0.domain_id,
            session: self.0.id.clone(),
            node_id: id,
            id,
            kind: Kind::Node,
            namespace: names.namespace().to_owned(),
            node: names.node().to_owned(),
            endpoint: None,
        };
        let announced = self.0.announced(&token)?;
        Ok(ZenohNode {
            session: self.clone(),
            token,
            _announced: Arc::new(announced),
        })
    }
}

impl Shared {
    fn next_id(&self) -> u32 {
        self.next_id.fetch_add(1, Ordering::Relaxed)
    }

    fn announced(&self, token: &Token) -> Result<LivelinessToken, String> {
        let declared = self.session.liveliness().declare_token(token.to_string());
        declared.wait().map_err(text)
    }
}

/// Says that a router was found or lost.
fn tell_of_router(event: &TransportEvent) {
    let transport = event.transport();
    if transport.whatami() != WhatAmI::Router {
        return;
    }
    let id = transport.zid();
    match event.kind() {
        SampleKind::Put => tracing::info!("connected to the Zenoh router {id}"),
        SampleKind::Delete => tracing::warn!(
            "the Zenoh router {id} is lost; peers to which there is a direct connection are still reached, and the session connects \
             again as soon as there is a router"
        ),
    }
}

/// The configuration that the variables ask for, read as rmw_zenoh reads it.
fn config(variables: &ZenohVariables) -> Result<Config, String> {
    let mut config = match &variables.session_config {
        Some(path) => Config::from_file(path).map_err(|error| {
            format!(
                "ZENOH_SESSION_CONFIG_URI: expected the path of a Zenoh configuration (JSON5 or YAML), found `{path}`: {error}"
            )
        })?,
        None => {
            let mut config = Config::default();
            for (key, value) in DEFAULTS {
                insert(&mut config, key, value)?;
            }
            config
        }
    };
    let overrides = variables.config_override.as_deref().unwrap_or_default();
    for pair in overrides.split(';').filter(|it| !it.trim().is_empty()) {
        let fault = |reason: &str| {
            format!(
                "ZENOH_CONFIG_OVERRIDE: expected key=value pairs separated by `;`, such as connect/endpoints=[\"tcp/10.0.0.1:7447\"], \
                 found `{pair}`: {reason}"
            )
        };
        let (key, value) = pair.split_once('=').ok_or_else(|| fault("it has no `=`"))?;
        insert(&mut config, key.trim(), value).map_err(|error| fault(&error))?;
    }
    Ok(config)
}

fn insert(config: &mut Config, key: &str, value: &str) -> Result<(), String> {
    config
        .insert_json5(key, value)
        .map_err(|error| format!("{key}: {error}"))
}

/// A node of a session.
#[derive(Clone)]
pub(in crate::ros) struct ZenohNode {
    session: ZenohSession,
    token: Token,
    _announced: Arc<LivelinessToken>,
}

impl ZenohNode {
    /// The session of the node, for further nodes.
    pub fn session(&self) -> ZenohSession {
        self.session.clone()
    }

    /// A publisher on a topic by its full name; `recorded` is the type hash of a type that this program may not know.
    ///
    /// # Errors
    /// The type is not known, or Zenoh does not create the publisher.
    pub fn publisher<M: Serialize>(
        &self,
        name: &str,
        type_name: &str,
        recorded: Option<&str>,
        qos: &QosProfile,
    ) -> Result<ZenohPublisher<M>, String> {
        let topic = TypedName::new(name, type_name, recorded)?;
        let (token, place) = self.place(Kind::Publisher, &topic, qos)?;
        let mut created = ZenohPublisher::new(self.zenoh(), &topic, self.key(&topic), qos, place)
            .map_err(text)?;
        self.announce(&token, &mut created.place)?;
        Ok(created)
    }

    /// A subscription of a topic by its full name.
    ///
    /// # Errors
    /// The type is not known, or Zenoh does not create the subscription.
    pub fn subscription<M: DeserializeOwned>(
        &self,
        name: &str,
        type_name: &str,
        qos: &QosProfile,
    ) -> Result<ZenohSubscription<M>, String> {
        let topic = TypedName::new(name, type_name, None)?;
        let (token, place) = self.place(Kind::Subscription, &topic, qos)?;
        let mut created = self.subscribed(&topic, qos, place)?;
        self.announce(&token, &mut created.place)?;
        Ok(created)
    }

    /// The messages of a topic and who sent each, without being announced as a subscription.
    ///
    /// # Errors
    /// As [`subscription`](Self::subscription).
    pub fn overheard<M: DeserializeOwned>(
        &self,
        name: &str,
        type_name: &str,
        qos: &QosProfile,
    ) -> Result<impl Stream<Item = (GUID, M)> + use<M>, String> {
        let topic = TypedName::new(name, type_name, None)?;
        let (_, place) = self.place(Kind::Subscription, &topic, qos)?;
        Ok(self.subscribed(&topic, qos, place)?.into_stream())
    }

    /// A server of a service by its full name.
    ///
    /// # Errors
    /// The type is not known, or Zenoh does not create the server.
    pub fn server<Request: Message, Response: Message>(
        &self,
        name: &str,
        type_name: &str,
        qos: &QosProfile,
    ) -> Result<ZenohServer<Request, Response>, String> {
        let service = TypedName::new(name, type_name, None)?;
        let (token, place) = self.place(Kind::Server, &service, qos)?;
        let mut created = ZenohServer::new(self.zenoh(), &service, self.key(&service), qos, place)
            .map_err(text)?;
        self.announce(&token, &mut created.place)?;
        Ok(created)
    }

    /// Calls `on` with everything that is discovered, indefinitely.
    pub fn events<F: FnMut(Discovered<'_>)>(&self, on: F) -> impl Future<Output = ()> + use<F> {
        Arc::clone(&self.session.0.graph).follow(on)
    }

    /// What all endpoints of the session have in common.
    pub fn guid(&self) -> GUID {
        // The identifier of a session is a number of 128 bits.
        self.token.guid().unwrap_or(GUID::GUID_UNKNOWN)
    }

    /// Full names of the topics with a type that others use.
    pub fn topics_of(&self, dds_type: &str) -> impl Iterator<Item = String> + use<> {
        self.session.0.graph.topics_of(dds_type).into_iter()
    }

    fn subscribed<M: DeserializeOwned>(
        &self,
        topic: &TypedName,
        qos: &QosProfile,
        place: Place,
    ) -> Result<ZenohSubscription<M>, String> {
        let place = (place, self.session.0.matches.given_up());
        ZenohSubscription::new(self.zenoh(), topic, self.key(topic), qos, place).map_err(text)
    }

    fn zenoh(&self) -> &Session {
        &self.session.0.session
    }

    fn key(&self, topic: &TypedName) -> String {
        topic.key(self.session.0.domain_id)
    }

    /// A new place on the network, and the token that announces it.
    fn place(
        &self,
        kind: Kind,
        topic: &TypedName,
        qos: &QosProfile,
    ) -> Result<(Token, Place), String> {
        let token = Token {
            id: self.session.0.next_id(),
            kind,
            endpoint: Some((topic.clone(), qos_code(qos))),
            ..self.token.clone()
        };
        let guid = token.guid();
        let place = Place {
            guid: guid.ok_or("the identifier of the session is no hexadecimal number")?,
            gid: gid(&token.to_string()),
            graph: Arc::clone(&self.session.0.graph),
            token: None,
        };
        Ok((token, place))
    }

    /// Announces an endpoint that exists: whoever is told of it can use it at once.
    fn announce(&self, token: &Token, place: &mut Place) -> Result<(), String> {
        if let Some((topic, _)) = &token.endpoint {
            place.graph.add(place.guid, place.gid, token.kind, topic);
        }
        place.token = Some(self.session.0.announced(token)?);
        Ok(())
    }
}

/// In the words of Zenoh.
fn text(error: zenoh::Error) -> String {
    error.to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_configuration_is_that_of_rmw_zenoh() {
        let config = config(&ZenohVariables::default()).expect("valid");
        let value = |key: &str| config.get_json(key).expect("known");
        assert_eq!(value("connect/endpoints"), r#"["tcp/localhost:7447"]"#);
        assert_eq!(value("listen/endpoints"), r#"["tcp/localhost:0"]"#);
        assert_eq!(value("scouting/multicast/enabled"), "false");
    }

    #[test]
    fn overrides_win_over_the_configuration() {
        let with = |text: &str| {
            config(&ZenohVariables {
                config_override: Some(text.to_owned()),
                ..ZenohVariables::default()
            })
        };
        let config =
            with(r#"listen/endpoints=["tcp/127.0.0.1:7999"];scouting/multicast/enabled=true;"#);
        let config = config.expect("valid");
        let value = |key: &str| config.get_json(key).expect("known");
        assert_eq!(value("listen/endpoints"), r#"["tcp/127.0.0.1:7999"]"#);
        assert_eq!(value("scouting/multicast/enabled"), "true");
        for wrong in ["mode", "no/such/key=1", "mode=\"twin\""] {
            let fault = with(wrong).expect_err("wrong");
            assert!(
                fault.starts_with("ZENOH_CONFIG_OVERRIDE: expected"),
                "{fault}"
            );
        }
    }

    #[test]
    fn a_file_that_is_no_configuration_is_named() {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
        for path in ["/nowhere/session.json5", file] {
            let fault = config(&ZenohVariables {
                session_config: Some(path.to_owned()),
                ..ZenohVariables::default()
            });
            let fault = fault.expect_err("wrong");
            assert!(
                fault.starts_with("ZENOH_SESSION_CONFIG_URI: expected"),
                "{fault}"
            );
            assert!(fault.contains(path), "{fault}");
        }
    }
}
