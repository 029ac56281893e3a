// SPDX-License-Identifier: Apache-2.0
// The page in German: the same keys as en.ts.
import type { Key } from "./en";

export const de: Record<Key, string> = {
  // The frame
  "app.title": "collinea",
  "app.skip": "Zum Inhalt",
  "app.projects": "Projekte",
  "app.views": "Ansichten",
  "app.view.project": "Projekt",
  "app.view.map": "Karte",
  "app.view.photographs": "Bilder",
  "app.view.control": "Passpunkte",
  "app.view.jobs": "Aufträge",
  "app.no_projects": "Hier ist kein Projekt. „collinea run BILDER -o PROJEKT“ legt eines an; danach diese Seite neu laden.",
  "app.language": "Sprache",
  "app.theme": "Darstellung",
  "app.theme.system": "wie das System",
  "app.theme.light": "hell",
  "app.theme.dark": "dunkel",
  "app.loading": "Wird geladen …",
  "app.missing": "Das bietet dieser Server noch nicht, oder das Projekt ist noch nicht so weit.",
  "app.failed": "Das kann nicht gezeigt werden: {why}",
  "app.close": "Schließen",
  "app.refused": "Der Server lehnt ab: {why}",

  // The status bar
  "status.connected": "verbunden",
  "status.not_connected": "keine Verbindung zum Server; neuer Versuch läuft",
  "status.link_needed": "kein Zutritt mehr: den Link öffnen, den collinea serve zuletzt gezeigt hat",
  "status.idle": "kein Auftrag in Arbeit",
  "status.waiting": "{count} warten",
  "status.job": "{project}: {step}",
  "status.left": "noch {time} für diesen Abschnitt",
  "status.progress": "Fortschritt des laufenden Auftrags",

  // Project
  "project.title": "Projekt",

  // Map
  "map.title": "Karte",

  // Photographs
  "photographs.title": "Bilder",

  // Control
  "control.title": "Passpunkte",

  // Jobs
  "jobs.title": "Aufträge",
};
