"""The page of diagrams in a real browser: power flow, the past, causes, search, paper, ten thousand rungs (cases.py)."""

import base64
import os
import re
import shutil
import tempfile
import time
import urllib.parse

import ladder
from cases import ADMIN, CHECKS, PLC_RUN, SHOTS, TANK, VIEWER, Keys, Plant, WithBrowser, main


# What the page shows of each point that has a shape.
STATES = """
const states = () => {
  const seen = {};
  for (const e of document.querySelectorAll(".sheet [data-k].shape, .sheet [data-k].wire"))
    seen[e.dataset.k] = e.classList.contains("on") ? "on" : e.classList.contains("off") ? "off" : e.classList.contains("notrun") ? "notrun" : "";
  return seen;
};
"""


def told_by(answer):
    """The same, as the replica of the recording has it; empty where nothing is known."""
    told = {}
    for point in answer["points"]:
        state = point["state"]
        told[str(point["point"])] = "notrun" if not state & 1 else "" if not state & 6 == 6 else "on" if state & 8 else "off"
    return told


class Diagrams(WithBrowser):
    """Drawings of a plant that runs."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.plant = Plant(PLC_RUN, TANK + "/tank.xml", "--stimulus", TANK + "/stimulus.csv")
        cls.addClassCleanup(cls.plant.remove)
        cls.plant.make_first_user()
        cls.plant.call("/api/users/add", {"user": VIEWER[0], "password": VIEWER[1], "role": "viewer"})
        cls.browser.login(cls.plant.url, *VIEWER)

    def open(self, pou, **more):
        b = self.browser
        b.size(1280, 800)
        b.open(self.plant.url, "#/diagrams?" + urllib.parse.urlencode({"pou": pou, **more}))
        b.wait(f"drawing of {pou}", lambda: b.find(".sheet .tile [data-e], .sheet .tile text"))
        b.wait("what it has", lambda: b.run("""
          return [...document.querySelectorAll(".sheet [data-k]")].some(
            (e) => e.classList.contains("on") || e.classList.contains("off") || e.textContent !== "");"""))

    def select(self, name, kind="contact"):
        """As a click does."""
        b = self.browser
        found = b.wait(name, lambda: b.run(
            "return [...document.querySelectorAll('.sheet g[data-e]')].find((e) => e.classList.contains(arguments[1]) && e.dataset.name === arguments[0])",
            name, kind))
        b.run("arguments[0].dispatchEvent(new MouseEvent('click', {bubbles: true}))", found)
        b.wait("selected", lambda: b.find(".sheet .selected"))

    def scan(self):
        """The scan that is shown."""
        found = re.match(r"Scan ([\d,]+)", self.browser.find(".scan-shown")[0].text)
        return int(found.group(1).replace(",", "")) if found else None

    def states(self):
        return self.browser.run(STATES + "return states();")

    def test_power_flows(self):
        b = self.browser
        self.open("Station")
        first = b.wait("a scan", self.scan)
        b.wait("the next scans", lambda: self.scan() > first + 5)
        # A coil is as its variable says, while that stays as it is.
        def agrees():
            before = self.plant.read("Running")
            shown = b.run("""
              const coil = [...document.querySelectorAll(".sheet g.coil")].find((e) => e.dataset.name === "Running");
              return coil.querySelector(".shape").classList.contains("on");""")
            return before == shown
        b.wait("Running as it is", agrees)
        self.shot("diagram-live")
        # On and off differ in width, not by colour alone.
        widths = b.run("""
          const width = (selector) => getComputedStyle(document.querySelector(selector)).strokeWidth;
          return [width(".sheet .wire.on"), width(".sheet .wire.off")];""")
        self.assertGreater(float(widths[0][:-2]), 2 * float(widths[1][:-2]))
        self.assertEqual(b.run(CHECKS), [])
        self.assert_nothing_noted()

    def test_time_stops_and_steps_back(self):
        b = self.browser
        self.open("Station")
        b.wait("a scan", lambda: (self.scan() or 0) > 100)
        b.button("Pause").click()
        b.button("Live again")
        at = b.wait("a scan", self.scan)
        time.sleep(0.5)
        self.assertEqual(self.scan(), at)
        b.one("button[aria-label='One scan back']").click()
        b.wait("the scan before", lambda: self.scan() == at - 1)
        points = b.run("return [...new Set([...document.querySelectorAll('.sheet [data-k]')].map((e) => Number(e.dataset.k)))]")
        recording = self.plant.call("/api/diagrams/past", {})["recording"]
        answer = self.plant.call("/api/diagrams/flow", {"recording": recording, "pou": "Station", "points": points, "scan": at - 1})
        self.assertEqual(answer["scan"], at - 1)
        told = told_by(answer)
        for point, shown in self.states().items():
            if told[point] != "":
                self.assertEqual(shown, told[point], point)
        b.one("button[aria-label='One scan forward']").click()
        b.wait("the scan after", lambda: self.scan() == at)
        # To the first recorded scan, by the slider and its keys.
        slider = b.labelled("Recorded scans")
        slider.send_keys(Keys.HOME)
        b.wait("the first scan", lambda: self.scan() == int(slider.get_attribute("min")))
        self.shot("diagram-past")
        b.button("Live again").click()
        b.wait("the present", lambda: (self.scan() or 0) > at)
        self.assert_nothing_noted()

    def test_why_a_coil_is_off(self):
        b = self.browser
        self.open("Station")
        b.wait("some batches", lambda: (self.scan() or 0) > 250)
        self.select("ValveDrain", "coil")
        b.button("Why this value?").click()
        b.wait("causes", lambda: b.find(".causes li"))
        self.assertIn("ValveDrain", b.text())
        first = b.find(".causes .place")[0]
        first.click()
        b.button("Live again")
        b.wait("its place", lambda: b.run("return !document.querySelector('.found-here').hidden"))
        self.shot("diagram-why")
        self.assert_nothing_noted()

    def test_search_uses_and_blocks_lead_on(self):
        b = self.browser
        self.open("Measure")
        self.assertNotIn("StopButton", b.one(".sheet").text)
        b.enter("Search", "StopButton")
        b.button("Find").click()
        b.wait_for_text("Found for StopButton")
        b.find(".places .place")[0].click()
        b.wait("Station", lambda: "pou=Station" in b.run("return location.hash"))
        b.wait("its place", lambda: b.run("return !document.querySelector('.found-here').hidden"))
        self.select("Running")
        b.button("All uses").click()
        b.wait_for_text("Uses of Running")
        b.wait("in Signals", lambda: [p for p in b.find(".places .place") if "Signals" in p.text])
        b.wait("the variable", lambda: b.find("a.button[href*='variables?path=']"))
        self.open("Measure")
        self.select("LevelScale", "block")
        b.button("Open its drawing").click()
        b.wait_for_text("RawToUnit: Measuring.LevelScale")
        b.wait("power", lambda: b.find(".sheet .value") and any(v.text for v in b.find(".sheet .value")))
        choice = b.labelled("Instance")
        choice.send_keys("Measuring.TempScale")
        b.wait_for_text("RawToUnit: Measuring.TempScale")
        b.run("history.back()")
        b.wait_for_text("RawToUnit: Measuring.LevelScale")

    def test_a_keyboard_is_enough(self):
        b = self.browser
        self.open("Station")
        b.run("document.querySelector('.sheet').focus()")
        b.press(Keys.ENTER)
        b.wait("an element", lambda: b.run("return document.activeElement.dataset.e !== undefined"))
        before = b.run("return document.activeElement.dataset.e")
        b.press(Keys.ARROW_RIGHT)
        b.wait("the next", lambda: b.run("return document.activeElement.dataset.e") != before)
        name = b.run("return document.activeElement.dataset.name")
        b.press(Keys.ENTER)
        if name:
            b.wait("its card", lambda: b.find(".details h2") and b.find(".details h2")[0].text == name)
        width = b.run("return document.querySelector('.sheet-in').offsetWidth")
        b.press("+")
        b.wait("larger", lambda: b.run("return document.querySelector('.sheet-in').offsetWidth") > width)
        b.press("-", Keys.ESCAPE)
        b.wait("the sheet", lambda: b.run("return document.activeElement.className.includes('sheet')"))

    def test_paper_and_svg(self):
        b = self.browser
        self.open("Station")
        href = b.one("a[download]").get_attribute("href")
        self.assertIn("/api/diagrams/svg?pou=Station", href)
        b.run("window.print = () => { window.printed = document.querySelectorAll('.paper-page').length; }")
        b.button("Print").click()
        pages = b.wait("pages", lambda: b.run("return window.printed"))
        self.assertGreater(pages, 1)
        self.assertIn("1 of " + str(pages), b.run("return document.querySelector('.paper-page .title-block').textContent"))
        pdf = base64.b64decode(b.driver.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True, "printBackground": True})["data"])
        with open(os.path.join(SHOTS, "diagram.pdf"), "wb") as file:
            file.write(pdf)
        self.assertEqual(len(re.findall(rb"/Type\s*/Page\b(?!s)", pdf)), pages)
        b.run("dispatchEvent(new Event('afterprint'))")
        self.assertEqual(b.find(".paper"), [])
        self.assert_nothing_noted()

    def test_narrow_screens(self):
        b = self.browser
        self.open("Station")
        for width, height in ((390, 844), (320, 640)):
            b.size(width, height)
            self.assertEqual(b.run(CHECKS), [])
            self.shot(f"diagram-{width}")


class LiveFlow(WithBrowser):
    """What is shown of a running plant, picture by picture; PLC_STATES of the environment has another number of them."""

    STATES = int(os.environ.get("PLC_STATES", "1000"))

    def test_each_picture_is_as_the_recording_has_it(self):
        b = self.browser
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        project, stimulus = folder + "/random.xml", folder + "/stimulus.csv"
        ladder.write_random(project, stimulus, 12, self.STATES // 10 + 60, 20261127)
        plant = Plant(PLC_RUN, project, "--stimulus", stimulus)
        self.addCleanup(plant.remove)
        plant.make_first_user()
        b.login(plant.url, *ADMIN)
        b.open(plant.url, "#/diagrams?pou=Logic")
        b.wait("power", lambda: b.find(".sheet .tile .wire.on"))
        b.run(STATES + """
          const shown = document.querySelector(".scan-shown");
          window.pictures = [];
          new MutationObserver(() => {
            const scan = /^Scan ([\\d,]+)/.exec(shown.textContent);
            if (scan !== null) pictures.push([Number(scan[1].replaceAll(",", "")), states()]);
          }).observe(shown, {childList: true, characterData: true, subtree: true});""")
        until = time.monotonic() + self.STATES / 10 + 30
        while b.run("return pictures.length") < self.STATES:
            self.assertLess(time.monotonic(), until, "pictures come too slowly")
            time.sleep(0.5)
        pictures = b.run("return pictures")
        points = sorted({int(point) for point in pictures[0][1]})
        self.assertGreater(len(points), 60)
        recording = plant.call("/api/diagrams/past", {})["recording"]
        different = set()
        for scan, states in pictures[: self.STATES]:
            told = told_by(plant.call("/api/diagrams/flow", {"recording": recording, "pou": "Logic", "points": points, "scan": scan}))
            for point, shown in states.items():
                if told[point] != "":
                    self.assertEqual(shown, told[point], f"scan {scan}, point {point}")
            different.add(tuple(states.values()))
        print(f"{self.STATES} pictures, {len(different)} different ones", flush=True)
        self.assertGreater(len(different), self.STATES // 8)


class AnotherProgram(WithBrowser):
    """A page that stays open while another program starts."""

    def test_the_page_shows_what_runs(self):
        b = self.browser
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        other = Plant(PLC_RUN, ladder.write(folder + "/other.xml", 3))
        self.addCleanup(other.remove)
        other.make_first_user()
        image = other.bytes("/api/program/image")
        other.stop()
        plant = Plant(PLC_RUN, ladder.write(folder + "/plant.xml", 6))
        self.addCleanup(plant.remove)
        plant.make_first_user()
        b.login(plant.url, *ADMIN)
        b.open(plant.url, "#/diagrams?pou=Logic")

        def coils():
            return set(b.run("return [...document.querySelectorAll('.sheet g.coil')].map((e) => e.dataset.name)"))
        b.wait("its drawing", lambda: "C5" in coils())
        plant.bytes("/api/program/upload", image)
        plant.call("/api/program/start", {})
        b.wait("that of the other program", lambda: {"C2"} <= coils() and "C5" not in coils())
        b.wait("its power flow", lambda: b.run("return document.querySelector('.sheet [data-k].on, .sheet [data-k].off') !== null"))


class Ladder(WithBrowser):
    """Ten thousand rungs; PLC_RUNGS of the environment has another number."""

    RUNGS = int(os.environ.get("PLC_RUNGS", "10000"))

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        folder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, folder)
        cls.plant = Plant(PLC_RUN, ladder.write(folder + "/ladder.xml", cls.RUNGS))
        cls.addClassCleanup(cls.plant.remove)
        cls.plant.make_first_user()
        cls.browser.login(cls.plant.url, *ADMIN)

    def test_only_what_is_in_view_is_there(self):
        b = self.browser
        b.open(self.plant.url, "#/diagrams")
        b.wait("power", lambda: b.find(".sheet .tile .wire.on"))
        for part in (1, 0.5, 0.25):
            b.run("const s = document.querySelector('.sheet'); s.scrollTop = (s.scrollHeight - s.clientHeight) * arguments[0]", part)
            wanted = part * self.RUNGS
            def shown():
                names = b.run("return [...document.querySelectorAll('.sheet g.coil')].map((e) => e.dataset.name)")
                return any(abs(int(name[1:]) - wanted) < 100 for name in names if name[1:])
            b.wait(f"rungs near {wanted}", shown)
            b.wait("power there", lambda: b.find(".sheet .tile .wire.on"))
            self.assertLess(b.run("return document.querySelectorAll('.sheet *').length"), 6000)
        # A blinks with each scan: pictures between miss it, and say so.
        b.wait("pulses", lambda: b.find(".sheet .pulse"))
        # 60 pictures a second while it is scrolled, as far as this machine has them.
        frames = b.driver.execute_async_script("""
          const done = arguments[0], sheet = document.querySelector(".sheet");
          let frames = 0;
          const begin = performance.now();
          const next = () => {
            sheet.scrollTop += 40;
            ++frames;
            if (performance.now() - begin < 2000) requestAnimationFrame(next); else done(frames / 2);
          };
          requestAnimationFrame(next);""")
        print(f"{self.RUNGS} rungs, scrolled: {frames:.0f} pictures a second", flush=True)
        self.shot("diagram-ladder")
        self.assert_nothing_noted()


if __name__ == "__main__":
    main()
