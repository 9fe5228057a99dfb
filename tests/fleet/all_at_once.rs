//! All columns of a fleet are hit at once.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;

use column_twin::endpoints::Qos;
use column_twin::messages::column_twin_msgs::{ImpactEvent, ImpactReport, TwinStatus};
use column_twin::ros::Subscription;
use column_twin::ros::qos::{self, Endpoint};
use serde::de::DeserializeOwned;

use super::domain::{Domain, PATIENCE};
use super::incoming::{Incoming, reader};
use super::node::{Running, event};

/// As the table of topics says for a fleet of so many columns.
fn of_a_fleet(endpoint: &Endpoint, columns: usize) -> Endpoint {
    Endpoint {
        qos: Qos {
            depth: endpoint.depth_of_a_fleet(columns),
            ..endpoint.qos
        },
        ..*endpoint
    }
}

fn taken<M: DeserializeOwned + 'static>(subscription: &Subscription<M>) -> Vec<M> {
    std::iter::from_fn(|| subscription.take().ok().flatten())
        .map(|(message, _)| message)
        .collect()
}

/// A reader with the depth of a single twin lost half of the reports when 20 columns were hit at once.
#[test]
fn a_reader_that_follows_the_table_loses_nothing_when_100_columns_are_hit_at_once() {
    const COLUMNS: usize = 100;
    let domain = Domain::fresh();
    let running = Running::start(&domain, COLUMNS);
    let mut late = reader(&domain);
    let [forecast, report, status] = [qos::IMPACT_FORECAST, qos::IMPACT_REPORT, qos::TWIN_STATUS]
        .map(|it| of_a_fleet(&it, COLUMNS));
    // They take nothing before all is over.
    let forecasts = late
        .subscription::<ImpactReport>(&forecast)
        .expect("a reader");
    let reports = late
        .subscription::<ImpactReport>(&report)
        .expect("a reader");
    let statuses = late.subscription::<TwinStatus>(&status).expect("a reader");
    let mut node = reader(&domain);
    let publisher = node
        .publisher::<ImpactEvent>(&qos::IMPACT_EVENT)
        .expect("a publisher");
    let told = Incoming::<ImpactReport>::start(&mut node, &forecast);
    let reported = Incoming::<ImpactReport>::start(&mut node, &report);
    let rested = Incoming::<TwinStatus>::start(&mut node, &status);
    let matched = Instant::now() + PATIENCE;
    for reader in [forecasts.guid(), reports.guid(), statuses.guid()] {
        assert!(running.node.matches().wait_for_peer(reader, matched));
    }
    assert!(node.matches().wait_for(publisher.guid(), 1, matched));
    let ids: BTreeSet<_> = (0..COLUMNS).map(|it| format!("e{it}")).collect();
    let stamp = running.fleet.now();
    for column in 0..COLUMNS {
        let hit = event(&format!("c{column}"), &format!("e{column}"), stamp);
        publisher.publish(hit).expect("sent");
    }
    // Ranges come later, with the lowest priority.
    let mut with_error = BTreeSet::new();
    let mut over = BTreeSet::new();
    told.find("all forecasts with their errors", |it| {
        if !it.error_estimate.is_nan() {
            with_error.insert(it.event_id.clone());
        }
        with_error == ids
    });
    reported.find("all reports", |it| {
        over.insert(it.event_id.clone());
        over == ids
    });
    let mut at_rest = BTreeSet::new();
    rested.find("all columns at rest", |it| {
        if it.is_at_rest() && it.impacts_since_reset == 1 {
            at_rest.insert(it.event_id.clone());
        }
        at_rest == ids
    });

    let mut forecasts_of = BTreeMap::<String, [u32; 2]>::new();
    for it in taken(&forecasts) {
        let count = forecasts_of.entry(it.event_id).or_default();
        count[usize::from(!it.error_estimate.is_nan())] += 1;
    }
    assert_eq!(forecasts_of.keys().cloned().collect::<BTreeSet<_>>(), ids);
    assert!(
        forecasts_of
            .values()
            .all(|[first, second]| *first > 0 && *second > 0),
        "{forecasts_of:?}"
    );
    let reports: BTreeSet<_> = taken(&reports).into_iter().map(|it| it.event_id).collect();
    assert_eq!(reports, ids);
    let mut phases = BTreeMap::<String, Vec<u8>>::new();
    for it in taken(&statuses) {
        if !it.event_id.is_empty() {
            phases.entry(it.event_id).or_default().push(it.phase);
        }
    }
    let most = phases.values().map(Vec::len).max();
    println!("at most {most:?} statuses of a column");
    assert_eq!(phases.len(), COLUMNS);
    for (id, phases) in &phases {
        // A busy machine leaves out what lies between.
        let is_at_rest = |it: &u8| [TwinStatus::IDLE, TwinStatus::REST].contains(it);
        assert!(phases.iter().any(is_at_rest), "{id}: {phases:?}");
        assert!(
            phases.len() * COLUMNS <= status.qos.depth,
            "{id}: {phases:?}"
        );
    }
    drop((told, reported, rested));
    running.node.stop();
}
