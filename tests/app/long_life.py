#!/usr/bin/env python3
"""long_life.py PROGRAM (serve | batch) SECONDS FOLDER [--device D] [--seed S]: commands that live long.

`serve` is visited by pages that come, give random orders and go; `batch` renders a set that does not end in this time.
The log has a line with what the process holds for every 5 seconds, and the last line names what grew: in `batch`, the
list of finished frames may.
"""

import argparse
import base64
import json
import os
import random
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "python"))

from footprint import check, footprint

PAGES = 3
INTERVAL = 5  # seconds between two footprints


class Page:
    """A connection to the server that sends texts and receives pictures, by RFC 6455."""

    def __init__(self, address):
        host, token = address.removeprefix("http://").strip("/").split("/")
        name, port = host.split(":")
        self.socket = socket.create_connection((name, int(port)), timeout=120)
        self.buffer = b""
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(
            f"GET /{token}/socket HTTP/1.1\r\nHost: {host}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
            f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n\r\n".encode()
        )
        while b"\r\n\r\n" not in self.buffer:
            self.receive()
        header, self.buffer = self.buffer.split(b"\r\n\r\n", 1)
        if b" 101 " not in header:
            raise ConnectionError(header.split(b"\r\n")[0].decode())

    def receive(self):
        got = self.socket.recv(1 << 16)
        if not got:
            raise ConnectionError("the server closed the connection")
        self.buffer += got

    def read(self, count):
        while len(self.buffer) < count:
            self.receive()
        bytes, self.buffer = self.buffer[:count], self.buffer[count:]
        return bytes

    def send(self, opcode, payload):
        size = bytes([0x80 | len(payload)]) if len(payload) < 126 else b"\xfe" + struct.pack(">H", len(payload))
        self.socket.sendall(bytes([0x80 | opcode]) + size + bytes(4) + payload)  # the mask is 0

    def say(self, **message):
        self.send(1, json.dumps(message).encode())

    def hear(self):
        """Returns the header of the next message, which it acknowledges."""
        while True:
            opcode, size = self.read(2)
            size &= 0x7F
            if size >= 126:
                size = int.from_bytes(self.read(2 if size == 126 else 8), "big")
            payload = self.read(size)
            if opcode & 15 == 9:
                self.send(10, payload)
            elif opcode & 15 == 8:
                raise ConnectionError(payload[2:].decode())
            elif opcode & 15 in (1, 2):
                header = json.loads(payload[4 : 4 + int.from_bytes(payload[:4], "little")])
                self.say(type="shown", number=header["number"])
                return header


def random_order(r, options):
    number = r.randrange
    option, names = r.choice(options)
    return r.choice(
        (
            dict(type="move", x=number(128), y=number(96)),
            dict(type="move", x=number(128), y=number(96)),
            dict(type="button", button=r.choice(("left", "middle", "right")), down=r.random() < 0.5),
            dict(type="wheel", steps=number(7) - 3),
            dict(type="key", name=r.choice(("ArrowLeft", "Home", "o", "w", "1", "p", "Escape")), down=r.random() < 0.5),
            dict(type="option", name=option, value=r.choice([*names, "", "0", "1", "x"]), side=r.choice(("left", "right"))),
            dict(type="output", name=r.choice(("picture", "depth", "normal", "id", "nothing")), side="left"),
            dict(type="split", mode=r.choice(("off", "slider", "difference")), at=r.random(), amplification=4),
            dict(type="environment", name=r.choice(("studio", "none"))),
            dict(type="resize", width=16 + number(113), height=16 + number(113)),
            dict(type="lights", on=r.random() < 0.5),
            dict(type="nudgeLight", light=0, dx=number(90), dy=number(60)),
            dict(type="screenshot"),
            dict(type="reload"),
        )
    )


def visit(address, seed, options, until, counts):
    """Pages one after another. Each ends without a message, as closed windows do."""
    r = random.Random(seed)
    while time.monotonic() < until:
        try:
            page = Page(address)
            page.hear()
            for _ in range(r.randint(1, 40)):
                page.say(**random_order(r, options))
                counts["orders"] += 1
            page.say(type="resize", width=64, height=48)
            page.socket.settimeout(1)
            for _ in range(r.randint(0, 6)):
                page.hear()
        except TimeoutError:  # all pictures were sent, or options contradict the scene and there is none
            pass
        except ConnectionError as error:
            counts[str(error)[:60]] = counts.get(str(error)[:60], 0) + 1
            continue
        page.socket.close()
        counts["sessions"] += 1


def watch(process, until, log, done):
    """Returns the footprints of the process until then."""
    footprints = []
    while time.monotonic() < until:
        time.sleep(INTERVAL)
        if process.poll() is not None:
            raise ChildProcessError(f"the command ended early, with code {process.returncode}")
        footprints.append(footprint(process.pid))
        print(f"{done()}: {footprints[-1]}", file=log, flush=True)
    return footprints


def serve(a, until, log):
    server = subprocess.Popen(
        [a.program, "serve", "builtin:boxes", "--port", "0", "--device", a.device, "--quiet"],
        stdout=subprocess.PIPE,
        text=True,
    )
    address = next(line.strip() for line in server.stdout if "http://" in line)
    listed = json.loads(subprocess.check_output([a.program, "list", "options", "--json"], text=True))["options"]
    options = [(option["name"].removeprefix("--"), option.get("names", [])) for option in listed]
    counts = [{"orders": 0, "sessions": 0} for _ in range(PAGES)]
    threads = [
        threading.Thread(target=visit, args=(address, a.seed * PAGES + i, options, until, counts[i])) for i in range(PAGES)
    ]
    for thread in threads:
        thread.start()
    done = lambda: f"{sum(c['orders'] for c in counts):,} orders, {sum(c['sessions'] for c in counts):,} sessions"
    footprints = watch(server, until, log, done)
    for thread in threads:
        thread.join()
    print(*counts, sep="\n", file=log)
    server.send_signal(signal.SIGTERM)
    return footprints, server.wait(60)


def batch(a, until, log):
    a.folder.mkdir(parents=True)
    job = {
        "scenes": ["builtin:boxes", "builtin:spheres"],
        "output": str(a.folder / "set"),
        "repeat": 1_000_000,
        "seed": a.seed,
        "formats": [{"format": "files", "outputs": ["color", "depth", "id"]}],
        "options": {"size": "64x48"},
        "variations": [
            {"type": "materials", "baseColor": [[0, 0, 0], [1, 1, 1]], "roughness": [0.2, 0.9]},
            {"type": "environments", "environments": ["studio", "none"], "rotation": [0, 360]},
        ],
    }
    (a.folder / "job.json").write_text(json.dumps(job))
    process = subprocess.Popen([a.program, "batch", a.folder / "job.json", f"--devices={a.device}", "--quiet"])
    frames = lambda: f"{len(os.listdir(a.folder / 'set')) // 4 if (a.folder / 'set').exists() else 0:,} frames"
    footprints = watch(process, until, log, frames)
    process.send_signal(signal.SIGTERM)
    return footprints, process.wait(60)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("command", choices=("serve", "batch"))
    parser.add_argument("seconds", type=float)
    parser.add_argument("folder", type=Path, help="for what is written, and the log")
    parser.add_argument("--device", default="auto")
    parser.add_argument("--seed", type=int, default=0)
    a = parser.parse_args()
    with open(f"{a.folder}.log", "w") as log:
        footprints, code = {"serve": serve, "batch": batch}[a.command](a, time.monotonic() + a.seconds, log)
        wrong = list(check(footprints[len(footprints) // 5 :], 0))
        print(f"exit code {code}", "\n".join(wrong) or "nothing grew", sep="\n", file=log)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
