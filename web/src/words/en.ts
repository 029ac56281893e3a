// SPDX-License-Identifier: Apache-2.0
// The page in English. Texts of a view stand in its block, so that work on one does not touch another. {name} is filled in.
export const en = {
  // The frame
  "app.title": "collinea",
  "app.skip": "To the content",
  "app.projects": "Projects",
  "app.views": "Views",
  "app.view.project": "Project",
  "app.view.map": "Map",
  "app.view.photographs": "Photographs",
  "app.view.control": "Control",
  "app.view.jobs": "Jobs",
  "app.no_projects": "There is no project here. Make one with “collinea run PHOTOS -o PROJECT”, then load this page again.",
  "app.language": "Language",
  "app.theme": "Theme",
  "app.theme.system": "as the system",
  "app.theme.light": "light",
  "app.theme.dark": "dark",
  "app.loading": "Loading …",
  "app.missing": "This server does not offer this yet, or the project is not so far.",
  "app.failed": "This cannot be shown: {why}",
  "app.close": "Close",
  "app.refused": "The server refused: {why}",

  // The status bar
  "status.connected": "connected",
  "status.not_connected": "no connection to the server; trying again",
  "status.link_needed": "no longer let in: open the link that collinea serve showed last",
  "status.idle": "no job in work",
  "status.waiting": "{count} waiting",
  "status.job": "{project}: {step}",
  "status.left": "{time} left of this stage",
  "status.progress": "Progress of the job in work",

  // Project
  "project.title": "Project",

  // Map
  "map.title": "Map",

  // Photographs
  "photographs.title": "Photographs",

  // Control
  "control.title": "Control",

  // Jobs
  "jobs.title": "Jobs",
} as const;

export type Key = keyof typeof en;
