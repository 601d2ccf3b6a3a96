"""Clients of the engineering server against plc-run: the examples of the reference page, the Python module, plc remote.

usage: test_clients.py PLC PLC_RUN REFERENCE PROJECT MODULE_FOLDER
"""

import io
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import unittest.mock

PLC, PLC_RUN, REFERENCE, PROJECT, MODULES = sys.argv[1:6]
sys.path.insert(0, MODULES)
import picard  # noqa: E402

PASSWORDS = ["correct horse battery", "another horse battery"]


class Plant:
    """A plc-run that runs, with a folder of its own."""

    def __init__(self, *flags, project=PROJECT):
        self.folder = tempfile.mkdtemp()
        self.out = os.path.join(self.folder, "out")
        with open(self.out, "wb") as out:
            self.process = subprocess.Popen(
                [PLC_RUN, project, "--modbus", "off", "--engineering", "127.0.0.1:0", "--state", self.folder + "/state", *flags],
                stdout=out,
                stderr=subprocess.STDOUT,
                start_new_session=True,  # Ctrl-C is for the test
            )
        self.url = self.wait_for(r"engineering: (https?://\S+)\n")
        self.code = self.wait_for(r"code of the first one (\S+) ")

    def text(self):
        with open(self.out) as file:
            return file.read()

    def wait_for(self, pattern):
        for _ in range(1200):
            found = re.search(pattern, self.text())
            if found:
                return found.group(1)
            if self.process.poll() is not None:
                break
            time.sleep(0.05)
        raise AssertionError(f"no {pattern} in\n{self.text()}")

    def stop(self):
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(60)
        said = self.text()
        shutil.rmtree(self.folder)
        return code, said

    def remote(self, *words, secret=None):
        environment = dict(os.environ, XDG_CONFIG_HOME=self.folder + "/config")
        return subprocess.run(
            [PLC, "remote", self.url, *words], input=secret, capture_output=True, text=True, env=environment, timeout=60
        )


class WithPlant(unittest.TestCase):
    flags = ()

    def setUp(self):
        self.plant = Plant(*self.flags)

    def tearDown(self):
        if self.plant is not None:
            self.plant.stop()


# The mixing station has pages of its own: these examples are of another plant, and refused for that alone.
OF_OTHER_PLANTS = {"pages.save": "P7778", "pages.press": "P7777", "pages.picture": "P7780"}


class Reference(WithPlant):
    def test_every_example_runs(self):
        with open(REFERENCE) as file:
            page = file.read()
        examples = re.findall(r"^## (\S+)\n(?:(?!^## ).)*?```sh\n(.*?)```", page, re.M | re.S)
        self.assertGreater(len(examples), 20)
        token = ""
        examples.sort(key=lambda example: example[0] != "first_user")  # all others need a user
        for name, command in examples:
            with self.subTest(call=name):
                if token:
                    token = self.still_in(token)
                if name == "first_user":
                    command = command.replace("ABCD-EFGH-JKMN", self.plant.code)
                if name == "sessions.end":
                    with picard.Plc(self.plant.url, token) as plc:
                        command = command.replace('"session": 1', f'"session": {plc.sessions()["sessions"][0]["session"]}')
                environment = dict(os.environ, URL=self.plant.url, TOKEN=token)
                done = subprocess.run(
                    ["sh", "-ec", command], capture_output=True, text=True, env=environment, cwd=self.plant.folder, timeout=60
                )
                self.assertEqual(done.returncode, 0, command + done.stderr)
                if name in OF_OTHER_PLANTS:
                    with open(os.path.join(self.plant.folder, name)) if " -o " in command else io.StringIO(done.stdout) as answer:
                        self.assertEqual(json.load(answer)["code"], OF_OTHER_PLANTS[name])
                    continue
                if " -o " in command:
                    self.assertGreater(os.path.getsize(os.path.join(self.plant.folder, name)), 100)
                    continue
                answer = json.loads(done.stdout)
                self.assertNotIn("code", answer, f"{command}\n{done.stdout}")
                if name == "first_user":
                    token = answer["token"]
                if name in ("program.stop", "program.start"):
                    self.wait_for_state(token, "stopped" if name == "program.stop" else "runs")

    def wait_for_state(self, token, state):
        for _ in range(300):
            time.sleep(0.1)
            try:
                with picard.Plc(self.plant.url, token) as plc:
                    if plc.program()["state"] == state:
                        return
            except OSError:
                pass  # another program starts
        raise AssertionError(f"the plant is not in the state {state}")

    def still_in(self, token):
        with picard.Plc(self.plant.url, token) as plc:
            try:
                plc.session()
                return token
            except picard.PicardError:
                pass
            for password in PASSWORDS:
                try:
                    return plc.login("anna", password, token=True)["token"]
                except picard.PicardError:
                    pass
        raise AssertionError("nobody gets in any more")


class Module(WithPlant):
    def setUp(self):
        super().setUp()
        self.plc = picard.Plc(self.plant.url)
        self.plc.token = self.plc.first_user(self.plant.code, "anna", PASSWORDS[0], token=True)["token"]

    def tearDown(self):
        self.plc.close()
        super().tearDown()

    def writable(self, kind):
        for node in self.plc.values_search("*", most=1000)["nodes"]:
            if node["writable"] and node["type"] == kind:
                return node["path"]
        raise AssertionError(f"no {kind} to be written")

    def test_calls(self):
        self.assertEqual(self.plc.session()["role"], "admin")
        self.assertIn(self.plc.target()["state"], ("starts", "runs"))
        self.assertGreater(len(self.plc.tasks()["tasks"]), 0)
        self.assertGreater(len(self.plc.values_browse()["nodes"]), 0)
        self.assertEqual(len(self.plc.values_browse(from_=1, most=1)["nodes"]), 1)
        self.assertTrue(self.plc.program_image().startswith(b"PLC") or len(self.plc.program_image()) > 100)
        with open(PROJECT, "rb") as file:
            self.assertEqual(self.plc.program_project(), file.read())

    def test_refusals(self):
        with self.assertRaises(picard.PicardError) as refused:
            self.plc.values_write([{"path": "Nowhere", "value": 1}])
        self.assertEqual(refused.exception.status, 404)
        self.assertEqual(refused.exception.code, "P7101")
        self.assertEqual(refused.exception.field, "values[0].path")
        with self.assertRaises(picard.PicardError) as refused:
            picard.Plc(self.plant.url).tasks()
        self.assertEqual(refused.exception.code, "P7710")

    def test_a_stream_of_values(self):
        path = self.writable("BOOL")
        stream = self.plc.values_stream([path], period_ms=10)
        before = next(stream)[path]
        self.plc.values_write([{"path": path, "value": not before}])
        self.assertEqual(next(stream), {path: not before})
        self.assertGreater(stream.scans, 0)
        stream.close()
        some = self.plc.values_stream([path, "Nowhere"])
        self.assertEqual([one["path"] for one in some.problems], ["Nowhere"])
        self.assertIn(path, next(some))
        some.close()
        with self.assertRaises(picard.PicardError) as refused:  # it would wait for ever
            self.plc.values_stream(["Nowhere"])
        self.assertEqual(refused.exception.code, "P7101")

    def test_a_stream_of_the_log(self):
        stream = self.plc.log_stream(after=0)
        stream.close()
        with self.assertRaises(picard.PicardError):
            picard.Plc(self.plant.url).log_stream()

    def test_a_connection_that_the_server_ended_is_made_anew(self):
        self.plc.session()
        self.plc._http.sock.shutdown(2)
        self.assertEqual(self.plc.session()["user"], "anna")


class Hostile:
    """A server that does with each connection what it is told: `parts` are answers; None: silence; "": it ends."""

    def __init__(self, *connections):
        self.asked = []
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.url = "http://127.0.0.1:%d" % self.listener.getsockname()[1]
        self.kept = []  # those that are silent
        threading.Thread(target=self.run, args=(connections,), daemon=True).start()

    def run(self, connections):
        for parts in connections:
            connection = self.listener.accept()[0]
            for part in parts:
                request = b""
                while b"\r\n\r\n" not in request:
                    request += connection.recv(65536)
                head, body = request.split(b"\r\n\r\n", 1)
                length = re.search(rb"Content-Length: (\d+)", head)
                while length and len(body) < int(length.group(1)):
                    body += connection.recv(65536)
                self.asked.append(head.split(b" ")[1].decode())
                if part is None:
                    break
                if part:
                    connection.sendall(b"HTTP/1.1 200 OK\r\nContent-Length: %d\r\n\r\n" % len(part) + part.encode())
            if parts[-1] is None:
                self.kept.append(connection)
            else:
                connection.close()


class Connection(unittest.TestCase):
    def test_after_a_time_out_the_next_call_is_made(self):
        server = Hostile([None], ['{"api": 1}', ""])
        with picard.Plc(server.url, timeout=0.3) as plc:
            with self.assertRaises(TimeoutError):
                plc.version()
            self.assertEqual(plc.version()["api"], 1)

    def test_the_rest_of_an_answer_is_not_taken_for_the_next(self):
        server = Hostile(['{"api": 0}'], ['{"api": 1}'])
        with picard.Plc(server.url) as plc:
            with unittest.mock.patch("http.client.HTTPResponse.read", side_effect=KeyboardInterrupt):
                with self.assertRaises(KeyboardInterrupt):
                    plc.version()
            self.assertEqual(plc.version()["api"], 1)

    def test_where_nobody_listens_the_module_says_so(self):
        with socket.create_server(("127.0.0.1", 0)) as taken:
            port = taken.getsockname()[1]
        with self.assertRaises(picard.NoServerError) as caught:
            picard.Plc(f"http://127.0.0.1:{port}").version()
        self.assertEqual((caught.exception.status, caught.exception.code), (0, "P7730"))
        self.assertIn("NoServerError", picard.__all__)

    def test_the_refusal_of_a_large_file_is_told(self):
        with socket.create_server(("127.0.0.1", 0)) as listener:

            def serve():
                link = listener.accept()[0]
                link.recv(1000)
                answer = b'{"code": "P7711", "text": "not for you"}'
                link.sendall(b"HTTP/1.1 403 Forbidden\r\nConnection: close\r\nContent-Length: %d\r\n\r\n" % len(answer) + answer)
                time.sleep(0.2)
                link.close()  # what was not read is refused by a reset

            threading.Thread(target=serve, daemon=True).start()
            with picard.Plc("http://127.0.0.1:%d" % listener.getsockname()[1]) as plc:
                with self.assertRaises(picard.PicardError) as caught:
                    plc.program_upload(bytes(20_000_000))
        self.assertEqual(caught.exception.code, "P7711")

    def test_only_what_changes_nothing_is_sent_again(self):
        server = Hostile(["{}", ""], ['{"api": 1}', ""], ['{"written": 1}', ""])
        with picard.Plc(server.url) as plc:
            plc.version()
            self.assertEqual(plc.version()["api"], 1, "the server ended the connection after the second request")
            with self.assertRaises(ConnectionError):
                plc.values_write([{"path": "X", "value": 1}])
            self.assertEqual(plc.values_write([{"path": "X", "value": 1}])["written"], 1)
        self.assertEqual(server.asked.count("/api/values/write"), 2)

    def test_a_connection_that_was_ended_meanwhile_is_made_anew_for_a_write(self):
        server = Hostile(["{}"], ['{"written": 1}', ""])
        with picard.Plc(server.url) as plc:
            plc.version()
            time.sleep(0.3)
            self.assertEqual(plc.values_write([{"path": "X", "value": 1}])["written"], 1)
        self.assertEqual(server.asked.count("/api/values/write"), 1)

    def test_without_tls_nothing_is_said_after_a_refused_certificate(self):
        server = Hostile(["{}"])
        plc = picard.Plc(server.url.replace("http:", "https:"), token="secret", timeout=1)
        with unittest.mock.patch.object(picard.Plc, "_socket", side_effect=picard.CertificateError("wrong")):
            for _ in range(2):
                with self.assertRaises(picard.CertificateError):
                    plc.version()
        self.assertEqual(server.asked, [])

    def test_a_stream_may_be_silent_for_longer_than_a_call(self):
        with socket.create_server(("127.0.0.1", 0)) as listener:

            def serve():
                link = listener.accept()[0]
                link.recv(65536)
                link.sendall(b"HTTP/1.1 101 Switching Protocols\r\n\r\n")
                time.sleep(3)
                link.sendall(b'\x81\x0d{"number": 1}')
                link.close()

            threading.Thread(target=serve, daemon=True).start()
            with picard.Plc("http://127.0.0.1:%d" % listener.getsockname()[1], timeout=2) as plc:
                self.assertEqual(next(plc.log_stream())["number"], 1)

    def test_the_check_of_a_file_takes_its_time(self):
        server = Hostile(["{}", "{}"])
        timeouts = []
        with picard.Plc(server.url) as plc:
            send = plc._send
            plc._send = lambda *all: timeouts.append(all[-1]) or send(*all)
            plc.call("POST", "/api/program/upload", {}, body=b"image")
            plc.call("GET", "/api/version", {})
        self.assertGreater(timeouts[0], 60)
        self.assertEqual(timeouts[1], 10)


class Tls(WithPlant):
    def setUp(self):
        folder = tempfile.mkdtemp()
        self.configuration = os.path.join(folder, "plc.toml")
        with open(self.configuration, "w") as file:
            file.write('[engineering]\ntls = "always"\n')
        self.flags = ("--config", self.configuration)
        super().setUp()

    def test_a_fingerprint_counts(self):
        fingerprint = self.plant.wait_for(r"certificate ([0-9A-F:]+)")
        self.assertTrue(self.plant.url.startswith("https://"))
        with picard.Plc(self.plant.url, fingerprint=fingerprint) as plc:
            self.assertEqual(plc.version()["api"], 1)
        with self.assertRaises(picard.CertificateError):
            picard.Plc(self.plant.url, fingerprint=fingerprint[:-2] + "00").version()
        import ssl

        with self.assertRaises(ssl.SSLError):
            picard.Plc(self.plant.url).version()
        refused = self.plant.remote("calls.nonsense")
        self.assertEqual(refused.returncode, 2)
        refused = self.plant.remote("version")
        self.assertEqual(refused.returncode, 1)
        self.assertIn("P7731", refused.stderr)
        self.assertIn(fingerprint, refused.stderr)
        made = self.plant.remote("first-user", self.plant.code, "anna", "--fingerprint", fingerprint, secret=PASSWORDS[0])
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertEqual(self.plant.remote("tasks").returncode, 0, "the fingerprint is kept")


class Remote(WithPlant):
    def test_what_people_do(self):
        first = self.plant.remote("tasks").stderr
        self.assertIn("P7710", first)
        self.assertIn(f"plc remote {self.plant.url} first-user CODE USER", first)
        made = self.plant.remote("first-user", self.plant.code, "anna", secret=PASSWORDS[0] + "\n")
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertIn("as anna, admin", made.stdout)
        mode = os.stat(self.plant.folder + "/config/picard/logins.json").st_mode & 0o777
        self.assertEqual(mode, 0o600)
        for words in ((), ("status",), ("tasks",), ("values",), ("log",), ("calls",), ("audit",), ("tasks", "--json")):
            done = self.plant.remote(*words)
            self.assertEqual(done.returncode, 0, f"{words} {done.stderr}")
            if words != ("log",):  # which may have nothing to say
                self.assertGreater(len(done.stdout), 20, words)
        added = self.plant.remote("users.add", "user=ben", "role=viewer", secret="battery horse")
        self.assertEqual(added.returncode, 0, added.stderr)
        self.assertIn("ben", self.plant.remote("users").stdout)
        self.assertIn("P7714", self.plant.remote("users.add", "user=eve", "role=king", "password=battery horse").stderr)
        self.assertEqual(self.plant.remote("users.add", "nonsense=1").returncode, 2)
        stored = self.plant.remote("program.project", "-o", self.plant.folder + "/project")
        self.assertEqual(stored.returncode, 0, stored.stderr)
        with open(PROJECT, "rb") as file, open(self.plant.folder + "/project", "rb") as copy:
            self.assertEqual(file.read(), copy.read())
        self.assertEqual(self.plant.remote("logout").returncode, 0)
        out = self.plant.remote("tasks").stderr
        self.assertIn("P7710", out)
        self.assertIn(f"help: plc remote {self.plant.url} login USER\n", out)
        self.assertNotIn("/api/", out)
        self.assertIn("help: the token of --token", self.plant.remote("tasks", "--token", "x" * 40).stderr)
        wrong = self.plant.remote("login", "anna", secret="wrong horse")
        self.assertIn("P7712", wrong.stderr)
        self.assertEqual(self.plant.remote("login", "anna", secret=PASSWORDS[0]).returncode, 0)

    def test_a_write_is_seen_and_audited(self):
        self.plant.remote("first-user", self.plant.code, "anna", secret=PASSWORDS[0])
        nodes = json.loads(self.plant.remote("values.search", "pattern=*", "most=1000").stdout)["nodes"]
        path = next(node["path"] for node in nodes if node["writable"] and node["type"] == "BOOL")
        done = self.plant.remote("write", path + "=TRUE")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout, f"{path}: FALSE -> TRUE\n")
        self.assertIn("TRUE", self.plant.remote("values", path).stdout)
        self.assertEqual(self.plant.remote("write", path + "=0").stdout, f"{path}: TRUE -> FALSE\n")
        time.sleep(0.5)
        audit = subprocess.run([PLC, "audit", self.plant.folder + "/state/engineering"], capture_output=True, text=True)
        self.assertEqual(audit.returncode, 0, audit.stderr)
        self.assertIn("values.write", audit.stdout)
        self.assertIn("as written", audit.stdout)

    def test_who_may_not_send_a_large_file_is_told_why(self):
        self.plant.remote("first-user", self.plant.code, "anna", secret=PASSWORDS[0])
        image = os.path.join(self.plant.folder, "large.pbc")
        with open(image, "wb") as file:
            file.write(bytes(20_000_000))
        token = json.loads(self.plant.remote("tokens.add", "name=v", "role=viewer", "--json").stdout)["token"]
        for secret, code in ((token, "P7711"), ("none", "P7710")):
            refused = self.plant.remote("--token", secret, "upload", image)
            self.assertEqual((refused.returncode, code in refused.stderr), (1, True), refused.stderr)

    def test_users_are_there_after_a_restart(self):
        self.plant.remote("first-user", self.plant.code, "anna", secret=PASSWORDS[0])
        state = os.path.join(self.plant.folder, "state")
        kept = tempfile.mkdtemp()
        self.plant.process.send_signal(signal.SIGTERM)
        self.plant.process.wait(60)
        shutil.copytree(state, kept + "/state")
        again = subprocess.Popen(
            [PLC_RUN, PROJECT, "--modbus", "off", "--engineering", "127.0.0.1:0", "--state", kept + "/state"],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        url = None
        while url is None:
            found = re.match(r"engineering: (http://\S+)", again.stdout.readline())
            url = found and found.group(1)
        with picard.Plc(url) as plc:
            with self.assertRaises(picard.PicardError):
                plc.first_user(self.plant.code, "eve", PASSWORDS[0])
            self.assertEqual(plc.login("anna", PASSWORDS[0], token=True)["role"], "admin")
        again.send_signal(signal.SIGTERM)
        said = again.stdout.read()
        again.stdout.close()
        again.wait(60)
        self.assertNotIn("code of the first one", said)
        shutil.rmtree(kept)


class Forced(WithPlant):
    def test_a_force_that_is_over_is_kept_no_more(self):
        self.plant.remote("first-user", self.plant.code, "anna", secret=PASSWORDS[0])
        nodes = json.loads(self.plant.remote("values.search", "pattern=*", "most=1000").stdout)["nodes"]
        path = next(node["path"] for node in nodes if node["writable"] and node["type"] == "BOOL")
        done = self.plant.remote("forces.set", "path=" + path, "value=true", "reason=trial", "seconds=5", "warm=true")
        self.assertEqual(done.returncode, 0, done.stderr)
        kept = os.path.join(self.plant.folder, "state", "engineering", "forces.json")
        with open(kept) as file:
            self.assertEqual([force["path"] for force in json.load(file)], [path])
        for _ in range(200):
            time.sleep(0.1)
            with open(kept) as file:
                if json.load(file) == []:
                    return
        raise AssertionError("it would be forced again")


class Kept(WithPlant):
    """Alarms and values of the past, over a kill."""

    def wait(self, condition):
        for _ in range(600):
            if found := condition():
                return found
            time.sleep(0.1)
        raise AssertionError(self.plant.text())

    def test_alarms_and_values_are_there_after_a_kill(self):
        self.plant.remote("first-user", self.plant.code, "anna", secret=PASSWORDS[0])
        # Nothing says that the emergency stop is good.
        self.wait(lambda: "unacked active" in self.plant.remote("alarms").stdout)
        done = self.plant.remote("alarms.ack", "names=EmergencyStop", "comment=is known")
        self.assertEqual(done.returncode, 0, done.stderr)
        listed = self.plant.remote("alarms").stdout
        self.assertRegex(listed, r"EmergencyStop +acked active +critical .*Fast \d+ +1 +anna")
        self.assertIn("3 alarms, 1 active, 0 not acknowledged", listed)
        self.wait(lambda: len(self.events()) > 1)
        history = self.events()
        self.assertEqual([event["what"] for event in history], ["acknowledged", "raised"])
        self.assertEqual(history[1]["scan"], 0, "in the first scan")
        self.wait(lambda: len(self.points(self.plant.remote("history.query", "tag=Level", "from=0", "to=9000000000").stdout)) > 80)
        killed = time.time()
        self.plant.process.kill()
        self.plant.process.wait(60)
        with open(self.plant.out, "wb") as out:
            self.plant.process = subprocess.Popen(
                [PLC_RUN, PROJECT, "--modbus", "off", "--engineering", "127.0.0.1:0", "--state", self.plant.folder + "/state"],
                stdout=out, stderr=subprocess.STDOUT, start_new_session=True,
            )
        self.plant.url = self.plant.wait_for(r"engineering: (https?://\S+)\n")
        self.assertEqual(self.plant.remote("login", "anna", secret=PASSWORDS[0]).returncode, 0)
        time.sleep(1)
        alarms = json.loads(self.plant.remote("alarms", "--json").stdout)
        self.assertEqual([(a["name"], a["state"]) for a in alarms["alarms"]], [("EmergencyStop", "acked active")])
        self.assertEqual(self.events(), history, "nothing new, nothing lost")
        before = [p for p in self.points(self.plant.remote("history.query", "tag=Level", "from=0", f"to={killed}").stdout)]
        self.assertGreater(before[-1]["time"], killed - 7, "some seconds are lost at most")

    def events(self):
        return json.loads(self.plant.remote("alarms.history").stdout)["events"]

    @staticmethod
    def points(text):
        return json.loads(text)["points"]


TEXTS = """
VAR_GLOBAL Text : STRING[20]; Wide : WSTRING[20]; Number : REAL; END_VAR
PROGRAM Main
END_PROGRAM
CONFIGURATION C
  RESOURCE R ON PLC
    TASK T(INTERVAL := T#20ms, PRIORITY := 0);
    PROGRAM main WITH T : Main;
  END_RESOURCE
END_CONFIGURATION
"""


class RemoteTexts(unittest.TestCase):
    def test_what_is_typed_is_written(self):
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        project = os.path.join(folder, "texts.st")
        with open(project, "w") as file:
            file.write(TEXTS)
        plant = Plant(project=project)
        self.addCleanup(plant.stop)
        plant.remote("first-user", plant.code, "anna", secret=PASSWORDS[0])
        for typed in ("1.50", "1e5", "TRUE", "null", "[1]", "a=b"):
            for more in ((), ("--json",)):
                done = plant.remote("write", f"Text={typed}", f"Wide={typed}", *more)
                self.assertEqual(done.returncode, 0, done.stderr)
                read = json.loads(plant.remote("values.read", "paths=Text", "paths=Wide").stdout)["values"]
                self.assertEqual([one["value"] for one in read], [typed, typed])
        self.assertEqual(plant.remote("write", "Number=1.50").returncode, 0)


class TwoInOneFolder(WithPlant):
    def test_the_second_one_leaves_what_the_first_one_keeps(self):
        with picard.Plc(self.plant.url) as plc:
            plc.token = plc.first_user(self.plant.code, "anna", PASSWORDS[0], token=True)["token"]
            state = self.plant.folder + "/state"
            second = os.path.join(self.plant.folder, "second")
            with open(second, "wb") as out:
                other = subprocess.Popen(
                    [PLC_RUN, PROJECT, "--modbus", "off", "--engineering", "127.0.0.1:0", "--state", state],
                    stdout=out, stderr=subprocess.STDOUT, start_new_session=True,
                )

            def said():
                with open(second) as file:
                    return file.read()
            try:
                for part in ("P7701: folder", "alarms.db: another plc-run writes it", "history.db cannot be written: another"):
                    for _ in range(600):
                        if part in said():
                            break
                        time.sleep(0.05)
                    self.assertIn(part, said())
                self.assertNotRegex(said(), r"engineering: https?:")
                plc.users_add("ben", PASSWORDS[1], "viewer")
                self.plant.process.send_signal(signal.SIGTERM)
                self.plant.process.wait(60)
                for _ in range(600):  # the first one has ended: the second one goes on with what is there
                    found = re.search(r"engineering: (https?://\S+)\n", said())
                    if found:
                        break
                    time.sleep(0.05)
                self.assertTrue(found, said())
                with picard.Plc(found.group(1)) as late:
                    late.login("ben", PASSWORDS[1])
                checked = subprocess.run([PLC, "audit", state + "/engineering", "--check"], capture_output=True, text=True, timeout=60)
                self.assertEqual(checked.returncode, 0, checked.stdout + checked.stderr)
            finally:
                other.send_signal(signal.SIGTERM)
                other.wait(60)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
