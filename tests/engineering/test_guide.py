"""The section "With the demo" of docs/guides/engineering.md: each command of it, with the plant that ./run-demo runs.

usage: test_guide.py PLC PLC_RUN SOURCE_FOLDER
"""

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PLC, PLC_RUN, SOURCE = sys.argv[1:4]
PASSWORD = "correct horse battery"


def demo_words():
    """The command line of plc-run in ./run-demo, with --keep."""
    with open(os.path.join(SOURCE, "run-demo")) as file:
        text = file.read().replace("\\\n", " ")
    line = re.search(r"^exec \S+/plc-run (.*)$", text, re.M).group(1)
    line = line.replace('${duration:+--duration "$duration"}', "").replace('"$@"', "")
    line = line.replace('"${repeat[@]}"', "--repeat")
    return shlex.split(line)


class Guide(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.out = os.path.join(self.folder, "out")
        with open(self.out, "wb") as out:
            self.process = subprocess.Popen(
                [PLC_RUN, *demo_words(), "--modbus", "off", "--engineering", "127.0.0.1:0"],
                stdout=out,
                stderr=subprocess.STDOUT,
                cwd=SOURCE,
                start_new_session=True,
            )
        self.url = self.wait_for(r"engineering: (http://\S+)\n")
        self.code = self.wait_for(r"code of the first one (\S+) ")

    def tearDown(self):
        self.process.send_signal(signal.SIGTERM)
        self.assertEqual(self.process.wait(60), 0)
        shutil.rmtree(self.folder)

    def wait_for(self, pattern):
        for _ in range(600):
            with open(self.out) as file:
                found = re.search(pattern, file.read())
            if found:
                return found.group(1)
            time.sleep(0.1)
        raise AssertionError(f"no {pattern}")

    def run_line(self, line):
        """What the line prints; a line that goes on until Ctrl-C is ended by it after three seconds."""
        environment = dict(
            os.environ,
            URL=self.url,
            PATH=os.path.dirname(PLC) + os.pathsep + os.environ["PATH"],
            XDG_CONFIG_HOME=self.folder,
        )
        process = subprocess.Popen(
            ["sh", "-c", "exec " + line],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env=environment,
            cwd=self.folder,
        )
        follows = "--follow" in line
        try:
            said, _ = process.communicate(PASSWORD + "\n", timeout=3 if follows else 60)
        except subprocess.TimeoutExpired:
            self.assertTrue(follows, line)
            process.send_signal(signal.SIGINT)
            said, _ = process.communicate(timeout=10)
        else:
            self.assertFalse(follows, f"{line} ended by itself: {said}")
            self.assertEqual(process.returncode, 0, f"{line}\n{said}")
        return said

    def test_each_command_does_what_is_said(self):
        with open(os.path.join(SOURCE, "docs/guides/engineering.md")) as file:
            section = re.search(r"^## With the demo\n(.*?)^## ", file.read(), re.M | re.S).group(1)
        lines = re.search(r"```sh\n(.*?)```", section, re.S).group(1).splitlines()
        self.assertTrue(lines.pop(0).startswith("export "))
        said = []
        for line in lines:
            line = line.split("  #")[0].strip()
            line = re.sub(r"first-user \S+ ", f"first-user {self.code} ", line)
            text = self.run_line(line)
            for _ in range(20):  # the task that owns Horn comes every 100 ms; people are slower
                if "values Horn" not in line or "TRUE" in text:
                    break
                text = self.run_line(line)
            said.append((line, text))

        def of(pattern):
            found = [text for line, text in said if re.search(pattern, line)]
            self.assertEqual(len(found), 1, pattern)
            return found[0]

        self.assertIn("as anna, admin", of("first-user"))
        self.assertRegex(of(r"\$URL$"), r"state +runs")
        self.assertRegex(of("tasks"), r"Fast +runs")
        self.assertGreater(of("values .*--follow").count("\nLevel "), 3, "the level changes")
        self.assertIn('"path": "Horn"', of("forces.set"))
        self.assertRegex(of("values Horn"), r"Horn +BOOL +TRUE")
        self.assertIn("who hears it", of("forces.list"))
        self.assertIn('"released": 1', of("forces.release"))
        self.assertRegex(of("log"), r"warning: forced Horn to TRUE by anna: who hears it\n(.*\n)*.*Horn is released by anna")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
