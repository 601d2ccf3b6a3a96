"""The connection to an engineering server: HTTP, WebSockets, certificates. Only the standard library is used."""

import base64
import hashlib
import http.client
import json
import os
import selectors
import socket
import ssl
import struct
import urllib.parse


class PicardError(Exception):
    """The server refused a call, or could not be asked: then `status` is 0. `code` has a page of its own: plc explain
    CODE."""

    def __init__(self, status, answer):
        self.status = status
        self.code = answer.get("code", "")
        self.text = answer.get("text", f"status {status}")
        self.field = answer.get("field")
        self.help = answer.get("help")
        self.retry_after_ms = answer.get("retry_after_ms")
        where = f"{self.field}: " if self.field else ""
        super().__init__(f"{self.code}: {where}{self.text}")

    def __str__(self):
        return str(self.args[0])


class CertificateError(PicardError, ssl.SSLCertVerificationError):
    """Nobody known has signed the certificate, and its fingerprint is not the one that was given."""

    def __init__(self, text):
        super().__init__(0, {"code": "P7731", "text": text})


class NoServerError(PicardError, ConnectionRefusedError):
    """Nobody listens at the address."""

    def __init__(self, text):
        super().__init__(0, {"code": "P7730", "text": text})


def _normal(fingerprint):
    return fingerprint.replace(":", "").upper()


FILE_TIMEOUT = 70.0  # seconds: the server checks a file for up to 60 before it answers
STREAM_TIMEOUT = 60.0  # seconds: where nothing else is to be said the server says every 15 that it is there


class Connection:
    """Calls of one server, one after another. Not for several threads at a time."""

    def __init__(self, url, token=None, fingerprint=None, cafile=None, timeout=10.0):
        """`token`: of login() or tokens_add(). `fingerprint`: of a certificate that the server has made for itself, as
        plc-run prints it. `cafile`: who may have signed it, in place of those that the system knows. `timeout`: seconds for
        an answer; those to files may take 70."""
        parts = urllib.parse.urlsplit(url if "://" in url else "https://" + url)
        self._secure = parts.scheme != "http"
        self._host = parts.hostname
        self._port = parts.port or 8061
        self._fingerprint = fingerprint
        self._cafile = cafile
        self._timeout = timeout
        self._http = None
        self.token = token

    def close(self):
        """Ends the connection; the session goes on."""
        if self._http is not None:
            self._http.close()
            self._http = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _socket(self):
        try:
            raw = socket.create_connection((self._host, self._port), self._timeout)
        except ConnectionRefusedError as refused:
            raise NoServerError(f"nobody listens on {self._host_header()}") from refused
        raw.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        if not self._secure:
            return raw
        context = ssl.create_default_context(cafile=self._cafile)
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        if self._fingerprint is not None:
            context.check_hostname = False
            context.verify_mode = ssl.CERT_NONE  # its fingerprint is compared below
        try:
            encrypted = context.wrap_socket(raw, server_hostname=self._host)
        except ssl.SSLCertVerificationError as refused:
            raw.close()
            raise CertificateError(f"{self._host_header()}: {refused.verify_message}") from refused
        except BaseException:
            raw.close()
            raise
        if self._fingerprint is not None:
            has = hashlib.sha256(encrypted.getpeercert(binary_form=True)).hexdigest().upper()
            if has != _normal(self._fingerprint):
                encrypted.close()
                raise CertificateError(f"the certificate has the fingerprint {has}")
        return encrypted

    def _host_header(self):
        host = f"[{self._host}]" if ":" in self._host else self._host
        return f"{host}:{self._port}"

    def _is_ended(self):
        """Whether the server has ended the connection: between calls nothing else comes from it."""
        with selectors.DefaultSelector() as selector:
            selector.register(self._http.sock, selectors.EVENT_READ)
            return bool(selector.select(0))

    def _connect(self):
        http_connection = http.client.HTTPConnection(self._host, self._port)
        http_connection.auto_open = 0  # it would connect without TLS
        http_connection.sock = self._socket()
        self._http = http_connection

    def _send(self, method, target, body, headers, timeout):
        """The whole answer. After any failure the connection is made anew by the next call: an answer that comes late must
        not be taken for another one. A request that the server may have had is sent again only when it changes nothing."""
        for attempt in (1, 2):
            # The server ends connections that were silent for long.
            if self._http is not None and (self._http.sock is None or self._is_ended()):
                self.close()
            fresh = self._http is None
            if fresh:
                self._connect()
            written = False
            try:
                self._http.sock.settimeout(timeout)
                try:
                    self._http.request(method, target, body, headers)
                    written = True
                except (ConnectionError, ssl.SSLEOFError):
                    pass  # a server that does not take all of it may have said why
                response = self._http.getresponse()
                answer = response.read()
            except ConnectionError:
                self.close()
                if fresh or attempt == 2 or (written and method != "GET"):
                    raise
            except BaseException:
                self.close()
                raise
            else:
                if response.will_close:
                    self.close()
                return response, answer
        raise AssertionError("unreachable")

    def call(self, method, path, fields, file=False, body=None):
        """One call; `fields` that are None are left out. `body`: bytes of a file, with which fields are in the query. What
        the methods with names of calls do."""
        fields = {name: value for name, value in fields.items() if value is not None}
        headers = {"Host": self._host_header()}
        if self.token:
            headers["Authorization"] = "Bearer " + self.token
        timeout = self._timeout
        if method == "GET" or body is not None:
            if body is not None:
                headers["Content-Type"] = "application/octet-stream"
                timeout = None if timeout is None else max(timeout, FILE_TIMEOUT)
            if fields:
                texts = {
                    name: str(value).lower() if isinstance(value, bool) else value for name, value in fields.items()
                }
                path += "?" + urllib.parse.urlencode(texts, doseq=True)
        else:
            body = json.dumps(fields).encode()
            headers["Content-Type"] = "application/json"
        response, answer = self._send(method, path, body, headers, timeout)
        if response.status == 200 and file:
            return answer
        try:
            document = json.loads(answer)
        except ValueError:
            document = {}
        if response.status != 200:
            raise PicardError(response.status, document)
        return document

    def stream(self, path, fields):
        """A WebSocket of the server."""
        fields = {name: value for name, value in fields.items() if value is not None}
        if fields:
            path += "?" + urllib.parse.urlencode(fields)
        return WebSocket(self._socket(), self._host_header(), path, self.token)


class WebSocket:
    """Messages of a stream, texts as str and others as bytes."""

    def __init__(self, sock, host, path, token):
        self._sock = sock
        self._buffer = b""
        key = base64.b64encode(os.urandom(16)).decode()
        lines = [
            f"GET {path} HTTP/1.1",
            f"Host: {host}",
            "Upgrade: websocket",
            "Connection: Upgrade",
            f"Sec-WebSocket-Key: {key}",
            "Sec-WebSocket-Version: 13",
        ]
        if token:
            lines.append(f"Authorization: Bearer {token}")
        sock.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        while b"\r\n\r\n" not in self._buffer:
            self._more()
        head, self._buffer = self._buffer.split(b"\r\n\r\n", 1)
        status = int(head.split(b" ", 2)[1])
        if status != 101:
            length = 0
            for line in head.split(b"\r\n"):
                if line.lower().startswith(b"content-length:"):
                    length = int(line.split(b":")[1])
            answer = json.loads(self._take(length) or b"{}")
            sock.close()
            raise PicardError(status, answer)
        if sock.gettimeout() is not None:
            sock.settimeout(max(sock.gettimeout(), STREAM_TIMEOUT))

    def _more(self):
        got = self._sock.recv(65536)
        if not got:
            raise ConnectionError("the server ended the stream")
        self._buffer += got

    def _take(self, size):
        while len(self._buffer) < size:
            self._more()
        taken, self._buffer = self._buffer[:size], self._buffer[size:]
        return taken

    def send(self, text, opcode=1):
        data = text.encode() if isinstance(text, str) else text
        head = bytes([0x80 | opcode])
        if len(data) < 126:
            head += bytes([0x80 | len(data)])
        elif len(data) < 65536:
            head += bytes([0x80 | 126]) + struct.pack(">H", len(data))
        else:
            head += bytes([0x80 | 127]) + struct.pack(">Q", len(data))
        mask = os.urandom(4)
        self._sock.sendall(head + mask + bytes(byte ^ mask[i % 4] for i, byte in enumerate(data)))

    def receive(self):
        """The next message; None when the server has ended the stream."""
        while True:
            first, second = self._take(2)
            length = second & 0x7F
            if length == 126:
                (length,) = struct.unpack(">H", self._take(2))
            elif length == 127:
                (length,) = struct.unpack(">Q", self._take(8))
            data = self._take(length)
            opcode = first & 0x0F
            if opcode == 8:
                return None
            if opcode == 9:
                self.send(data, 10)
            elif opcode == 1:
                return data.decode()
            elif opcode == 2:
                return data

    def close(self):
        self._sock.close()


_FORMS = {
    "bool": "?",
    "i8": "b",
    "u8": "B",
    "i16": "h",
    "u16": "H",
    "i32": "i",
    "u32": "I",
    "i64": "q",
    "u64": "Q",
    "f32": "f",
    "f64": "d",
}


class Values:
    """Values of a subscription as they change: iterate over it. Each step gives a dict of path and value of those that
    have changed; `scans` and `time_ns` are of the newest frame. Times and dates are nanoseconds. `problems` names the paths
    that have no values; when none has, PicardError is raised."""

    def __init__(self, web, paths):
        self._web = web
        web.send(json.dumps({"subscribe": list(paths)}))
        message = web.receive()
        if message is None:
            web.close()
            raise ConnectionError("the server ended the stream")
        answer = json.loads(message)
        if "code" in answer:
            web.close()
            raise PicardError(400, answer)
        self._number = answer["subscription"]
        self.layout = answer["layout"]
        self.problems = answer.get("problems", [])
        if not self.layout and self.problems:  # no frame would ever have a value
            web.close()
            raise PicardError(404, self.problems[0])
        self.scans = 0
        self.time_ns = 0

    def __iter__(self):
        return self

    def __next__(self):
        while True:
            frame = self._web.receive()
            if frame is None:
                raise StopIteration
            if isinstance(frame, bytes):
                version, _, number, count, self.scans, self.time_ns = struct.unpack_from("<BBHIQq", frame)
                if version == 1 and number == self._number:
                    changed = self._decode(frame, count)
                    if changed:  # else the frame tells the clock alone
                        return changed

    def _decode(self, frame, count):
        dirty = 24
        at = dirty + (count + 7) // 8
        changed = {}
        for i, value in enumerate(self.layout):
            if not frame[dirty + i // 8] >> (i % 8) & 1:
                continue
            if value["form"] == "text":
                (length,) = struct.unpack_from("<H", frame, at)
                changed[value["path"]] = frame[at + 2 : at + 2 + length].decode()
                at += 2 + length
                continue
            form = "<" + _FORMS[value["form"]]
            (number,) = struct.unpack_from(form, frame, at)
            at += struct.calcsize(form)
            for member in value.get("members", ()):
                if member["value"] == number:
                    number = member["name"]
                    break
            changed[value["path"]] = number
        return changed

    def close(self):
        self._web.close()


class Log:
    """Messages of the log as they come: iterate over it."""

    def __init__(self, web):
        self._web = web

    def __iter__(self):
        return self

    def __next__(self):
        message = self._web.receive()
        if message is None:
            raise StopIteration
        return json.loads(message)

    def close(self):
        self._web.close()
