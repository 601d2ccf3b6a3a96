"""Pages that are open for long: memory of the browser and of plc-run stays as it is.

usage: soak.py PLC_RUN TANK_FOLDER MINUTES

Walks through the pages of a plant that runs, 15 s on each; after each round the heap is collected and measured. Exit code
1, with the figures, when the last rounds need more than the first ones; 77, and why, without a browser.
"""

import sys
import time

MINUTES = float(sys.argv[3])
sys.argv[3:] = ["."]
from cases import ADMIN, CHROMIUM, DRIVER, PLC_RUN, TANK, Browser, Plant  # noqa: E402

PAGES = ["overview", "panel", "diagrams?pou=Station", "variables", "trends?path=Level", "alarms", "log"]
STAY_S = 15
# What a browser keeps on its own account: code that became hot, strings of the debugger.
MAY_GROW = 1.10
MAY_GROW_BYTES = 1_000_000


def resident(pid):
    with open(f"/proc/{pid}/status") as file:
        return next(int(line.split()[1]) * 1024 for line in file if line.startswith("VmRSS"))


def children(pid):
    with open(f"/proc/{pid}/task/{pid}/children") as file:
        found = [int(one) for one in file.read().split()]
    return found + [deep for one in found for deep in children(one)]


def measure(browser, plant):
    run = browser.driver.execute_cdp_cmd
    run("HeapProfiler.collectGarbage", {})
    heap = run("Runtime.getHeapUsage", {})["usedSize"]
    counts = run("Memory.getDOMCounters", {})
    server = sum(resident(pid) for pid in [plant.process.pid, *children(plant.process.pid)])
    return {"heap": heap, "nodes": counts["nodes"], "listeners": counts["jsEventListeners"], "plc-run": server}


def main():
    plant = Plant(PLC_RUN, TANK + "/tank.xml", "--stimulus", TANK + "/stimulus.csv")
    browser = Browser(CHROMIUM, DRIVER)
    rounds = []
    try:
        plant.make_first_user()
        browser.login(plant.url, *ADMIN)
        end = time.monotonic() + 60 * MINUTES
        while time.monotonic() < end:
            for page in PAGES:
                browser.run("location.hash = '#/' + arguments[0]", page)
                time.sleep(STAY_S)
            rounds.append(measure(browser, plant))
            print("round {}: heap {:.2f} MB, {} nodes, {} listeners, plc-run {:.1f} MB".format(
                len(rounds), rounds[-1]["heap"] / 1e6, rounds[-1]["nodes"], rounds[-1]["listeners"],
                rounds[-1]["plc-run"] / 1e6), flush=True)
        noted = browser.noted()
    finally:
        browser.quit()
        plant.remove()
    # The first round makes what stays: tables of texts, compiled code, the course of a trend.
    early, late = rounds[len(rounds) // 2], rounds[-1]
    grown = [what for what in early
             if late[what] > MAY_GROW * early[what] and late[what] - early[what] > (MAY_GROW_BYTES if what in ("heap", "plc-run") else 200)]
    if noted or grown:
        print(f"soak: failed: grown {grown}, noted {noted}")
        return 1
    print(f"soak: passed: {len(rounds)} rounds of {len(PAGES) * STAY_S} s")
    return 0


sys.exit(main())
