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
  if (!answer.ok) throw new Error(value.error || `${path}: ${answer.status}`);
  return value;
}

const changing = { "x-trunnion": "page" };
const posting = (body) => ({
  method: "POST",
  headers: { ...changing, "content-type": "application/json" },
  body: JSON.stringify(body),
});
const run = (name) => `/api/runs/${encodeURIComponent(name)}`;
const inModel = (name, effect) => `${run(name)}/model/${encodeURIComponent(effect)}`;

export const status = () => call("/api/status");
export const runs = () => call("/api/runs");
export const history = () => call("/api/history");
export const story = (name) => call(run(name));
export const linear = (name) => call(`${run(name)}/linear`);
export const add = (name, effect, by) => call(inModel(name, effect), posting({ by }));
export const remove = (name, effect) => call(inModel(name, effect), { method: "DELETE", headers: changing });
export const formula = (typed) => call("/api/formula", posting(typed));
export const reportAddress = (name) => `${run(name)}/report`;
export const trialAddress = (name, effect) => `${run(name)}/trial/${encodeURIComponent(effect)}`;
