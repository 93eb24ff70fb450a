// The summary, for the points that are shown: what stands in the file is for all of them.
"use strict";
(() => {
  const { $, html, table, groups } = sweep.dom;
  const text = sweep.text;
  const box = $("summary-of");
  if (!box) return;
  const TRACES = 3, VALUES = 12;
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
    const unit = result.unit && result.unit !== "bytes" ? [" ", html("small", {}, result.unit)] : [];
    const what = (row) => sweep.dimensions.filter((own) => own !== each && own.values[row] !== null).map((own) => `${own.name} ${text.value(own, own.values[row])}`).join(", ");
    const shown = best.slice(0, TRACES).flatMap(({ name, row }) => [html("b", {}, text.value(result, result.values[row]), ...unit, text.within(result, row)),
      html("span", {}, ...(name ? [html("em", {}, name), " "] : []), what(row))]);
    const more = best.length > TRACES ? [html("span", {}, `and ${best.length - TRACES} more traces`)] : [];
    return html("div", { class: best.length > 1 ? "tile-number several" : "tile-number" }, html("dt", {}, `${least ? "least" : "most"} ${result.name}`), html("dd", {}, ...shown, ...more));
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

  sweep.filter.listen(() => {
    if (sweep.filter.isAll) { box.replaceChildren(...whole); return; }
    const { rows, withFailed } = sweep.filter;
    const failed = withFailed.length - rows.length;
    const of = `${withFailed.length} of ${sweep.all.length} points${failed > 0 ? `; ${failed} of them failed` : ""}`;
    const tiles = sweep.raw.headlines.map((name) => sweep.column(name)).filter(Boolean).map(tile).filter(Boolean);
    box.replaceChildren(...[html("p", { class: "read" }, of), tiles.length > 0 ? html("dl", { class: "numbers" }, ...tiles) : null, axes()].filter(Boolean));
  });
})();
