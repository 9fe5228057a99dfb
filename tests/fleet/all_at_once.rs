//! All columns of a fleet are hit at once.

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

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

/// Takes messages until they are all that is waited for, because a datagram that the reader lost is sent to it again later
/// than another reader received it.
fn taken_until<M: DeserializeOwned + 'static>(
    subscription: &Subscription<M>,
    what: &str,
    mut is_all: impl FnMut(M) -> bool,
) {
    let deadline = Instant::now() + PATIENCE;
    while Instant::now() < deadline {
        match subscription.take().ok().flatten() {
            Some((message, _)) => {
                if is_all(message) {
                    return;
                }
            }
            None => std::thread::sleep(Duration::from_millis(5)),
        }
    }
    panic!("timeout while waiting for {what}");
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

    let mut forecasts_of = BTreeSet::new();
    taken_until(
        &forecasts,
        "forecasts without and with their errors of all columns",
        |it| {
            forecasts_of.insert((it.event_id, it.error_estimate.is_nan()));
            forecasts_of.len() == 2 * COLUMNS
        },
    );
    let mut over = BTreeSet::new();
    taken_until(&reports, "reports of all columns", |it| {
        over.insert(it.event_id);
        over == ids
    });
    // A busy machine leaves out the statuses between the impact and the rest.
    let mut at_rest = BTreeSet::new();
    let mut statuses_of = BTreeMap::<String, usize>::new();
    taken_until(&statuses, "statuses of all columns at rest", |it| {
        if !it.event_id.is_empty() {
            *statuses_of.entry(it.event_id.clone()).or_default() += 1;
            if it.is_at_rest() {
                at_rest.insert(it.event_id);
            }
        }
        at_rest == ids
    });
    let most = statuses_of.values().max().copied().unwrap_or_default();
    println!("at most {most} statuses of a column");
    assert!(most * COLUMNS <= status.qos.depth, "{statuses_of:?}");
    drop((told, reported, rested));
    running.node.stop();
}
