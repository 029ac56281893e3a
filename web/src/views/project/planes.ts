// SPDX-License-Identifier: Apache-2.0
// Products of the step frames among the files of a project (docs/manual/frames.md).
import type { ProjectFile } from "../../lib/types";

export interface PlaneProducts {
  name: string;
  ortho: ProjectFile | undefined;
  /** The front view at scale, on paper. */
  view: ProjectFile | undefined;
}

/** Planes that have an orthophoto or a front view, by their names. */
export function planesOf(files: readonly ProjectFile[]): PlaneProducts[] {
  const planes = new Map<string, PlaneProducts>();
  for (const file of files) {
    const [, name, what] = /^products\/frames\/([^/]+)\/(ortho\.tif|elevation\.pdf)$/.exec(file.path) ?? [];
    if (!name) continue;
    const plane = planes.get(name) ?? { name, ortho: undefined, view: undefined };
    planes.set(name, what === "ortho.tif" ? { ...plane, ortho: file } : { ...plane, view: file });
  }
  return [...planes.values()].sort((a, b) => a.name.localeCompare(b.name, "en", { numeric: true }));
}
