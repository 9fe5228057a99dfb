//! What the only solver thread of a single twin does, without a thread.

use super::super::clock::SimClock;
use super::super::inbox::MAX_COMMANDS;
use super::*;
use crate::twin::{NoticeLevel, Output};

/// A pool of one column that nobody works for, and its receivers.
fn pool(clock: &Arc<SimClock>, queues: &[OutputQueue]) -> (Shared, Vec<Receiver>) {
    let outputs = queues.iter().map(|it| Arc::new(OutputQueues::new(it)));
    let pool = Pool {
        real_time: RealTime::none(),
        threads: 1,
        state_files: Vec::new(),
        outputs: outputs.collect(),
        taken_outputs: 0,
        journals: queues.len(),
        upkeep: Upkeep::Constant,
        max_requests: MAX_COMMANDS,
        sensors: None,
    };
    let receivers = pool.outputs.iter().map(|it| Receiver::new(Arc::clone(it)));
    let readers = Arc::new(Readers::new(pool.outputs.clone(), pool.journals));
    let twin = Twin::new(Parameters::default(), None, Box::new(|| 0), 0).expect("stands");
    let shared = pool.share(vec![twin], Arc::clone(clock) as _, readers, None);
    (shared, receivers.collect())
}

fn impact(event_id: &str) -> Command {
    Command::Impact(ImpactCommand {
        event_id: event_id.to_owned(),
        column_id: "column".to_owned(),
        stamp: 0,
        vehicle: String::new(),
        impact: ImpactSpecification {
            mass: 1500.0,
            velocity: 10.0,
            gap: Some(0.1),
            restitution: None,
            height: None,
            direction: None,
        },
    })
}

fn submit(shared: &Shared, command: Command) {
    let reply = Reply::none();
    let request = Request::Command { command, reply };
    assert!(shared.submit(0, request).is_ok());
}

#[test]
fn a_stop_reports_the_commands_that_it_loses() {
    let clock = Arc::new(SimClock::new(0));
    let (shared, mut receivers) = pool(&clock, &[OutputQueue::ros()]);
    let (reply, _answer) = Reply::channel();
    assert!(shared.submit(0, Request::Snapshot { reply }).is_ok());
    let reset = Command::Reset {
        source: "test".into(),
    };
    for command in [impact("a"), reset, impact("b")] {
        submit(&shared, command);
    }
    shared.finish();
    let Some(Output::Notice(notice)) = receivers[0].try_next() else {
        panic!("no notice");
    };
    assert_eq!(notice.level, NoticeLevel::Error);
    assert!(
        notice.text.contains("2 impacts and 1 other commands"),
        "{}",
        notice.text
    );
}

/// From the schedule by way of the step to the queues, one of which is full.
#[test]
fn a_response_allocates_no_memory() {
    let few = OutputQueue {
        name: "few".to_owned(),
        states: 3,
        others: 3,
        when_full: WhenFull::DropNewest,
    };
    let clock = Arc::new(SimClock::new(0));
    let (shared, _receivers) = pool(&clock, &[OutputQueue::ros(), few]);
    let mut urgency = Urgency::default();
    let mut work = || {
        while let Ok(task) = shared.take_task(0) {
            shared.do_task(task, &mut urgency);
        }
    };
    submit(&shared, impact("a"));
    // Under a clock that stands still, the forecast is computed to its end.
    work();
    let jobs = || shared.counters.jobs.load(Ordering::Relaxed);
    let before = jobs();
    let memory = allocation_counter::measure(|| {
        for now in 1..40 {
            clock.set(now * 1_000_000);
            work();
        }
    });
    assert!(jobs() >= before + 39, "{} jobs", jobs() - before);
    let slot = shared.slots[0].lock().expect("no panic");
    assert!(slot.twin.is_responding());
    assert!(shared.counters.newton_iterations.load(Ordering::Relaxed) > 0);
    assert_eq!((memory.count_total, memory.bytes_total), (0, 0));
}
