// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import { assigned, commandsOf, controlTable, type ControlTable, pointsOf, separatorOf, swapped } from "./control_file";

const read = (text: string): ControlTable => {
  const table = controlTable(text);
  if (!table) throw new Error("no table");
  return table;
};

test("a gcp_list.txt has CRS, points and their pixels", () => {
  const table = read("EPSG:32633\n546812.31 5338101.92 352.18 812.4 1033.7 IMG_0003.jpg A1\n546812.31 5338101.92 352.18 100 200.5 IMG_0004.jpg A1\n546871.02 5338120.44 NaN 1711.2 640.9 IMG_0003.jpg A2\n");
  expect([table.kind, table.crs, table.separator]).toEqual(["gcp_list", "EPSG:32633", " "]);
  const { points, problems } = pointsOf(table);
  expect(problems).toEqual([]);
  expect(points.map((one) => [one.name, ...one.position, one.marks.length])).toEqual([["A1", 546812.31, 5338101.92, 352.18, 2], ["A2", 546871.02, 5338120.44, null, 1]]);
  expect(points[0]?.marks[1]).toEqual({ file: "IMG_0004.jpg", pixel: [100, 200.5], sigma_px: null });
});

test("points of a gcp_list.txt without names are told apart by where they are", () => {
  const table = read("WGS84 UTM 54N\r\n494399.2 4232697.1 5 83.250 397.500 IMG_6785.jpg\r\n494399.2 4232697.1 5 189.5 424.5 IMG_6786.jpg\r\n494400.2 4232697.1 5 1 2 IMG_6786.jpg\r\n");
  expect(pointsOf(table).points.map((one) => [one.name, one.marks.length])).toEqual([["P1", 2], ["P2", 1]]);
});

test("a gcp_list.txt may be without heights", () => {
  const [point] = pointsOf(read("+proj=utm +zone=52 +datum=WGS84\n509546\t3887986\t678.75\t819\tIMG_4389.jpeg\tg\n509547\t3887986\t1\t2\tIMG_4390.jpeg\th\n")).points;
  expect([point?.position, point?.marks[0]?.pixel]).toEqual([[509546, 3887986, null], [678.75, 819]]);
});

test("titles say what columns are, in several languages, with a byte order mark and decimal commas", () => {
  const table = read("\ufeffPunkt;Rechtswert;Hochwert;Höhe;sigma_e;sigma_n;sigma_h;note\nA;610852,39;5277733,59;463,662;0,01;0,01;0,02;near a tree\nB;610872,97;5277729,76;;0,01;0,01;;\n");
  expect(table.fields).toEqual(["name", "e", "n", "h", "se", "sn", "sh", "ignore"]);
  expect(pointsOf(table).points.map((one) => [one.name, one.position, one.sigma_m])).toEqual([
    ["A", [610852.39, 5277733.59, 463.662], [0.01, 0.01, 0.02]],
    ["B", [610872.97, 5277729.76, null], [0.01, 0.01, null]],
  ]);
  expect(pointsOf(table).problems).toEqual([]);
});

test("columns without titles are guessed by what stands in them", () => {
  expect(read("1 610852.39 5277733.59 463.6\n2 610872.97 5277729.76 461.7").fields).toEqual(["name", "e", "n", "h"]);
  expect(read("610852.39,5277733.59,463.6\n610872.97,5277729.76,461.7").fields).toEqual(["e", "n", "h"]);
  expect(read("A,610852.39,5277733.59,463.6,0.01,0.01,0.02,check\nB,1.0,2.0,3.0,0.01,0.01,0.02,control").fields).toEqual(["name", "e", "n", "h", "se", "sn", "sh", "role"]);
});

test("collinea's own table has points and marks in rows of their own", () => {
  const table = read("# collinea control, EPSG:32633\npoint, id, easting, northing, height, sigma_e_m, sigma_n_m, sigma_h_m, role\npoint, A1, 1.5, 2.5, 3.5, 0.01, 0.01, 0.015, check\npoint, H3, , , 348.77, inf, inf, 0.01, control\nimage, id, file, x_px, y_px, sigma_px\nimage, A1, IMG_0003.jpg, 812.4, 1033.7, 0.3\n");
  expect(pointsOf(table).points).toEqual([
    { name: "A1", role: "check", position: [1.5, 2.5, 3.5], sigma_m: [0.01, 0.01, 0.015], marks: [{ file: "IMG_0003.jpg", pixel: [812.4, 1033.7], sigma_px: 0.3 }] },
    { name: "H3", role: "control", position: [null, null, 348.77], sigma_m: [null, null, 0.01], marks: [] },
  ]);
});

test("what cannot be read is named by its line", () => {
  const { points, problems } = pointsOf(read("name,e,n,h\nA,1,2,3\nA,1,2,4\nB,x1,2,3\n,1,2,3\n"));
  expect(points.map((one) => one.name)).toEqual(["A", "B"]);
  expect(problems).toEqual([{ line: 3, what: "twice" }, { line: 4, what: "number" }, { line: 5, what: "name" }]);
  expect(controlTable("")).toBeUndefined();
  expect(controlTable("one\ntwo\n")).toBeUndefined();
});

test("a coordinate whose standard deviation is missing beside others is said, and gets that of the server", () => {
  const { points, problems } = pointsOf(read("name,e,n,h,se,sn,sh\nA,1,2,3,0.1,0.1,\n"));
  expect([points[0]?.sigma_m, problems]).toEqual([null, [{ line: 2, what: "sigma" }]]);
});

test("the separator is the one that parts lines alike", () => {
  expect(separatorOf(["a b;1,5;2,5", "c d;1,5;2,5"])).toBe(";");
  expect(separatorOf(["P 1\t1\t2", "P 2\t1\t2"])).toBe("\t");
  expect(separatorOf(["a 1 2", "b 1 2 "])).toBe(" ");
});

test("axes are exchanged with their sigmas, and a meaning has one column", () => {
  expect(swapped(["name", "e", "n", "h", "se", "sn"])).toEqual(["name", "n", "e", "h", "sn", "se"]);
  expect(assigned(["name", "e", "n"], 0, "e")).toEqual(["e", "ignore", "n"]);
  expect(assigned(["ignore", "ignore", "n"], 0, "ignore")).toEqual(["ignore", "ignore", "n"]);
});

test("points become commands, and marks of photographs that are not there are counted", () => {
  const { points } = pointsOf(read("EPSG:32633\n1.5 2.5 NaN 8.4 10.7 a.jpg A1\n1.5 2.5 NaN 1 2 b.jpg A1\n"));
  expect(commandsOf(points, (name) => (name === "a.jpg" ? "flight/a.jpg" : undefined))).toEqual({
    commands: [["point", "A1", "control", "1.5", "2.5", "-"], ["mark", "A1", "flight/a.jpg", "8.4", "10.7"]],
    left_out: 1,
  });
});
