#!/usr/bin/env python3
"""FUXA, a real HMI, set up from what `plc map --format fuxa` writes, against the program of examples/hmi.

usage: fuxa_test.py PORT PLC EXAMPLE-FOLDER FUXA-FOLDER     (started by scripts/test-fuxa through with_plant.py)

A dead PLC keeps its last values in FUXA: every check wants a time stamp after the moment it asks about.
"""
import json
import os
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.parse
import urllib.request

failures = []


def check(what, good, shown=""):
    print("ok  " if good else "FAIL", what, shown, flush=True)
    if not good:
        failures.append(what)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Fuxa:
    def __init__(self, folder, user_folder):
        package = pathlib.Path(folder) / "node_modules/@frangoteam/fuxa"
        settings = (package / "settings.default.js").read_text()
        data = pathlib.Path(user_folder) / "_appdata"
        data.mkdir()
        data.joinpath("settings.js").write_text(settings.replace('//uiHost: "127.0.0.1",', 'uiHost: "127.0.0.1",'))
        self.port = free_port()
        self.log = open(pathlib.Path(user_folder) / "log.txt", "w+")
        self.process = subprocess.Popen(
            ["node", str(package / "main.js"), "--port", str(self.port), "--userDir", user_folder],
            cwd=user_folder, stdout=self.log, stderr=subprocess.STDOUT)

    def call(self, path, body=None):
        request = urllib.request.Request(
            f"http://127.0.0.1:{self.port}{path}", method="GET" if body is None else "POST",
            data=None if body is None else json.dumps(body).encode(), headers={"Content-Type": "application/json"})
        answer = urllib.request.urlopen(request, timeout=20).read()
        return json.loads(answer) if answer else None

    def wait_until_up(self):
        for _ in range(300):
            try:
                return self.call("/api/settings")
            except OSError:
                if self.process.poll() is not None:
                    break
                time.sleep(0.1)
        self.log.seek(0)
        sys.exit("FUXA does not start:\n" + self.log.read())

    def tags(self, ids):
        """{id: (value, ms since 1970)} of the tags that have a value."""
        answer = self.call("/api/getTagValue?ids=" + urllib.parse.quote(json.dumps(ids))) or []
        return {tag["id"]: (tag["value"], tag.get("ts", 0)) for tag in answer if tag.get("value") is not None}

    def write(self, tag, value):
        self.call("/api/setTagValue", {"tags": [{"id": tag, "value": value}]})

    def stop(self):
        self.process.terminate()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()


def as_number(value):
    if value in (True, "true"):
        return 1
    if value in (False, "false"):
        return 0
    return float(value)


def expect(fuxa, what, tag, wanted):
    """The value, read from the PLC after now."""
    begin = time.time() * 1000
    deadline = time.monotonic() + 8
    got = None
    while time.monotonic() < deadline:
        value, stamp = fuxa.tags([tag]).get(tag, (None, 0))
        got = value
        if stamp > begin and value is not None and as_number(value) == wanted:
            check(what, True, f"{value}, {(stamp - begin) / 1000:.2f} s later")
            return
        time.sleep(0.1)
    check(what, False, f"{got}, not {wanted}")


def run(fuxa, devices):
    fuxa.wait_until_up()
    begin = time.time() * 1000
    ids = {}
    for device in devices:
        fuxa.call("/api/projectData", {"cmd": "set-device", "data": device})
        ids.update({tag["name"]: tag["id"] for tag in device["tags"].values()})
    deadline = time.monotonic() + 20
    seen = {}
    while time.monotonic() < deadline and len(seen) < len(ids):
        time.sleep(0.2)
        seen = {tag: value for tag, value in fuxa.tags(list(ids.values())).items() if value[1] > begin}
    check("every variable of the map has a fresh value", len(seen) == len(ids), f"{len(seen)} of {len(ids)}")

    moving = [ids[name] for name in ("Scans", "Ramp")]
    first = fuxa.tags(moving)
    time.sleep(2)
    second = fuxa.tags(moving)
    for tag in moving:
        good = tag in first and tag in second and second[tag][0] != first[tag][0] and second[tag][1] > first[tag][1]
        check(f"{tag} moves", good, f"{first.get(tag)} -> {second.get(tag)}")
    beats = set()
    for _ in range(40):
        beats.update(str(value) for value, _ in fuxa.tags([ids["Heartbeat"]]).values())
        time.sleep(0.1)
    check("the heartbeat, a coil, moves", len(beats) == 2, beats)
    expect(fuxa, "a constant among the input registers", ids["MaxSpeed"], 1000)

    fuxa.write(ids["SetSpeed"], 345)
    expect(fuxa, "INT: speed follows its set-point", ids["Speed"], 345)
    fuxa.write(ids["SetTemperature"], 100.0)
    expect(fuxa, "REAL: 100 degrees in Fahrenheit", ids["Fahrenheit"], 212)
    fuxa.write(ids["SetPieces"], -40000)
    expect(fuxa, "DINT: length of the order", ids["LengthMm"], -10_000_000)
    fuxa.write(ids["SetPrice"], 0.375)
    expect(fuxa, "LREAL: price of a MWh", ids["PriceOfMwh"], 375)
    fuxa.write(ids["StartCommand"], 1)
    expect(fuxa, "BOOL: the belt runs", ids["Running"], 1)
    fuxa.write(ids["StopCommand"], 1)
    expect(fuxa, "and stops", ids["Running"], 0)
    fuxa.write(ids["Recipe[2]"], 77)
    expect(fuxa, "an element at an automatic address", ids["RecipeSum"], 77)


def main():
    port, plc, example, folder = sys.argv[1:5]
    exported = subprocess.run(
        [plc, "map", f"{example}/hmi.xml", "--config", f"{example}/plc.toml", "--format", "fuxa", "--port", port],
        check=True, capture_output=True, text=True).stdout
    user_folder = tempfile.mkdtemp(prefix="plc-fuxa-")
    fuxa = Fuxa(folder, user_folder)
    try:
        run(fuxa, json.loads(exported))
    finally:
        fuxa.stop()
        if failures and os.environ.get("PLC_KEEP"):
            print("kept:", user_folder)
        else:
            shutil.rmtree(user_folder, ignore_errors=True)
    sys.exit(1 if failures else 0)


main()
