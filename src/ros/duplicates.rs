//! Warns about another node with the same name, and about another twin of the same column, on the network.

use std::collections::BTreeSet;
use std::pin::pin;
use std::sync::Arc;

use futures::StreamExt;
use futures::channel::mpsc::{UnboundedReceiver, unbounded};
use futures::future::{Either, select};
use futures::stream::{BoxStream, unfold};
use rustdds::no_key::SimpleDataReader;
use rustdds::{CDRDeserializerAdapter, DomainParticipant, GUID, QosPolicies, Topic};

use super::live_columns::LiveColumns;
use super::qos::Qos;
use crate::messages::column_twin_msgs::TwinStatus;
use ros_node::matches::Found;

/// Statuses, each with the endpoint that sent it.
pub(super) type Statuses = BoxStream<'static, (GUID, TwinStatus)>;

/// Begins to listen to statuses.
pub(super) type Listen = Box<dyn Fn() -> Result<Statuses, String> + Send + Sync>;

/// What a node compares with its peers.
pub(super) struct Duplicates {
    /// Any endpoint of the node: all of them have one prefix.
    pub own: GUID,
    /// Fully qualified name of the node.
    pub node: String,
    /// Full name of the topic on which the node publishes its status.
    pub status: String,
    /// Listens to that topic.
    pub listen: Listen,
    /// The columns of the node.
    pub columns: Arc<LiveColumns>,
}

/// The statuses on a topic of DDS. `qos` is that with which the node publishes its own: a reader that asks for more would not match
/// a twin that was started like this one.
pub(super) fn statuses(
    participant: &DomainParticipant,
    topic: &Topic,
    qos: &Qos,
) -> Result<Statuses, String> {
    let qos = QosPolicies::from(qos.profile());
    let subscriber = participant.create_subscriber(&qos);
    let subscriber = subscriber.map_err(|error| error.to_string())?;
    let reader: SimpleDataReader<TwinStatus, CDRDeserializerAdapter<TwinStatus>> = subscriber
        .create_simple_datareader_no_key(topic, Some(qos))
        .map_err(|error| error.to_string())?;
    let statuses = unfold(reader, |reader| async move {
        loop {
            let taken = pin!(reader.as_async_stream()).next().await?;
            // What is no status is skipped.
            if let Ok(status) = taken {
                return Some(((status.writer_guid, status.sample), reader));
            }
        }
    });
    Ok(statuses.boxed())
}

impl Duplicates {
    /// A handler for every writer that is discovered, and a future that compares the columns of twins. Each warns once.
    pub fn watch(self) -> (impl FnMut(Found<'_>), impl Future<Output = ()>) {
        let own = self.own.prefix;
        let node = self.node.clone();
        // Every ROS 2 node with parameters replies on this topic.
        let replies = format!("rr{node}/get_parametersReply");
        let status = format!("rt{}", self.status);
        // As many as are followed at most.
        let (found, other_twins) = unbounded();
        let mut is_unique = true;
        let on_writer = move |writer: Found<'_>| {
            if writer.guid.prefix == own {
                return;
            }
            if *writer.topic_name == replies && is_unique {
                is_unique = false;
                tracing::warn!(
                    "another node on the network is called {node}; stop one of the two, or start one with another name \
                     (-r __node:=...) or namespace (-r __ns:=...)"
                );
            }
            if *writer.topic_name == status {
                // Without a receiver the warning was given, or the node is stopping.
                let _ = found.unbounded_send(writer.guid);
            }
        };
        let compare = async move {
            if let Err(error) = self.wait_for_same_column(other_twins).await {
                tracing::warn!("twins on the same topics cannot be compared: {error}");
            }
        };
        (on_writer, compare)
    }

    /// Returns after the warning. The reader exists only until every other twin on the node's topics has told its column:
    /// the twins of a large machine would otherwise send all their statuses to one another.
    async fn wait_for_same_column(
        &self,
        mut other_twins: UnboundedReceiver<GUID>,
    ) -> Result<(), String> {
        while let Some(twin) = other_twins.next().await {
            let mut statuses = (self.listen)()?;
            let mut unknown = BTreeSet::from([twin]);
            while !unknown.is_empty() {
                match select(other_twins.next(), statuses.next()).await {
                    Either::Left((Some(twin), _)) => {
                        unknown.insert(twin);
                    }
                    Either::Right((Some((sender, status)), _)) => {
                        unknown.remove(&sender);
                        let is_other = sender.prefix != self.own.prefix;
                        let column_id = &status.column_id;
                        let is_own = self.columns.face().index_of(column_id).is_some();
                        if is_other && is_own {
                            tracing::warn!(
                                "another twin of the column {column_id:?} is running on the same topics; stop one of the two, or \
                                 start one with another column_id or in another namespace (-r __ns:=...)"
                            );
                            return Ok(());
                        }
                    }
                    Either::Left((None, _)) | Either::Right((None, _)) => return Ok(()),
                }
            }
        }
        Ok(())
    }
}
