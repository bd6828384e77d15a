"""`cargo xtask drive` as a process, and helpers for its clients. NARX_TERMINAL names the program."""

import os
import signal
import subprocess
from pathlib import Path

import can
import cantools

TERMINAL = os.environ["NARX_TERMINAL"]
ROOT = Path(__file__).parents[2]
DATABASE = cantools.database.load_file(ROOT / "docs" / "narx.dbc", strict=True)

BROADCAST_SECONDS = 0.05
"""Time between two status words (parameter 111)."""


class Drive:
    """The process, and the addresses of its TCP port and its pseudo-terminal."""

    def __init__(self, *arguments):
        command = [TERMINAL, "drive", "--mode", "hall", "--tcp", "127.0.0.1:0", *arguments]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True)
        self.channels = {}
        for line in self.process.stdout:
            door, _, call = line.partition("  ")
            if door in ("tcp", "pty"):
                self.channels[door] = call.split('channel="')[1].split('"')[0]
            if len(self.channels) == 1 + ("--pty" in arguments):
                return
        raise AssertionError(f"it ended with {self.process.wait()}")

    @property
    def address(self):
        host, _, port = self.channels["tcp"].removeprefix("socket://").partition(":")
        return host, int(port)

    def bus(self, door="tcp", **options):
        return can.Bus(interface="slcan", channel=self.channels[door], bitrate=500_000, sleep_after_open=0.0, **options)

    def end(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        code = self.process.wait(timeout=10)
        self.process.stdout.close()
        return code
