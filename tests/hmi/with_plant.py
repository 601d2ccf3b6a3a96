#!/usr/bin/env python3
"""Runs a client against the program of examples/hmi.

usage: with_plant.py PLC-RUN EXAMPLE-FOLDER SECONDS COMMAND...   "{port}" in the command becomes the Modbus port

Exit code: that of the command (77 = skipped); 1 when plc-run does not serve or does not end well.
"""
import re
import signal
import subprocess
import sys
import threading


def start(plc_run, folder):
    """plc-run on any free port, and that port."""
    plant = subprocess.Popen(
        [plc_run, f"{folder}/hmi.xml", "--config", f"{folder}/plc.toml", "--modbus", "127.0.0.1:0", "--duration", "600s"],
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
    plant, port = start(plc_run, folder)
    try:
        client = subprocess.run([part.replace("{port}", port) for part in command], timeout=seconds)
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
