// The summary, for the points that are shown: what stands in the file is for all of them.
"use strict";
(() => {
  const { $, html, table, groups } = sweep.dom;
  const text = sweep.text;
  const box = $("summary-of");
  if (!box) return;
  const TRACES = 3, VALUES = 12, FAILURES = 50;
  const whole = [...box.childNodes];
  const each = sweep.raw.each === null ? undefined : sweep.column(sweep.raw.each);

  /** The best value of a result on each trace, as in `summary.rs`. */
  const tile = (result) => {
    const least = result.goal === "min";
    const better = (a, b) => (least ? a < b : a > b);
    const best = groups(sweep.filter.rows, each).map(({ name, rows }) => {
      const own = rows.filter((row) => sweep.value(result, row) !== null);
      return own.length === 0 ? null : { name, row: own.reduce((a, b) => (better(sweep.value(result, b), sweep.value(result, a)) ? b : a)) };
    }).filter(Boolean);
    if (best.length === 0) return null;
    // An element of its own for each trace: one would stand in the last place only.
    const unit = () => (result.unit && result.unit !== "bytes" ? [" ", html("small", {}, result.unit)] : []);
    const what = (row) => sweep.dimensions.filter((own) => own !== each && own.values[row] !== null).map((own) => `${own.name} ${text.value(own, own.values[row])}`).join(", ");
    const shown = best.slice(0, TRACES).flatMap(({ name, row }) => [html("b", {}, text.value(result, result.values[row]), ...unit(), text.within(result, row)),
      html("span", {}, ...(name ? [html("em", {}, name), " "] : []), what(row))]);
    const more = best.length > TRACES ? [html("span", {}, `and ${text.counted(best.length - TRACES, "more trace")}`)] : [];
    return html("div", { class: best.length > 1 ? "tile-number several" : "tile-number" }, html("dt", {}, `${sweep.all.length === 1 ? "" : least ? "least " : "most "}${result.name}`), html("dd", {}, ...shown, ...more));
  };

  /** The values that are left of each dimension. */
  const axes = () => {
    const rows = sweep.dimensions.map((own) => {
      const left = new Set(sweep.filter.withFailed.map((row) => own.values[row]));
      const values = own.of.filter((value) => value !== null && left.has(value)).map((value) => text.value(own, value));
      const more = values.length > VALUES ? ` and ${values.length - VALUES} more` : "";
      return { cells: [own.name, String(values.length), values.slice(0, VALUES).join(", ") + more, own.text] };
    });
    return rows.length === 0 ? null : table("What varies", [{ name: "Axis" }, { name: "Values", number: true }, { name: "Which" }, { name: "What it is" }], rows);
  };

  /** How many points are estimates; what that means stands in the file. */
  const estimates = () => {
    const interval = sweep.column("cycles_interval_percent");
    const sentence = whole.find((node) => node.id === "estimates")?.cloneNode(true);
    const rows = sweep.filter.withFailed;
    const count = sentence && interval ? rows.filter((row) => sweep.value(interval, row) !== null).length : 0;
    if (count === 0) return null;
    sentence.querySelector("span").textContent = `${count} of ${text.counted(rows.length, "point")} ${count === 1 ? "is an estimate" : "are estimates"}`;
    return sentence;
  };

  /** How many points were only counted, in the sentence of the file. */
  const counts = () => {
    const detail = sweep.column("detail");
    const sentence = whole.find((node) => node.id === "counts")?.cloneNode(true);
    const rows = sweep.filter.withFailed;
    const count = sentence && detail ? rows.filter((row) => detail.values[row] === "counts").length : 0;
    if (count === 0) return null;
    sentence.querySelector("span").textContent = `${count} of ${text.counted(rows.length, "point")} ${count === 1 ? "is" : "are"}`;
    return sentence;
  };

  /** Points without results. */
  const failures = () => {
    const done = new Set(sweep.filter.rows);
    const rows = sweep.filter.withFailed.filter((row) => !done.has(row));
    const why = sweep.column("error");
    const lines = rows.slice(0, FAILURES).map((row) => ({ cells: [sweep.point.button(row), text.describe(row), why?.values[row] ?? "failed"] }));
    return rows.length === 0 ? null : table("Points that failed", [{ name: "Point", number: true }, { name: "What" }, { name: "Why" }], lines);
  };

  sweep.filter.listen(() => {
    if (sweep.filter.isAll) { box.replaceChildren(...whole); return; }
    const { rows, withFailed } = sweep.filter;
    const failed = withFailed.length - rows.length;
    const of = `${withFailed.length} of ${text.counted(sweep.all.length, "point")}${failed > 0 ? `; ${failed} of them failed${failed > FAILURES ? `, of which the first ${FAILURES} are shown` : ""}` : ""}`;
    const tiles = sweep.raw.headlines.map((name) => sweep.column(name)).filter(Boolean).map(tile).filter(Boolean);
    box.replaceChildren(...[html("p", { class: "read" }, of), tiles.length > 0 ? html("dl", { class: "numbers" }, ...tiles) : null, estimates(), counts(), axes(), failures()].filter(Boolean));
  });
})();
