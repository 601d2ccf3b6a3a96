"""What tests of pages have in common: the command line, a browser for each class, a second try.

usage: TEST.py PLC_RUN TANK_FOLDER SCREENSHOT_FOLDER [unittest options]

Exit code 77, and why, where there is no Chromium with its driver and Selenium. Screenshots are left in the folder.
"""

import os
import re
import shutil
import sys
import unittest

try:
    import selenium  # noqa: F401
except ImportError:
    print("skipped: python3-selenium is not installed (scripts/install-packages browser)")
    sys.exit(77)
CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
if not CHROMIUM or not DRIVER:
    print("skipped: chromium or chromium-driver is not installed (scripts/install-packages browser)")
    sys.exit(77)

from browser import ADMIN, Browser, By, Keys, Plant  # noqa: E402, F401

PLC_RUN, TANK, SHOTS = sys.argv[1:4]
HERE = os.path.dirname(os.path.abspath(__file__))
SIZES = {"1280x800": (1280, 800), "390x844": (390, 844)}
PAGES = ["overview", "panel", "diagrams", "variables", "trends", "alarms", "log", "users"]
VIEWER, OPERATOR = ("vera", "viewer horse battery"), ("otto", "operator horse battery")
ENGINEER = ("emil", "engineer horse battery")
with open(os.path.join(HERE, "checks.js")) as file:
    CHECKS = file.read()


class WithBrowser(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.browser = Browser(CHROMIUM, DRIVER)
        cls.addClassCleanup(cls.browser.quit)

    def shot(self, name):
        self.browser.driver.save_screenshot(os.path.join(SHOTS, name + ".png"))

    def assert_nothing_noted(self):
        self.assertEqual(self.browser.noted(), [])
        foreign = self.browser.run(
            "return performance.getEntriesByType('resource').map((one) => one.name).filter((name) => !name.startsWith(location.origin))")
        self.assertEqual(foreign, [])
        self.assertEqual(self.browser.outside.asked, [])


def main():
    os.makedirs(SHOTS, exist_ok=True)
    program = unittest.main(module="__main__", argv=[sys.argv[0], "--verbose", *sys.argv[4:]], exit=False)
    failed = {re.search(r"__main__\.([\w.]+)", test.id()).group(1) for test, _ in program.result.failures + program.result.errors}
    if failed:
        # A browser on a busy machine misses a key now and then: wrong is what fails twice.
        print("tried again:", *sorted(failed), flush=True)
        program = unittest.main(module="__main__", argv=[sys.argv[0], "--verbose", *sorted(failed)], exit=False)
    sys.exit(not program.result.wasSuccessful())
