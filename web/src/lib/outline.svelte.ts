// SPDX-License-Identifier: Apache-2.0
// An outline that is being drawn: of a mask in a photograph, of a patch on the map.
import type { Vector2 } from "./types";

/** The first name of a kind, A1, A2, .., that is not taken. */
export function freeName(kind: string, taken: readonly string[]): string {
  let number = 1;
  while (taken.includes(`${kind}${number}`)) ++number;
  return `${kind}${number}`;
}

export class Outline {
  points = $state.raw<Vector2[]>([]);

  get canFinish(): boolean {
    return this.points.length >= 3;
  }
  add(point: Vector2): void {
    this.points = [...this.points, point];
  }
  back(): void {
    this.points = this.points.slice(0, -1);
  }
  clear(): void {
    this.points = [];
  }
  /** The words of a command, two for each point. */
  words(digits: number): string[] {
    return this.points.flatMap((point) => point.map((value) => value.toFixed(digits)));
  }
}
