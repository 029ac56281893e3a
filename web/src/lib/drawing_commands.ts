// SPDX-License-Identifier: Apache-2.0
// Commands of the journal that draw, as docs/manual/edit.md lists them.
import type { FeatureKind, Vertex } from "./drawing_types";

/** The shortest text that reads as the same number. */
const exact = (value: number): string => String(value);

export function vertexWords(vertex: Vertex): string[] {
  const words = [vertex.source, ...vertex.position.map(exact)];
  if (vertex.covariance_m2) words.push("cov", ...vertex.covariance_m2.map(exact));
  for (const mark of vertex.marks) words.push("mark", mark.file, ...mark.pixel.map(exact), exact(mark.sigma_px));
  return words;
}

/** `id` "*": a new feature, which the program gives its id. Attributes that are not named stay. */
export const drawCommand = (id: string, layer: string, kind: FeatureKind, vertices: Vertex[], attributes: Record<string, string> = {}): string[] => [
  "draw", id, layer, kind,
  ...Object.entries(attributes).flatMap(([name, value]) => ["with", name, value]),
  ...vertices.flatMap(vertexWords),
];
