# SPDX-FileCopyrightText: The latticed authors
# SPDX-License-Identifier: Apache-2.0
"""usage: s3_stub.py BUCKET REGION ACCESS_KEY SECRET_KEY [SESSION_TOKEN]

A server of S3 with one bucket in memory, on a free port of 127.0.0.1, which it prints. It has PUT, GET, HEAD and DELETE of
objects, and checks each signature (AWS Signature Version 4), written from Amazon's text and not from libcurl's source:

  key       = HMAC(HMAC(HMAC(HMAC("AWS4" + secret, date), region), "s3"), "aws4_request")
  signature = HMAC(key, "AWS4-HMAC-SHA256" \n time \n scope \n SHA256(request))
  request   = method \n path \n query \n header:value \n ... \n \n names of the headers \n SHA256(body)

Each line of standard input is a command, which is answered by a line:

  fail COUNT STATUS CODE   the next requests are refused
  stall COUNT              the next requests are never answered
  drop COUNT               the connections of the next requests are closed instead of an answer
  cut COUNT                the next objects end in the middle
  flip KEY                 flips a bit of an object
  remove KEY               removes an object
  keys                     answers with the keys of all objects
  requests                 answers with the number of requests
"""

import datetime
import hashlib
import hmac
import http.server
import re
import sys
import threading
import urllib.parse

BUCKET, REGION, ACCESS_KEY, SECRET_KEY = sys.argv[1:5]
TOKEN = sys.argv[5] if len(sys.argv) > 5 else ""
MOST_SKEW = datetime.timedelta(minutes=15)
FORM = re.compile(r"AWS4-HMAC-SHA256 ?Credential=([^,]+), ?SignedHeaders=([^,]+), ?Signature=([0-9a-f]{64})")


class Refused(Exception):
    def __init__(self, status, code):
        super().__init__(code)
        self.status, self.code = status, code


class Bucket:
    def __init__(self):
        self.lock = threading.Lock()
        self.objects = {}
        self.requests = 0
        self.faults = dict.fromkeys(("fail", "stall", "drop", "cut"), 0)
        self.refusal = Refused(503, "SlowDown")

    def takes(self, fault):
        """Whether this request has the fault."""
        with self.lock:
            self.faults[fault] -= 1
            if self.faults[fault] >= 0:
                return True
            self.faults[fault] = 0
            return False

    def execute(self, command, *words):
        with self.lock:
            if command in self.faults:
                self.faults[command] = int(words[0])
            if command == "fail":
                self.refusal = Refused(int(words[1]), words[2])
            elif command == "flip":
                data = self.objects[words[0]]
                self.objects[words[0]] = data[:-1] + bytes([data[-1] ^ 1])
            elif command == "remove":
                del self.objects[words[0]]
            elif command == "keys":
                return " ".join(sorted(self.objects))
            elif command == "requests":
                return str(self.requests)
        return "ok"


bucket = Bucket()


def sign(key, text):
    return hmac.new(key, text.encode(), hashlib.sha256).digest()


def check_signature(method, target, headers, body):
    path, _, query = target.partition("?")
    match = FORM.fullmatch(headers.get("authorization", ""))
    if match is None:
        raise Refused(403, "AccessDenied")
    key_id, date, region, service, end = match[1].split("/")
    if key_id != ACCESS_KEY:
        raise Refused(403, "InvalidAccessKeyId")
    if (region, service, end) != (REGION, "s3", "aws4_request"):
        raise Refused(400, "AuthorizationHeaderMalformed")
    if headers.get("x-amz-security-token", "") != TOKEN:
        raise Refused(400, "InvalidToken")
    when = headers["x-amz-date"]
    time_of_request = datetime.datetime.strptime(when, "%Y%m%dT%H%M%SZ")
    if not when.startswith(date) or abs(time_of_request - datetime.datetime.utcnow()) > MOST_SKEW:
        raise Refused(403, "RequestTimeTooSkewed")
    names = match[2].split(";")
    if names != sorted(names) or not {"host", *(n for n in headers if n.startswith("x-amz-"))} <= set(names):
        raise Refused(403, "AccessDenied")
    hash_of_body = headers["x-amz-content-sha256"]
    lines = [method, urllib.parse.quote(urllib.parse.unquote(path)), query]
    lines += [f"{name}:{' '.join(headers[name].split())}" for name in names]
    lines += ["", match[2], hash_of_body]
    request = hashlib.sha256("\n".join(lines).encode()).hexdigest()
    key = ("AWS4" + SECRET_KEY).encode()
    for part in (date, REGION, "s3", "aws4_request"):
        key = sign(key, part)
    text = "\n".join(["AWS4-HMAC-SHA256", when, f"{date}/{REGION}/s3/aws4_request", request])
    if not hmac.compare_digest(sign(key, text).hex(), match[3]):
        raise Refused(403, "SignatureDoesNotMatch")
    if hash_of_body != hashlib.sha256(body).hexdigest():
        raise Refused(400, "XAmzContentSHA256Mismatch")


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def handle_request(self):
        body = self.rfile.read(int(self.headers.get("content-length", 0)))
        with bucket.lock:
            bucket.requests += 1
        if bucket.takes("stall"):
            threading.Event().wait()
        if bucket.takes("drop"):
            self.close_connection = True
            return
        try:
            headers = {name.lower(): value for name, value in self.headers.items()}
            check_signature(self.command, self.path, headers, body)
            if bucket.takes("fail"):
                raise bucket.refusal
            self.answer(200 if self.command != "DELETE" else 204, self.result(body))
        except Refused as refused:
            self.answer(refused.status, f"<Error><Code>{refused.code}</Code></Error>".encode())

    do_PUT = do_GET = do_HEAD = do_DELETE = handle_request

    def result(self, body):
        name, _, key = self.path.removeprefix("/").partition("/")
        if name != BUCKET:
            raise Refused(404, "NoSuchBucket")
        with bucket.lock:
            if self.command == "PUT":
                bucket.objects[key] = body
                return b""
            if self.command == "DELETE":
                bucket.objects.pop(key, None)
                return b""
            if key not in bucket.objects:
                raise Refused(404, "NoSuchKey")
            return bucket.objects[key]

    def answer(self, status, body):
        self.send_response(status)
        if status != 204:
            self.send_header("content-length", str(len(body)))
        self.end_headers()
        if self.command == "HEAD" or status == 204:
            return
        if status == 200 and self.command == "GET" and bucket.takes("cut"):
            body = body[: len(body) // 2]
            self.close_connection = True
        self.wfile.write(body)

    def log_message(self, *_):
        pass


class Server(http.server.ThreadingHTTPServer):
    daemon_threads = True


server = Server(("127.0.0.1", 0), Handler)
print(server.server_address[1], flush=True)
threading.Thread(target=server.serve_forever, daemon=True).start()
for line in sys.stdin:
    print(bucket.execute(*line.split()), flush=True)
