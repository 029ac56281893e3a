// SPDX-License-Identifier: Apache-2.0
// Files of control points as a table whose columns have meanings, guessed first and then as a person assigns them.
import type { Vector2 } from "./types";

export const fields = ["ignore", "name", "e", "n", "h", "se", "sn", "sh", "role", "image", "x", "y", "s_px"] as const;
export type Field = (typeof fields)[number];
export type Separator = "," | ";" | "\t" | " ";

export interface ControlTable {
  kind: "gcp_list" | "collinea" | "table";
  /** As the file words it. */
  crs: string | null;
  separator: Separator;
  hasDecimalComma: boolean;
  header: string[] | null;
  rows: string[][];
  /** In the file, of each row, from 1. */
  lines: number[];
  fields: Field[];
  /** Those that stand in rows of their own. */
  marks: { point: string; mark: FileMark }[];
}

export interface FileMark {
  file: string;
  pixel: Vector2;
  sigma_px: number | null;
}

export interface FilePoint {
  name: string;
  role: "control" | "check";
  /** Of the columns E, N, H. */
  position: (number | null)[];
  sigma_m: (number | null)[] | null;
  marks: FileMark[];
}

export interface Problem {
  line: number;
  what: "number" | "name" | "twice" | "pixel" | "sigma";
}

const mostLines = 20_000;
const isCrs = (line: string): boolean => /^(epsg:\s*\d+|wgs ?84 utm \d+ ?[ns]|\+proj=.*)$/i.test(line.trim());
const isImageName = (text: string): boolean => /\.(jpe?g|tiff?|png|dng|jp2)$/i.test(text.trim());

function split(line: string, separator: Separator): string[] {
  const parts = separator === " " ? line.trim().split(/\s+/) : line.split(separator);
  return parts.map((part) => part.trim().replace(/^"(.*)"$/, "$1"));
}

/** The one that parts most lines into as many fields; of equals the rarer in numbers and names. */
export function separatorOf(lines: readonly string[]): Separator {
  let best: Separator = " ";
  let most = -1;
  for (const separator of ["\t", ";", ",", " "] as const) {
    const counts = new Map<number, number>();
    for (const line of lines) {
      const count = split(line, separator).length;
      if (count > 2) counts.set(count, (counts.get(count) ?? 0) + 1);
    }
    const agreeing = Math.max(0, ...counts.values());
    if (agreeing > most) [best, most] = [separator, agreeing];
  }
  return best;
}

export function numberIn(text: string, hasDecimalComma = false): number | null {
  const plain = hasDecimalComma ? text.replace(",", ".") : text;
  return /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain.trim()) ? Number(plain) : null;
}

const meanings: [Field, RegExp][] = [
  ["se", /^(sigma|std|s|sd|acc\w*|sig)[_ ]?(e|x|east\w*)(_m)?$/], ["sn", /^(sigma|std|s|sd|acc\w*|sig)[_ ]?(n|y|north\w*)(_m)?$/],
  ["sh", /^(sigma|std|s|sd|acc\w*|sig)[_ ]?(h|z|height\w*)(_m)?$/], ["s_px", /^(sigma|std|s)_?px$/],
  ["x", /^(x_?px|px|pixel_?x|col(umn)?|u|im_?x|x_pixel)$/], ["y", /^(y_?px|py|pixel_?y|row|lig(ne)?|v|im_?y|y_pixel)$/],
  ["image", /^(image|file|photo|foto|bild|photograph)\w*$/], ["role", /^(role|type|typ|kind)$/],
  ["name", /^(name|point|punkt|id|label|nr|no|number|nom\w*|gcp|station|pnr|punktnr)\b.*$/],
  ["e", /^(e|x|east\w*|rechts\w*|rw|ost\w*|x_?\w*\(m\)|lon\w*)(\[m\])?$/], ["n", /^(n|y|north\w*|hoch\w*|hw|nord\w*|y_?\w*\(m\)|lat\w*)(\[m\])?$/],
  ["h", /^(h|z|height\w*|elev\w*|alt\w*|h(ö|oe)he\w*|z_?\w*\(m\))(\[m\])?$/],
];

/** Each meaning goes to one column, the first that is called so. */
export function fieldsOfHeader(header: readonly string[]): Field[] {
  const taken = new Set<Field>();
  return header.map((title) => {
    const word = title.trim().toLowerCase();
    const found = meanings.find(([field, pattern]) => !taken.has(field) && pattern.test(word))?.[0] ?? "ignore";
    taken.add(found);
    return found;
  });
}

/** Of columns without titles: names are text or counted through, images end like files, numbers are E, N, H and their sigmas. */
export function fieldsOfRows(rows: readonly string[][], hasDecimalComma: boolean): Field[] {
  const width = Math.max(0, ...rows.map((row) => row.length));
  const column = (at: number): string[] => rows.map((row) => row[at] ?? "").filter(Boolean);
  const isNumber = Array.from({ length: width }, (_, at) => column(at).length > 0 && column(at).every((text) => numberIn(text, hasDecimalComma) !== null));
  const result: Field[] = isNumber.map(() => "ignore");
  const text = isNumber.flatMap((is, at) => (is ? [] : [at]));
  const image = text.find((at) => column(at).some(isImageName));
  if (image !== undefined) result[image] = "image";
  let name = text.find((at) => at !== image && !column(at).every((one) => /^(control|check)$/i.test(one)));
  const role = text.find((at) => at !== image && at !== name && column(at).every((one) => /^(control|check)$/i.test(one)));
  const numbers = isNumber.flatMap((is, at) => (is ? [at] : []));
  if (name === undefined && image === undefined && numbers.length > 3 && column(numbers[0] ?? 0).every((one) => /^\d+$/.test(one))) name = numbers.shift();
  if (name !== undefined) result[name] = "name";
  if (role !== undefined) result[role] = "role";
  const wanted: Field[] = image !== undefined ? ["e", "n", ...(numbers.length > 4 ? ["h" as const] : []), "x", "y"] : ["e", "n", "h", "se", "sn", "sh"];
  numbers.forEach((at, index) => (result[at] = wanted[index] ?? "ignore"));
  return result;
}

function collineaTable(lines: { text: string; line: number }[], crs: string | null, separator: Separator): ControlTable {
  const table: ControlTable = {
    kind: "collinea", crs, separator, hasDecimalComma: false, header: null, rows: [], lines: [], fields: ["name", "e", "n", "h", "se", "sn", "sh", "role"], marks: [],
  };
  for (const { text, line } of lines) {
    const [word, ...rest] = split(text, separator);
    if (rest[0] === "id") continue; // titles
    if (word === "point") {
      table.rows.push(rest.length === 4 ? [...rest, "", "", "", "control"] : rest.map((one) => (/^inf$/i.test(one) ? "" : one)));
      table.lines.push(line);
    }
    const pixel = word === "image" ? [numberIn(rest[2] ?? ""), numberIn(rest[3] ?? "")] : [];
    if (typeof pixel[0] === "number" && typeof pixel[1] === "number")
      table.marks.push({ point: rest[0] ?? "", mark: { file: rest[1] ?? "", pixel: [pixel[0], pixel[1]], sigma_px: numberIn(rest[4] ?? "") } });
  }
  return table;
}

/** A text as a table; nothing where no line has three fields. */
export function controlTable(text: string): ControlTable | undefined {
  const all = text.replace(/^\ufeff/, "").split(/\r\n|\n|\r/).slice(0, mostLines).map((line, at) => ({ text: line, line: at + 1 })).filter((one) => one.text.trim());
  const first = all[0]?.text ?? "";
  const own = /^#\s*collinea control(?:,\s*(.*))?$/i.exec(first.trim());
  const body = all.filter((one) => !one.text.trim().startsWith("#"));
  if (own) return collineaTable(body, own[1]?.trim() || null, separatorOf(body.map((one) => one.text)));
  const hasCrs = isCrs(first);
  const lines = hasCrs ? body.slice(1) : body;
  const separator = separatorOf(lines.slice(0, 500).map((one) => one.text));
  // A title that is a comment is a title all the same.
  if (!hasCrs && first.trim().startsWith("#") && split(first.trim().slice(1), separator).length > 2) lines.unshift({ text: first.trim().slice(1), line: 1 });
  const cut = lines.map((one) => ({ cells: split(one.text, separator), line: one.line })).filter((one) => one.cells.length > 2);
  if (!cut.length) return undefined;
  const hasDecimalComma = separator !== "," && cut.slice(1, 50).some((one) => one.cells.some((cell) => /^[+-]?\d+,\d+$/.test(cell)));
  const isTitle = !hasCrs && (cut[0]?.cells ?? []).every((cell) => numberIn(cell, hasDecimalComma) === null);
  const header = isTitle ? (cut.shift()?.cells ?? null) : null;
  const rows = cut.map((one) => one.cells);
  let guessed = header ? fieldsOfHeader(header) : fieldsOfRows(rows.slice(0, 500), hasDecimalComma);
  if (header && !guessed.includes("e")) guessed = fieldsOfRows(rows.slice(0, 500), hasDecimalComma);
  if (hasCrs) guessed = fieldsOfGcpList(rows, guessed);
  return { kind: hasCrs ? "gcp_list" : "table", crs: hasCrs ? first.trim() : null, separator, hasDecimalComma, header, rows, lines: cut.map((one) => one.line), fields: guessed, marks: [] };
}

/** x, y, z (may be missing in a whole file), column, row, image, name. */
function fieldsOfGcpList(rows: readonly string[][], otherwise: Field[]): Field[] {
  const image = Math.max(...rows.slice(0, 500).map((row) => row.findIndex(isImageName)));
  if (image !== 4 && image !== 5) return otherwise;
  const width = Math.max(...rows.map((row) => row.length));
  const known: Field[] = image === 5 ? ["e", "n", "h", "x", "y", "image", "name"] : ["e", "n", "x", "y", "image", "name"];
  return Array.from({ length: width }, (_, at) => known[at] ?? "ignore");
}

/** E and N exchanged. */
export const swapped = (given: readonly Field[]): Field[] => given.map((field) => (({ e: "n", n: "e", se: "sn", sn: "se" }) as Partial<Record<Field, Field>>)[field] ?? field);

/** One field means one column: what had that meaning before has none now. */
export const assigned = (given: readonly Field[], column: number, field: Field): Field[] => given.map((one, at) => (at === column ? field : one === field && field !== "ignore" ? "ignore" : one));

/** The points of a table as its columns are assigned, and what cannot be read. Rows of one name and one position are marks of one point. */
export function pointsOf(table: ControlTable): { points: FilePoint[]; problems: Problem[] } {
  const points = new Map<string, FilePoint>();
  const problems: Problem[] = [];
  const names = new Map<string, string>(); // of points without one, by their coordinates
  const at = (field: Field): number => table.fields.indexOf(field);
  table.rows.forEach((row, index) => {
    const line = table.lines[index] ?? 0;
    const text = (field: Field): string => (at(field) < 0 ? "" : (row[at(field)] ?? "").trim());
    const number = (field: Field): number | null => {
      const cell = text(field);
      if (!cell || /^(nan|-|inf)$/i.test(cell)) return null;
      const value = numberIn(cell, table.hasDecimalComma);
      if (value === null) problems.push({ line, what: "number" });
      return value;
    };
    const position = [number("e"), number("n"), number("h")];
    const sigmas = [number("se"), number("sn"), number("sh")];
    let name = text("name");
    if (!name && (at("name") < 0 || table.kind === "gcp_list")) {
      const key = position.join(" ");
      name = names.get(key) ?? `P${names.size + 1}`;
      names.set(key, name);
    }
    if (!name) return void problems.push({ line, what: "name" });
    const known = points.get(name);
    if (known && known.position.some((one, axis) => one !== position[axis])) return void problems.push({ line, what: "twice" });
    let hasSigma = sigmas.some((one) => one !== null);
    // A coordinate with an infinite sigma is not known: only collinea's own table means that.
    if (hasSigma && table.kind !== "collinea" && position.some((one, axis) => one !== null && sigmas[axis] === null)) {
      hasSigma = false;
      problems.push({ line, what: "sigma" });
    }
    const point: FilePoint = known ?? { name, role: /^(check|cp|kontroll\w*)$/i.test(text("role")) ? "check" : "control", position, sigma_m: hasSigma ? sigmas : null, marks: [] };
    points.set(name, point);
    if (!text("image")) return;
    const [x, y] = [number("x"), number("y")];
    if (x === null || y === null) problems.push({ line, what: "pixel" });
    else point.marks.push({ file: text("image"), pixel: [x, y], sigma_px: number("s_px") });
  });
  for (const { point, mark } of table.marks) points.get(point)?.marks.push(mark);
  return { points: [...points.values()], problems };
}

/** The commands that bring points and marks into a project. Marks of photographs that it does not have are left out. */
export function commandsOf(points: readonly FilePoint[], fileOf: (name: string) => string | undefined): { commands: string[][]; left_out: number } {
  const word = (value: number | null | undefined): string => (typeof value === "number" ? String(value) : "-");
  const commands: string[][] = [];
  let left_out = 0;
  for (const point of points) {
    commands.push(["point", point.name, point.role, ...point.position.map(word), ...(point.sigma_m ? point.sigma_m.map(word) : [])]);
    for (const mark of point.marks) {
      const file = fileOf(mark.file);
      if (file === undefined) ++left_out;
      else commands.push(["mark", point.name, file, ...mark.pixel.map(word), ...(mark.sigma_px ? [String(mark.sigma_px)] : [])]);
    }
  }
  return { commands, left_out };
}
