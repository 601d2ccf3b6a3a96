"""HMI pages in a real browser: drawn, saved, loaded again; what they write, and what they refuse (cases.py)."""

import json
import os
import re
import shutil
import signal
import tempfile
import time
import urllib.error

from selenium.webdriver.common.action_chains import ActionChains

from cases import ADMIN, CHECKS, OPERATOR, PLC_RUN, SIZES, TANK, VIEWER, Keys, Plant, WithBrowser, main

PROJECT = """VAR_GLOBAL
  Pump : BOOL;
  Push : BOOL;
  Presses : DINT;
  SlowPresses : DINT;
  SlowSeesPush : BOOL;
  Setpoint : REAL := 20.0;
  Level : REAL;
  Wait : TIME := T#12s500ms;
  Large : LINT := 9007199254740993;
END_VAR
PROGRAM Main
VAR_EXTERNAL Pump, Push : BOOL; Presses : DINT; Setpoint, Level : REAL; END_VAR
VAR Edge : R_TRIG; Smooth : LOWPASS; END_VAR
  Edge(CLK := Push);
  IF Edge.Q THEN Presses := Presses + 1; END_IF
  Smooth(IN := REAL_TO_LREAL(SEL(Pump, 0.0, Setpoint)), CUTOFF := 1.0);
  Level := LREAL_TO_REAL(Smooth.OUT);
END_PROGRAM
PROGRAM Slowly
VAR_EXTERNAL Push, SlowSeesPush : BOOL; SlowPresses : DINT; END_VAR
VAR Edge : R_TRIG; END_VAR
  Edge(CLK := Push);
  IF Edge.Q THEN SlowPresses := SlowPresses + 1; END_IF
  SlowSeesPush := Push;
END_PROGRAM
CONFIGURATION c
  RESOURCE r ON PLC
    TASK fast(INTERVAL := T#20ms, PRIORITY := 1);
    TASK slow(INTERVAL := T#300ms, PRIORITY := 2);
    PROGRAM main WITH fast : Main;
    PROGRAM slowly WITH slow : Slowly;
  END_RESOURCE
END_CONFIGURATION
"""

PAGES = """# By hand.

[[page]]
name = "panel"
title = "<img src=x onerror=alert(1)>"

[[page.element]]
kind = "button"
x = 0
y = 0
label = "<b>Push</b>"
variable = "Push"

[[page.element]]
kind = "slider"
x = 4
y = 0
variable = "Setpoint"
low = 10
high = 30

[[page.element]]
kind = "number"
x = 11
y = 0
label = "Wanted"
variable = "Setpoint"
low = 10
high = 30
entered = true

[[page.element]]
kind = "switch"
x = 16
y = 0
variable = "Pump"

[[page.element]]
kind = "link"
x = 20
y = 0
page = "more"

[[page.element]]
kind = "picture"
x = 0
y = 3
label = "The plant"
file = "plant.svg"

[[page.element]]
kind = "lamp"
x = 8
y = 3
variable = "Nowhere"

[[page.element]]
kind = "plot"
x = 12
y = 3
variables = ["Level", "Setpoint"]

[[page]]
name = "more"

[[page.element]]
kind = "text"
x = 0
y = 0
text = "Level"
variable = "Level"
format = "0.00"
unit = "m"
"""
TIMES = """[[page]]
name = "times"

[[page.element]]
kind = "slider"
x = 0
y = 0
variable = "Wait"
low = 1
high = 20
step = 0.5

[[page.element]]
kind = "number"
x = 6
y = 0
variable = "Wait"
entered = true
low = 1
high = 20
format = "0.0"
unit = "s"

[[page.element]]
kind = "number"
x = 0
y = 4
variable = "Large"
format = "0"
"""
PICTURE = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 40 20"><script>top.alert(2)</script>
<rect width="40" height="20" fill="#0b5cad" onload="alert(3)"/></svg>
"""


class Pages(WithBrowser):
    def element(self, path, part=""):
        return self.browser.one(f".hmi [data-path='{path}'] {part}")


class OwnFolder(Pages):
    """A plant in a folder of its own."""

    pages = None

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.file = os.path.join(self.folder, "pages.toml")
        self.write("plant.st", PROJECT)
        if self.pages is not None:
            self.write("pages.toml", self.pages)
            self.write("plant.svg", PICTURE)
        self.plant = Plant(PLC_RUN, os.path.join(self.folder, "plant.st"))
        self.addCleanup(self.plant.remove)
        self.plant.make_first_user()
        for (user, password), role in ((VIEWER, "viewer"), (OPERATOR, "operator")):
            self.plant.call("/api/users/add", {"user": user, "password": password, "role": role})
        self.browser.size(1280, 800)

    def write(self, name, text):
        with open(os.path.join(self.folder, name), "w") as file:
            file.write(text)

    def text(self):
        with open(self.file) as file:
            return file.read()

    def as_operator(self, path, fields):
        """The answer to an operator's script: None, or the code of the refusal."""
        token = self.plant.call("/api/login", {"user": OPERATOR[0], "password": OPERATOR[1], "token": True})["token"]
        before, self.plant.token = self.plant.token, token
        try:
            self.plant.call(path, fields)
            return None
        except urllib.error.HTTPError as error:
            return json.load(error)["code"]
        finally:
            self.plant.token = before


class Editor(OwnFolder):
    """From a program without pages to a page of one's own."""

    def place(self, path):
        """Column, row, width, height of an element, as its name tells them."""
        label = self.element(path).get_attribute("aria-label")
        return tuple(int(n) for n in re.search(r"column (\d+), row (\d+), (\d+) by (\d+)", label).groups())

    def drag(self, source, target, dx, dy):
        ActionChains(self.browser.driver).move_to_element(source).click_and_hold().move_to_element_with_offset(
            target, dx, dy).release().perform()

    def test_a_page_is_drawn_saved_and_loaded_again(self):
        b = self.browser
        b.login(self.plant.url, *ADMIN)
        b.go("panel")
        # The page that is made from the program: globals, and the taskblock with its unit.
        self.element("Pump", "[role=switch]")
        b.wait("the unit of a port", lambda: self.element("main.Smooth.CUTOFF", ".hmi-value").text == "1 Hz")
        self.shot("hmi-first")
        self.assertEqual(b.run(CHECKS), [])
        b.button("Edit").click()
        b.button("Add a page").click()
        b.enter("Title", "Heater")
        grid = b.one(".hmi-grid")
        cell = grid.size["width"] / 24
        # From the middle of the page: a gauge of 4 by 4 cells at column 10, row 5, counted from 1.
        self.drag(b.one(".hmi-palette [data-kind=gauge]"), grid, round((9 + 2 - 12) * cell), round((4 + 2 - 7) * cell))
        b.enter("Variable", "Level")
        self.assertEqual(self.place("Level"), (10, 5, 4, 4))
        b.enter("Unit", "m")
        b.enter("High", "30")
        # By the keyboard alone: a switch, moved and sized.
        kind = b.one(".hmi-palette [data-kind=switch]")
        kind.send_keys(Keys.ENTER)
        b.enter("Variable", "Pump")
        self.assertEqual(self.place("Pump"), (1, 1, 3, 2))
        switch = self.element("Pump")
        switch.send_keys(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT, Keys.ARROW_DOWN)
        b.wait("moved", lambda: self.place("Pump") == (3, 2, 3, 2))
        self.element("Pump").send_keys(Keys.SHIFT + Keys.ARROW_RIGHT)
        b.wait("sized", lambda: self.place("Pump") == (3, 2, 4, 2))
        # A drag moves, its handle sizes, and each is one step back.
        gauge = self.element("Level")
        ActionChains(b.driver).drag_and_drop_by_offset(gauge, round(3 * cell), round(-2 * cell)).perform()
        b.wait("dragged", lambda: self.place("Level") == (13, 3, 4, 4))
        ActionChains(b.driver).drag_and_drop_by_offset(b.one(".hmi-handle"), round(2 * cell), round(cell)).perform()
        b.wait("sized", lambda: self.place("Level") == (13, 3, 6, 5))
        self.shot("hmi-editor-1280x800")
        self.assertEqual(b.run(CHECKS), [])
        self.element("Level").send_keys(Keys.CONTROL + "z")
        b.wait("undone", lambda: self.place("Level") == (13, 3, 4, 4))
        b.button("Redo").click()
        b.wait("again", lambda: self.place("Level") == (13, 3, 6, 5))
        self.element("Level").send_keys(Keys.CONTROL + "d")
        b.wait("a copy", lambda: len(b.find(".hmi-grid [data-path=Level]")) == 2)
        b.find(".hmi-grid [data-path=Level]")[1].send_keys(Keys.DELETE)
        b.wait("removed", lambda: len(b.find(".hmi-grid [data-path=Level]")) == 1)
        b.button("Save").click()
        b.wait_for_text("pages.toml is saved")
        text = self.text()
        self.assertIn('title = "Heater"', text)
        self.assertIn('[[page.element]]\nkind = "gauge"\nx = 12\ny = 2\nwidth = 6\nheight = 5\nvariable = "Level"\nunit = "m"\nhigh = 30\n', text)
        self.assertIn('[[page.element]]\nkind = "switch"\nx = 2\ny = 1\nwidth = 4\nheight = 2\nvariable = "Pump"\n', text)
        b.button("Close").click()
        # Loaded again, it works: the switch moves the gauge.
        b.open(self.plant.url, "#/panel?page=page")
        self.element("Pump", "[role=switch]:enabled").click()
        b.wait("the pump", lambda: self.plant.read("Pump") is True)
        b.wait("the gauge", lambda: float(self.element("Level", "[role=meter]").get_attribute("aria-valuenow")) > 15)
        self.assertIn(" m", self.element("Level", ".hmi-value").text)
        self.shot("hmi-own-1280x800")
        self.assertEqual(b.noted(), [])

    def test_it_asks_before_changes_are_lost_and_tells_of_others(self):
        b = self.browser
        b.login(self.plant.url, *ADMIN)
        b.go("panel")
        b.button("Edit").click()
        b.one(".hmi-palette [data-kind=text]").click()
        b.enter("Text", "Mine")
        b.button("Close").click()
        b.wait_for_text("Leave without saving?")
        b.button("Go on editing").click()
        self.write("pages.toml", PAGES)
        b.button("Save").click()
        b.wait_for_text("plc explain P7778")
        self.assertEqual(self.text(), PAGES)
        b.button("Close").click()
        b.button("Leave").click()
        b.wait("the other's page", lambda: self.element("Setpoint"))

    def test_wrong_pages_are_refused_with_a_reason(self):
        b = self.browser
        b.login(self.plant.url, *ADMIN)
        b.go("panel")
        b.button("Edit").click()
        b.enter("Name, for links", "no name")
        b.button("Save").click()
        b.wait_for_text("plc explain P7772")
        b.enter("Name, for links", "good")
        b.button("Save").click()
        b.wait_for_text("pages.toml is saved")

    def test_a_narrow_screen_is_enough(self):
        b = self.browser
        b.login(self.plant.url, *ADMIN)
        b.size(390, 844)
        b.go("panel")
        b.wait("values", lambda: b.find(".hmi [role=switch]") and "…" not in b.one(".hmi").text)
        self.shot("hmi-first-390x844")
        self.assertEqual(b.run(CHECKS), [])
        b.button("Edit").click()
        b.one(".hmi-palette [data-kind=lamp]").click()
        b.labelled("Variable")
        self.shot("hmi-editor-390x844")
        self.assertEqual(b.run(CHECKS), [])

    def test_operators_do_not_edit(self):
        b = self.browser
        b.login(self.plant.url, *OPERATOR)
        b.go("panel")
        self.element("Pump", "[role=switch]")
        self.assertEqual([one.text for one in b.find("button") if one.text == "Edit"], [])


    def test_columns_are_taken_when_they_are_entered(self):
        b = self.browser
        b.login(self.plant.url, *ADMIN)
        b.go("panel")
        b.button("Edit").click()
        b.button("Add a page").click()
        b.one(".hmi-palette [data-kind=switch]").send_keys(Keys.ENTER)
        b.enter("Variable", "Pump")
        for _ in range(10):
            self.element("Pump").send_keys(Keys.ARROW_RIGHT)
        b.wait("moved", lambda: self.place("Pump") == (11, 1, 3, 2))
        b.enter("Columns", "30")
        self.assertEqual(self.place("Pump"), (11, 1, 3, 2), "3, on the way to 30, is no number of columns")
        b.press(Keys.ENTER)
        b.wait("30 columns", lambda: "repeat(30," in b.one(".hmi-grid").get_attribute("style"))
        self.assertEqual(self.place("Pump"), (11, 1, 3, 2))

    def test_other_pages_and_the_end_of_a_session_lose_nothing(self):
        b = self.browser
        b.login(self.plant.url, *ADMIN)
        b.go("panel")
        b.button("Edit").click()
        b.one(".hmi-palette [data-kind=text]").click()
        b.enter("Text", "Mine")
        b.go("trends")
        b.go("panel")
        b.wait_for_text("not saved")
        self.assertIn("Mine", b.one(".hmi-grid").text)
        b.driver.delete_all_cookies()
        b.wait("login", lambda: b.find("main.alone form"))
        b.enter("User", ADMIN[0])
        b.enter("Password", ADMIN[1])
        b.press(Keys.ENTER)
        b.wait_for_text("not saved")
        self.assertIn("Mine", b.one(".hmi-grid").text)
        # Somebody else's are not lost either, unless that is wanted.
        self.write("pages.toml", TIMES)
        b.button("Save").click()
        b.wait_for_text("plc explain P7778")
        b.button("Keep a copy of mine")
        b.button("Save mine over theirs").click()
        b.wait("saved", lambda: 'text = "Mine"' in self.text())
        b.wait("nothing left", lambda: "not saved" not in b.text())


class Writing(OwnFolder):
    """A page with everything that writes."""

    pages = PAGES

    def press(self, script):
        self.browser.run(script, self.element("Push", "button"))

    def counts(self):
        return self.plant.read("Presses"), self.plant.read("SlowPresses")

    def test_markup_is_text_and_nothing_of_a_picture_runs(self):
        b = self.browser
        b.login(self.plant.url, *OPERATOR)
        b.go("panel")
        b.wait_for_text("<img src=x onerror=alert(1)>")
        b.wait_for_text("<b>Push</b>")
        b.wait("the picture", lambda: b.run("return document.querySelector('.hmi img').naturalWidth") > 0)
        b.wait_for_text("pages.toml is not as it should be")
        b.wait_for_text("Nowhere")
        self.shot("hmi-writing-1280x800")
        self.assertEqual(b.run(CHECKS), [])
        self.assertEqual(b.noted(), [])
        b.driver.get(self.plant.url + "/api/pages/picture?file=plant.svg")
        self.assertEqual(b.noted() or [], [])

    def test_a_short_press_is_seen_by_each_task(self):
        b = self.browser
        b.login(self.plant.url, *OPERATOR)
        b.go("panel")
        self.element("Push", "button:enabled")
        for n in range(1, 6):
            # Down and up in the same instant: no scan of 20 ms, and none of 300 ms, would see it.
            self.press("""
              const at = {bubbles: true, button: 0, pointerId: 1};
              arguments[0].setPointerCapture = () => {};
              arguments[0].dispatchEvent(new PointerEvent("pointerdown", at));
              arguments[0].dispatchEvent(new PointerEvent("pointerup", at));""")
            b.wait(f"press {n}", lambda: self.counts() == (n, n))
            # An edge needs a scan without it, too.
            b.wait("let go", lambda: self.plant.read("Push") is False and self.plant.read("SlowSeesPush") is False)
        self.element("Push", "button").send_keys(Keys.ENTER)
        b.wait("by key", lambda: self.counts() == (6, 6))
        records = [one["what"] for one in self.plant.call("/api/audit?most=20")["records"]]
        self.assertEqual(records.count("pages.press"), 12)

    def test_a_button_is_held_until_it_is_let_go_or_the_browser_is_gone(self):
        b = self.browser
        b.login(self.plant.url, *OPERATOR)
        b.go("panel")
        button = self.element("Push", "button:enabled")
        ActionChains(b.driver).move_to_element(button).click_and_hold().perform()
        b.wait("pressed", lambda: self.plant.read("Push") is True)
        until = time.monotonic() + 4.5
        while time.monotonic() < until:
            self.assertIs(self.plant.read("Push"), True)
            time.sleep(0.1)
        ActionChains(b.driver).release().perform()
        b.wait("let go", lambda: self.plant.read("Push") is False)
        self.assertEqual(self.counts(), (1, 1))
        ActionChains(b.driver).move_to_element(button).click_and_hold().perform()
        b.wait("pressed", lambda: self.plant.read("Push") is True)
        b.driver.get("about:blank")
        b.wait("let go", lambda: self.plant.read("Push") is False)

    def test_limits_hold_in_the_browser_and_on_the_server(self):
        b = self.browser
        b.login(self.plant.url, *OPERATOR)
        b.go("panel")
        slider = b.one(".kind-slider input:enabled")
        slider.send_keys(Keys.END)
        b.wait("the greatest", lambda: self.plant.read("Setpoint") == 30)
        slider.send_keys(Keys.ARROW_LEFT, Keys.ARROW_LEFT)
        b.wait("two steps less", lambda: abs(self.plant.read("Setpoint") - 29.6) < 0.01)
        entry = b.one(".kind-number input:enabled")
        entry.click()
        entry.send_keys("31", Keys.ENTER)
        b.wait_for_text("Wanted must be from 10 to 30")
        entry.send_keys(Keys.CONTROL + "a" + Keys.NULL, "12.5", Keys.ENTER)
        b.wait("what was entered", lambda: self.plant.read("Setpoint") == 12.5)
        write = lambda path, value: self.as_operator("/api/values/write", {"values": [{"path": path, "value": value}]})
        self.assertEqual(write("Setpoint", 31), "P7777")
        self.assertEqual(write("Presses", 31), "P7777")
        self.assertEqual(write("Push", True), "P7777")
        self.assertIsNone(write("Setpoint", 11))
        # Limits that are changed by hand hold although no page is open.
        b.driver.get("about:blank")
        self.write("pages.toml", PAGES.replace("low = 10", "low = 11.5"))
        b.wait("the new limit", lambda: write("Setpoint", 11) == "P7777")
        self.write("pages.toml", PAGES)
        b.wait("the old limit", lambda: write("Setpoint", 11) is None)
        b.open(self.plant.url, "#/panel")
        self.element("Pump", "[role=switch]:enabled").click()
        b.wait("the pump", lambda: self.plant.read("Pump") is True)

    def test_durations_are_seconds(self):
        b = self.browser
        self.write("pages.toml", TIMES)
        b.login(self.plant.url, *OPERATOR)
        b.go("panel")
        b.wait("all digits", lambda: "9007199254740993" in self.element("Large").text)
        entry = b.one(".kind-number input:enabled")
        b.wait("what it is", lambda: entry.get_attribute("value") == "12.5")
        entry.click()
        entry.send_keys("20", Keys.ENTER)
        b.wait("20 s", lambda: self.plant.read("Wait") == "T#20s")
        entry.send_keys(Keys.CONTROL + "a" + Keys.NULL, "T#1m", Keys.ENTER)
        b.wait_for_text("from 1 to 20")
        slider = b.one(".kind-slider input:enabled")
        slider.send_keys(Keys.HOME)
        b.wait("the least", lambda: self.plant.read("Wait") == "T#1s")
        slider.send_keys(Keys.ARROW_RIGHT)
        b.wait("a step", lambda: self.plant.read("Wait") == "T#1s500ms")

    def test_a_dead_line_is_seen_and_presses_nothing_later(self):
        b = self.browser
        b.login(self.plant.url, *OPERATOR)
        b.go("panel")
        button = self.element("Push", "button:enabled")
        ActionChains(b.driver).move_to_element(button).click_and_hold().perform()
        b.wait("pressed", lambda: self.plant.read("Push") is True)
        # As a cable that is pulled: nothing comes, and no connection ends. (The program stands still, too.)
        os.killpg(self.plant.process.pid, signal.SIGSTOP)
        try:
            b.wait_for_text("No connection to the PLC")
            self.assertEqual(len(b.find(".shell.stale")), 1)
            ActionChains(b.driver).release().perform()
            time.sleep(3)
        finally:
            os.killpg(self.plant.process.pid, signal.SIGCONT)
        b.wait("let go", lambda: self.plant.read("Push") is False)
        presses = self.counts()[0]
        b.wait("it is live again", lambda: not b.find(".shell.stale"))
        self.element("Pump", "[role=switch]:enabled").click()
        b.wait("a value that is written and shown", lambda: self.element("Pump", "[role=switch]").get_attribute("aria-checked") == "true")
        self.assertEqual(self.counts()[0], presses)

    def test_viewers_see_the_same_without_controls(self):
        b = self.browser
        b.login(self.plant.url, *VIEWER)
        b.go("panel")
        b.wait("values", lambda: "…" not in self.element("Pump").text)
        self.assertEqual(b.find(".hmi button, .hmi input"), [])

    def test_what_is_changed_by_hand_is_shown(self):
        b = self.browser
        b.login(self.plant.url, *VIEWER)
        b.go("panel")
        b.one(".kind-link a").click()
        b.wait("the other page", lambda: re.fullmatch(r"[\d.]+ m", self.element("Level", ".hmi-value").text))
        self.write("pages.toml", PAGES.replace('text = "Level"', 'text = "How high"'))
        b.wait_for_text("How high")
        self.write("pages.toml", PAGES.replace('kind = "text"', 'kind = "txet"'))
        b.wait_for_text("error P7771")
        b.wait_for_text("How high")


class Tank(Pages):
    """The page of the example moves."""

    def setUp(self):
        self.browser.size(1280, 800)

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.folder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        shutil.copytree(TANK, cls.folder, dirs_exist_ok=True)
        cls.plant = Plant(PLC_RUN, cls.folder + "/tank.xml", "--stimulus", cls.folder + "/stimulus.csv", "--repeat")
        cls.addClassCleanup(cls.plant.remove)
        cls.plant.make_first_user()

    def test_the_station_moves(self):
        b = self.browser
        b.login(self.plant.url, *ADMIN)
        self.assertEqual(self.plant.call("/api/pages")["problems"], [])
        for theme in ("light", "dark"):
            b.run("localStorage.setItem('picard.theme', JSON.stringify(arguments[0]))", theme)
            b.open(self.plant.url, "#/panel")
            for size, (width, height) in SIZES.items():
                b.size(width, height)
                b.wait("values", lambda: b.find(".hmi [role=meter]") and "…" not in b.one(".hmi").text)
                self.assertEqual(b.run(CHECKS), [])
                self.shot(f"hmi-tank-{size}-{theme}")
        b.size(1280, 800)
        level = lambda: float(self.element("Level", "[role=meter]").get_attribute("aria-valuenow"))
        seen = set()
        b.wait("a level that moves", lambda: seen.add(round(level())) or len(seen) > 5)
        b.wait("an open valve", lambda: b.find(".kind-valve svg.on"))
        b.wait("flow", lambda: b.find(".kind-pipe svg.runs"))
        self.shot("hmi-demo")
        # The stimulus begins again after its 20 seconds, which end with a full tank.
        b.wait("its end", lambda: self.plant.read("Level") > 90)
        b.wait("its begin", lambda: self.plant.read("Level") < 10)
        b.wait("another batch", lambda: self.plant.read("BatchCount") >= 1 and self.plant.read("Level") < 50)
        self.assertEqual(b.noted(), [])

    def test_it_is_saved_as_it_is(self):
        pages = self.plant.call("/api/pages")
        with open(self.folder + "/pages.toml") as file:
            before = file.read()
        self.plant.call("/api/pages/save", {"version": pages["version"], "pages": pages["pages"], "comment": pages["comment"]})
        with open(self.folder + "/pages.toml") as file:
            self.assertEqual(file.read(), before)


if __name__ == "__main__":
    main()
