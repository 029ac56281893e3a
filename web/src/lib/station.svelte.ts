// SPDX-License-Identifier: Apache-2.0
// What the page knows of the server, followed over its WebSocket: all tabs show the same.
import { SvelteMap } from "svelte/reactivity";

import * as api from "./api";
import { Loaded } from "./loaded.svelte";
import { route } from "./route.svelte";
import type { Changes, Job, LogLine, OptionGroup, Project, ProjectName } from "./types";

const mostLines = 5000;
const retryMs = 2000;

export const isOver = (job: Job): boolean => job.state !== "queued" && job.state !== "running";

class Station {
  projects = $state.raw<ProjectName[]>([]);
  options = $state.raw<OptionGroup[]>([]);
  started = $state(false);
  /** Why nothing is there, or what was refused last; empty: all is well. */
  complaint = $state("");
  connection = $state<"open" | "closed" | "refused">("closed");
  jobs = new SvelteMap<number, Job>();
  log = $state.raw<LogLine[]>([]);
  /** Number of the last edit of control and marks, by project: views load again when it grows. */
  edits = new SvelteMap<string, number>();
  /** Grows with every job of a project that ends: views load again what steps make. */
  ended = new SvelteMap<string, number>();
  /** Grows with every job of a project that begins or ends: its options may have changed. */
  turns = new SvelteMap<string, number>();
  #project = new Loaded<Project>();
  #board = 0;
  #number = 0;

  /** The one that is looked at. */
  get project(): Loaded<Project> {
    return this.#project;
  }

  jobList = $derived([...this.jobs.values()].sort((a, b) => b.id - a.id));
  running = $derived(this.jobList.find((job) => job.state === "running"));
  waiting = $derived(this.jobList.filter((job) => job.state === "queued"));

  async start(): Promise<void> {
    try {
      [this.projects, this.options] = await Promise.all([api.projects(), api.options()]);
    } catch (error) {
      this.complain(error);
    }
    this.started = true;
    const first = this.projects[0];
    if (first && !this.projects.some((one) => one.id === route.place.project)) route.go(first.id, route.place.view);
    this.#follow();
  }

  /** Loads a project; the one before it is forgotten. */
  async choose(id: string): Promise<void> {
    await this.#project.load(() => api.project(id), this.#project.value?.id !== id);
  }

  async run(project: string, step: string, changes: Parameters<typeof api.run>[2] = {}): Promise<boolean> {
    return await this.#asked(api.run(project, step, changes));
  }

  async stop(job: Job): Promise<boolean> {
    return await this.#asked(api.stop(job.id));
  }

  complain(error: unknown): void {
    this.complaint = api.messageOf(error);
  }

  async #asked(request: Promise<unknown>): Promise<boolean> {
    try {
      await request;
      this.complaint = "";
      return true;
    } catch (error) {
      this.complain(error);
      return false;
    }
  }

  #follow(): void {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/api/events?since=${this.#number}`);
    socket.onopen = () => (this.connection = "open");
    socket.onclose = () => {
      this.connection = "closed";
      setTimeout(() => void this.#followAgain(), retryMs);
    };
    const taken = (changes: Changes): void => {
      if (!this.#take(changes)) socket.close();
    };
    socket.onmessage = (event) => taken(JSON.parse(String(event.data)) as Changes);
  }

  /** A WebSocket does not say why it was refused; an ordinary request does. */
  async #followAgain(): Promise<void> {
    try {
      this.projects = await api.projects();
      this.#follow();
    } catch (error) {
      // Another tab may open the link meanwhile.
      if (error instanceof api.Refused && (error.status === 401 || error.status === 403)) this.connection = "refused";
      setTimeout(() => void this.#followAgain(), retryMs);
    }
  }

  /** False: another server counts from 0, and everything is to be asked for anew. */
  #take(changes: Changes): boolean {
    if (changes.board !== this.#board) {
      const first = this.#board === 0;
      this.#board = changes.board;
      if (!first) {
        this.jobs.clear();
        this.log = [];
        this.#number = 0;
        return false;
      }
    }
    this.#number = changes.number;
    const over = new Set<string>();
    for (const job of changes.jobs) {
      const before = this.jobs.get(job.id);
      if (before?.state !== job.state) this.turns.set(job.project, (this.turns.get(job.project) ?? 0) + 1);
      if (isOver(job) && before && !isOver(before)) over.add(job.project);
      this.jobs.set(job.id, { ...job, received_ms: Date.now() });
    }
    if (changes.log.length) this.log = [...this.log, ...changes.log].slice(-mostLines);
    for (const edit of changes.edits ?? []) this.edits.set(edit.project, edit.number);
    for (const project of over) this.#projectEnded(project);
    return true;
  }

  #projectEnded(project: string): void {
    this.ended.set(project, (this.ended.get(project) ?? 0) + 1);
    if (this.#project.value?.id === project) void this.choose(project);
  }
}

export const station = new Station();
