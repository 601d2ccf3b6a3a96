"""Client of PICARD's engineering server.

    import picard

    with picard.Plc("http://127.0.0.1:8061") as plc:
        plc.token = plc.login("anna", "correct horse battery", token=True)["token"]
        plc.values_write([{"path": "Setpoint", "value": 21.5}])
        for changed in plc.values_stream(["Level", "Main.Valve"], period_ms=50):
            print(changed)

Each call of the server is a method; docs/reference/engineering.md describes them. calls.py is made from the same rows as
the server.
"""

from picard.calls import Calls
from picard.connection import CertificateError, Log, NoServerError, PicardError, Values

__all__ = ["CertificateError", "Log", "NoServerError", "PicardError", "Plc", "Values"]


class Plc(Calls):
    """A running PLC."""

    def values_stream(self, paths, period_ms=None):
        """Values as they change: an iterator of dicts. Its own connection; close() ends it."""
        return Values(self.stream("/api/values/stream", {"period_ms": period_ms}), paths)

    def log_stream(self, after=None, least=None):
        """Messages of the log as they come: an iterator of dicts. Its own connection; close() ends it."""
        return Log(self.stream("/api/log/stream", {"after": after, "least": least}))
