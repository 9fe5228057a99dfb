//! Live topics, parameters and services of the node for Foxglove, past DDS.

use std::collections::HashMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use foxglove_live::{
    Channel, Handler, Importance, Notices, Parameter, Schema, Server, Service, Settings, Statistics,
};
use futures::executor::block_on;
use ros2_client::parameters::raw;
use ros2_client::rcl_interfaces::{ListParametersRequest, SetParametersRequest};
use serde_json::Value as Json;

use crate::endpoints::{Direction, ENDPOINTS, Endpoint, NodeKind};
use crate::host_header::is_name_of_this_machine;
use crate::messages::column_twin_msgs::{PredictImpactRequest, ResetColumnRequest};
use crate::messages::{self, INTERFACES, cdr};
use crate::parameters::{FoxgloveMode, Value};
use crate::twin::{Accepted, Command, Rejection};

use super::inputs::predicted;
use super::lifecycle::Lifecycle;
use super::live_columns::LiveColumns;
use super::metrics::FoxgloveCounts;
use super::node::NodeError;
use super::parameter_services as parameters;
use super::qos;
use super::requests;
use super::senders::Rejected;
use ros_node::log_limit::SubjectLimit;
use ros_node::names::Names;

/// Most messages of a topic that are kept for clients which connect later.
const MAX_HISTORY: usize = 100;

/// Most messages about clients per period in the log: whoever connects again and again would fill it.
const MAX_TOLD: u64 = 10;

/// The period of the log.
const TELLING_PERIOD: Duration = Duration::from_secs(10);

/// What causes a reset, for the journal.
const SOURCE: &str = "Foxglove";

/// The server of a running node; its last copy ends it.
#[derive(Clone)]
pub(super) struct NodeFoxglove(Arc<Live>);

struct Live {
    server: Server,
    columns: Arc<LiveColumns>,
    /// The channels of the topics, by their names in the table of endpoints.
    channels: HashMap<&'static str, usize>,
}

impl NodeFoxglove {
    /// Starts the server if the parameters ask for it; `lifecycle` is that of a managed node.
    pub fn start(
        columns: &Arc<LiveColumns>,
        names: &Names,
        lifecycle: Option<Arc<Lifecycle>>,
    ) -> Result<Option<Self>, NodeError> {
        let settings = columns.node_parameters().settings();
        let wanted = &settings.foxglove;
        if wanted.mode == FoxgloveMode::Off {
            return Ok(None);
        }
        let kind = columns.face().kind();
        let published: Vec<_> = ENDPOINTS
            .iter()
            .filter(|it| it.direction == Direction::Out && is_published(it, kind))
            .collect();
        let services = offered(kind, wanted.control);
        let channels: Result<_, _> = published.iter().map(|it| channel(it, names)).collect();
        let described: Result<_, _> = services.iter().map(|it| service(it, names)).collect();
        let handler = Answers {
            columns: Arc::clone(columns),
            lifecycle,
            services,
        };
        let served = Settings {
            name: names.fully_qualified(),
            address: wanted.address.clone(),
            origins: wanted.origins.clone(),
            origins_name: "foxglove.origins",
            is_this_machine: is_name_of_this_machine,
            control: wanted.control,
            channels: channels?,
            services: described?,
            playback: None,
        };
        let limit = SubjectLimit::new("clients of Foxglove", MAX_TOLD, TELLING_PERIOD);
        let notices: Notices = Arc::new(move |importance, text| {
            let hidden = match importance {
                // The server tells each of them once.
                Importance::Rejection => Some(String::new()),
                Importance::Info | Importance::Warning => limit.admit(Instant::now()),
            };
            let Some(hidden) = hidden else { return };
            match importance {
                Importance::Info => tracing::info!("Foxglove: {text}{hidden}"),
                Importance::Warning | Importance::Rejection => {
                    tracing::warn!("Foxglove: {text}{hidden}");
                }
            }
        });
        let server = Server::start(served, handler, notices).map_err(|fault| {
            let address = &wanted.address;
            NodeError::Foxglove(format!(
                "cannot listen on foxglove.address {address:?}: {fault}; give a free address and port, such as 127.0.0.1:8765"
            ))
        })?;
        let address = server.address();
        tracing::info!("Foxglove connects to ws://{address}");
        if !address.ip().is_loopback() {
            tracing::warn!(
                "everybody who reaches {address} sees the topics and parameters, past DDS security, without a password or encryption"
            );
        }
        if wanted.control && !settings.senders.allowed.is_empty() {
            tracing::warn!(
                "foxglove.control allows clients of {address} to change the column, regardless of senders.*"
            );
        }
        let names = published.iter().map(|it| it.name);
        Ok(Some(Self(Arc::new(Live {
            server,
            columns: Arc::clone(columns),
            channels: names.zip(0..).collect(),
        }))))
    }

    /// Passes on a message that the node sent; `bytes` include the encapsulation header.
    pub fn sent(&self, endpoint: &Endpoint, bytes: &Arc<[u8]>) {
        let Live {
            server,
            columns,
            channels,
        } = &*self.0;
        if let Some(channel) = channels.get(endpoint.name) {
            let now = u64::try_from(columns.now()).unwrap_or_default();
            server.publish(*channel, now, bytes);
        }
    }

    /// What the server has done since the start.
    pub fn counts(&self) -> FoxgloveCounts {
        let Statistics {
            clients,
            rejected,
            dropped,
        } = self.0.server.statistics();
        FoxgloveCounts {
            clients,
            rejected,
            dropped,
        }
    }

    /// Tells the new values of parameters that have changed.
    pub fn changed(&self, names: &[String]) {
        if !names.is_empty() {
            let values = values(&self.0.columns, names);
            self.0.server.parameters_changed(values);
        }
    }
}

/// Whether a topic shows all columns or the node; its lifecycle is left to the programs that manage it.
fn is_published(endpoint: &Endpoint, kind: NodeKind) -> bool {
    endpoint.is_of(kind) && endpoint.name != qos::TRANSITION_EVENT.name
}

/// The services that are offered; those that change something only under control.
fn offered(kind: NodeKind, control: bool) -> Vec<&'static Endpoint> {
    let all = [
        (&qos::PREDICT, true),
        (&qos::RESET, control),
        (&qos::RESET_COLUMN, control),
    ];
    let offered = all
        .into_iter()
        .filter(|(it, is_offered)| *is_offered && it.is_of(kind));
    offered.map(|(it, _)| it).collect()
}

fn channel(endpoint: &Endpoint, names: &Names) -> Result<Channel, NodeError> {
    let history = match endpoint.qos.transient_local {
        true => endpoint.qos.depth.min(MAX_HISTORY),
        false => 0,
    };
    Ok(Channel {
        topic: names.resolve(endpoint.kind(), endpoint.name)?,
        schema: schema(endpoint.type_name)?,
        history,
    })
}

fn service(endpoint: &Endpoint, names: &Names) -> Result<Service, NodeError> {
    let type_name = endpoint.type_name;
    Ok(Service {
        name: names.resolve(endpoint.kind(), endpoint.name)?,
        type_name: type_name.to_owned(),
        request: schema(&format!("{type_name}_Request"))?,
        response: schema(&format!("{type_name}_Response"))?,
    })
}

fn schema(type_name: &str) -> Result<Schema, NodeError> {
    let fault = |reason: String| NodeError::Foxglove(format!("cannot describe a type: {reason}"));
    let interface =
        messages::find(type_name).ok_or_else(|| fault(format!("{type_name} is unknown")))?;
    let text = interface.schema_text(INTERFACES);
    Ok(Schema {
        name: type_name.to_owned(),
        text: text.map_err(|it| fault(it.to_string()))?,
    })
}

/// Answers the requests of clients.
struct Answers {
    columns: Arc<LiveColumns>,
    /// Of a managed node.
    lifecycle: Option<Arc<Lifecycle>>,
    /// In the order in which the server knows them.
    services: Vec<&'static Endpoint>,
}

impl Answers {
    /// # Errors
    /// The node is managed and not active, or the column cannot be reset.
    fn reset(&self, endpoint: &Endpoint, column: u32) -> Result<Accepted, Rejection> {
        if let Some(lifecycle) = &self.lifecycle {
            lifecycle
                .check_active(endpoint, Instant::now())
                .map_err(|rejected| {
                    let Rejected { rejection, is_told } = rejected;
                    if is_told {
                        tracing::warn!("a reset of {SOURCE} was rejected: {rejection}");
                    }
                    rejection
                })?;
        }
        let source = SOURCE.into();
        self.columns.execute(column, Command::Reset { source })
    }
}

impl Handler for Answers {
    fn parameters(&mut self, names: &[String]) -> Vec<Parameter> {
        if !names.is_empty() {
            return values(&self.columns, names);
        }
        let all = ListParametersRequest {
            prefixes: Vec::new(),
            depth: 0,
        };
        let listed = parameters::list(&*self.columns, &all);
        values(&self.columns, &listed.result.names)
    }

    fn set_parameters(&mut self, given: &[Parameter]) -> Result<(), String> {
        let parameter = given.iter().map(raw_parameter).collect::<Result<_, _>>()?;
        let request = SetParametersRequest { parameter };
        let result = parameters::set_atomically(&*self.columns, request).result;
        match result.successful {
            true => Ok(()),
            false => Err(result.reason),
        }
    }

    fn call(&mut self, service: usize, request: &[u8]) -> Result<Vec<u8>, String> {
        let columns = &*self.columns;
        let endpoint = self.services.get(service);
        let endpoint = endpoint.ok_or("there is no service with this number")?;
        tracing::debug!("received a request to {} of Foxglove", endpoint.name);
        let answer = match endpoint.name {
            name if name == qos::PREDICT.name => {
                let request: PredictImpactRequest = cdr::decode(request).map_err(in_words)?;
                cdr::encode(&block_on(predicted(columns, &request)))
            }
            name if name == qos::RESET_COLUMN.name => {
                let request: ResetColumnRequest = cdr::decode(request).map_err(in_words)?;
                let column = columns.face().requested(&request.column_id);
                let outcome = column.and_then(|it| self.reset(endpoint, it));
                cdr::encode(&requests::column_was_reset(outcome))
            }
            // Its request says nothing: some clients send the byte of an empty message, others none.
            _ => cdr::encode(&requests::was_reset(self.reset(endpoint, 0))),
        };
        answer.map_err(in_words)
    }
}

fn in_words(fault: cdr::CdrError) -> String {
    fault.to_string()
}

/// The values of those parameters that exist.
fn values(columns: &LiveColumns, names: &[String]) -> Vec<Parameter> {
    let known = names.iter().filter_map(|name| {
        let value = parameters::value_of(columns, name)?;
        let kind = match &value {
            Value::Double(_) => Some("float64"),
            Value::DoubleArray(_) => Some("float64_array"),
            _ => None,
        };
        Some(Parameter {
            name: name.clone(),
            value: serde_json::to_value(&value).unwrap_or_default(),
            kind: kind.map(str::to_owned),
        })
    });
    known.collect()
}

/// # Errors
/// The value is of no type that a parameter has.
fn raw_parameter(given: &Parameter) -> Result<raw::Parameter, String> {
    let Parameter { name, value, .. } = given;
    let texts = |all: &[Json]| {
        let texts = all.iter().map(|it| it.as_str().map(str::to_owned));
        texts.collect::<Option<Vec<_>>>().map(Value::StringArray)
    };
    let numbers = |all: &[Json]| {
        let numbers = all.iter().map(Json::as_f64);
        numbers.collect::<Option<Vec<_>>>().map(Value::DoubleArray)
    };
    let found = match value {
        Json::Bool(it) => Some(Value::Bool(*it)),
        // A whole number is taken for a double as well.
        Json::Number(it) => match it.as_i64() {
            Some(whole) => Some(Value::Integer(whole)),
            None => it.as_f64().map(Value::Double),
        },
        Json::String(it) => Some(Value::String(it.clone())),
        Json::Array(all) => numbers(all).or_else(|| texts(all)),
        Json::Null | Json::Object(_) => None,
    };
    let found = found.ok_or_else(|| {
        format!("{name}: expected a boolean, a number, a string, or a list of numbers or strings")
    })?;
    Ok(raw::Parameter {
        name: name.clone(),
        value: parameters::raw_value(found),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::live::LiveOptions;
    use crate::messages::std_srvs::TriggerResponse;
    use crate::parameters::Parameters;

    #[test]
    fn values_of_json_become_values_of_parameters() {
        let kind = |value: Json| {
            let given = Parameter {
                name: "x".to_owned(),
                value,
                kind: None,
            };
            raw_parameter(&given).map(|it| it.value.ptype)
        };
        assert_eq!(kind(true.into()), Ok(1));
        assert_eq!(kind(3.into()), Ok(2));
        assert_eq!(kind(2.5.into()), Ok(3));
        assert_eq!(kind("a".into()), Ok(4));
        assert_eq!(kind(vec![1.0, 2.5].into()), Ok(8));
        assert_eq!(kind(vec!["a"].into()), Ok(9));
        assert!(kind(Json::Null).is_err());
        assert!(kind(serde_json::json!({ "a": 1 })).is_err());
        assert!(kind(serde_json::json!([1, "a"])).is_err());
    }

    #[test]
    fn a_reset_is_offered_only_under_control() {
        let names = |kind, control| -> Vec<_> {
            let offered = offered(kind, control).into_iter();
            offered.map(|it| it.name).collect()
        };
        assert_eq!(names(NodeKind::Single, false), ["~/predict"]);
        assert_eq!(names(NodeKind::Single, true), ["~/predict", "~/reset"]);
        assert_eq!(
            names(NodeKind::Fleet, true),
            ["~/predict", "~/reset_column"]
        );
    }

    #[test]
    fn a_managed_node_that_is_not_active_rejects_a_reset_of_foxglove() {
        let quiet = [
            ("state.directory", Value::from("")),
            ("real_time.priority", Value::Integer(0)),
            ("real_time.lock_memory", Value::Bool(false)),
        ];
        let parameters = Parameters::from_values(quiet).unwrap();
        let (columns, _outputs) =
            LiveColumns::start_one(parameters, LiveOptions::default()).unwrap();
        let lifecycle = Arc::new(Lifecycle::unconfigured());
        let mut answers = Answers {
            columns: Arc::clone(&columns),
            lifecycle: Some(Arc::clone(&lifecycle)),
            services: vec![&qos::RESET],
        };
        let mut is_reset = || {
            let answer = answers.call(0, &[]).unwrap();
            cdr::decode::<TriggerResponse>(&answer).unwrap().success
        };
        assert!(!is_reset());
        assert_eq!(lifecycle.rejected(), 1);
        for label in ["configure", "activate"] {
            lifecycle.change((0, label), |_| Ok(()), |_| ());
        }
        assert!(is_reset());
        columns.stop();
    }

    #[test]
    fn every_published_topic_and_offered_service_has_a_schema() {
        for endpoint in ENDPOINTS.iter().filter(|it| it.direction == Direction::Out) {
            assert!(schema(endpoint.type_name).is_ok(), "{}", endpoint.name);
        }
        for endpoint in [qos::PREDICT, qos::RESET, qos::RESET_COLUMN] {
            for half in ["Request", "Response"] {
                let name = format!("{}_{half}", endpoint.type_name);
                assert!(schema(&name).is_ok(), "{name}");
            }
        }
    }
}
