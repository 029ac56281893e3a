#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""serve_kills.py PROGRAM PROJECT [KILLS]: `collinea serve` killed (-9) again and again while edits come in and a job is at work.

PROJECT is copied. Counts the edits that were acknowledged and are missing afterwards (0 are allowed; one that was under way may be there or not), and measures how long
after its start a new server answers with the project. At the end the job runs through, and the products are those of a run that nobody disturbed.
"""

import hashlib
import http.client
import json
import pathlib
import random
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
import time

PRODUCTS = ["cloud.copc.laz", "dsm.tif", "ortho.tif", "ortho_source.tif"]


class Server:
    def __init__(self, program, project):
        self.began = time.monotonic()
        self.process = subprocess.Popen([program, "serve", project, "--port", "0", "--progress", "none"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        for line in self.process.stdout:
            found = re.search(r"http://127\.0\.0\.1:(\d+)(/\?token=\w+)", line)
            if found:
                break
        threading.Thread(target=self.process.stdout.read, daemon=True).start()
        self.port = int(found[1])
        response, _ = self.ask("GET", found[2], cookie="")
        self.cookie = response.getheader("Set-Cookie").split(";")[0]
        self.id = json.loads(self.ask("GET", "/api/projects")[1])[0]["id"]
        self.ask("GET", f"/api/projects/{self.id}")
        self.seconds = time.monotonic() - self.began

    def ask(self, method, path, body=None, cookie=None):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=60)
        headers = {"Cookie": self.cookie if cookie is None else cookie}
        if body is not None:
            body = json.dumps(body)
            headers["Content-Type"] = "application/json"
        connection.request(method, path, body, headers)
        response = connection.getresponse()
        return response, response.read().decode()

    def edit(self, *words):
        response, text = self.ask("POST", f"/api/projects/{self.id}/edits", {"command": list(words)})
        return json.loads(text)["number"] if response.status == 200 else None

    def run(self, step, options=None):
        response, text = self.ask("POST", f"/api/projects/{self.id}/jobs", {"step": step, "options": options or {}})
        if response.status != 202:
            raise RuntimeError(f"the job was refused: {response.status} {text}")

    def kill(self):
        self.process.kill()
        self.process.wait()


def hashes(project):
    return {name: hashlib.sha256((project / "products" / name).read_bytes()).hexdigest() for name in PRODUCTS}


def missed(project, acknowledged):
    """How many of the edits that were acknowledged the journal does not hold."""
    known = {}
    for line in (project / "journal.jsonl").read_text().splitlines() if acknowledged else []:
        try:
            entry = json.loads(line)
        except ValueError:
            continue  # the last line may be broken off
        known[entry["number"]] = entry["command"]
    return sum(known.get(number) != list(words) for number, words in acknowledged.items())


def main():
    program, original = sys.argv[1], pathlib.Path(sys.argv[2])
    kills = int(sys.argv[3]) if len(sys.argv) > 3 else 50
    chance = random.Random(1)
    with tempfile.TemporaryDirectory() as folder:
        project = pathlib.Path(folder) / "project"
        shutil.copytree(original, project)
        before = hashes(project)
        missing, jobs, starts, acknowledged = 0, 0, [], {}
        edits_before = len((project / "journal.jsonl").read_text().splitlines()) if (project / "journal.jsonl").exists() else 0
        for turn in range(kills):
            server = Server(program, project)
            starts.append(server.seconds)
            missing += missed(project, acknowledged)
            if turn % 3 == 0:
                server.run("ortho", {"ortho": {"feather_cells": 10 + turn % 5}})
            elif turn % 3 == 1:
                server.run("report", {"densify": {"min_images": 2 + turn % 2}})
            jobs += turn % 3 < 2
            until = time.monotonic() + chance.uniform(0.05, 2.5)
            timer = threading.Timer(until - time.monotonic(), server.process.kill)
            timer.start()
            number = 0
            while time.monotonic() < until + 1:
                words = ("mask", f"K{turn}_{number}", "*", "1", "1", str(2 + number), "1", "2", "3")
                try:
                    made = server.edit(*words)
                except (OSError, http.client.HTTPException):
                    break
                if made:
                    acknowledged[made] = words  # the server has answered
                number += 1
            timer.cancel()
            server.kill()
        server = Server(program, project)
        starts.append(server.seconds)
        missing += missed(project, acknowledged)
        made = sum(1 for line in (project / "journal.jsonl").read_text().splitlines()) - edits_before
        for _ in range(made):  # those of this run alone
            server.edit("undo")
        server.kill()
        settings = (original / "project.json").read_text()
        (project / "project.json").write_text(settings)
        subprocess.run([program, "report", project, "--progress", "none"], check=True, capture_output=True)
        after = hashes(project)
        print(f"{kills} kills, {jobs} of them with a job at work; {len(acknowledged)} edits acknowledged, {missing} of them missing")
        print(f"start to the project: median {statistics.median(starts):.2f} s, longest {max(starts):.2f} s")
        print("products as before" if after == before else f"products differ: {[n for n in PRODUCTS if after[n] != before[n]]}")
        sys.exit(missing > 0 or after != before)


if __name__ == "__main__":
    main()
