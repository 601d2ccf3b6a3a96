"""What the editor of HMI pages says of mistakes, what has no place in an element, and what comes too late (cases.py)."""

import os
import signal
import time

from cases import ADMIN, CHECKS, OPERATOR, SIZES, Keys, main
from test_hmi import PAGES, TIMES, OwnFolder

# Three in a row: a switch whose variable is not there, between two that are.
CLOSE = """[[page]]
name = "close"

[[page.element]]
kind = "lamp"
x = 0
y = 0
variable = "Pump"

[[page.element]]
kind = "switch"
x = 3
y = 0
variable = "NobodyHasEverHeardOfThisVariable"

[[page.element]]
kind = "switch"
x = 6
y = 0
variable = "Pump"

[[page.element]]
kind = "valve"
x = 9
y = 0
variable = "Main.Nowhere.AtAll"

[[page.element]]
kind = "number"
x = 11
y = 0
variable = "Main.Nowhere.AtAll"

[[page.element]]
kind = "link"
x = 15
y = 0
label = "To where all the others are"
page = "close"
"""
# Parts of elements that are not inside of them.
STICKS_OUT = """
const wrong = [];
for (const element of document.querySelectorAll(".hmi-element")) {
  const box = element.getBoundingClientRect();
  for (const part of element.querySelectorAll("button, a, input, .hmi-label, .hmi-word, .hmi-value, .hmi-lamp")) {
    const at = part.getBoundingClientRect();
    const by = Math.max(box.left - at.left, at.right - box.right, box.top - at.top, at.bottom - box.bottom);
    if (at.width > 0 && by > 1) wrong.push(`${by.toFixed(1)} px: ${part.outerHTML.slice(0, 120)}`);
  }
}
return wrong;
"""
# Buttons whose text is wider than they are.
RUNS_OUT = """
return [...document.querySelectorAll("button, a.button")].filter((one) => one.scrollWidth > one.clientWidth).map((one) => one.textContent);
"""


class Times(OwnFolder):
    pages = TIMES

    def refused(self, label):
        return self.browser.labelled(label).get_attribute("aria-invalid") == "true"

    def entered(self, label, text):
        """What an entry has after this text was entered."""
        self.browser.enter(label, text)
        self.browser.press(Keys.TAB)
        return self.browser.labelled(label).get_attribute("value")

    def test_limits_of_times_are_seconds_or_durations(self):
        b = self.browser
        b.login(self.plant.url, *ADMIN)
        b.go("panel")
        b.button("Edit").click()
        b.one(".hmi-grid [data-kind=slider]").click()
        b.wait_for_text("In seconds: 120, or T#2m")
        self.assertEqual(self.entered("High", "T#2m"), "120")
        self.assertEqual(self.entered("Low", "1m30s500ms"), "90.5")
        self.assertEqual(self.entered("Step", "T#1,5s"), "1.5")
        self.assertEqual(self.entered("Step", "0,5"), "0.5")
        for wrong in ("T#2x", "2m1h", "1m3", "T#", "soon", "9" * 400 + "s"):
            self.assertEqual(self.entered("High", wrong), wrong, "it stays, and is not cut")
            shown = wrong if len(wrong) <= 40 else wrong[:40] + "…"
            b.wait_for_text(f"{shown} is no number, and no duration like T#2m")
            self.assertTrue(self.refused("High"))
        self.shot("hmi-refused-1280x800")
        self.assertEqual(b.run(CHECKS), [])
        b.button("Save").click()
        b.wait_for_text("pages.toml is saved")
        self.assertIn("low = 90.5\nhigh = 120\nstep = 0.5\n", self.text())
        self.assertEqual(self.entered("High", "200"), "200")
        self.assertFalse(self.refused("High"))
        b.wait("nothing more to say", lambda: "is no number" not in b.text())
        # A number that is none of seconds takes no duration.
        b.one(".hmi-grid [data-path=Large]").click()
        b.wait("its properties", lambda: b.labelled("Format").get_attribute("value") == "0")
        self.assertEqual(self.entered("High", "T#2m"), "T#2m")
        b.wait_for_text("T#2m is no number")
        self.assertNotIn("In seconds", b.text())
        # What was refused stays with its element.
        b.one(".hmi-grid [data-kind=slider]").click()
        b.wait("its own limit", lambda: b.labelled("High").get_attribute("value") == "200")
        b.one(".hmi-grid [data-path=Large]").click()
        b.wait("its own properties", lambda: b.labelled("Format").get_attribute("value") == "0")
        self.assertNotEqual(b.labelled("High").get_attribute("value"), "T#2m")
        self.assertEqual(self.entered("High", "9007199254740993"), "9007199254740993", "it is not rounded")
        b.wait_for_text("9007199254740993 is too large: whole numbers are exact up to 9007199254740991")
        self.assertEqual(self.entered("High", "1000"), "1000")
        b.button("Save").click()
        b.wait("saved", lambda: "high = 1000\n" in self.text())


class Mistakes(OwnFolder):
    pages = PAGES

    def test_a_refused_save_names_the_element_and_goes_there(self):
        b = self.browser
        b.login(self.plant.url, *ADMIN)
        b.go("panel")
        b.button("Edit").click()
        b.one(".hmi-grid [data-kind=number]").click()
        b.enter("High", "5")
        b.button("more").click()
        b.wait("the other page", lambda: b.find(".hmi-grid [data-kind=text]"))
        b.button("Save").click()
        b.wait_for_text("Number Wanted (column 12, row 1), High: high is 5, and should be more than low, 10")
        b.wait_for_text("plc explain P7772")
        chosen = b.one(".hmi-grid .selected")
        self.assertEqual(chosen.get_attribute("data-kind"), "number")
        b.wait("its focus", lambda: b.driver.switch_to.active_element == chosen)
        self.assertEqual(b.labelled("High").get_attribute("value"), "5")
        b.enter("High", "50")
        b.button("Save").click()
        b.wait_for_text("pages.toml is saved")
        # One that has no name is found by its place; on a narrow screen it is scrolled to.
        b.size(390, 844)
        b.one(".hmi-palette [data-kind=picture]").send_keys(Keys.ENTER)
        b.enter("Column", "19")
        b.enter("Row", "11")
        b.run("scrollTo(0, 0)")
        b.button("Save").click()
        b.wait_for_text("Picture (column 19, row 11), File: ")
        b.wait("it in view", lambda: b.run("""
          const box = document.querySelector(".hmi-grid .selected").getBoundingClientRect();
          return box.left >= 0 && box.right <= innerWidth && box.top >= 0 && box.bottom <= innerHeight;"""))
        b.size(1280, 800)

    def test_a_mistake_of_a_page_names_the_page(self):
        b = self.browser
        b.login(self.plant.url, *ADMIN)
        b.go("panel")
        b.button("Edit").click()
        b.button("Add a page").click()
        b.enter("Title", "Second")
        b.enter("Name, for links", "no name")
        b.button("Save").click()
        b.wait_for_text("Page Second: \"no name\" is no name of a page")

    def test_why_nothing_can_be_edited_is_seen(self):
        b = self.browser
        b.login(self.plant.url, *ADMIN)
        self.write("pages.toml", PAGES.replace('kind = "lamp"', 'kind = "lmap"'))
        b.go("panel")
        b.wait_for_text("Cannot be edited: pages.toml has mistakes, mend them first")
        self.assertFalse(b.button("Edit").is_enabled())
        for size, (width, height) in SIZES.items():
            b.size(width, height)
            self.shot(f"hmi-not-edited-{size}")
            self.assertEqual(b.run(CHECKS), [])
        b.size(1280, 800)
        self.write("pages.toml", PAGES)
        b.wait("mended", lambda: b.button("Edit").is_enabled() and "Cannot be edited" not in b.text())


class Places(OwnFolder):
    pages = CLOSE

    def test_what_is_too_long_stays_in_its_element(self):
        b = self.browser
        b.login(self.plant.url, *ADMIN)
        for size, (width, height) in SIZES.items():
            b.size(width, height)
            b.open(self.plant.url, "#/panel")
            switch = b.wait("the reason", lambda: [one for one in b.find(".hmi .switch") if "NobodyHasEver" in (one.get_attribute("title") or "")])[0]
            self.assertIn("NobodyHasEverHeardOfThisVariable", switch.get_attribute("title"))
            b.wait("values", lambda: "off" in self.element("Pump").text)
            self.assertEqual(b.run(STICKS_OUT), [], size)
            self.assertEqual(b.run(CHECKS), [])
            self.shot(f"hmi-close-{size}")
            b.button("Edit").click()
            b.wait("values", lambda: "off" in self.element("Pump").text)
            self.assertEqual(b.run(STICKS_OUT), [], size)
            self.assertEqual(b.run(RUNS_OUT), [], size)
            b.one(".hmi-palette [data-kind=slider]").send_keys(Keys.ENTER)
            b.enter("Variable", "Setpoint")
            self.assertEqual(b.run(STICKS_OUT), [], size)
            self.shot(f"hmi-close-editor-{size}")
            b.button("Close").click()
            b.button("Leave").click()
        b.size(1280, 800)

    def test_the_first_page_has_place_for_its_names(self):
        b = self.browser
        b.login(self.plant.url, *ADMIN)
        os.remove(self.file)
        for size, (width, height) in SIZES.items():
            b.size(width, height)
            b.open(self.plant.url, "#/panel")
            b.button("Edit").click()
            b.wait("values", lambda: "…" not in b.one(".hmi-grid").text)
            self.assertEqual(b.run(STICKS_OUT), [], size)
            b.button("Close").click()
        b.size(1280, 800)


class Late(OwnFolder):
    pages = PAGES

    def test_a_tap_over_a_dead_line_writes_nothing_later(self):
        b = self.browser
        b.login(self.plant.url, *OPERATOR)
        b.go("panel")
        switch = self.element("Pump", "[role=switch]:enabled")
        b.wait("values", lambda: "…" not in self.element("Pump").text)
        # As a cable that is pulled: nothing comes, and no connection ends. (The program stands still, too.)
        os.killpg(self.plant.process.pid, signal.SIGSTOP)
        try:
            switch.click()
            time.sleep(3)
        finally:
            os.killpg(self.plant.process.pid, signal.SIGCONT)
        b.wait_for_text("The connection stood still: nothing was written")
        self.assertIs(self.plant.read("Pump"), False)
        self.assertNotIn("values.write", [one["what"] for one in self.plant.call("/api/audit?most=20")["records"]])
        b.wait("it is live again", lambda: not b.find(".shell.stale"))
        self.element("Pump", "[role=switch]:enabled").click()
        b.wait("the pump", lambda: self.plant.read("Pump") is True)


if __name__ == "__main__":
    main()
