"""A plc-run and a browser that looks at it: what the tests of the pages stand on."""

import json
import os
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import time
import urllib.error
import urllib.parse
import urllib.request
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

__all__ = ["ADMIN", "Browser", "By", "Keys", "Plant"]

ADMIN = ("anna", "correct horse battery")
WAIT_S = 60

# Runs before anything of a page: what it must not do is noted.
WITNESS = """
window.noted = [];
addEventListener("securitypolicyviolation", (e) => noted.push(`policy: ${e.violatedDirective} ${e.blockedURI}`));
addEventListener("error", (e) => noted.push(`error: ${e.message}`));
addEventListener("unhandledrejection", (e) => noted.push(`rejection: ${e.reason}`));
window.alert = (text) => noted.push(`alert: ${text}`);
"""


class Plant:
    """A plc-run with a folder of its own."""

    def __init__(self, plc_run, project, *flags):
        self.folder = tempfile.mkdtemp()
        self.out = os.path.join(self.folder, "out")
        out = open(self.out, "wb")
        self.process = subprocess.Popen(
            [plc_run, project, "--modbus", "off", "--engineering", "127.0.0.1:0", "--state", self.folder + "/state", *flags],
            stdout=out,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        out.close()
        self.url = self.wait_for(r"engineering: (https?://\S+)\n")
        self.code = self.wait_for(r"code of the first one (\S+) ")
        self.token = None

    def text(self):
        with open(self.out, errors="replace") as file:
            return file.read()

    def wait_for(self, pattern):
        for _ in range(20 * WAIT_S):
            found = re.search(pattern, self.text())
            if found:
                return found.group(1)
            if self.process.poll() is not None:
                break
            time.sleep(0.05)
        raise AssertionError(f"no {pattern} in\n{self.text()}")

    def call(self, path, fields=None):
        request = urllib.request.Request(self.url + path)
        if fields is not None:
            request.data = json.dumps(fields).encode()
            request.add_header("Content-Type", "application/json")
        if self.token:
            request.add_header("Authorization", "Bearer " + self.token)
        with urllib.request.urlopen(request, timeout=WAIT_S) as answer:
            return json.load(answer)

    def bytes(self, path, file=None):
        """The answer of a call that gives, or takes, a file."""
        request = urllib.request.Request(self.url + path, data=file, headers={"Authorization": "Bearer " + self.token})
        if file is not None:
            request.add_header("Content-Type", "application/octet-stream")
        with urllib.request.urlopen(request, timeout=WAIT_S) as answer:
            return answer.read()

    def page(self, path):
        request = urllib.request.Request(self.url + path, headers={"Accept-Encoding": "gzip"})
        return urllib.request.urlopen(request, timeout=WAIT_S)

    def make_first_user(self):
        user, password = ADMIN
        self.token = self.call("/api/first-user", {"code": self.code, "user": user, "password": password, "token": True})["token"]

    def read(self, path):
        return self.call("/api/values/read", {"paths": [path]})["values"][0]["value"]

    def stop(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
            self.process.wait(WAIT_S)

    def remove(self):
        self.stop()
        shutil.rmtree(self.folder)


# Chromium's own: time, updates, accounts, passwords. What pages take from others (fonts, scripts, maps) has other names.
ASKED_BY_CHROMIUM = re.compile(r"(accounts|clients\d|update|redirector|www|[a-z-]+-pa|content-autofill|safebrowsing)\.(google|googleapis|gvt1)\.com")


class Outside:
    """A proxy that notes what is asked for, and gives nothing: addresses of this machine do not go through it."""

    def __init__(self):
        asked = self.asked = []

        class Refuse(BaseHTTPRequestHandler):
            def refuse(self):
                host = urllib.parse.urlsplit(self.path if "://" in self.path else "//" + self.path).hostname
                if not ASKED_BY_CHROMIUM.fullmatch(host or ""):
                    asked.append(f"{self.command} {self.path}")
                self.send_error(502)

            do_CONNECT = do_GET = do_HEAD = do_POST = do_PUT = do_OPTIONS = refuse

            def log_message(self, *_):
                pass

        self.server = ThreadingHTTPServer(("127.0.0.1", 0), Refuse)
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def address(self):
        return f"http://127.0.0.1:{self.server.server_port}"

    def close(self):
        self.server.shutdown()
        self.server.server_close()


class Browser:
    """`outside.asked`: whatever the browser asked other machines for."""

    def __init__(self, chromium, driver):
        self.outside = Outside()
        options = webdriver.ChromeOptions()
        options.binary_location = chromium
        # No sandbox: tests run as root, too, in containers that have no name spaces.
        for flag in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars",
                     "--force-device-scale-factor=1", "--no-first-run", "--disable-background-networking",
                     "--disable-component-update", "--disable-sync", "--disable-default-apps",
                     "--disable-features=OptimizationHints,MediaRouter", "--proxy-server=" + self.outside.address()):
            options.add_argument(flag)
        self.driver = webdriver.Chrome(service=Service(driver), options=options)
        self.driver.set_script_timeout(WAIT_S)
        self.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": WITNESS})
        self.size(1280, 800)

    def quit(self):
        self.driver.quit()
        self.outside.close()

    def size(self, width, height):
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                    {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600})

    def run(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def noted(self):
        return self.run("return window.noted")

    def find(self, selector):
        return self.driver.find_elements(By.CSS_SELECTOR, selector)

    def wait(self, what, condition):
        """The first result of the condition that counts as true."""
        until = time.monotonic() + WAIT_S
        while True:
            try:
                found = condition()
                if found:
                    return found
            except Exception as error:  # an element that has gone meanwhile
                if time.monotonic() > until:
                    raise AssertionError(f"{what}: {error}") from error
            if time.monotonic() > until:
                raise AssertionError(f"{what}: not within {WAIT_S} s; the page says\n{self.text()}")
            time.sleep(0.05)

    def one(self, selector):
        return self.wait(selector, lambda: self.find(selector))[0]

    def text(self):
        return self.run("return document.body.innerText")

    def wait_for_text(self, text):
        self.wait(repr(text), lambda: text in self.text())

    def button(self, text):
        """Of this text, in a dialog when there is one."""
        def look():
            inside = self.find("dialog[open]") or self.find("body")
            return [b for b in inside[0].find_elements(By.CSS_SELECTOR, "button, a.button") if b.text.strip() == text and b.is_displayed()]
        return self.wait(f"button {text}", look)[0]

    def labelled(self, label):
        def look():
            return self.run("""
              const inside = document.querySelector("dialog[open]") ?? document;
              const label = [...inside.querySelectorAll("label")].find((one) => one.textContent.trim() === arguments[0]);
              return label === undefined ? null : document.getElementById(label.htmlFor) ?? label.querySelector("input");
            """, label)
        return self.wait(f"field {label}", look)

    def enter(self, label, text):
        field = self.labelled(label)
        field.send_keys(Keys.CONTROL, "a")
        field.send_keys(Keys.DELETE)
        field.send_keys(text)

    def press(self, *keys):
        for key in keys:
            self.driver.switch_to.active_element.send_keys(key)

    def open(self, url, page=""):
        self.driver.get("about:blank")
        self.driver.get(f"{url}/{page}")

    def login(self, url, user, password):
        self.driver.get(url)
        self.driver.delete_all_cookies()
        self.run("localStorage.clear()")
        self.open(url)
        self.enter("User", user)
        self.enter("Password", password)
        self.button("Log in").click()
        self.one("header")

    def go(self, page):
        self.run("location.hash = '#/' + arguments[0]", page)
        self.wait(f"page {page}", lambda: self.find("nav a[aria-current=page]") and self.find("main h1"))

    def row(self, path):
        """The row of a variable in the tree."""
        return self.wait(f"row {path}", lambda: self.run(
            "return [...document.querySelectorAll('.rows [data-path]')].find((row) => row.dataset.path === arguments[0])", path))

    def value(self, path):
        return self.row(path).find_element(By.CSS_SELECTOR, ".row-value").text
