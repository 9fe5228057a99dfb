"""A receiver of webhooks from Python's standard library alone: python3 https_receiver.py CERTIFICATE KEY SECRET [ANSWERS]

Prints the port, then one line of JSON for each request: whether its signature is right, its id, and its body.
ANSWERS are the status codes of the first answers, separated by commas; later ones are 204.
"""

import base64
import hashlib
import hmac
import http.server
import json
import ssl
import sys

certificate, key, secret = sys.argv[1:4]
answers = [int(it) for it in sys.argv[4].split(",")] if len(sys.argv) > 4 else []
secret = base64.b64decode(open(secret).read().strip().removeprefix("whsec_"))


class Receiver(http.server.BaseHTTPRequestHandler):
    def do_POST(self):
        body = self.rfile.read(int(self.headers["content-length"]))
        signed = f"{self.headers['webhook-id']}.{self.headers['webhook-timestamp']}.".encode() + body
        expected = "v1," + base64.b64encode(hmac.digest(secret, signed, hashlib.sha256)).decode()
        right = hmac.compare_digest(expected, self.headers["webhook-signature"])
        line = {"right": right, "id": self.headers["webhook-id"], "body": json.loads(body)}
        print(json.dumps(line), flush=True)
        self.send_response(answers.pop(0) if answers else 204)
        self.end_headers()

    def log_message(self, *_):
        pass


server = http.server.HTTPServer(("127.0.0.1", 0), Receiver)
context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
context.load_cert_chain(certificate, key)
server.socket = context.wrap_socket(server.socket, server_side=True)
print(server.server_port, flush=True)
server.serve_forever()
