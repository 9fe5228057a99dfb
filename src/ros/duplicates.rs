//! Warns about another node with the same name, and about another twin of the same column, on the network.

use std::collections::BTreeSet;
use std::pin::pin;
use std::sync::Arc;

use futures::StreamExt;
use futures::channel::mpsc::{UnboundedReceiver, unbounded};
use futures::future::{Either, select};
use ros2_client::CreateResult;
use rustdds::no_key::SimpleDataReader;
use rustdds::{
    CDRDeserializerAdapter, DomainParticipant, EndpointDescription, GUID, QosPolicies, RTPSEntity,
    Topic, TopicDescription,
};

use super::live_columns::LiveColumns;
use super::qos::Qos;
use crate::messages::column_twin_msgs::TwinStatus;

/// What a node compares with its peers.
pub(super) struct Duplicates {
    pub participant: DomainParticipant,
    /// Fully qualified name of the node.
    pub node: String,
    /// The topic on which the node publishes its status.
    pub status: Topic,
    /// With which quality of service it does so: a reader that asks for more would not match a twin that was started like this one.
    pub qos: Qos,
    /// The columns of the node.
    pub columns: Arc<LiveColumns>,
}

impl Duplicates {
    /// A handler for every writer that is discovered, and a future that compares the columns of twins. Each warns once.
    pub fn watch(self) -> (impl FnMut(&EndpointDescription), impl Future<Output = ()>) {
        let own = self.participant.guid().prefix;
        let node = self.node.clone();
        // Every ROS 2 node with parameters replies on this topic.
        let replies = format!("rr{node}/get_parametersReply");
        let status = self.status.name();
        // As many as RustDDS follows at most.
        let (found, other_twins) = unbounded();
        let mut is_unique = true;
        let on_writer = move |writer: &EndpointDescription| {
            if writer.guid.prefix == own {
                return;
            }
            if writer.topic_name == replies && is_unique {
                is_unique = false;
                tracing::warn!(
                    "another node on the network is called {node}; stop one of the two, or start one with another name \
                     (-r __node:=...) or namespace (-r __ns:=...)"
                );
            }
            if writer.topic_name == status {
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
    ) -> CreateResult<()> {
        while let Some(twin) = other_twins.next().await {
            let qos = QosPolicies::from(self.qos.profile());
            let subscriber = self.participant.create_subscriber(&qos)?;
            let reader: SimpleDataReader<TwinStatus, CDRDeserializerAdapter<TwinStatus>> =
                subscriber.create_simple_datareader_no_key(&self.status, Some(qos))?;
            let mut statuses = pin!(reader.as_async_stream());
            let mut unknown = BTreeSet::from([twin]);
            while !unknown.is_empty() {
                match select(other_twins.next(), statuses.next()).await {
                    Either::Left((Some(twin), _)) => {
                        unknown.insert(twin);
                    }
                    Either::Right((Some(Ok(status)), _)) => {
                        unknown.remove(&status.writer_guid);
                        let is_other = status.writer_guid.prefix != self.participant.guid().prefix;
                        let column_id = &status.sample.column_id;
                        let is_own = self.columns.face().index_of(column_id).is_some();
                        if is_other && is_own {
                            tracing::warn!(
                                "another twin of the column {column_id:?} is running on the same topics; stop one of the two, or \
                                 start one with another column_id or in another namespace (-r __ns:=...)"
                            );
                            return Ok(());
                        }
                    }
                    // Not a status.
                    Either::Right((Some(Err(_)), _)) => {}
                    Either::Left((None, _)) | Either::Right((None, _)) => return Ok(()),
                }
            }
        }
        Ok(())
    }
}
