//! The same permissions as configurations of Zenoh: of a router that grants them by certificate, and of the sessions that connect to
//! it.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::{Value, json};
use sros2_keystore::{EnclaveName, EnclavePlan, IdentityFiles};

use super::plan::PlannedEnclave;

/// Where the keystore, the router and the nodes are.
#[derive(Debug, Clone, Copy)]
pub struct ZenohSite<'a> {
    /// Folder of the keystore.
    pub keystore: &'a Path,
    /// `host:port` of the router.
    pub address: &'a str,
    /// `ROS_DOMAIN_ID` of the nodes.
    pub domain_id: u16,
}

impl ZenohSite<'_> {
    /// The configuration of a router with the certificate of the enclave `own`. It admits sessions with a certificate of the keystore's
    /// authority only, and grants each of them what its enclave may do. The common name of a certificate tells the enclave.
    #[must_use]
    pub fn router(&self, own: &EnclaveName, enclaves: &[PlannedEnclave]) -> String {
        let files = IdentityFiles::of(self.keystore, own);
        let mut rules = vec![
            self.graph(
                "find nodes",
                INGRESS,
                &["declare_liveliness_subscriber", "liveliness_query"],
            ),
            self.graph("see nodes", EGRESS, &["liveliness_token"]),
        ];
        let everyone: Vec<Value> = rules.iter().map(|it| it["id"].clone()).collect();
        let (mut subjects, mut policies) = (vec![], vec![]);
        for PlannedEnclave { plan, .. } in enclaves {
            let name = plan.name.as_str();
            let of_enclave = self.rules(plan);
            let ids = of_enclave.iter().map(|it| it["id"].clone());
            let ids: Vec<Value> = everyone.iter().cloned().chain(ids).collect();
            subjects.push(json!({ "id": name, "cert_common_names": [name] }));
            policies.push(json!({ "subjects": [name], "rules": ids }));
            rules.extend(of_enclave);
        }
        written(&json!({
            "mode": "router",
            "listen": { "endpoints": [format!("tls/{}", self.address)] },
            // Neither other routers nor sessions are searched for.
            "scouting": { "multicast": { "enabled": false }, "gossip": { "enabled": false } },
            "transport": { "link": { "protocols": ["tls"], "tls": {
                "root_ca_certificate": files.authority.to_string_lossy(),
                "enable_mtls": true,
                "listen_certificate": files.certificate.to_string_lossy(),
                "listen_private_key": files.key.to_string_lossy(),
                "close_link_on_expiration": true,
            } } },
            "access_control": {
                "enabled": true,
                "default_permission": "deny",
                "rules": rules,
                "subjects": subjects,
                "policies": policies,
            },
        }))
    }

    /// The configuration of a session with the certificate of an enclave. It speaks to the router only, because the permissions hold
    /// there.
    #[must_use]
    pub fn session(&self, own: &EnclaveName) -> String {
        let files = IdentityFiles::of(self.keystore, own);
        written(&json!({
            "mode": "client",
            // A start without the router fails; a router that is lost later is tried for ever.
            "connect": { "endpoints": [format!("tls/{}", self.address)], "timeout_ms": 10_000, "exit_on_failure": true },
            "scouting": { "multicast": { "enabled": false }, "gossip": { "enabled": false } },
            // The history for late joiners needs the time of each message.
            "timestamping": { "enabled": true },
            "transport": { "link": {
                // Longer messages are not put together.
                "rx": { "max_message_size": 8_388_608 },
                "protocols": ["tls"],
                "tls": {
                    "root_ca_certificate": files.authority.to_string_lossy(),
                    "enable_mtls": true,
                    "connect_certificate": files.certificate.to_string_lossy(),
                    "connect_private_key": files.key.to_string_lossy(),
                    // Certificates of a keystore name enclaves and not hosts.
                    "verify_name_on_connect": false,
                    "close_link_on_expiration": true,
                },
            } },
        }))
    }

    /// What an enclave may send through the router and receive from it.
    fn rules(&self, plan: &EnclavePlan) -> Vec<Value> {
        let EnclavePlan { name, access } = plan;
        let topics = |names: &BTreeSet<String>| self.keys(names, &["/*/*", "/*/*/@adv/**"]);
        let services = |names: &BTreeSet<String>| self.keys(names, &["/*/*"]);
        let (publish, subscribe) = (topics(&access.publish), topics(&access.subscribe));
        let (reply, request) = (services(&access.reply), services(&access.request));
        let rows: [(&str, &str, &[&str], Vec<String>); 9] = [
            (
                "announces",
                INGRESS,
                &["liveliness_token"],
                self.tokens(plan),
            ),
            // A publisher of latched messages answers queries for them, announces itself to their readers and tells the last number.
            (
                "publishes",
                INGRESS,
                &["put", "reply", "declare_queryable", "liveliness_token"],
                publish.clone(),
            ),
            (
                "is subscribed to",
                EGRESS,
                &["declare_subscriber", "query"],
                publish,
            ),
            (
                "subscribes",
                INGRESS,
                &[
                    "declare_subscriber",
                    "query",
                    "declare_liveliness_subscriber",
                    "liveliness_query",
                    "liveliness_token",
                ],
                subscribe.clone(),
            ),
            (
                "receives",
                EGRESS,
                &["put", "reply", "declare_queryable", "liveliness_token"],
                subscribe,
            ),
            (
                "replies",
                INGRESS,
                &["declare_queryable", "reply"],
                reply.clone(),
            ),
            ("is requested", EGRESS, &["query"], reply),
            ("requests", INGRESS, &["query"], request.clone()),
            (
                "is replied to",
                EGRESS,
                &["declare_queryable", "reply"],
                request,
            ),
        ];
        let rows = rows.into_iter().filter(|(.., keys)| !keys.is_empty());
        rows.map(|(what, flow, messages, keys)| {
            rule(&format!("{name} {what}"), flow, messages, &keys)
        })
        .collect()
    }

    /// The keys of topics or services: domain, name, type and its hash, and what follows.
    fn keys(&self, names: &BTreeSet<String>, ends: &[&str]) -> Vec<String> {
        let domain_id = self.domain_id;
        names
            .iter()
            .flat_map(|name| {
                ends.iter()
                    .map(move |end| format!("{domain_id}{name}{end}"))
            })
            .collect()
    }

    /// The liveliness tokens by which an enclave announces nodes, and endpoints that it may have.
    fn tokens(&self, plan: &EnclavePlan) -> Vec<String> {
        let access = &plan.access;
        let lists = [
            ("MP", &access.publish),
            ("MS", &access.subscribe),
            ("SS", &access.reply),
            ("SC", &access.request),
        ];
        let start = format!("{TOKENS}/{}/*/*/*", self.domain_id);
        let endpoints = lists.into_iter().flat_map(|(kind, names)| {
            let start = &start;
            // Enclave, namespace and node; then the name, type, hash and quality of service.
            names
                .iter()
                .map(move |name| format!("{start}/{kind}/*/*/*/{}/*/*/*", name.replace('/', "%")))
        });
        std::iter::once(format!("{start}/NN/*/*/*"))
            .chain(endpoints)
            .collect()
    }

    fn graph(&self, id: &str, flow: &str, messages: &[&str]) -> Value {
        rule(
            id,
            flow,
            messages,
            &[format!("{TOKENS}/{}/**", self.domain_id)],
        )
    }
}

/// What the liveliness tokens of ROS 2 begin with.
const TOKENS: &str = "@ros2_lv";

/// From a session to the router.
const INGRESS: &str = "ingress";

/// From the router to a session.
const EGRESS: &str = "egress";

fn rule(id: &str, flow: &str, messages: &[&str], keys: &[String]) -> Value {
    json!({ "id": id, "permission": "allow", "flows": [flow], "messages": messages, "key_exprs": keys })
}

fn written(configuration: &Value) -> String {
    format!(
        "// Made by `column-twin keystore zenoh` from the table of the node's topics and services; docs/zenoh.md describes it.\n\
         {configuration:#}\n"
    )
}
