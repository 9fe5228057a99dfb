//! The host that an HTTP request asks for.

use std::net::IpAddr;

/// Whether every `Host` in the head of an HTTP request is a name or an address of this machine, with or without a port.
///
/// A page in a browser of this machine can reach a port of loopback by a name of its own, which it has made to lead here (DNS
/// rebinding). It cannot choose what the browser writes as the host.
#[must_use]
pub fn is_this_machine(head: &str) -> bool {
    let mut hosts = head.split("\r\n").skip(1).filter_map(|line| {
        let (name, value) = line.split_once(':')?;
        name.eq_ignore_ascii_case("host").then(|| value.trim())
    });
    hosts.all(is_name_of_this_machine)
}

/// Whether a host, with or without a port, is a name or an address of this machine.
#[must_use]
pub fn is_name_of_this_machine(host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|it| it.is_ascii_digit()) => name,
        _ => host,
    };
    let address = name.trim_start_matches('[').trim_end_matches(']');
    name.eq_ignore_ascii_case("localhost")
        || address.parse::<IpAddr>().is_ok_and(|it| it.is_loopback())
}
