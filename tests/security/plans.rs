//! Which enclaves there are for some twins.

use column_twin::keystore::{Twins, plan};
use sros2_keystore::Access;

use super::made::twin;

#[test]
fn names_and_roles_of_enclaves_are_checked() {
    let rejected = |texts: &[&str]| {
        let texts: Vec<String> = texts.iter().map(|it| (*it).to_owned()).collect();
        plan(&texts, &twin()).expect_err("rejected").to_string()
    };
    for wrong in [
        "",
        "/",
        "monitor",
        "/../x=monitor",
        "/a b=twin",
        "/a/=twin",
        "/\u{202e}=twin",
    ] {
        rejected(&[wrong]);
    }
    assert!(rejected(&[&format!("/{}=twin", "x".repeat(64))]).contains("at most 64"));
    assert!(rejected(&["/control_room"]).contains("NAME=monitor"));
    assert!(rejected(&["/a=admin"]).contains("NAME=monitor"));
    assert!(rejected(&["/a=twin", "/a=monitor"]).contains("twice"));
    let longest = format!("/{}", "x".repeat(63));
    let planned = plan(&[format!("{longest}=monitor")], &twin());
    assert_eq!(planned.expect("64 characters fit").len(), 1);
}

#[test]
fn each_twin_gets_its_own_enclave_and_the_others_see_all_of_them() {
    let namespaces = ["/garage/a1".to_owned(), "/garage/a2".to_owned()];
    let twins = Twins::new(&namespaces, "pillar", &[]).unwrap();
    let plans = plan(&[], &twins).unwrap();
    let states = |access: &Access| {
        let topics = access.publish.union(&access.subscribe);
        topics.filter(|it| it.ends_with("/column_state")).count()
    };
    let names: Vec<_> = plans
        .iter()
        .map(|it| (it.plan.name.as_str(), states(&it.plan.access)))
        .collect();
    assert_eq!(
        names,
        [
            ("/garage/a1/pillar", 1),
            ("/garage/a2/pillar", 1),
            ("/monitor", 2),
            ("/operator", 2)
        ]
    );
}
