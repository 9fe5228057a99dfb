//! Who may connect.
//!
//! A web page may open a WebSocket to any address, loopback included; the browser says only in `Origin` which page it was. A page may
//! also have a name that leads to this machine (DNS rebinding); then `Host` names it. Programs that are no browsers send no origin.

use std::sync::Arc;

use tungstenite::handshake::server::{Callback, ErrorResponse, Request, Response};
use tungstenite::http::{HeaderMap, HeaderValue, StatusCode};

/// The protocols whose frames these are, the preferred one first.
const PROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];

/// What the door asks of everybody.
pub(crate) struct Rules {
    /// Whether the server listens for this machine only.
    pub is_of_this_machine: bool,
    /// Whether a host, with or without a port, is this machine.
    pub is_this_machine: fn(&str) -> bool,
    /// Pages that may connect besides those of this machine.
    pub origins: Vec<String>,
    /// What the host calls them.
    pub origins_name: &'static str,
}

/// Looks at the request of one client.
pub(crate) struct Door(pub Arc<Rules>);

impl Callback for Door {
    fn on_request(
        self,
        request: &Request,
        mut response: Response,
    ) -> Result<Response, ErrorResponse> {
        let headers = request.headers();
        self.0
            .check(headers)
            .map_err(|reason| rejected(StatusCode::FORBIDDEN, reason))?;
        let Some(protocol) = chosen_protocol(headers) else {
            let reason = format!("expected the subprotocol {}", PROTOCOLS.join(" or "));
            return Err(rejected(StatusCode::BAD_REQUEST, reason));
        };
        let name = "Sec-WebSocket-Protocol";
        response
            .headers_mut()
            .insert(name, HeaderValue::from_static(protocol));
        Ok(response)
    }
}

impl Rules {
    fn check(&self, headers: &HeaderMap) -> Result<(), String> {
        let text = |value: &HeaderValue| String::from_utf8_lossy(value.as_bytes()).into_owned();
        for origin in headers.get_all("Origin").iter().map(text) {
            if !self.is_admitted(&origin) {
                return Err(format!(
                    "pages of {:?} may not connect; {} lists the web pages that may",
                    origin.chars().take(100).collect::<String>(),
                    self.origins_name
                ));
            }
        }
        let mut hosts = headers.get_all("Host").iter().map(text).peekable();
        let is_this_machine = |host: String| (self.is_this_machine)(&host);
        if self.is_of_this_machine && (hosts.peek().is_none() || !hosts.all(is_this_machine)) {
            return Err("expected the host localhost or 127.0.0.1".to_owned());
        }
        Ok(())
    }

    fn is_admitted(&self, origin: &str) -> bool {
        let host = origin
            .strip_prefix("http://")
            .or_else(|| origin.strip_prefix("https://"));
        host.is_some_and(self.is_this_machine)
            || self
                .origins
                .iter()
                .any(|it| it.trim_end_matches('/').eq_ignore_ascii_case(origin))
    }
}

/// The first protocol of this server that the client offers.
fn chosen_protocol(headers: &HeaderMap) -> Option<&'static str> {
    let offered = headers.get_all("Sec-WebSocket-Protocol").iter();
    let offered: Vec<_> = offered
        .filter_map(|it| it.to_str().ok())
        .flat_map(|it| it.split(','))
        .map(str::trim)
        .collect();
    PROTOCOLS.into_iter().find(|it| offered.contains(it))
}

fn rejected(status: StatusCode, reason: String) -> ErrorResponse {
    let mut response = ErrorResponse::new(Some(reason));
    *response.status_mut() = status;
    response
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rules(is_of_this_machine: bool) -> Rules {
        Rules {
            is_of_this_machine,
            is_this_machine: |host| host.split(':').next() == Some("localhost"),
            origins: vec!["https://viewer.example".to_owned()],
            origins_name: "origins",
        }
    }

    fn is_admitted(rules: &Rules, given: &[(&'static str, &'static str)]) -> bool {
        let mut headers = HeaderMap::new();
        for (name, value) in given {
            headers.append(*name, HeaderValue::from_static(value));
        }
        rules.check(&headers).is_ok()
    }

    #[test]
    fn programs_pages_of_this_machine_and_listed_pages_may_connect_and_nobody_else() {
        let here = ("host", "localhost:8765");
        let rules = rules(true);
        for (origin, expected) in [
            ("http://localhost:8080", true),
            ("https://localhost", true),
            ("https://viewer.example", true),
            ("https://evil.example", false),
            ("https://viewer.example.evil.example", false),
            ("https://localhost.evil.example", false),
            ("http://localhost@evil.example", false),
            ("https://evil.example/localhost", false),
            ("null", false),
            ("file://", false),
            ("", false),
        ] {
            let given = [here, ("origin", origin)];
            assert_eq!(is_admitted(&rules, &given), expected, "{origin}");
        }
        assert!(is_admitted(&rules, &[here]));
        let both = [
            here,
            ("origin", "http://localhost"),
            ("origin", "https://evil.example"),
        ];
        assert!(!is_admitted(&rules, &both));
    }

    #[test]
    fn a_name_that_was_made_to_lead_to_this_machine_is_rejected() {
        let strict = rules(true);
        assert!(!is_admitted(&strict, &[("host", "evil.example:8765")]));
        assert!(!is_admitted(&strict, &[]));
        assert!(is_admitted(
            &rules(false),
            &[("host", "column.example:8765")]
        ));
    }

    #[test]
    fn the_newer_protocol_is_preferred_and_names_are_compared_whole() {
        let chosen = |offered: &'static str| {
            let mut headers = HeaderMap::new();
            headers.insert("sec-websocket-protocol", HeaderValue::from_static(offered));
            chosen_protocol(&headers)
        };
        assert_eq!(
            chosen("foxglove.websocket.v1, foxglove.sdk.v1"),
            Some("foxglove.sdk.v1")
        );
        assert_eq!(
            chosen("foxglove.websocket.v1"),
            Some("foxglove.websocket.v1")
        );
        assert_eq!(chosen("foxglove.sdk.v1.1"), None);
    }
}
