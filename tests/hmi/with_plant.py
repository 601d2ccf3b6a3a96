#!/usr/bin/env python3
"""Runs a client against the program of examples/hmi.

usage: with_plant.py PLC-RUN EXAMPLE-FOLDER SECONDS COMMAND...
"{port}" in the command becomes the Modbus port; "{line}" the path of a serial line on which plc-run is unit 1, too.

Exit code: that of the command (77 = skipped); 1 when plc-run does not serve or does not end well.
"""
import os
import re
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import tty


COPY = tempfile.TemporaryDirectory()


def make_cable():
    """Paths of two ends of a serial line."""
    ends = [os.openpty(), os.openpty()]
    for _, slave in ends:
        tty.setraw(slave)
    masters = [master for master, _ in ends]

    def carry():
        while True:
            for fd in select.select(masters, [], [])[0]:
                os.write(masters[1 - masters.index(fd)], os.read(fd, 512))

    threading.Thread(target=carry, daemon=True).start()
    return [os.ttyname(slave) for _, slave in ends]


def start(plc_run, folder, line):
    """plc-run on any free port, and on a line unless None; and that port."""
    config = f"{folder}/plc.toml"
    if line:
        folder = shutil.copytree(folder, f"{COPY.name}/plant")
        config = f"{folder}/plc.toml"
        with open(config, "a") as toml:
            toml.write(f'[modbus.serial]\npath = "{line}"\nline = "115200 8N1"\n')
    plant = subprocess.Popen(
        [plc_run, f"{folder}/hmi.xml", "--config", config, "--modbus", "127.0.0.1:0", "--duration", "600s"],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, bufsize=1)
    too_late = threading.Timer(20, plant.kill)
    too_late.start()
    said = ""
    for line in plant.stdout:
        said += line
        found = re.search(r"modbus: listening on 127\.0\.0\.1:(\d+)", line)
        if found:
            too_late.cancel()
            return plant, found.group(1)
    sys.exit(f"plc-run serves no Modbus:\n{said}")


def main():
    plc_run, folder, seconds, command = sys.argv[1], sys.argv[2], float(sys.argv[3]), sys.argv[4:]
    server_end, client_end = make_cable() if "{line}" in command else (None, "")
    plant, port = start(plc_run, folder, server_end)
    try:
        command = [part.replace("{port}", port).replace("{line}", client_end) for part in command]
        client = subprocess.run(command, timeout=seconds)
        code = client.returncode
    except subprocess.TimeoutExpired:
        print(f"the client took longer than {seconds:g} s")
        code = 1
    plant.send_signal(signal.SIGTERM)
    try:
        rest, _ = plant.communicate(timeout=20)
    except subprocess.TimeoutExpired:
        plant.kill()
        sys.exit("plc-run does not end")
    print(rest)
    if plant.returncode != 0:
        sys.exit(f"plc-run ended with {plant.returncode}")
    sys.exit(code)


main()
