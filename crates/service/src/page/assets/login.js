// From another computer: the token, once.

import * as calls from "./calls.js";
import { el, notice } from "./dom.js";

// Until the token was right.
export function login(place) {
  return new Promise((resolve) => {
    const token = el("input", { id: "token", type: "password", autocomplete: "current-password", required: true, size: "40" });
    const form = el("form", {}, el("p", { class: "row" }, el("label", {}, "Token", token), el("button", { class: "main" }, "Open the page")));
    form.addEventListener("submit", async (event) => {
      event.preventDefault();
      try {
        await calls.login(token.value);
        notice("");
        resolve();
      } catch (failure) {
        notice(failure.message, true);
        token.select();
      }
    });
    place.replaceChildren(
      el("h1", {}, "Who is it?"),
      el("p", {}, "This page is for those who have its token: the file that token_file of [page] in the configuration names."),
      form);
    place.setAttribute("aria-busy", "false");
    token.focus();
  });
}
