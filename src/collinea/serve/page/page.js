// SPDX-License-Identifier: Apache-2.0
// The plain page of `collinea serve`: what the server knows, as text and tables. Nothing from a project becomes markup.
"use strict";

// Forms are kept, as they were left, by project and step.
const state = { projects: [], project: null, options: [], forms: new Map(), jobs: new Map(), log: [], number: 0 };
const byId = (id) => document.getElementById(id);

function element(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children.filter((child) => child !== null));
  return made;
}

async function ask(path, body) {
  const how = body === undefined
    ? {}
    : { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) };
  const response = await fetch(path, how);
  const answer = await response.json().catch(() => ({}));
  if (!response.ok) throw Object.assign(new Error(answer.error || response.statusText), { status: response.status });
  return answer;
}

function complain(error) {
  state.log.push("error: " + error.message);
  showLog();
}

const sizeText = (bytes) =>
  bytes < 1e6 ? (bytes / 1e3).toFixed(0) + " kB" : bytes < 1e9 ? (bytes / 1e6).toFixed(1) + " MB" : (bytes / 1e9).toFixed(2) + " GB";
const timeText = (seconds) =>
  seconds < 100 ? seconds.toFixed(0) + " s" : seconds < 6000 ? (seconds / 60).toFixed(0) + " min" : (seconds / 3600).toFixed(1) + " h";

function showProjects() {
  byId("projects").replaceChildren(...state.projects.map((project) =>
    element("button", {
      textContent: project.name,
      title: project.folder,
      className: state.project && state.project.id === project.id ? "chosen" : "",
      onclick: () => choose(project.id).catch(complain),
    })));
}

async function choose(id) {
  const before = state.project && state.project.id;
  state.project = await ask("/api/projects/" + id);
  location.hash = id;
  if (before !== id) byId("form").replaceChildren();
  showProjects();
  showProject();
}

// The form stays as it is.
async function refresh() {
  const id = state.project.id;
  const project = await ask("/api/projects/" + id);
  if (state.project.id !== id) return;  // another one was chosen meanwhile
  state.project = project;
  showProject();
}

function stepRow(step) {
  return element("tr", {},
    element("td", { textContent: step.name }),
    element("td", { textContent: step.done ? step.summary : "not done" }),
    element("td", { className: "number", textContent: step.done ? timeText(step.seconds) : "" }),
    element("td", {},
      element("button", { textContent: "run to here", onclick: () => run(step.name, {}).catch(complain) }), " ",
      element("button", { textContent: "options", onclick: () => showForm(step.name).catch(complain) })));
}

function fileRow(file) {
  const path = file.path.split("/").map(encodeURIComponent).join("/");
  return element("tr", {},
    element("td", {}, element("a", { href: `/api/projects/${state.project.id}/files/${path}`, textContent: file.path })),
    element("td", { className: "number", textContent: sizeText(file.bytes) }));
}

const findingItem = (finding) =>
  element("li", { className: finding.severity, textContent: [finding.what, finding.remedy].filter(Boolean).join(" ") });

function showProject() {
  const project = state.project;
  const facts = `${project.images} images (${project.oriented} oriented), ${project.cameras} cameras, ` +
    (project.crs ? project.crs : "local frame");
  byId("steps").replaceChildren(
    element("h2", { textContent: project.name }),
    element("div", { textContent: facts }),
    element("h2", { textContent: "Steps" }),
    element("table", {}, ...project.steps.map(stepRow)));
  byId("made").replaceChildren(
    element("h2", { textContent: "Findings" }),
    project.findings.length ? element("ul", {}, ...project.findings.map(findingItem)) : element("div", { textContent: "none" }),
    element("h2", { textContent: "Products" }),
    element("table", {}, ...project.files.map(fileRow)));
}

const kept = (value) => (value === null || value === undefined ? "" : String(value));

function choicesOf(option) {
  const words = option.kind === "word" ? option.choices : [{ word: "true", meaning: "yes" }, { word: "false", meaning: "no" }];
  const standard = kept(option.default);  // perhaps nothing, to which it can be set back
  return words.some((choice) => choice.word === standard) ? words : [{ word: standard, meaning: option.automatic }, ...words];
}

function control(option, value) {
  if (option.kind === "flag" && typeof option.default === "boolean")
    return element("input", { type: "checkbox", checked: value === true });
  if (option.kind === "word" || option.kind === "flag") {
    const words = choicesOf(option);
    const known = words.some((choice) => choice.word === kept(value));
    const select = element("select", {}, ...(known ? words : [{ word: kept(value) }, ...words]).map((choice) =>
      element("option", { value: choice.word, textContent: choice.meaning ? `${choice.word}: ${choice.meaning}` : choice.word })));
    select.value = kept(value);
    return select;
  }
  return element("input", { type: "text", value: kept(value) });
}

function boundsOf({ min, max }) {
  if (min === undefined) return max === undefined ? "" : `at most ${max}`;
  return max === undefined ? `at least ${min}` : `${min} to ${max}`;
}

function helpOf(option) {
  const more = [boundsOf(option), option.kind === "word_or_text" ? option.choices.map((choice) => choice.word).join(" | ") : ""];
  const text = more.filter(Boolean).join("; ");
  return text ? `${option.help} (${text})` : option.help;
}

function valueOf(option, input) {
  if (input.type === "checkbox") return input.checked;
  const text = input.value.trim();
  if (text === "") return typeof option.default === "string" && option.default !== "auto" ? "" : null;
  if (option.kind === "flag" && text !== "auto") return text === "true";
  if ((option.kind === "number" || option.kind === "whole") && text !== "auto") {
    const value = Number(text);
    if (!Number.isFinite(value)) throw new Error(`${option.name}: "${text}" is no number`);
    return value;
  }
  return text;
}

// What is not as the settings have it, by groups.
function changesIn(inputs) {
  const options = {};
  for (const { group, option, input, value } of inputs) {
    const now = valueOf(option, input);
    if (now !== value) (options[group] ||= {})[option.name] = now;
  }
  return options;
}

const shownIn = (input) => (input.type === "checkbox" ? input.checked : input.value);
const isEdited = (form) => form.inputs.some((one) => shownIn(one.input) !== one.shown);

function newForm(project, step, settings) {
  const inputs = [];
  const groups = state.options.filter((group) => group.step === step).map((group) =>
    element("fieldset", {}, element("legend", { textContent: group.group }), element("table", {}, ...group.options.map((option) => {
      const value = settings.options[group.group][option.name];
      const input = control(option, value);
      inputs.push({ group: group.group, option, input, value, shown: shownIn(input) });
      const unit = option.unit && option.unit !== "1" ? ` [${option.unit}]` : "";
      return element("tr", {}, element("td", { textContent: option.name + unit }), element("td", {}, input),
        element("td", { className: "help", textContent: helpOf(option) }));
    }))));
  const start = async () => {
    await run(step, changesIn(inputs));
    for (const one of inputs) one.shown = shownIn(one.input);  // no longer unsaved
  };
  return { inputs, nodes: [element("h2", { textContent: "Options of " + step }), ...groups,
    element("button", { textContent: "run to here with these", onclick: () => start().catch(complain) })] };
}

async function showForm(step) {
  const project = state.project.id;
  const key = `${project}/${step}`;
  const settings = await ask(`/api/projects/${project}/settings`);
  if (state.project.id !== project) return;
  if (!state.forms.has(key) || !isEdited(state.forms.get(key))) state.forms.set(key, newForm(project, step, settings));
  byId("form").replaceChildren(...state.forms.get(key).nodes);
}

async function run(step, options) {
  await ask(`/api/projects/${state.project.id}/jobs`, { step, options });
}

const isOver = (job) => !["queued", "running"].includes(job.state);

function jobRow(job) {
  const over = isOver(job);
  const left = job.left_s === null ? "" : timeText(job.left_s) + " left";
  return element("tr", {},
    element("td", { textContent: `${job.name}: ${job.step}` }),
    element("td", {}, over ? job.state : job.state === "queued" ? "waiting" : element("progress", { value: job.done }), " ",
      element("span", { textContent: over ? timeText(job.elapsed_s) : job.stage + " " + left }),
      job.error ? element("div", { className: "wrong", textContent: job.error }) : null),
    element("td", {}, over ? "" : element("button", { textContent: "stop", onclick: () => ask(`/api/jobs/${job.id}/stop`, {}).catch(complain) })));
}

function showJobs() {
  const jobs = [...state.jobs.values()].sort((a, b) => b.id - a.id);
  byId("jobs").replaceChildren(element("table", {}, ...jobs.map(jobRow)));
}

function showLog() {
  state.log.splice(0, Math.max(0, state.log.length - 500));
  byId("log").textContent = state.log.join("\n");
  byId("log").scrollTop = byId("log").scrollHeight;
}

function follow() {
  const socket = new WebSocket(`ws://${location.host}/api/events?since=${state.number}`);
  socket.onopen = () => { byId("connection").textContent = ""; };
  socket.onmessage = (event) => {
    const changes = JSON.parse(event.data);
    state.number = changes.number;
    let ended = false;
    for (const job of changes.jobs) {
      const before = state.jobs.get(job.id);
      ended ||= isOver(job) && !(before && isOver(before)) && state.project && job.project === state.project.id;
      state.jobs.set(job.id, job);
    }
    state.log.push(...changes.log.map((line) => line.line));
    showJobs();
    if (changes.log.length) showLog();
    if (ended) refresh().catch(complain);
  };
  socket.onclose = () => {
    byId("connection").textContent = "not connected";
    Object.assign(state, { jobs: new Map(), log: [], number: 0 });  // another server counts from 0
    setTimeout(followAgain, 2000);
  };
}

// A WebSocket does not say why it was refused; an ordinary request does.
async function followAgain() {
  try {
    await ask("/api/projects");
    follow();
  } catch (error) {
    if (error.status === 401 || error.status === 403) complain(error);
    else setTimeout(followAgain, 2000);
  }
}

async function start() {
  state.projects = await ask("/api/projects");
  state.options = await ask("/api/options");
  showProjects();
  const wanted = state.projects.find((project) => project.id === location.hash.slice(1)) || state.projects[0];
  if (wanted) await choose(wanted.id);
  follow();
}

start().catch(complain);
