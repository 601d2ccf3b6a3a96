"""The pages of plc-run in a real browser: login, each page, keyboard, hostile projects (cases.py)."""

import gzip
import re
import shutil
import tempfile
import time
from datetime import datetime

import hostile
from cases import ADMIN, CHECKS, ENGINEER, OPERATOR, PAGES, PLC_RUN, SIZES, TANK, VIEWER, By, Keys, Plant, WithBrowser, main


class FirstUser(WithBrowser):
    """From a plant without users to somebody who is logged in."""

    def setUp(self):
        self.plant = Plant(PLC_RUN, TANK + "/tank.xml")
        self.addCleanup(self.plant.remove)

    def test_is_made_with_the_code_and_logs_in(self):
        b = self.browser
        b.open(self.plant.url)
        b.wait_for_text("Make the first user")
        self.shot("first-user")
        b.enter("Code", "AAAA-AAAA-AAAA")
        b.enter("User", ADMIN[0])
        b.enter("Password, at least 10 characters", ADMIN[1])
        b.button("Make this user and log in").click()
        b.wait_for_text("plc explain P7719")
        b.enter("Code", self.plant.code)
        b.button("Make this user and log in").click()
        b.one("nav a[aria-current=page]")
        b.button("Log out").click()
        b.wait("login", lambda: b.find("main.alone form"))
        b.enter("User", ADMIN[0])
        b.enter("Password", "wrong horse battery")
        b.press(Keys.ENTER)
        b.wait_for_text("plc explain P7712")
        self.assertEqual(b.find("[role=alert] .problem")[0].text.split("\n")[0], "wrong user or password")
        b.enter("Password", ADMIN[1])
        b.press(Keys.ENTER)
        b.one("header")
        self.assert_nothing_noted()
        # The plant goes, and comes back no more.
        self.plant.stop()
        b.wait_for_text("No connection to the PLC")
        self.shot("no-connection")


class OtherMachines(WithBrowser):
    def test_what_goes_there_is_noted(self):
        self.browser.driver.get("http://elsewhere.invalid/a")
        self.assertIn("GET http://elsewhere.invalid/a", self.browser.outside.asked)


class Tank(WithBrowser):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.plant = Plant(PLC_RUN, TANK + "/tank.xml", "--stimulus", TANK + "/stimulus.csv")
        cls.addClassCleanup(cls.plant.remove)
        cls.plant.make_first_user()
        for (user, password), role in ((VIEWER, "viewer"), (OPERATOR, "operator"), (ENGINEER, "engineer")):
            cls.plant.call("/api/users/add", {"user": user, "password": password, "role": role})

    def setUp(self):
        self.browser.size(1280, 800)

    def test_files_come_with_their_headers(self):
        with self.plant.page("/") as answer:
            headers = answer.headers
            text = gzip.decompress(answer.read()).decode()
        self.assertEqual(headers["Content-Security-Policy"].split(";")[0], "default-src 'self'")
        self.assertEqual((headers["X-Content-Type-Options"], headers["Referrer-Policy"]), ("nosniff", "no-referrer"))
        self.assertNotIn("http", text.replace("http-equiv", ""))
        script = re.search(r'src="(/app-[0-9a-f]+\.js)"', text).group(1)
        with self.plant.page(script) as answer:
            self.assertIn("immutable", answer.headers["Cache-Control"])
            self.assertLess(len(answer.read()), 100_000)
        with self.plant.page("/licences.txt") as answer:
            self.assertIn("Jason Miller", gzip.decompress(answer.read()).decode())

    def test_each_page_at_each_size_in_each_colour(self):
        b = self.browser
        b.login(self.plant.url, *ADMIN)
        b.run("localStorage.setItem('picard.watch', JSON.stringify(['Level', 'Running']));"
              "localStorage.setItem('picard.trends', JSON.stringify(['Level', 'Temperature', 'BatchCount']))")
        for theme in ("light", "dark"):
            b.run("localStorage.setItem('picard.theme', JSON.stringify(arguments[0]))", theme)
            b.open(self.plant.url)
            b.one("header")
            for size, (width, height) in SIZES.items():
                b.size(width, height)
                for page in PAGES:
                    with self.subTest(page=page, size=size, theme=theme):
                        b.go(page)
                        b.wait("what is loaded", lambda: "Loading" not in b.text())
                        if page == "panel":
                            b.wait("values", lambda: "…" not in b.one("main").text)
                        if page == "diagrams":
                            b.wait("power", lambda: b.find(".sheet .tile .wire.on"))
                        if page == "variables":
                            b.wait("values", lambda: b.value("Running") in ("TRUE", "FALSE"))
                        if page == "trends":
                            b.one(".chart canvas")
                            time.sleep(1)
                        self.shot(f"{page}-{size}-{theme}")
                        self.assertEqual(b.run(CHECKS), [])
        self.assert_nothing_noted()
        b.run("localStorage.clear()")

    def test_320_pixels_are_enough(self):
        b = self.browser
        b.login(self.plant.url, *ADMIN)
        b.size(320, 640)
        for page in PAGES:
            with self.subTest(page=page):
                b.go(page)
                b.wait("what is loaded", lambda: "Loading" not in b.text())
                self.assertEqual(b.run(CHECKS), [])

    def test_everything_has_a_name_for_screen_readers(self):
        b = self.browser
        b.login(self.plant.url, *ADMIN)
        roles = {"button", "link", "textbox", "searchbox", "combobox", "checkbox", "tree", "treeitem", "table", "region", "image"}
        for page in PAGES:
            b.go(page)
            b.wait("what is loaded", lambda: "Loading" not in b.text())
            nodes = b.driver.execute_cdp_cmd("Accessibility.getFullAXTree", {})["nodes"]
            nameless = [node for node in nodes if not node["ignored"] and node["role"]["value"] in roles
                        and not node.get("name", {}).get("value")]
            self.assertEqual(nameless, [], page)
            self.assertTrue([n for n in nodes if n["role"]["value"] == "main"], page)

    def test_values_are_those_of_the_api(self):
        b = self.browser
        b.login(self.plant.url, *OPERATOR)
        b.go("variables")
        for raw in (1234, 4321):
            self.plant.call("/api/values/write", {"values": [{"path": "BatchCount", "value": raw}]})
            b.wait(f"BatchCount = {raw}", lambda: b.value("BatchCount") == str(self.plant.read("BatchCount")))
        # A number that changes with each scan is what the API says before or after.
        before, shown, after = self.plant.read("Level"), float(b.value("Level")), self.plant.read("Level")
        self.assertLessEqual(min(before, after) - 50, shown)
        self.assertGreaterEqual(max(before, after) + 50, shown)

    def test_a_keyboard_is_enough(self):
        b = self.browser
        b.login(self.plant.url, *ENGINEER)
        b.go("variables")
        b.value("BatchCount")
        b.run("document.activeElement.blur()")
        for _ in range(30):
            b.press(Keys.TAB)
            if b.run("return document.activeElement.getAttribute('role')") == "tree":
                break
        self.assertEqual(b.run("return document.activeElement.getAttribute('role')"), "tree")
        b.press(Keys.HOME)
        for _ in range(200):
            active = b.run("return document.querySelector('.rows .row.active')?.dataset.path")
            if active == "BatchCount":
                break
            b.press(Keys.ARROW_DOWN)
        self.assertEqual(active, "BatchCount")
        b.press("w")
        b.wait("watch list", lambda: b.find(".watched") and "BatchCount" in b.find(".watched")[0].text)
        b.press(Keys.ENTER)
        b.one("dialog[open]")
        b.wait("field", lambda: b.run("return document.activeElement.tagName") == "INPUT")
        self.shot("write")
        b.press("no number", Keys.ENTER)
        b.wait_for_text("This is no whole number")
        b.press(Keys.CONTROL + "a", "16#4D2", Keys.ENTER)
        b.wait("dialog closed", lambda: not b.find("dialog[open]"))
        b.wait_for_text("BatchCount is written")
        b.wait("focus is back", lambda: b.run("return document.activeElement.getAttribute('role')") == "tree")
        b.press("w")
        b.wait("no watch list", lambda: not b.find(".watched"))
        record = self.plant.call("/api/audit?most=5")["records"][-1]
        self.assertEqual((record["user"], record["details"]["values"][0]["value"]), (ENGINEER[0], 1234))

    def test_a_viewer_sees_and_does_not_write(self):
        b = self.browser
        b.login(self.plant.url, *VIEWER)
        self.assertNotIn("Users", [a.text for a in b.find("nav a")])
        b.go("variables")
        b.row("BatchCount").click()
        b.button("Watch")
        self.assertEqual([one.text for one in b.find("button") if one.text.startswith("Write")], [])
        b.row("BatchCount").click()
        b.find("[role=tree]")[0].send_keys(Keys.ENTER)
        self.assertEqual(b.find("dialog[open]"), [])
        b.run("location.hash = '#/users'")
        b.wait_for_text("This page is for the role Admin")
        b.run("location.hash = '#/nowhere'")
        b.wait_for_text("There is no such page")

    def test_a_variable_is_forced_and_released(self):
        b = self.browser
        b.login(self.plant.url, *ADMIN)
        b.go("variables")
        b.row("BatchCount").click()
        b.button("Force …").click()
        b.enter("Value", "4711")
        b.enter("Reason", "<i>valve</i> is being changed")
        b.labelled("Ends by itself after").send_keys("8 h")
        self.shot("force")
        b.button("Force").click()
        b.wait("the force", lambda: self.plant.call("/api/forces")["forces"])
        force = self.plant.call("/api/forces")["forces"][0]
        self.assertEqual((force["path"], force["value"], force["owner"]), ("BatchCount", "4711", ADMIN[0]))
        self.assertIn("until", force)
        b.wait("its value", lambda: b.value("BatchCount") == "4711")
        b.wait("its mark", lambda: "forced" in b.row("BatchCount").text)
        b.wait_for_text("Forced by anna: <i>valve</i> is being changed")
        b.go("overview")
        b.wait_for_text("Forced variables")
        row = b.wait("its row", lambda: [r for r in b.find("tbody tr") if r.text.startswith("BatchCount")])[0]
        row.find_element(By.TAG_NAME, "button").click()
        b.wait("no force", lambda: not self.plant.call("/api/forces")["forces"])
        b.wait_for_text("No variable is forced")

    def test_an_alarm_is_acknowledged_and_shelved(self):
        b = self.browser
        b.login(self.plant.url, *OPERATOR)
        self.plant.call("/api/forces/set", {"path": "Temperature", "value": 99.5, "reason": "trial of an alarm"})
        self.addCleanup(self.plant.call, "/api/forces/release", {"path": "Temperature"})

        def alarm():
            return [one for one in self.plant.call("/api/alarms?all=true")["alarms"] if one["name"] == "TempHigh"][0]
        b.wait("the alarm", lambda: alarm()["state"] == "unacked active")
        self.assertIn("scan", alarm())
        # On every page, until somebody has seen it.
        b.wait("the banner", lambda: "Temperature is too high" in b.one(".alarm-banner").text)
        b.go("alarms")
        b.wait("its row", lambda: [r for r in b.find("tbody tr") if "TempHigh" in r.text and "not acknowledged" in r.text])
        self.shot("alarm")
        # On an HMI page, too.
        b.go("panel")
        b.wait("its line", lambda: "Temperature is too high" in b.one(".hmi-alarms").text)
        self.shot("alarm-panel")
        b.wait("its button", lambda: b.find(".hmi-alarms [aria-label='Acknowledge TempHigh']"))
        b.go("alarms")
        b.wait("its button", lambda: b.find("[aria-label='Acknowledge TempHigh']"))[0].click()
        b.enter("Comment", "<i>mixer</i> is being changed")
        b.button("Acknowledge").click()
        b.wait("acknowledged", lambda: alarm()["state"] == "acked active")
        self.assertEqual((alarm()["user"], alarm()["comment"]), (OPERATOR[0], "<i>mixer</i> is being changed"))
        self.assertEqual([r["user"] for r in self.plant.call("/api/audit?most=20")["records"] if r["what"] == "alarms.ack"][-1], OPERATOR[0])
        b.wait("no banner", lambda: "Temperature is too high" not in "".join(one.text for one in b.find(".alarm-banner")))
        b.wait("its button", lambda: b.find("[aria-label='More about TempHigh']"))[0].click()
        b.enter("Reason", "until the mixer is there")
        self.assertEqual([one.text for one in b.find("dialog[open] button") if one.text == "Take out of service"], [])
        b.button("Shelve").click()
        b.wait("shelved", lambda: alarm()["state"] == "shelved")
        b.wait_for_text("TempHigh: Shelved")
        b.wait("its button", lambda: b.find("[aria-label='More about TempHigh']"))[0].click()
        b.button("End the shelf").click()
        b.wait("raised again", lambda: alarm()["state"] == "unacked active")
        self.plant.call("/api/forces/release", {"path": "Temperature"})
        b.wait("returned", lambda: alarm()["state"] == "unacked returned")
        b.button("Acknowledge all …").click()
        b.button("Acknowledge").click()
        b.wait("normal", lambda: alarm()["state"] == "normal")

        def happened():
            return [e["what"] for e in self.plant.call("/api/alarms/history?name=TempHigh")["events"]][::-1]
        b.wait("what happened", lambda: len(happened()) == 7)
        self.assertEqual(happened(), ["raised", "acknowledged", "shelved", "unshelved", "raised", "returned", "acknowledged"])
        b.wait("the history", lambda: "shelf ended" in b.one("main").text)
        self.assert_nothing_noted()

    def test_a_session_that_was_ended_asks_for_a_login(self):
        b = self.browser
        b.login(self.plant.url, *VIEWER)
        b.go("variables")
        b.value("BatchCount")
        for one in self.plant.call("/api/sessions")["sessions"]:
            if one["user"] == VIEWER[0]:
                self.plant.call("/api/sessions/end", {"session": one["session"]})
        b.wait_for_text("The session has ended")

    def test_a_course_is_drawn_and_saved(self):
        b = self.browser
        b.login(self.plant.url, *VIEWER)
        b.go("trends")
        b.wait_for_text("No variable is drawn")
        b.enter("Add a variable", "Level")
        b.press(Keys.ENTER)
        b.one(".chart canvas")
        b.run("""window.saved = []; const made = URL.createObjectURL;
                 URL.createObjectURL = (blob) => { blob.text().then((text) => saved.push(text)); return made(blob); };""")
        value = b.wait("a value", lambda: float(b.find(".table-frame td.number")[0].text) + 1) - 1
        self.assertLess(abs(value - self.plant.read("Level")), 100)
        time.sleep(1)
        # It goes on while another page is shown.
        b.go("log")
        time.sleep(1)
        b.go("trends")
        b.one(".chart canvas")
        b.button("Pause").click()
        b.button("Go on")
        b.button("CSV").click()
        lines = b.wait("CSV", lambda: b.run("return saved[0]")).strip().split("\r\n")
        self.assertEqual(lines[0], '"time","scan","Level"')
        times = [datetime.fromisoformat(line.split(",")[0].replace("Z", "+00:00")) for line in lines[1:]]
        self.assertGreater((times[-1] - times[0]).total_seconds(), 1.5)
        self.assertRegex(lines[1], r"^\d{4}-\d\d-\d\dT[\d:.]+Z,\d+,[-\d.e]+$")
        # Something is drawn in the colour of the course.
        drawn = b.run("""
          const canvas = document.querySelector(".chart canvas");
          const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
          let blue = 0;
          for (let i = 0; i < data.length; i += 4) if (data[i] < 60 && data[i + 2] > 120 && data[i + 3] > 200) ++blue;
          return blue;""")
        self.assertGreater(drawn, 20)
        b.run("localStorage.clear()")

    def test_the_historian_goes_on_with_a_course(self):
        b = self.browser
        b.login(self.plant.url, *VIEWER)
        query = "/api/history?tag=Level&from=0&to=9000000000&points=1000"
        b.wait("what is kept", lambda: len(self.plant.call(query)["points"]) > 20)
        b.go("trends")
        b.enter("Add a variable", "level")  # programs name it in any letter case
        b.press(Keys.ENTER)
        b.one(".chart canvas")
        b.labelled("Shown").send_keys("8 h")
        b.wait_for_text("From the historian")
        b.run("""window.saved = []; const made = URL.createObjectURL;
                 URL.createObjectURL = (blob) => { blob.text().then((text) => saved.push(text)); return made(blob); };""")

        def lines():
            b.button("CSV").click()
            return b.run("return saved[saved.length - 1]").strip().split("\r\n")
        b.wait("its values", lambda: len(lines()) > 1)
        self.shot("trends-past")
        self.assertEqual(lines()[0], '"time","variable","least","mean","greatest"')
        self.assertRegex(lines()[1], r'^\d{4}-\d\d-\d\dT[\d:.]+Z,"level",[-\d.e]+,[-\d.e]+,[-\d.e]+$')
        # Nearer, down to the samples.
        for _ in range(12):
            b.wait("zoom", lambda: b.find("[aria-label='Zoom in']"))[0].click()
        b.wait_for_text("Drag to zoom")
        b.run("localStorage.clear()")
        self.assert_nothing_noted()

    def test_the_overview_tells_of_devices_memory_and_times(self):
        b = self.browser
        b.login(self.plant.url, *VIEWER)
        b.wait("memory", lambda: re.search(r"Memory\s+[\d.]+ MB; ", b.one("main").text))
        machine = self.plant.call("/api/machine")
        self.assertGreater(machine["memory"], 1_000_000)
        self.assertGreater(machine["disk_free"], 0)
        b.wait("histograms", lambda: len(b.find(".histogram svg rect")) > 4)
        for name, bars in [(t["name"], t) for t in self.plant.call("/api/tasks/histograms")["tasks"]]:
            self.assertEqual([bar["up_to_ns"] for bar in bars["scan"]], sorted({bar["up_to_ns"] for bar in bars["scan"]}), name)

    def test_users_are_made_changed_and_removed(self):
        b = self.browser
        b.login(self.plant.url, *ADMIN)
        b.go("users")
        b.button("Add a user").click()
        b.enter("User", "ben")
        b.enter("Password, at least 10 characters", "short")
        b.button("Add").click()
        b.wait_for_text("plc explain P7714")
        b.enter("Password, at least 10 characters", "battery horse staple")
        b.button("Add").click()
        b.wait("ben", lambda: {"user": "ben", "role": "viewer"} in self.plant.call("/api/users")["users"])
        b.wait("the dialog's end", lambda: not b.find("dialog[open]"))
        row = b.wait("row", lambda: [r for r in b.find("tbody tr") if r.text.startswith("ben")])[0]
        row.find_elements(By.TAG_NAME, "button")[1].click()
        b.button("Remove").click()
        b.wait("no ben", lambda: "ben" not in [u["user"] for u in self.plant.call("/api/users")["users"]])
        self.assert_nothing_noted()

    def test_the_log_is_filtered_and_followed(self):
        b = self.browser
        b.login(self.plant.url, *VIEWER)
        b.go("log")
        for record in self.plant.call("/api/log?most=1")["records"]:
            b.wait_for_text(record["message"][:60])
        b.enter("Contains", "there is no such message")
        b.wait_for_text("No message matches")


class Hostile(WithBrowser):
    """A project whose names and values are markup, and large."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.folder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.plant = Plant(PLC_RUN, hostile.write(cls.folder))
        cls.addClassCleanup(cls.plant.remove)
        cls.plant.make_first_user()
        cls.browser.login(cls.plant.url, *ADMIN)

    def setUp(self):
        self.browser.open(self.plant.url)
        self.browser.one("header")

    def test_markup_is_text(self):
        b = self.browser
        b.go("overview")
        b.wait_for_text("<img src=x onerror=alert(3)> &amp; plant")
        b.go("variables")
        b.wait("markup", lambda: b.value("Markup") == hostile.MARKUP.replace("$27", "'"))
        b.row("Markup").click()
        self.assertEqual(b.find("main img, main script"), [])
        self.assert_nothing_noted()

    def test_markup_in_a_drawn_text_is_text(self):
        b = self.browser
        b.go("diagrams")
        b.wait("the text", lambda: "CONCAT(Long, '<b>x')" in b.one(".sheet").text)
        b.wait("values", lambda: [v for v in b.find(".sheet tspan[data-words]") if v.text == "FALSE"])
        self.shot("diagram-text")
        self.assertEqual(b.find("main img, main script, main b"), [])
        self.assert_nothing_noted()

    def test_values_are_shown_as_the_api_tells_them(self):
        b = self.browser
        b.go("variables")
        for path, text in (("Wait", "T#1m30s500ms"), ("Day", "D#2024-02-29"), ("Large", "-9007199254740993"), ("Small", "0.1"), ("Bits", "255")):
            b.wait(path, lambda: b.value(path) == text)
            self.assertEqual(str(self.plant.read(path)), text)
        b.labelled("Numbers").send_keys("hexadecimal")
        b.wait("hexadecimal", lambda: b.value("Bits") == "16#00FF")
        b.wait("hexadecimal", lambda: b.value("Large") == "16#FFDFFFFFFFFFFFFF")
        b.labelled("Numbers").send_keys("decimal")
        b.wait("clipped", lambda: b.value("Choice").startswith("AAAA") and len(b.value("Choice")) < 300)

    def test_a_hundred_thousand_elements_scroll(self):
        b = self.browser
        b.go("variables")
        b.row("Many").click()
        tree = b.find("[role=tree]")[0]
        tree.send_keys(Keys.ARROW_RIGHT)
        b.row("Many[0]")
        for _ in range(3):
            b.run("const t = document.querySelector('[role=tree]'); t.scrollTop = t.scrollHeight / 2")
            b.wait("the middle", lambda: b.find(".rows [data-path^='Many[4'], .rows [data-path^='Many[5']"))
            self.assertLess(len(b.find(".rows .row")), 60)
        self.plant.call("/api/values/write", {"values": [{"path": "Many[99999]", "value": 77}]})
        tree.send_keys(Keys.END)
        # Rows that have just come into view get their names from the server: no key before that.
        active = lambda: b.run("return document.querySelector('.rows .row.active')?.dataset.path")
        b.wait("a row at the end", active)
        for _ in range(40):
            before = active()
            if before == "Many[99999]":
                break
            tree.send_keys(Keys.ARROW_UP)
            b.wait("the row above", lambda: active() not in (None, before))
        b.wait("the last one", lambda: b.value("Many[99999]") == "77")
        tree.send_keys(Keys.ARROW_LEFT)
        b.wait("back", lambda: b.run("return document.querySelector('.rows .row.active')?.dataset.path") == "Many")
        tree.send_keys(Keys.ARROW_LEFT)
        b.wait("folded", lambda: not b.find(".rows [data-path='Many[0]']"))

    def test_ten_megabytes_of_text_do_not_hang_it(self):
        b = self.browser
        b.go("variables")
        text = "<b>" * 10_000
        self.plant.call("/api/values/write", {"values": [{"path": f"Longs[{i}]", "value": text} for i in range(10)]})
        b.row("Longs").click()
        b.find("[role=tree]")[0].send_keys(Keys.ARROW_RIGHT)
        b.wait("text", lambda: b.value("Longs[0]").startswith("<b><b>"))
        self.assertLess(len(b.text()), 20_000)
        begin = time.monotonic()
        b.run("return document.body.getBoundingClientRect().height")
        self.assertLess(time.monotonic() - begin, 5)
        b.find("[role=tree]")[0].send_keys(Keys.ARROW_LEFT)
        self.assertEqual(b.find("main b"), [])

    def test_a_switch_of_the_panel_moves_a_lamp(self):
        b = self.browser
        b.go("panel")
        switch = b.one("[data-path=Push] [role=switch]")
        b.wait("off", lambda: switch.get_attribute("aria-checked") == "false" and switch.is_enabled())
        for state, word in (("true", "Lamp: on"), ("false", "Lamp: off")):
            switch.send_keys(Keys.SPACE)
            b.wait(word, lambda: b.one("[data-path=Lamp] svg").get_attribute("aria-label") == word)
            self.assertEqual(switch.get_attribute("aria-checked"), state)
            self.assertEqual(str(self.plant.read("Push")).lower(), state)
        self.assertEqual(len(b.find(".hmi [data-path]")), 2)
        self.assertEqual(b.find("[data-path=Lamp] [role=switch], [data-path=Count]"), [])

    def test_search_finds_and_says_when_there_is_nothing(self):
        b = self.browser
        b.go("variables")
        b.enter("Search", "Nested*Deep")
        b.wait("found", lambda: b.find("[role=listbox] [data-path='Nested.In.Deep[1]']"))
        b.enter("Search", "<script>")
        b.wait_for_text("No variable matches")
        b.enter("Search", Keys.BACKSPACE)


MANY = 1001
MANY_ALARMS = f"""
VAR_GLOBAL Wrong : ARRAY[1..{MANY}] OF BOOL := [{MANY}(TRUE)]; END_VAR
PROGRAM Main
END_PROGRAM
CONFIGURATION C
  RESOURCE R ON PLC
    TASK T(INTERVAL := T#20ms, PRIORITY := 0);
    PROGRAM main WITH T : Main;
  END_RESOURCE
END_CONFIGURATION
"""


class ManyAlarms(WithBrowser):
    def test_that_not_all_are_shown_is_said(self):
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        with open(folder + "/many.st", "w") as file:
            file.write(MANY_ALARMS)
        with open(folder + "/alarms.toml", "w") as file:
            for i in range(1, MANY + 1):
                file.write(f'[[alarm]]\nvariable = "Wrong[{i}]"\ntext = "wrong {i}"\n')
        plant = Plant(PLC_RUN, folder + "/many.st")
        self.addCleanup(plant.remove)
        plant.make_first_user()
        b = self.browser
        b.login(plant.url, *ADMIN)
        b.go("alarms")
        b.wait_for_text("These are the 1000 that need somebody first")
        self.assert_nothing_noted()


if __name__ == "__main__":
    main()
