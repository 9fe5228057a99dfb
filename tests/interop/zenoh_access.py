#!/usr/bin/env python3
"""Tests who reaches a twin over Zenoh through a router with the configurations of config/zenoh/, which `column-twin keystore zenoh`
makes: mutual TLS, and permissions by the names of the certificates.

    zenoh_access.py COLUMN_TWIN [--router PROGRAM]

The arguments are those of zenoh_peer.py. The certificates are made by openssl as `ros2 security` makes them. Everything listens and
connects on 127.0.0.1. Exit code 1 with what went wrong. It waits for conditions and never sleeps: that something was not received is
known when what was sent after it has arrived.
"""

import argparse
import json
import signal
import subprocess
import tempfile
from pathlib import Path

import zenoh

from zenoh_peer import DOMAIN, LIGHT, REPOSITORY, Fault, Peer, Program, Router, Types, check, end, free_port, wait_for

KEYSTORE = "/etc/column_twin/keystore"
ADDRESS = "127.0.0.1:7447"
CONFIGURATIONS = REPOSITORY / "config/zenoh"
# Valid for some hours, or for a year that is over.
VALID, EXPIRED = (["-days", "1"], ["-startdate", "20200101000000Z", "-enddate", "20210101000000Z"])
AUTHORITY = """
[ca]
default_ca = authority
[authority]
database = index.txt
new_certs_dir = .
certificate = ca.pem
private_key = ca.key
rand_serial = yes
default_md = sha256
unique_subject = no
policy = names
x509_extensions = identity
[names]
commonName = supplied
[identity]
basicConstraints = CA:FALSE
"""
KEY = ["-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"]


def openssl(folder, *arguments):
    done = subprocess.run(["openssl", *arguments], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise Fault(f"openssl {' '.join(arguments)}: {done.stderr}")


def authority(folder):
    """A new authority, in a folder of its own."""
    folder.mkdir()
    Path(folder, "openssl.cnf").write_text(AUTHORITY)
    Path(folder, "index.txt").touch()
    openssl(folder, "req", "-x509", *KEY, "-subj", "/CN=authority", "-days", "1", "-keyout", "ca.key", "-out", "ca.pem")
    return folder


def identity(keystore, of_authority, name, folder=None, validity=VALID):
    """A certificate and its key in the folder of an enclave."""
    enclave = Path(keystore, "enclaves", folder or name.strip("/"))
    enclave.mkdir(parents=True)
    key, request, certificate = (str(enclave / it) for it in ("key.pem", "request.pem", "cert.pem"))
    subject = name.replace("/", "\\/")
    openssl(of_authority, "req", "-new", *KEY, "-subj", f"/CN={subject}", "-keyout", key, "-out", request)
    openssl(of_authority, "ca", "-batch", "-notext", "-config", "openssl.cnf", *validity, "-in", request, "-out", certificate)


def configured(name, keystore, port):
    """A configuration of the repository, for a keystore, a port and the domain of the tests."""
    text = Path(CONFIGURATIONS, name).read_text().replace(KEYSTORE, str(keystore)).replace(ADDRESS, f"127.0.0.1:{port}")
    text = text.replace('"0/', f'"{DOMAIN}/').replace("@ros2_lv/0/", f"@ros2_lv/{DOMAIN}/")
    return json.loads("\n".join(line for line in text.splitlines() if not line.startswith("//")))


def session_of(folder, keystore, port):
    """The configuration of a session with the certificate of another folder than that of the twin."""
    settings = configured("secured_session.json5", keystore, port)
    tls = settings["transport"]["link"]["tls"]
    for key in ("connect_certificate", "connect_private_key"):
        tls[key] = tls[key].replace("/column_twin/", f"/{folder}/")
    # A session that is not admitted shall not be waited for.
    settings["connect"] = {**settings["connect"], "timeout_ms": 0}
    return settings


class Visitor(Peer):
    """Who reads and strikes."""

    def __init__(self, types, settings):
        super().__init__(types, settings)
        for name in ("twin_status", "impact_forecast", "column_state"):
            self.subscribe(name)

    def received(self):
        """Topics of which something was received, and sessions that were seen besides this one."""
        sessions = {it.split("/")[2] for it in self.tokens} - {str(self.session.zid())}
        return {name for name, seen in self.seen.items() if seen}, sessions


def status(peer):
    return peer.seen["twin_status"][-1][1]


def check_granted(twin, operator, monitor):
    """The operator strikes and calls, the monitor reads."""
    for peer in (operator, monitor):
        wait_for("the kept status", lambda: peer.seen["twin_status"])  # noqa: B023
    operator.strike("by_operator", LIGHT)
    for peer in (operator, monitor):
        peer.message("impact_forecast", "by_operator")
    wait_for("the states", lambda: monitor.seen["column_state"])
    wait_for("the service", lambda: "/column_twin/reset" in operator.of_twin("SS"))
    reply = operator.request("get_parameters", "rcl_interfaces/GetParameters", names=["column_id"])
    check("parameters that the operator reads", len(reply.values), 1)
    print("granted: the operator strikes and calls, the monitor reads what is kept and what is new")


def check_denied(operator, monitor, stranger):
    """A valid certificate without the permission neither writes nor reads."""
    accepted, rejected = status(monitor).events_accepted, status(monitor).events_rejected
    for peer in (monitor, stranger):
        peer.strike("not_granted", LIGHT)
    wait_for("the service in the graph", lambda: "/column_twin/reset" in monitor.of_twin("SS"))
    _, dds_type, hash_, _ = monitor.of_twin("SS")["/column_twin/reset"]
    for peer in (monitor, stranger):
        check("reply to who may not call", peer.call(f"{DOMAIN}/column_twin/reset/{dds_type}/{hash_}", b"\0\1\0\0\0"), None)
    operator.strike("afterwards", LIGHT)
    monitor.message("impact_forecast", "afterwards")
    wait_for("the status after it", lambda: status(monitor).event_id == "afterwards" and status(monitor).events_accepted > accepted)
    check("accepted events", status(monitor).events_accepted, accepted + 1)
    check("rejected events", status(monitor).events_rejected, rejected)
    announced = {it.split("/")[2] for it in operator.tokens if "/MP/%/%/striker/" in it}
    check("who announces a publisher of events", announced, {str(operator.session.zid())})
    check("what the stranger received", stranger.received(), (set(), set()))
    print("denied: the monitor neither strikes nor calls; a certificate without permissions neither reads nor writes")


def check_not_admitted(what, types, settings):
    """A session that the router does not admit reaches nothing."""
    try:
        peer = Visitor(types, settings)
    except zenoh.ZError as error:
        print(f"not admitted: {what}: {error}")
        return None
    return what, peer


def run(program, router_program):
    types, port = Types("", "column"), free_port()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        keystore = folder / "keystore"
        known, other = authority(folder / "known"), authority(folder / "other")
        Path(keystore, "public").mkdir(parents=True)
        Path(keystore, "public/identity_ca.cert.pem").write_bytes(Path(known, "ca.pem").read_bytes())
        for enclave in ("/router", "/column_twin", "/monitor", "/operator", "/stranger"):
            identity(keystore, known, enclave)
        identity(keystore, known, "/operator", "expired", EXPIRED)
        identity(keystore, other, "/operator", "other")

        router = Router(router_program, configured("secured_router.json5", keystore, port), name)
        session = folder / "session.json5"
        session.write_text(json.dumps(configured("secured_session.json5", keystore, port)))
        twin = Program([program, "run", "--transport", "zenoh", "--ros-args", "-p", "state.directory:=''"], name,
                       ZENOH_SESSION_CONFIG_URI=str(session))
        twin.wait_to_say("is ready in domain")
        twin.wait_to_say("connected to the Zenoh router")
        operator, monitor, stranger = (Visitor(types, session_of(it, keystore, port)) for it in ("operator", "monitor", "stranger"))
        check_granted(twin, operator, monitor)
        check_denied(operator, monitor, stranger)

        without, plain = session_of("operator", keystore, port), session_of("operator", keystore, port)
        for key in ("enable_mtls", "connect_certificate", "connect_private_key"):
            without["transport"]["link"]["tls"].pop(key)
        plain["connect"]["endpoints"] = [f"tcp/127.0.0.1:{port}"]
        plain["transport"]["link"]["protocols"] = ["tcp"]
        visitors = {"no certificate": without, "no TLS": plain, "a certificate of another authority": session_of("other", keystore, port),
                    "an expired certificate": session_of("expired", keystore, port)}
        outside = [it for what, settings in visitors.items() if (it := check_not_admitted(what, types, settings))]
        for _, peer in outside:
            peer.strike("from_outside", LIGHT)
        accepted, rejected = status(monitor).events_accepted, status(monitor).events_rejected
        operator.strike("at_the_end", LIGHT)
        wait_for("the status at the end", lambda: status(monitor).events_accepted > accepted)
        check("accepted events", status(monitor).events_accepted, accepted + 1)
        check("rejected events", status(monitor).events_rejected, rejected)
        for what, peer in outside:
            check(f"routers with {what}", list(peer.session.info.routers_zid()), [])
            check(f"what was received with {what}", peer.received(), (set(), set()))
            print(f"not admitted: {what}")
            peer.close()

        router.close()
        twin.wait_to_say("is lost")
        line = [program, "run", "--transport", "zenoh", "--ros-args", "-p", "state.directory:=''"]
        lost = Program(line, name, ZENOH_SESSION_CONFIG_URI=str(session))
        lost.wait_to_say("cannot open a Zenoh session")
        check("exit code without a router", lost.ended(), 2)
        router = Router(router_program, configured("secured_router.json5", keystore, port), name)
        twin.wait_to_say("connected to the Zenoh router", 2)
        odd = folder / "odd.json5"
        odd.write_text(json.dumps(session_of("nowhere", keystore, port)))
        lost = Program(line, name, ZENOH_SESSION_CONFIG_URI=str(odd))
        lost.wait_to_say("cannot open a Zenoh session")
        check("exit code with a certificate that does not exist", lost.ended(), 2)
        print("without the router or the certificate, a twin does not start; a router that comes back is found again")

        check("exit code of the twin", twin.end(), 0)
        for peer in (operator, monitor, stranger):
            peer.close()
        router.close(signal.SIGTERM)


def main():
    arguments = argparse.ArgumentParser(usage="zenoh_access.py COLUMN_TWIN [--router PROGRAM]")
    arguments.add_argument("program", type=lambda it: str(Path(it).resolve()))
    arguments.add_argument("--router")
    given = arguments.parse_args()
    end(lambda: run(given.program, given.router))


if __name__ == "__main__":
    main()
