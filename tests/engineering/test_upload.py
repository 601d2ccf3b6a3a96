"""Another program for a plant that runs: uploads, starts, stops, losses of power, devices.

usage: test_upload.py PLC PLC_RUN TANK MODULE_FOLDER THROWS [unittest arguments]

THROWS: a library with the taskblock FAULTY, which throws.
"""

import glob
import hashlib
import http.client
import os
import random
import re
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

PLC, PLC_RUN, TANK, MODULES, THROWS = sys.argv[1:6]
sys.path.insert(0, MODULES)
import picard  # noqa: E402

SWITCHES = 100
KILLS = 25
# Of what has to happen within the second of a trial.
ATTEMPTS = 5
PASSWORD = "correct horse battery"
# While another program starts, and when the process was killed.
AWAY = (OSError, ValueError, http.client.HTTPException)

MOTOR = """
PROGRAM Main
VAR Motor AT %QX0.0 : BOOL; Lamp AT %QX0.1 : BOOL; END_VAR
VAR RETAIN Scans : DINT; END_VAR
VAR Index : DINT := {index}; END_VAR
  Motor := TRUE;
  Lamp := TRUE;
  Scans := Scans + 1;
  WHILE Index = 9 DO (* for ever *)
    Index := 9;
  END_WHILE;
END_PROGRAM
CONFIGURATION C
  RESOURCE R ON PLC
    TASK T(INTERVAL := T#10ms, PRIORITY := 0);
    PROGRAM main WITH T : Main;
  END_RESOURCE
END_CONFIGURATION
"""


def run(*words):
    done = subprocess.run(words, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, f"{words}\n{done.stdout}{done.stderr}"
    return done.stdout


def compiled(folder, name, text, *flags):
    """An image of the project: its path and its bytes."""
    source, image = os.path.join(folder, name), os.path.join(folder, name + ".pbc")
    with open(source, "w") as file:
        file.write(text)
    run(PLC, "compile", source, "-o", image, *flags)
    with open(image, "rb") as file:
        return image, file.read()


def hash_of(data):
    return hashlib.sha256(data).hexdigest()


class Plant:
    """plc-run with a state folder; it may be killed and started again."""

    def __init__(self, project, folder, *flags, program=PLC_RUN):
        self.project, self.folder, self.flags, self.run = project, folder, flags, program
        self.out = os.path.join(folder, "out")
        open(self.out, "w").close()
        self.process, self.token = None, None
        self.start()
        code = self.wait_for(r"code of the first one (\S+) ")
        with self.client() as plc:
            plc.first_user(code, "anna", PASSWORD)
            plc.token = plc.login("anna", PASSWORD, token=True)["token"]
            self.token = plc.tokens_add("test", "admin", 1)["token"]

    def start(self):
        with open(self.out, "ab") as out:
            self.from_byte = out.tell()
            self.process = subprocess.Popen(
                [self.run, self.project, "--modbus", "off", "--engineering", "127.0.0.1:0", "--state", self.folder + "/state"]
                + list(self.flags),
                stdout=out,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        self.url = self.wait_for(r"engineering: (https?://\S+)\n")

    def text(self):
        with open(self.out) as file:
            file.seek(self.from_byte)
            return file.read()

    def wait_for(self, pattern):
        for _ in range(2400):
            found = re.search(pattern, self.text())
            if found:
                return found.group(1)
            if self.process.poll() is not None:
                break
            time.sleep(0.025)
        raise AssertionError(f"no {pattern} in\n{self.text()}")

    def client(self):
        return picard.Plc(self.url, self.token)

    def kill(self):
        os.killpg(self.process.pid, signal.SIGKILL)  # with the guardian, if there is one
        self.process.wait(60)

    def stop(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        return self.process.wait(60)

    def program(self, patience=30):
        """What `program` says, also while the server is away."""
        until = time.monotonic() + patience
        while True:
            try:
                with self.client() as plc:
                    return plc.program()
            except AWAY as away:
                if self.process.poll() is not None or time.monotonic() > until:
                    raise AssertionError(f"plc-run is away\n{self.text()}") from away
                time.sleep(0.02)

    def wait_until(self, good, patience=30):
        until = time.monotonic() + patience
        while time.monotonic() < until:
            program = self.program()
            if good(program):
                return program
            time.sleep(0.05)
        raise AssertionError(f"{program}\n{self.text()}")

    def audited(self, what):
        """Records of the audit whose names begin so."""
        with self.client() as plc:
            return [record for record in plc.audit()["records"] if record["what"].startswith(what)]

    def crashes(self):
        """What was saved of processes that died."""
        return glob.glob(self.folder + "/state/records/crash-*.rec")

    def upload_and_start(self, image, kind="warm"):
        with self.client() as plc:
            plc.program_upload(image)
            plc.program_start(kind=kind)


class WithFolder(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.plant = None

    def tearDown(self):
        if self.plant is not None:
            self.plant.stop()
        shutil.rmtree(self.folder)

    def versions_of_the_tank(self):
        with open(TANK) as file:
            text = file.read()
        self.assertIn("<expression>T#3s</expression>", text)
        self.project, self.old = compiled(self.folder, "tank.xml", text)
        _, self.new = compiled(self.folder, "new.xml", text.replace("<expression>T#3s</expression>", "<expression>T#4s</expression>"))
        self.assertNotEqual(self.old, self.new)


class Load:
    """Clients that read values, as fast as they get answers, and go on when the server was away."""

    def __init__(self, plant, count):
        self.plant, self.ends, self.answers = plant, False, 0
        self.threads = [threading.Thread(target=self.read) for _ in range(count)]
        for thread in self.threads:
            thread.start()

    def read(self):
        while not self.ends:
            try:
                with self.plant.client() as plc:
                    while not self.ends:
                        plc.tasks()
                        plc.values_search("*", most=100)
                        self.answers += 1
                        time.sleep(0.005)  # 2000 calls a second of one address are taken
            except AWAY:
                time.sleep(0.01)

    def stop(self):
        self.ends = True
        for thread in self.threads:
            thread.join()


class Switches(WithFolder):
    def test_between_two_versions_under_load(self):
        self.versions_of_the_tank()
        self.plant = Plant(self.project, self.folder)
        load = Load(self.plant, 3)
        stood = []
        try:
            for i in range(SWITCHES):
                image = self.new if i % 2 == 0 else self.old
                self.plant.upload_and_start(image, "warm" if i % 3 else "cold")
                now = self.plant.wait_until(lambda p: p["image"] == hash_of(image) and p["state"] == "runs")
                stood.append(now["stood_ms"])
                self.assertNotIn("failed", now)
        finally:
            load.stop()
        print(f"{SWITCHES} switches: control stood for {sum(stood) / len(stood):.0f} ms on average, at most {max(stood)} ms; {load.answers} answers")
        self.assertLessEqual(max(stood), 1000)
        self.assertGreater(load.answers, SWITCHES)
        with self.plant.client() as plc:
            # Each start is a line.
            self.assertGreaterEqual(plc.log(most=1)["records"][0]["number"], SWITCHES, "the log goes on over starts")
            self.assertEqual(sum(r["what"] == "program.start" for r in plc.audit(most=1000)["records"]), SWITCHES)
        for _ in range(100):  # the last one is confirmed at once, and a little later on the disk
            files = os.listdir(self.folder + "/state/program")
            if len(files) == 2:
                break
            time.sleep(0.05)
        self.assertEqual(len(files), 2, f"chosen.json and the image that runs: {files}")
        self.assertEqual(self.plant.crashes(), [], "a start by a call is a good end of what ran")

    def test_sessions_and_who_follows_the_log_stay(self):
        self.versions_of_the_tank()
        self.plant = Plant(self.project, self.folder)
        with self.plant.client() as plc:
            session = plc.login("anna", PASSWORD, token=True)["token"]
        self.plant.upload_and_start(self.new)
        self.plant.wait_until(lambda p: p["image"] == hash_of(self.new) and p["state"] == "runs")
        with picard.Plc(self.plant.url, session) as plc:
            self.assertEqual(plc.session()["user"], "anna")

    def test_who_logs_out_while_another_program_starts_stays_out(self):
        self.versions_of_the_tank()
        self.plant = Plant(self.project, self.folder)
        with self.plant.client() as plc:
            plc.users_add("ben", PASSWORD, "viewer")
            sessions = [plc.login("anna", PASSWORD, token=True)["token"] for _ in range(24)]
            plc.program_start()
        begin, out = time.monotonic(), []

        def log_out(session, after):
            time.sleep(max(0, begin + after - time.monotonic()))
            try:
                with picard.Plc(self.plant.url, session) as plc:
                    plc.logout()
                out.append(session)
            except AWAY:
                pass  # nobody has told it

        def log_in():
            try:
                with picard.Plc(self.plant.url) as plc:
                    plc.login("ben", PASSWORD, token=True)
            except AWAY + (picard.PicardError,):
                pass

        # A password that is looked at holds up the end of the server.
        threads = [threading.Thread(target=log_in) for _ in range(4)]
        # The wish is taken after 0.05 s; from there on until the server is away.
        threads += [threading.Thread(target=log_out, args=(session, 0.04 + 0.005 * i)) for i, session in enumerate(sessions)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.plant.wait_until(lambda p: p["starts"] == 1 and p["state"] == "runs")
        self.assertGreater(len(out), 0)
        for session in out:
            with picard.Plc(self.plant.url, session) as plc:
                with self.assertRaises(picard.PicardError) as caught:
                    plc.session()
            self.assertEqual(caught.exception.status, 401)

    def test_a_page_of_a_folder_is_no_other_program(self):
        os.mkdir(self.folder + "/plant")
        compiled(self.folder + "/plant", "good.st", MOTOR.format(index=1))
        _, other = compiled(self.folder, "other.st", MOTOR.format(index=2))
        self.plant = Plant(self.folder + "/plant", self.folder)
        self.plant.upload_and_start(other)
        self.plant.wait_until(lambda p: p["image"] == hash_of(other) and p["state"] == "runs")
        self.plant.stop()
        with open(self.folder + "/plant/pages.toml", "w") as file:
            file.write("# nothing yet\n")
        self.plant.start()
        self.assertEqual(self.plant.program()["image"], hash_of(other))
        self.plant.stop()
        # As a version before has noted the folder: nobody knows whether it has changed.
        chosen = self.folder + "/state/program/chosen.json"
        with open(chosen) as file:
            text = file.read()
        with open(chosen, "w") as file:
            file.write(re.sub('"sources:[0-9a-f]{64}"', '"' + 64 * "1" + '"', text))
        for sentence in ("what was uploaded goes on", None):
            self.plant.start()
            self.assertEqual(self.plant.program()["image"], hash_of(other))
            self.assertEqual("is not known" in self.plant.text(), sentence is not None, self.plant.text())
            self.assertIn(sentence or "", self.plant.text())
            self.plant.stop()
        with open(self.folder + "/plant/good.st", "a") as file:
            file.write("(* another one *)\n")
        self.plant.start()
        self.assertNotEqual(self.plant.program()["image"], hash_of(other))

    def test_after_an_upgrade_the_program_that_runs_goes_on(self):
        self.versions_of_the_tank()
        program = self.folder + "/plc-run"
        shutil.copy2(PLC_RUN, program)
        self.plant = Plant(self.project, self.folder, program=program)
        shutil.copy2(PLC_RUN, program + ".new")
        os.rename(program + ".new", program)
        self.plant.upload_and_start(self.new)
        self.plant.wait_until(lambda p: p["image"] == hash_of(self.new) and p["state"] == "runs")

    def test_killed_at_any_moment_one_of_the_two_is_there(self):
        self.versions_of_the_tank()
        self.plant = Plant(self.project, self.folder)
        chance = random.Random(int.from_bytes(os.urandom(4), "big"))
        seen = {"old": 0, "new": 0}
        image = self.new
        for i in range(KILLS):
            pause = chance.uniform(0, 1.6)
            self.plant.wait_until(lambda p: p["state"] == "runs")
            try:
                self.plant.upload_and_start(image)
            except AWAY:
                pass
            time.sleep(pause)
            self.plant.kill()
            self.plant.start()
            now = self.plant.program()
            self.assertIn(now["image"], (hash_of(self.old), hash_of(self.new)), f"killed after {pause} s")
            self.plant.wait_until(lambda p: p["state"] == "runs")
            with self.plant.client() as plc:
                # The server may answer before the first scan has ended.
                for _ in range(100):
                    if plc.tasks()["tasks"][0]["scans"] > 0:
                        break
                    time.sleep(0.05)
                self.assertGreater(plc.tasks()["tasks"][0]["scans"], 0)
            seen["new" if now["image"] == hash_of(self.new) else "old"] += 1
            image = self.old if now["image"] == hash_of(self.new) else self.new
        print(f"{KILLS} kills: {seen}")
        self.assertGreater(len(self.plant.crashes()), 0, "what led to a kill is saved")

    def test_a_file_that_has_changed_counts_at_the_next_start(self):
        self.versions_of_the_tank()
        self.plant = Plant(self.project, self.folder)
        self.plant.upload_and_start(self.new)
        self.plant.wait_until(lambda p: p["image"] == hash_of(self.new) and p["state"] == "runs")
        self.plant.stop()
        self.plant.start()
        self.assertEqual(self.plant.program()["image"], hash_of(self.new))
        self.plant.stop()
        with open(self.folder + "/new.xml") as file:
            _, third = compiled(self.folder, "tank.xml", file.read().replace("T#4s", "T#5s"))
        self.plant.start()
        self.assertEqual(self.plant.program()["image"], hash_of(third))
        self.assertIn("is another one than when a program was uploaded", self.plant.text())


class Forces(WithFolder):
    def test_hold_over_a_warm_start_when_asked_and_end_with_a_cold_one(self):
        source, _ = compiled(self.folder, "good.st", MOTOR.format(index=1))
        _, other = compiled(self.folder, "other.st", MOTOR.format(index=2))
        self.plant = Plant(source, self.folder)
        with self.plant.client() as plc:
            plc.forces_set("%QX0.0", False, "valve is changed", warm=True)
            plc.forces_set("%QX0.1", False, "until the next start")
        self.plant.upload_and_start(other)
        self.plant.wait_until(lambda p: p["image"] == hash_of(other) and p["state"] == "runs")
        with self.plant.client() as plc:
            self.assertEqual([force["path"] for force in plc.forces_list()["forces"]], ["%QX0.0"])
            values = plc.values_read(["%QX0.0", "%QX0.1"])["values"]
            self.assertEqual([value["value"] for value in values], [False, True])
        self.plant.kill()
        self.plant.start()
        with self.plant.client() as plc:
            self.assertEqual(len(plc.forces_list()["forces"]), 1, "a loss of power is a warm start, too")
            plc.program_start(kind="cold")
        self.plant.wait_until(lambda p: p["starts"] == 1 and p["state"] == "runs")
        with self.plant.client() as plc:
            self.assertEqual(plc.forces_list()["forces"], [])
        self.plant.wait_for("(%QX0.0 is not forced any more: it was a cold start)")


class Refusals(WithFolder):
    def test_what_is_broken_wrong_or_unsigned_changes_nothing(self):
        self.versions_of_the_tank()
        run(PLC, "sign", "--make-key", self.folder + "/anna")
        run(PLC, "sign", "--make-key", self.folder + "/eve")
        with open(self.folder + "/plc.toml", "w") as file:
            file.write('[engineering]\nkeys = ["anna.pub"]\n')
        self.plant = Plant(self.project, self.folder, "--config", self.folder + "/plc.toml")

        def signature(data, key):
            with open(self.folder + "/image.pbc", "wb") as file:
                file.write(data)
            return run(PLC, "sign", self.folder + "/image.pbc", "--key", f"{self.folder}/{key}.key", "-o", "-").strip()

        def files():
            return sorted(os.listdir(self.folder + "/state/program")) if os.path.exists(self.folder + "/state/program") else []

        chance = random.Random(1)
        before = files()
        with self.plant.client() as plc:
            scans = plc.tasks()["tasks"][0]["scans"]

            def refused(code, data, **more):
                with self.assertRaises(picard.PicardError) as caught:
                    plc.program_upload(data, **more)
                self.assertEqual(caught.exception.code, code, str(caught.exception))
                self.assertNotIn("waits", plc.program())

            refused("P7751", self.new)
            refused("P7751", self.new, signature=signature(self.new, "eve"))
            refused("P7751", self.new, signature=signature(self.old, "anna"))
            with open(TANK, "rb") as file:
                tank = file.read()
            for broken in (b"", b"no image", self.new[:-1], self.new + b"\0", tank):
                refused("P7750", broken, signature=signature(broken, "anna"))
            for _ in range(10):
                at = chance.randrange(len(self.new))
                broken = self.new[:at] + bytes([self.new[at] ^ 1 << chance.randrange(8)]) + self.new[at + 1 :]
                refused("P7750", broken, signature=signature(broken, "anna"))
            self.assertEqual(plc.program()["image"], hash_of(self.old))
            self.assertGreater(plc.tasks()["tasks"][0]["scans"], scans)
            self.assertEqual(set(files()) - set(before) - {"chosen.json"}, set())
            self.assertEqual(plc.program_upload(self.new, signature=signature(self.new, "anna"))["signer"], "anna")

    def test_a_program_that_faults_is_left(self):
        source, good = compiled(self.folder, "good.st", MOTOR.format(index=1))
        _, bad = compiled(self.folder, "bad.st", MOTOR.format(index=9))
        self.plant = Plant(source, self.folder)
        self.plant.upload_and_start(bad)
        now = self.plant.wait_until(lambda p: "failed" in p and p["state"] == "runs")
        self.assertEqual(now["image"], hash_of(good))
        self.assertEqual(now["failed"]["program"]["image"], hash_of(bad))
        self.assertIn("R1001", now["failed"]["why"])
        started, failed = self.plant.audited("program.start")
        self.assertEqual((started["what"], started["user"]), ("program.start", "anna"))
        self.assertEqual((failed["what"], failed["user"]), ("program.start.failed", "anna"))
        self.assertEqual(failed["details"]["image"], hash_of(bad))
        self.assertIn("R1001", failed["details"]["why"])

    def test_a_program_that_faults_costs_the_one_before_nothing(self):
        source, good = compiled(self.folder, "good.st", MOTOR.format(index=1))
        # A fault after 0.3 s, when its own retained variable could have been stored.
        late = (
            MOTOR.format(index=1)
            .replace("Scans", "Sum")
            .replace("VAR Index", "VAR Count : DINT; Index")
            .replace("  WHILE", "  IF Count < 30 THEN Count := Count + 1; ELSE Index := 9; END_IF;\n  WHILE")
        )
        _, bad = compiled(self.folder, "bad.st", late)
        self.plant = Plant(source, self.folder)

        def scans():
            with self.plant.client() as plc:
                return plc.values_read(["main.Scans"])["values"][0]["value"]

        with self.plant.client() as plc:
            plc.forces_set("%QX0.0", False, "valve is changed", warm=True)
        while scans() < 100:
            time.sleep(0.05)
        for kind in ("warm", "cold"):
            before = scans()
            self.plant.upload_and_start(bad, kind)
            now = self.plant.wait_until(lambda p: "failed" in p and p["image"] == hash_of(good) and p["state"] == "runs")
            self.assertEqual(now["failed"]["program"]["image"], hash_of(bad))
            self.assertGreater(scans(), before, kind)
            with self.plant.client() as plc:
                self.assertEqual([force["path"] for force in plc.forces_list()["forces"]], ["%QX0.0"], kind)
        self.assertFalse(os.path.exists(self.folder + "/state/retain.previous"))

    def test_a_program_that_throws_is_left(self):
        """Without outputs there is no guardian: the process itself becomes the next one."""
        library, config = self.folder + "/throws.so", self.folder + "/plc.toml"
        shutil.copyfile(THROWS, library)
        os.chmod(library, 0o755)
        with open(config, "w") as file:
            file.write('[taskblocks]\nlibraries = ["throws.so"]\n')
        text = MOTOR.format(index=1).replace("VAR Index", "VAR Component : FAULTY; Index")
        source, good = compiled(self.folder, "good.st", text, "--config", config)
        _, bad = compiled(
            self.folder, "bad.st", text.replace("  WHILE", "  Component(GO := Index = 1);\n  WHILE"), "--config", config
        )
        self.plant = Plant(source, self.folder, "--config", config)
        before = self.plant.process.pid
        self.plant.upload_and_start(bad)
        now = self.plant.wait_until(lambda p: "failed" in p and p["state"] == "runs")
        self.assertEqual(now["image"], hash_of(good))
        self.assertEqual(now["failed"]["program"]["image"], hash_of(bad))
        self.assertIn("pressure sensor gone", now["failed"]["why"])
        self.assertIsNone(self.plant.process.poll())
        self.assertEqual(self.plant.process.pid, before)

    def test_forces_on_trial_are_gone_with_it(self):
        source, good = compiled(self.folder, "good.st", MOTOR.format(index=1))
        # A fault after 0.9 s: late enough to force something before.
        late = (
            MOTOR.format(index=1)
            .replace("VAR Index", "VAR Count : DINT; Index")
            .replace("  WHILE", "  IF Count < 90 THEN Count := Count + 1; ELSE Index := 9; END_IF;\n  WHILE")
        )
        _, bad = compiled(self.folder, "bad.st", late)
        self.plant = Plant(source, self.folder)
        with self.plant.client() as plc:
            plc.forces_set("%QX0.0", False, "valve is changed", warm=True)

        def acts():
            """Whether it was on trial all the time."""
            try:
                with self.plant.client() as plc:
                    if plc.program()["image"] != hash_of(bad):
                        return False
                    plc.forces_set("%QX0.1", False, "on trial", warm=True)
                    plc.forces_release("%QX0.0")
                    return plc.program()["state"] == "trial"
            except AWAY + (picard.PicardError,):
                return False

        def forced():
            with self.plant.client() as plc:
                return [force["path"] for force in plc.forces_list()["forces"]]

        for kind in ("warm", "cold"):
            for _ in range(ATTEMPTS):
                starts = self.plant.program()["starts"]
                self.plant.upload_and_start(bad, kind)
                self.plant.wait_until(lambda p: p["image"] == hash_of(bad) or p["starts"] > starts + 1)
                in_time = acts()
                now = self.plant.wait_until(lambda p: p["state"] == "runs")
                if in_time and now["image"] == hash_of(good):
                    break
                if now["image"] != hash_of(good):  # confirmed before its fault
                    self.plant.upload_and_start(good)
                    self.plant.wait_until(lambda p: p["image"] == hash_of(good) and p["state"] == "runs")
                with self.plant.client() as plc:
                    for path in forced():
                        plc.forces_release(path)
                    plc.forces_set("%QX0.0", False, "valve is changed", warm=True)
            else:
                self.fail("the machine is too slow for a trial of a second")
            self.assertEqual(forced(), ["%QX0.0"], kind)

    def test_a_trial_that_cannot_be_noted_is_none(self):
        source, good = compiled(self.folder, "good.st", MOTOR.format(index=1))
        _, other = compiled(self.folder, "other.st", MOTOR.format(index=2))
        self.plant = Plant(source, self.folder)
        in_the_way = self.folder + "/state/program/chosen.json.new/directory"
        self.plant.upload_and_start(other)
        os.makedirs(in_the_way)  # before the tasks have ended: nothing can be written in place of chosen.json
        now = self.plant.wait_until(lambda p: "failed" in p and p["starts"] == 1 and p["state"] == "runs")
        self.assertEqual(now["image"], hash_of(good))
        self.assertIn("it was not tried", now["failed"]["why"])
        self.plant.wait_for("(P7753.* it is tried again)")
        shutil.rmtree(os.path.dirname(in_the_way))
        self.plant.wait_for("(it is kept now)")
        self.plant.kill()
        self.plant.start()
        self.assertEqual(self.plant.program()["image"], hash_of(good), "the trial is forgotten")

    def test_a_program_that_the_configuration_does_not_fit_is_refused(self):
        source, _ = compiled(self.folder, "good.st", MOTOR.format(index=1))
        _, other = compiled(self.folder, "other.st", MOTOR.format(index=1).replace("%QX0.1", "%QX0.7"))
        with open(self.folder + "/plc.toml", "w") as file:
            file.write('[drivers.panel]\nkind = "simulated"\n[outputs]\n"%QX0.1" = { driver = "panel" }\n')
        self.plant = Plant(source, self.folder, "--config", self.folder + "/plc.toml")
        with self.plant.client() as plc:
            with self.assertRaises(picard.PicardError) as caught:
                plc.program_upload(other)
        self.assertEqual(caught.exception.code, "P7750")
        self.assertIn("%QX0.1", caught.exception.text)


class Coils(threading.Thread):
    """A Modbus device that notes when which coil was written to what."""

    def __init__(self):
        super().__init__(daemon=True)
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.coils = [False] * 16
        self.written = []
        self.start()

    def run(self):
        while True:
            link, _ = self.listener.accept()
            threading.Thread(target=self.serve, args=(link,), daemon=True).start()

    def serve(self, link):
        stream = link.makefile("rb")
        while True:
            head = stream.read(7)
            if len(head) < 7:
                return
            number, _, length, unit = struct.unpack(">HHHB", head)
            pdu = stream.read(length - 1)
            function, address, value = struct.unpack(">BHH", pdu[:5])
            if function == 5:
                self.note(address, value == 0xFF00)
                answer = pdu
            elif function == 15:
                for i in range(value):
                    self.note(address + i, bool(pdu[6 + i // 8] >> (i % 8) & 1))
                answer = pdu[:5]
            elif function == 1:
                bits = bytearray((value + 7) // 8)
                for i in range(value):
                    bits[i // 8] |= self.coils[address + i] << (i % 8)
                answer = bytes([1, len(bits)]) + bytes(bits)
            else:
                answer = bytes([function | 0x80, 1])
            link.sendall(struct.pack(">HHHB", number, 0, len(answer) + 1, unit) + answer)

    def note(self, coil, value):
        if self.coils[coil] != value:
            self.written.append((time.monotonic(), coil, value))
        self.coils[coil] = value


class Outputs(WithFolder):
    def setUp(self):
        super().setUp()
        self.device = Coils()
        with open(self.folder + "/plc.toml", "w") as file:
            file.write(
                f"""
[drivers.panel]
kind = "modbus"
bus = "127.0.0.1:{self.device.port}"
poll = "20ms"
[outputs]
"%QX0.0" = {{ driver = "panel", table = "coils", address = 0, safe = false }}
"%QX0.1" = {{ driver = "panel", table = "coils", address = 1, safe = true }}
"""
            )
        self.source, self.good = compiled(self.folder, "good.st", MOTOR.format(index=1))
        _, self.other = compiled(self.folder, "other.st", MOTOR.format(index=2))
        _, self.bad = compiled(self.folder, "bad.st", MOTOR.format(index=9))
        self.plant = Plant(self.source, self.folder, "--config", self.folder + "/plc.toml")
        self.wait_for_coils(True, True)

    def wait_for_coils(self, motor, lamp, patience=10):
        until = time.monotonic() + patience
        while self.device.coils[:2] != [motor, lamp]:
            self.assertLess(time.monotonic(), until, f"{self.device.written}\n{self.plant.text()}")
            time.sleep(0.01)

    def scans(self):
        with self.plant.client() as plc:
            return plc.values_read(["main.Scans"])["values"][0]["value"]

    def test_outputs_are_safe_as_declared_while_control_stands(self):
        before = self.plant.process.pid
        self.device.written.clear()
        retained = self.scans()
        self.plant.upload_and_start(self.other, "warm")
        self.plant.wait_until(lambda p: p["image"] == hash_of(self.other) and p["state"] == "runs")
        self.wait_for_coils(True, True)
        self.assertEqual([(coil, value) for _, coil, value in self.device.written], [(0, False), (0, True)], "the lamp stays")
        gone = self.device.written[1][0] - self.device.written[0][0]
        print(f"the output was safe for {gone * 1000:.0f} ms")
        self.assertLess(gone, 1)
        self.assertIsNone(self.plant.process.poll())
        self.assertEqual(self.plant.process.pid, before)
        self.assertGreater(self.scans(), retained, "a warm start")
        self.assertEqual(self.plant.crashes(), [], "the runtime of a guardian ends well, too")
        time.sleep(2)
        before_cold = self.scans()
        with self.plant.client() as plc:
            plc.program_start(kind="cold")
        self.plant.wait_until(lambda p: p["starts"] == 2 and p["state"] == "runs")
        self.assertLess(self.scans(), before_cold, "a cold start")

    def test_stopped_outputs_stay_safe_until_a_start(self):
        with self.plant.client() as plc:
            plc.program_stop()
        self.wait_for_coils(False, True)
        self.assertEqual(self.plant.wait_until(lambda p: p["state"] == "stopped")["image"], hash_of(self.good))
        time.sleep(1.5)  # longer than the guardian waits for a scan
        self.assertEqual(self.device.coils[:2], [False, True])
        with self.plant.client() as plc:
            self.assertEqual(plc.target()["state"], "stopped")
            plc.program_start()
        self.wait_for_coils(True, True)
        self.assertEqual(self.plant.stop(), 0)
        self.assertEqual(self.device.coils[:2], [False, True])

    def test_a_signal_ends_it_in_the_middle_of_a_start(self):
        chance = random.Random(1)
        for i in range(20):
            pause = chance.uniform(0.03, 0.3)  # the wish is taken after 0.05 s
            with self.plant.client() as plc:
                plc.program_start()
            time.sleep(pause)
            self.plant.process.send_signal(signal.SIGTERM)
            self.assertIn(self.plant.process.wait(20), (0, -signal.SIGTERM), f"after {pause} s\n{self.plant.text()}")
            self.assertEqual(self.device.coils[:2], [False, True], f"after {pause} s")
            self.plant.start()
            self.wait_for_coils(True, True)

    def dies_on_trial(self, before=lambda: None, meanwhile=lambda: None):
        """The runtime of another program dies on trial, after `meanwhile`; when it was none any more, all of it again."""
        for _ in range(ATTEMPTS):
            before()
            self.plant.upload_and_start(self.other)
            self.plant.wait_until(lambda p: p["image"] == hash_of(self.other))
            children = subprocess.run(["pgrep", "-P", str(self.plant.process.pid)], capture_output=True, text=True).stdout.split()
            self.assertEqual(len(children), 1, "the runtime of the guardian")
            meanwhile()
            os.kill(int(children[0]), signal.SIGKILL)
            until = time.monotonic() + 30
            # The guardian of a program that stays ends with its runtime.
            while self.plant.process.poll() is None:
                try:
                    with self.plant.client() as plc:
                        now = plc.program()
                    if "failed" in now and now["state"] == "runs":
                        return
                except AWAY:
                    pass
                self.assertLess(time.monotonic(), until, self.plant.text())
                time.sleep(0.02)
            self.tearDown()
            self.setUp()
        self.fail("the machine is too slow for a trial of a second")

    def test_a_runtime_that_dies_in_the_first_second_is_left(self):
        self.dies_on_trial()
        self.assertEqual(self.plant.program()["image"], hash_of(self.good))
        self.assertEqual([record["user"] for record in self.plant.audited("program.start.failed")], ["anna"])
        self.wait_for_coils(True, True)
        self.assertEqual(self.plant.stop(), 0)

    def test_who_logs_out_on_trial_stays_out_when_it_dies(self):
        tokens = {}

        def log_in():
            with self.plant.client() as plc:
                for who in ("stays", "leaves"):
                    tokens[who] = plc.login("anna", PASSWORD, token=True)["token"]

        def log_out():
            with picard.Plc(self.plant.url, tokens["leaves"]) as plc:
                plc.logout()

        self.dies_on_trial(log_in, log_out)
        with picard.Plc(self.plant.url, tokens["stays"]) as plc:
            self.assertEqual(plc.session()["user"], "anna")
        with picard.Plc(self.plant.url, tokens["leaves"]) as plc:
            with self.assertRaises(picard.PicardError) as caught:
                plc.session()
        self.assertEqual(caught.exception.status, 401)


class Disks(WithFolder):
    def hang(self):
        time.sleep(0.5)  # what has happened until now is in the audit
        # Who opens it waits for a reader who never comes.
        os.mkfifo(self.folder + "/state/engineering/audit.head.new")
        with self.plant.client() as plc:
            plc.login("anna", PASSWORD, token=True)
        time.sleep(0.5)

    def check_end(self, end, code, shortest, longest):
        begin = time.monotonic()
        self.assertEqual(end(), code, self.plant.text())
        self.assertGreater(time.monotonic() - begin, shortest, "a disk may be slow")
        # TimeoutStopSec of the unit, and stop_timeout_ns of the guardian.
        self.assertLess(time.monotonic() - begin, longest, self.plant.text())
        self.assertIn("the end takes too long: perhaps a disk hangs", self.plant.text())

    def test_one_that_hangs_does_not_hold_up_the_end_for_ever(self):
        source, _ = compiled(self.folder, "good.st", MOTOR.format(index=1))
        self.plant = Plant(source, self.folder)
        self.hang()
        self.check_end(self.plant.stop, 3, 8, 15)

    def test_with_a_guardian_the_end_comes_before_that_one_has_no_patience_any_more(self):
        source, _ = compiled(self.folder, "good.st", MOTOR.format(index=1))
        with open(self.folder + "/plc.toml", "w") as file:
            file.write('[drivers.panel]\nkind = "modbus"\nbus = "127.0.0.1:%d"\n' % Coils().port)
            file.write('[outputs]\n"%QX0.0" = { driver = "panel", table = "coils", address = 0, safe = false }\n')
        self.plant = Plant(source, self.folder, "--config", self.folder + "/plc.toml")
        self.hang()
        self.check_end(self.plant.stop, 3, 3, 6)
        self.assertNotIn("it was killed", self.plant.text())

    def test_a_fault_that_stops_the_plant_is_no_reason_to_start_it_again(self):
        text = (
            MOTOR.format(index=1)
            .replace("VAR Index", "VAR_EXTERNAL Break : BOOL; END_VAR\nVAR Index")
            .replace("WHILE Index = 9 DO", "WHILE Break DO")
            .replace("  RESOURCE", "  VAR_GLOBAL Break : BOOL; END_VAR\n  RESOURCE")
        )
        source, _ = compiled(self.folder, "good.st", text)
        self.plant = Plant(source, self.folder, "--on-fault", "stop")
        self.hang()
        with self.plant.client() as plc:
            plc.values_write([{"path": "Break", "value": True}])
        self.check_end(lambda: self.plant.process.wait(60), 1, 8, 20)


class Alarms(WithFolder):
    def test_a_delay_is_as_long_after_a_restart(self):
        """The clock of programs goes on where it was when plc-run ended: it is behind that of the machine then."""
        source, _ = compiled(self.folder, "good.st", MOTOR.format(index=1))
        self.plant = Plant(source, self.folder)
        time.sleep(1)
        self.assertEqual(self.plant.stop(), 0)
        with open(self.folder + "/alarms.toml", "w") as file:
            file.write('[[alarm]]\nname = "Late"\ntext = "It scans"\nvariable = "main.Scans"\nabove = 0.5\non_delay = "8s"\n')
        time.sleep(9)
        self.plant.start()

        def alarms():
            with self.plant.client() as plc:
                return [alarm["name"] for alarm in plc.alarms_list()["alarms"]]

        begin = time.monotonic()
        while time.monotonic() < begin + 3:
            self.assertEqual(alarms(), [], f"after {time.monotonic() - begin:.1f} s")
            time.sleep(0.1)
        while not alarms() and time.monotonic() < begin + 30:
            time.sleep(0.1)
        self.assertEqual(alarms(), ["Late"])


class Remote(WithFolder):
    def test_what_people_do(self):
        source, good = compiled(self.folder, "good.st", MOTOR.format(index=1))
        other, other_bytes = compiled(self.folder, "other.st", MOTOR.format(index=2))
        bad, _ = compiled(self.folder, "bad.st", MOTOR.format(index=9))
        self.plant = Plant(source, self.folder)

        def remote(*words):
            return subprocess.run(
                [PLC, "remote", self.plant.url, "--token", self.plant.token, *words], capture_output=True, text=True, timeout=90
            )

        uploaded = remote("upload", other, self.folder + "/other.st")
        self.assertEqual(uploaded.returncode, 0, uploaded.stderr)
        self.assertIn("was found good", uploaded.stdout)
        started = remote("start")
        self.assertEqual(started.returncode, 0, started.stderr)
        self.assertRegex(started.stdout, f"program {hash_of(other_bytes)[:8]} runs; control stood for [0-9]+ ms")
        self.plant.wait_for(f"(PICARD [0-9.]+: program {hash_of(other_bytes)[:8]} that anna uploaded)")
        stored = remote("program.project", "-o", self.folder + "/stored")
        self.assertEqual(stored.returncode, 0, stored.stderr)
        with open(self.folder + "/stored") as a, open(self.folder + "/other.st") as b:
            self.assertEqual(a.read(), b.read())
        self.assertEqual(remote("upload", bad).returncode, 0)
        failed = remote("start", "cold")
        self.assertEqual(failed.returncode, 1)
        self.assertIn("P7752", failed.stderr)
        self.assertIn(hash_of(other_bytes)[:8] + " runs again", failed.stderr)
        self.assertEqual(remote("stop").returncode, 0)
        self.plant.wait_until(lambda p: p["state"] == "stopped")
        again = remote("start")
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(remote("upload", source[:-4]).returncode, 2, "no image")
        self.assertEqual(remote("start", "hot").returncode, 2)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[6:])
