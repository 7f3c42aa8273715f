// The main numbers, large.

import { METHODS } from "/methods.js";
import { grouped, short, withErrorHtml } from "./numbers.js";
import { gapOf, gapText, isSilent, isTransient } from "./table.js";
import { unitOf } from "./units.js";

export function showTiles(view, element, playing) {
  const { theory, measured, state } = view, old = view.old.theory, best = theory?.recommended;
  const answer = best && theory.methods[best], transient = isTransient(measured);
  const write = (id, html) => { element(id).innerHTML = html; };
  const say = (id, text) => { element(id).textContent = text || "\u00a0"; };
  const number = (value, quantity, error) => {
    const { factor, name } = unitOf(quantity, state);
    return Number.isFinite(value) ? withErrorHtml(value * factor, Number.isFinite(error) ? error * factor : null, name) : "–";
  };
  const measuredOf = (quantity) => (measured ? number(measured.values[quantity], quantity, measured.errors[quantity]) : "–");
  const plainly = (quantity) => {
    const { factor } = unitOf(quantity, state);
    return answer && !old ? `${METHODS[best].label}: ${short(answer.moments[quantity] * factor)}` : "";
  };

  write("tile-measured", measuredOf("amplitude_mean_square"));
  say("tile-measured-note", measured && `mean, ${view.si ? "t" : "Ωt"} > ${short(measured.settings.window[0], 3)}${view.si ? " s" : ""}`);
  write("tile-rms", measuredOf("x_rms"));
  say("tile-rms-note", plainly("x_rms"));
  write("tile-rate", measuredOf("impact_rate"));
  say("tile-rate-note", view.values.wall && plainly("impact_rate"));

  element("tile-theory").classList.toggle("stale", old);
  say("tile-theory-name", best ? METHODS[best].label : "");
  write("tile-theory", answer ? number(answer.moments.amplitude_mean_square, "amplitude_mean_square") : "–");
  const { values, errors } = measured ?? { values: {}, errors: {} }, name = "amplitude_mean_square";
  const gap = answer && measured && !old && !transient ? gapText(gapOf(answer.moments[name], values[name], errors[name])) : "";
  const none = theory && !best && !old ? (isSilent(theory) ? "no stationary answer" : "no method is recommended here") : "";
  say("tile-theory-note", gap ? `gap ${gap}` : none || (answer && transient ? "of the stationary state" : ""));

  say("tile-paths", grouped(measured?.paths ?? 0));
  element("progress").value = measured ? measured.paths / measured.of : 0;
  if (measured) {
    const steps = measured.paths * Math.round(measured.settings.duration / measured.settings.step);
    say("tile-paths-note", measured.complete ? `done: ${short(steps, 2)} steps in ${short(measured.seconds, 2)} s` : `of ${grouped(measured.of)}${playing ? "" : ": paused"}`);
  } else if (!playing) say("tile-paths-note", "paused: Play or Step");
}
