// SPDX-License-Identifier: Apache-2.0
// Where the page is: #/PROJECT/VIEW/REST, so that a place can be linked to and the browser's back works.

export const views = ["project", "map", "scene", "photographs", "stereo", "control", "jobs"] as const;
export type View = (typeof views)[number];

export interface Place {
  project: string;
  view: View;
  /** What a view makes of it: #/PROJECT/photographs/3. */
  rest: string[];
}

export function parsedHash(hash: string): Place {
  const parts = hash.replace(/^#\/?/, "").split("/").filter(Boolean).map(decoded);
  const view = views.find((one) => one === parts[1]) ?? "project";
  return { project: parts[0] ?? "", view, rest: parts.slice(2) };
}

export const hashOf = (project: string, view: View, ...rest: string[]): string =>
  "#/" + [project, view, ...rest].map(encodeURIComponent).join("/");

function decoded(part: string): string {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}

class Route {
  place = $state.raw<Place>({ project: "", view: "project", rest: [] });

  constructor() {
    if (typeof window === "undefined") return;
    this.place = parsedHash(location.hash);
    window.addEventListener("hashchange", () => (this.place = parsedHash(location.hash)));
  }

  go(project: string, view: View, ...rest: string[]): void {
    location.hash = hashOf(project, view, ...rest);
    this.place = parsedHash(location.hash); // the event comes later, and keys may come before it
  }
}

export const route = new Route();
