"use strict";
const $ = (selector, within = document) => within.querySelector(selector);
const all = (selector, within = document) => [...within.querySelectorAll(selector)];
const page = document.body.dataset.page;
const shell = words => words.map(word => /^[\w./:=@%+-]+$/.test(word) ? word : `'${word.replaceAll("'", `'\\''`)}'`).join(" ");

async function answerOf(response) {
  const answer = await response.json();
  $("#problem").textContent = answer?.error || "";
  if (answer?.error) throw new Error(answer.error);
  return answer;
}
const call = async (name, body = {}) =>
  answerOf(await fetch(`${name}?page=${page}`, { method: "POST", body: JSON.stringify(body) }));

// --- files
const cellsOf = row => Object.fromEntries(all("[data-column]", row).map(cell => [cell.dataset.column, cell.value]));
const rows = () => all(".row").map(cellsOf);

function show(cells) {
  const row = $("#row").content.cloneNode(true).firstElementChild;
  for (const [name, value] of Object.entries(cells)) {
    const cell = $(`[data-column="${name}"]`, row);
    if (cell) cell.value = value;
  }
  $(".pick", row).setAttribute("aria-label", `select ${cells.surface}`);
  $("#rows").append(row);
  row.addEventListener("change", event => event.target.dataset.column && inspect(row));
  return inspect(row);
}

async function inspect(row) {
  const turn = row.turn = (row.turn || 0) + 1;  // an answer to what was typed before comes too late
  const { text, problem, channels, map, command } = await call("inspect", { row: cellsOf(row) });
  if (turn !== row.turn) return;
  $("pre", row).textContent = text;
  $("img", row).hidden = !map;
  if (map) $("img", row).src = map;
  $(".command", row).textContent = shell(command);
  if (problem) $("details", row).open = true;
  const channel = $('[data-column="channel"]', row);
  if (channels.length > 1 && channel.tagName === "INPUT") {
    const choice = document.createElement("select");
    choice.dataset.column = "channel";
    choice.append(new Option("", ""), ...channels.map(name => new Option(name, name, false, name === channel.value)));
    channel.replaceWith(choice);
  }
}

async function add(paths) {
  const { rows: added, skipped } = await call("add", { paths, rows: rows() });
  $("#added").textContent = `${added.length} added` + (skipped.length ? `; left out, as no measurements: ${skipped.join(", ")}` : "");
  await Promise.all(added.map(show));
  await check();
}

async function drop(files) {
  for (const file of files) {
    const { path } = await answerOf(
      await fetch(`drop?page=${page}&name=${encodeURIComponent(file.name)}`, { method: "PUT", body: file }));
    await add([path]);
  }
}
$("#choose").addEventListener("change", event => drop(event.target.files));
$("#drop").addEventListener("dragover", event => { event.preventDefault(); $("#drop").classList.add("over"); });
$("#drop").addEventListener("dragleave", () => $("#drop").classList.remove("over"));
$("#drop").addEventListener("drop", event => {
  event.preventDefault();
  $("#drop").classList.remove("over");
  drop(event.dataTransfer.files);
});
$("#add").addEventListener("submit", event => { event.preventDefault(); add([$("#path").value]); });
const picked = () => all(".row").filter(row => $(".pick", row).checked);
$("#selected").addEventListener("submit", event => {
  event.preventDefault();
  for (const row of picked()) for (const name of ["group", "part"]) $(`[data-column="${name}"]`, row).value = $(`#${name}`).value;
  check();
});
$("#all").addEventListener("click", () => all(".pick").forEach(box => { box.checked = true; }));
$("#remove").addEventListener("click", () => { picked().forEach(row => row.remove()); check(); });

// --- settings
const texts = () => Object.fromEntries(all("#settings [name]").map(field => [field.name, field.value]));

function markMistakes(mistakes) {
  all("output.mistake").forEach(output => { output.textContent = ""; });
  all("[aria-invalid]").forEach(field => field.removeAttribute("aria-invalid"));
  $("#mistakes").replaceChildren();
  for (const [name, sentences] of Object.entries(mistakes)) {
    const [, number, column] = name.match(/^rows\.(\d+)\.(\w+)$/) || [];
    let output = null;
    for (let part = name; part && !output && !column; part = part.replace(/\.?[^.]*$/, ""))
      output = $(`output[for="${part}"]`);
    if (column && all(".row")[number]) output = $(`[data-of="${column}"]`, all(".row")[number]);
    const field = output && (column ? $(`[data-column="${column}"]`, all(".row")[number]) : document.getElementById(output.htmlFor.value));
    if (field) field.setAttribute("aria-invalid", "true");
    if (output) output.textContent = [output.textContent, ...sentences].filter(Boolean).join("\n");
    $("#mistakes").append(...sentences.map(sentence => Object.assign(document.createElement("li"), { textContent: sentence })));
  }
}

let latest = 0;
async function check(name = "check") {
  const turn = ++latest;
  const answer = await call(name, { texts: texts(), rows: rows() });
  if (turn !== latest) return answer;
  markMistakes(answer.mistakes);
  for (const field of all("#bodies [name^='contact.bodies.']")) {
    field.dataset.example ??= field.placeholder;
    if (field.tagName === "INPUT") field.placeholder = answer.defaults[field.name] || field.dataset.example;
  }
  $("#preview").replaceChildren(...Object.entries(answer.files).flatMap(([path, text]) =>
    [Object.assign(document.createElement("code"), { textContent: path }), Object.assign(document.createElement("pre"), { textContent: text, tabIndex: 0 })]));
  $("#save").disabled = $("#start").disabled = Object.keys(answer.mistakes).length > 0;
  if (name === "check") $("#saved").textContent = "";
  return answer;
}
async function save() {
  const { files, kept } = await check("write");
  $("#saved").textContent = `written: ${Object.keys(files).join(", ")}` + (kept.length ? `; what was there is kept in ${kept.join(", ")}` : "");
}
let typing = 0;
document.addEventListener("input", event => {
  if (!event.target.name && !event.target.dataset.column) return;
  clearTimeout(typing);
  typing = setTimeout(check, 200);
});
$("#settings").addEventListener("submit", event => event.preventDefault());
$("#settings").addEventListener("click", event => {
  if (!event.target.classList.contains("more")) return;
  const list = event.target.parentElement, number = all(":scope > .entry", list).length;
  const fields = $("template", list).content.cloneNode(true).firstElementChild;
  for (const element of all("[name], [id], [for]", fields))
    for (const name of ["name", "id", "for"]) if (element.hasAttribute(name)) element.setAttribute(name, element.getAttribute(name).replace("#", number));
  event.target.before(fields);
  $("input", fields).focus();
});
$("#save").addEventListener("click", save);

// --- run
let wasRunning = false, started = 0;
async function follow() {
  try {
    const state = await call("state");
    $("#cancel").disabled = !state.running;
    if (state.running) $("#start").disabled = true;
    else if (wasRunning) $("#start").disabled = $("#save").disabled;
    $("#share").value = state.share ?? (state.code === 0 ? 1 : 0);
    $("#screen").textContent = state.text;
    $("#state").textContent = state.running ? state.bar || "the run begins ..." : state.cancelled ? "cancelled: Run goes on where it stopped"
      : state.code === null ? (state.text ? "the last run; Run goes on where it stopped" : "not run yet") : state.code === 0 ? "done" : "ended with errors: see below for the way out";
    $("#surfaces").replaceChildren(...rows().map(({ surface }) => {
      const is = name => name.split("/").includes(surface);
      const word = state.running && state.bar.split(/[ ,]/).some(is) ? "at work" : state.done.some(is) ? "done" : state.failed.some(is) ? "failed" : "waiting";
      return Object.assign(document.createElement("li"), { textContent: `${surface}: ${word}` });
    }));
    if (wasRunning && !state.running) await look();
    wasRunning = state.running;
  } catch (error) { $("#problem").textContent = error.message; }
  setTimeout(follow, 1000);
}
$("#start").addEventListener("click", async () => { await save(); await call("start"); wasRunning = true; });
$("#cancel").addEventListener("click", () => call("cancel"));

// --- look
const options = (select, names) => $(select).replaceChildren(...names.map(([value, text]) => new Option(text, value)));
async function look() {
  const { results, report, files, formats } = await call("results");
  $("#results").replaceChildren(...Object.entries(results).map(([name, result]) => Object.assign(document.createElement("li"), {
    textContent: `${name}: ${result.verdict}${result.main_reason ? ` (${result.main_reason})` : ""}.${result.halve ? ` To halve the ± of the contact area: ${result.halve}.` : ""}` })));
  const names = Object.keys(results).map(name => [name, name]);
  ["#before", "#after", "#of"].forEach(select => options(select, names));
  options("#form", Object.entries(formats).map(([name, text]) => [name, `${name}: ${text}`]));
  $("#tables").replaceChildren(...files.flatMap(name => [Object.assign(document.createElement("a"), { href: `results/${name}`, textContent: name, target: "_blank" }), " "]));
  $("#report").hidden = !report;
  if (report) $("#report").src = `results/report.html?${report}`;
}
async function tell(name, body) {
  const { command, text } = await call(name, body);
  $("#command").textContent = command;
  $("#answer").textContent = text;
}
$("#compare").addEventListener("submit", event => { event.preventDefault(); tell("compare", { before: $("#before").value, after: $("#after").value }); });
$("#export").addEventListener("submit", event => { event.preventDefault(); tell("export", { result: $("#of").value, form: $("#form").value }); });
window.addEventListener("unhandledrejection", event => { $("#problem").textContent = event.reason.message; });
window.addEventListener("pagehide", () => navigator.sendBeacon(`leave?page=${page}`));
Promise.all(JSON.parse($("#table").textContent).map(show)).then(() => check());
follow();
look();
