//! A clock that jumps back, as that of a looped recording does.

use column_twin::twin::{Command, NoticeLevel, Output, StateOutput};

use crate::{Bench, MS, START, event};

/// The twin once stood still, without a word, until the clock had come back to where it had been.
#[test]
fn a_clock_that_jumps_back_does_not_freeze_the_response() {
    let states_of = |bench: &Bench| -> Vec<_> {
        let values = |it: &&StateOutput| (it.stamp, it.phase, it.sample);
        bench.states().iter().map(values).collect()
    };
    let mut undisturbed = Bench::new(&[]);
    undisturbed.hit(event("a", START));
    undisturbed.rest();

    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.go_on(12 * MS);
    let back = 60_000 * MS;
    bench.now -= back;
    let by = back.unsigned_abs();
    bench
        .handle(Command::ClockJumpedBack { by })
        .expect("taken in every state");
    assert!(bench.twin.is_completing());
    let mut calls = 0;
    while bench.twin.is_responding() {
        assert_eq!(bench.twin.next_deadline(bench.now), bench.now);
        bench.twin.advance_to(bench.now, &mut bench.out);
        calls += 1;
        assert!(calls < 1_000, "the response does not end");
    }
    assert!(!bench.twin.is_completing());
    assert_eq!(states_of(&bench), states_of(&undisturbed));
    assert_eq!(bench.reports()[0].report, undisturbed.reports()[0].report);
    let told = |it: &Output| {
        matches!(it, Output::Notice(notice) if notice.level == NoticeLevel::Warning
            && notice.text.contains("jumped back by 60 s during the response to impact \"a\""))
    };
    assert!(bench.out.iter().any(told));

    // Life goes on at the new time, and no later impact belongs into the response before the jump.
    bench.hit(event("b", bench.now));
    bench.rest();
    assert_eq!(bench.rejections().len(), 0);
    assert_eq!(&*bench.reports()[1].event_id, "b");
}

/// The stamps of the next round lie within the response of the last one: they are not late impacts.
#[test]
fn an_impact_of_the_next_round_does_not_belong_into_the_last_response() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.rest();
    bench.now = START;
    let by = 1_000_000_000;
    let _ = bench.handle(Command::ClockJumpedBack { by });
    bench.now = START + 5 * MS;
    bench.hit(event("b", bench.now));
    bench.rest();
    assert_eq!(bench.reports().len(), 2);
    let notes = |it: &Output| matches!(it, Output::Notice(notice) if notice.text.contains("whose report no longer holds"));
    assert!(!bench.out.iter().any(notes));
}

/// Impacts that were accepted for later are executed at their stamps.
#[test]
fn accepted_impacts_still_hit_the_column_after_a_jump() {
    let mut bench = Bench::new(&[]);
    bench.hit(event("a", START));
    bench.hit(event("b", START + 30 * MS));
    bench.go_on(12 * MS);
    bench.now -= 1_000 * MS;
    let by = 1_000_000_000;
    let _ = bench.handle(Command::ClockJumpedBack { by });
    while bench.twin.is_responding() {
        bench.twin.advance_to(bench.now, &mut bench.out);
    }
    let report = bench.reports()[0];
    assert_eq!((&*report.event_id, report.stamp), ("b", START + 30 * MS));
}
