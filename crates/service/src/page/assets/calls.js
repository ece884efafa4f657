// The calls of docs/use/page.md.

async function call(path, options = {}) {
  const answer = await fetch(path, options);
  const text = await answer.text();
  let value;
  try {
    value = JSON.parse(text);
  } catch {
    throw new Error(`${path}: ${answer.status} without an answer that can be read`);
  }
  if (!answer.ok) throw Object.assign(new Error(value.error || `${path}: ${answer.status}`), { status: answer.status });
  return value;
}

const changing = { "x-trunnion": "page" };
const sending = (method, body) => ({
  method,
  headers: { ...changing, "content-type": "application/json" },
  body: JSON.stringify(body),
});
const posting = (body) => sending("POST", body);
const run = (name) => `/api/runs/${encodeURIComponent(name)}`;
const inModel = (name, effect) => `${run(name)}/model/${encodeURIComponent(effect)}`;

export const status = () => call("/api/status");
export const runs = () => call("/api/runs");
export const history = () => call("/api/history");
export const change = () => call("/api/history/change");
export const nextDay = () => call("/api/history/next-day");
export const corrected = (by, what) => call("/api/history/corrections", posting({ by, what }));
export const story = (name) => call(run(name));
export const linear = (name) => call(`${run(name)}/linear`);
export const linearWith = (name, typed) => call(`${run(name)}/linear`, posting(typed));
export const add = (name, effect, by) => call(inModel(name, effect), posting({ by }));
export const remove = (name, effect, by) => call(inModel(name, effect), sending("DELETE", { by }));
export const choose = (cycle) => call("/api/cycle/choose", posting({ cycle }));
export const begin = (cycle) => call("/api/cycle/begin", posting({ cycle }));
const setUp = (step) => call(`/api/set-up/${step}`, { method: "POST", headers: changing });
export const beginNest = () => setUp("nest");
export const finishNest = () => setUp("nest/finish");
export const writeNest = () => setUp("nest/write");
export const beginSignTest = () => setUp("sign-test");
export const stopSetUp = () => setUp("stop");
export const login = (token) => call("/api/login", posting({ token }));
export const abort = () => call("/api/cycle/abort", { method: "POST", headers: changing });
export const formula = (typed) => call("/api/formula", posting(typed));
export const methods = (name) => call(`${run(name)}/methods`);
export const methodAddress = (name, method) => `${run(name)}/method/${encodeURIComponent(method)}`;
export const reportAddress = (name) => `${run(name)}/report`;
export const file = (name, by, language) => call(`${run(name)}/filed`, posting({ by, language }));
export const print = (name) => call(`${run(name)}/filed/pdf`, { method: "POST", headers: changing });
export const filedAddress = (name) => `${run(name)}/filed`;
export const printedAddress = (name) => `${run(name)}/filed/pdf`;
export const trialAddress = (name, effect) => `${run(name)}/trial/${encodeURIComponent(effect)}`;
