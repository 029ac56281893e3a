// SPDX-License-Identifier: Apache-2.0
// A small project and a server of it, for tests of the page in a browser.
import { execFileSync, spawn } from "node:child_process";
import { existsSync, mkdirSync, rmSync } from "node:fs";
import { join } from "node:path";

/** Six small photographs of a made-up village with control and check points, up to the report: seconds of work. */
export function makeProject(program, folder) {
  const survey = join(folder, "survey");
  const project = join(folder, "village");
  rmSync(survey, { recursive: true, force: true });
  rmSync(project, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  const run = (...args) => execFileSync(program, args, { stdio: ["ignore", "ignore", "inherit"] });
  run("simulate", survey, "--strips", "2", "--images-per-strip", "3", "--cross-strips", "0", "--width-px", "640", "--height-px", "480",
    "--gsd-m", "0.16", "--control-points", "4", "--check-points", "3");
  run("run", join(survey, "images"), "-o", project, "--control", join(survey, "control.csv"), "--cloud", "copc", "--progress", "none");
  return project;
}

/** A server at a port that is free: its link, and how to end it. */
export async function serve(program, project, port = 0) {
  const server = spawn(program, ["serve", project, "--port", String(port), "--progress", "none"], { stdio: ["ignore", "pipe", "pipe"] });
  process.once("exit", () => server.kill());
  const ended = new Promise((resolve) => server.once("exit", resolve));
  const link = await new Promise((resolve, reject) => {
    let said = "";
    const look = (bytes) => {
      said += bytes;
      const found = /http:\/\/[^\s]+token=[0-9a-f]+/.exec(said);
      if (found) resolve(found[0]);
    };
    server.stdout.on("data", look);
    server.stderr.on("data", look);
    void ended.then((status) => reject(new Error(`the server ended with ${status}: ${said}`)));
  });
  return {
    link,
    base: new URL(link).origin,
    end: () => {
      server.kill("SIGTERM");
      return ended;
    },
  };
}

/** Where a browser is; nothing where there is none. */
export const browserAt = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"].find((path) => existsSync(path));

/** A browser that reaches this machine alone, and draws in 3D by its processor. */
export async function startBrowser(chromium) {
  return await chromium.launch({
    executablePath: browserAt,
    args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-gpu-compositing", "--disable-background-networking", "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"],
  });
}
