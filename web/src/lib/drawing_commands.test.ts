// SPDX-License-Identifier: Apache-2.0
import { expect, it } from "vitest";

import { drawCommand } from "./drawing_commands";
import type { Vertex } from "./drawing_types";

it("writes a vertex with all that is known of it", () => {
  const plain: Vertex = { position: [500000.25, 5300000, -1e-7], covariance_m2: null, sigma_m: null, source: "typed", marks: [] };
  const marked: Vertex = {
    ...plain, source: "mono", covariance_m2: [1, 0, 0, 1, 0, 4],
    marks: [{ image: 3, file: "a b.jpg", pixel: [10.5, 20], sigma_px: 0.5, residual_px: null }],
  };
  expect(drawCommand("*", "roof", "line", [plain, marked]).join("|")).toBe(
    "draw|*|roof|line|typed|500000.25|5300000|-1e-7|mono|500000.25|5300000|-1e-7|cov|1|0|0|1|0|4|mark|a b.jpg|10.5|20|0.5",
  );
});

it("writes the attributes of a feature before its vertices", () => {
  const vertex: Vertex = { position: [1, 2, 3], covariance_m2: null, sigma_m: null, source: "typed", marks: [] };
  expect(drawCommand("*", "roof", "point", [vertex], { code: "R", use: "a shed" }).join("|")).toBe("draw|*|roof|point|with|code|R|with|use|a shed|typed|1|2|3");
});
