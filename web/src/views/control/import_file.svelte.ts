// SPDX-License-Identifier: Apache-2.0
// A control file before it is accepted: its table, where its points lie in the project, and the commands that it becomes.
import proj4 from "proj4";

import { type Bounds, type Fit, fitOf, projOf } from "../../lib/block_fit";
import { assigned, commandsOf, type ControlTable, controlTable, type Field, type FilePoint, pointsOf, swapped } from "../../lib/control_file";
import type { ImageInfo, MapInfo, Vector2 } from "../../lib/types";
import type { Desk } from "./desk.svelte";

const largest = 20e6; // bytes
export type Frame = "project" | "file" | "degrees";

export class FileImport {
  name = $state("");
  table = $state.raw<ControlTable | undefined>();
  /** What the coordinates count from. */
  frame = $state<Frame>("project");
  error = $state<"" | "empty" | "large">("");
  done = $state(0);
  isSending = $state(false);

  constructor(
    readonly desk: Desk,
    readonly info: () => MapInfo | undefined,
  ) {}

  async read(file: File): Promise<void> {
    [this.name, this.table, this.error] = [file.name, undefined, ""];
    if (file.size > largest) return void (this.error = "large");
    this.table = controlTable(textOf(new Uint8Array(await file.arrayBuffer())));
    if (!this.table) this.error = "empty";
    this.frame = this.table?.crs && projOf(this.table.crs) && this.table.crs.toUpperCase() !== this.info()?.crs?.toUpperCase() ? "file" : "project";
  }

  swap(): void {
    if (this.table) this.table = { ...this.table, fields: swapped(this.table.fields) };
  }

  assign(column: number, field: Field): void {
    if (this.table) this.table = { ...this.table, fields: assigned(this.table.fields, column, field) };
  }

  content = $derived(this.table ? pointsOf(this.table) : { points: [], problems: [] });

  /** In the CRS of the project. */
  points = $derived.by<FilePoint[]>(() => {
    const from = this.frame === "project" ? undefined : projOf(this.frame === "degrees" ? "EPSG:4326" : (this.table?.crs ?? ""));
    const to = this.info()?.proj4;
    if (!from || !to) return this.content.points;
    try {
      const convert = proj4(from, to);
      return this.content.points.map((point) => {
        const [e, n, h = null] = point.position;
        if (typeof e !== "number" || typeof n !== "number") return point;
        return { ...point, position: [...convert.forward([e, n]).map((one) => Number(one.toFixed(4))), h] };
      });
    } catch {
      return this.content.points;
    }
  });

  located = $derived(this.points.filter((point) => typeof point.position[0] === "number" && typeof point.position[1] === "number"));
  places = $derived(this.located.map((point) => [point.position[0], point.position[1]] as Vector2));
  fit = $derived.by<Fit | undefined>(() => {
    const bounds = this.info()?.bounds;
    return bounds && this.places.length ? fitOf(this.places, bounds as Bounds) : undefined;
  });
  commands = $derived(commandsOf(this.points, (name) => imageNamed(this.desk.images.value?.images ?? [], name)?.file));
  marks = $derived(this.commands.commands.filter((command) => command[0] === "mark").length);
  replaced = $derived(this.points.filter((point) => this.desk.control.value?.points.some((known) => known.name === point.name)).map((point) => point.name));

  /** False: the server refused one, and those before it are made. */
  async accept(): Promise<boolean> {
    this.isSending = true;
    this.done = 0;
    try {
      for (const command of this.commands.commands) {
        if (!(await this.desk.edit(command, false))) return false;
        ++this.done;
      }
      return true;
    } finally {
      this.isSending = false;
      await this.desk.reload();
    }
  }
}

/** By path or name, in any letter case and without its ending where that names one only. */
export function imageNamed(images: readonly ImageInfo[], name: string): ImageInfo | undefined {
  const path = name.replaceAll("\\", "/");
  const last = path.split("/").at(-1)?.toLowerCase();
  const exact = images.find((image) => image.file === path);
  const nameOf = (image: ImageInfo): string => image.file.split("/").at(-1)?.toLowerCase() ?? "";
  const alike = images.filter((image) => nameOf(image) === last);
  if (exact ?? alike.length) return exact ?? (alike.length === 1 ? alike[0] : undefined);
  const bare = images.filter((image) => nameOf(image).replace(/\.[^.]+$/, "") === last);
  return bare.length === 1 ? bare[0] : undefined;
}

/** UTF-8, UTF-16 with its byte order mark, else Latin-1. */
export function textOf(bytes: Uint8Array): string {
  if (bytes[0] === 0xff && bytes[1] === 0xfe) return new TextDecoder("utf-16le").decode(bytes);
  if (bytes[0] === 0xfe && bytes[1] === 0xff) return new TextDecoder("utf-16be").decode(bytes);
  try {
    return new TextDecoder("utf-8", { fatal: true }).decode(bytes);
  } catch {
    return new TextDecoder("windows-1252").decode(bytes);
  }
}
