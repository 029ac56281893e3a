// SPDX-License-Identifier: Apache-2.0
// A region of the cloud that is being chosen, and the command of the journal that it becomes.
import { drawing } from "../../lib/drawing.svelte";
import type { Overlay } from "./overlays";
import { sum, type Triple } from "./viewpoint";

/** A height as typed: nothing is without end; undefined: no number. */
export function heightOf(text: string): number | null | undefined {
  const trimmed = text.trim().replace("−", "-").replace(",", ".");
  if (!trimmed) return null;
  const value = Number(trimmed);
  return Number.isFinite(value) ? value : undefined;
}

export class RegionDraft {
  isActive = $state(false);
  /** Corners in the map. */
  corners = $state.raw<Triple[]>([]);
  low = $state("");
  high = $state("");
  class = $state(2);

  get swapped(): boolean {
    const [low, high] = [heightOf(this.low), heightOf(this.high)];
    return typeof low === "number" && typeof high === "number" && low > high;
  }
  get isReady(): boolean {
    return this.corners.length >= 3 && heightOf(this.low) !== undefined && heightOf(this.high) !== undefined && !this.swapped;
  }

  begin(): void {
    [this.isActive, this.corners, drawing.chosen] = [true, [], undefined]; // keys are about the region
  }
  end(): void {
    [this.isActive, this.corners] = [false, []];
  }
  add(corner: Triple): void {
    this.corners = [...this.corners, corner];
  }
  back(): void {
    this.corners = this.corners.slice(0, -1);
  }

  command(action: "classify" | "cut" | "crop"): string[] {
    const height = (text: string): string => String(heightOf(text) ?? "-");
    const ring = this.corners.flatMap(([e, n]) => [e.toFixed(3), n.toFixed(3)]);
    return [action, ...(action === "classify" ? [String(this.class)] : []), height(this.low), height(this.high), ...ring];
  }

  /** As a prism between its heights, or those of the cloud. */
  show(overlay: Overlay, origin: Triple, lowest: number, highest: number): void {
    overlay.clear();
    const ring = this.corners.map((corner) => sum(corner, origin, -1));
    if (ring.length > 2) overlay.prism(ring, (heightOf(this.low) ?? lowest) - origin[2], (heightOf(this.high) ?? highest) - origin[2], "#ffd400");
    else if (ring.length === 2) overlay.line(ring, false, "#ffd400");
    for (const corner of ring) overlay.mark(corner, "#b58900");
  }
}
