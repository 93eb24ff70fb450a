// A result over two axes; of several points in a cell the mean, the least or the most.
"use strict";
(() => {
  const { $, hide, html, results, dimensions, choices, on } = sweep.dom;
  const text = sweep.text;
  if (!sweep.raw.heat || !sweep.raw.pair) { hide("heat"); return; }

  const first = sweep.raw.pair[1];
  results($("heat-result"), first);
  dimensions($("heat-row"), sweep.raw.heat[0]);
  dimensions($("heat-column"), sweep.raw.heat[1]);

  // One select for each axis that is on neither side.
  const fixed = new Map(sweep.dimensions.map((own) => {
    const select = html("select", { "data-axis": own.name });
    const values = own.of.map((value, i) => [String(i), text.value(own, value), ""]).filter((_, i) => own.of[i] !== null);
    choices(select, [["", [["", "all", ""], ...values]]], "");
    const label = html("label", {}, `${own.name} `, select);
    select.addEventListener("change", () => draw());
    return [own, { label, select }];
  }));
  $("heat-fixed").append(...[...fixed.values()].map((own) => own.label));

  const MOST = sweep.raw.most_heat;
  let rowsOf = () => [];
  const saves = window.rayreel.offer($("heat-map").closest("figure"), () => rowsOf());
  const draw = () => {
    rowsOf = () => [];
    const result = sweep.column($("heat-result").value);
    const [down, across] = [sweep.column($("heat-row").value), sweep.column($("heat-column").value)];
    const others = sweep.dimensions.filter((own) => own !== down && own !== across);
    for (const [own, { label }] of fixed) label.hidden = !others.includes(own);
    $("heat-fixed").hidden = others.length === 0;
    const held = others.filter((own) => fixed.get(own).select.value !== "");
    const wanted = held.map((own) => [own, own.of[Number(fixed.get(own).select.value)]]);
    const how = $("heat-how").value;
    const cells = new Map();
    let most = 0, without = 0, left = 0, apart = 0;
    for (const row of sweep.filter.rows) {
      const value = sweep.value(result, row);
      if (wanted.some(([own, only]) => own.values[row] !== only)) continue;
      if (value === null) { without += 1; continue; }
      if (!Number.isFinite(value)) { left += 1; continue; }
      const [a, b] = [down.values[row], across.values[row]];
      if (a === null || b === null) { apart += 1; continue; }
      const key = JSON.stringify([a, b]);
      const cell = cells.get(key) ?? { sum: 0, count: 0, min: Infinity, max: -Infinity, row };
      cell.sum += value;
      cell.count += 1;
      cell.min = Math.min(cell.min, value);
      cell.max = Math.max(cell.max, value);
      most = Math.max(most, cell.count);
      cells.set(key, cell);
    }
    const valueOf = (cell) => (how === "mean" ? cell.sum / cell.count : cell[how]);
    let low = Infinity, high = -Infinity;
    for (const cell of cells.values()) { low = Math.min(low, valueOf(cell)); high = Math.max(high, valueOf(cell)); }
    const share = (value) => (high > low ? (value - low) / (high - low) : 0.5);

    $("heat-name").textContent = text.named(result);
    const word = { mean: "the mean", min: "the least", max: "the most" }[how];
    const rest = others.filter((own) => !held.includes(own)).map((own) => own.name).join(", ");
    const where = wanted.map(([own, only]) => `${own.name} ${text.value(own, only)}`).join(", ");
    $("heat-what").textContent = `${result.text}. ${most > 1 ? `A cell is ${word} of up to ${most} points${rest ? ` over ${rest}` : ""}.` : "A cell is one point."}${where ? ` Only ${where}.` : ""}`
      + text.leftOut(without, `without ${result.name}`) + text.leftOut(left, "with ∞") + text.leftOut(apart, `without ${down.name} or ${across.name}`);

    const seen = (own, i) => own.of.filter((value) => value !== null && [...cells.keys()].some((key) => JSON.parse(key)[i] === value));
    const [rows, columns] = [seen(down, 0), seen(across, 1)];
    const same = down === across;
    const box = $("heat-map");
    if (same || cells.size === 0 || rows.length > MOST || columns.length > MOST) {
      const why = same ? "Choose two different axes." : cells.size === 0 ? "No point has both axes and the result." : `An axis has more than ${MOST} values: choose another, or fewer points with the filter.`;
      box.replaceChildren(html("p", {}, why));
      $("heat-legend").replaceChildren();
      saves.enable(false);
      return;
    }
    rowsOf = () => [[down.name, across.name, result.name, "points"], ...rows.flatMap((a) => columns.map((b) => {
      const cell = cells.get(JSON.stringify([a, b]));
      return [text.cell(down, a), text.cell(across, b), cell ? valueOf(cell) : null, cell?.count ?? 0];
    }))];
    saves.enable(true);
    // Values stand in the cells as long as there is room for them.
    const values = columns.length <= 24;
    const head = html("tr", {}, html("th", { scope: "col" }, html("span", { class: "corner" }, `${down.name} ↓ ${across.name} →`)), ...columns.map((own) => html("th", { scope: "col", title: text.value(across, own) }, text.value(across, own))));
    const body = rows.map((a) => html("tr", {}, html("th", { scope: "row", title: text.value(down, a) }, text.value(down, a)), ...columns.map((b) => {
      const cell = cells.get(JSON.stringify([a, b]));
      if (!cell) return html("td", { class: "none" }, "–");
      const value = valueOf(cell);
      const t = share(value);
      // Of one point its interval is known; of several nobody has said how theirs go together.
      const within = cell.count === 1 ? text.within(result, cell.row) : "";
      const tip = [`${down.name} ${text.value(down, a)}, ${across.name} ${text.value(across, b)}`, `${result.name} ${text.withUnit(result, value)}${within}`,
        ...(cell.count > 1 ? [`${cell.count} points from ${text.number(cell.min)} to ${text.number(cell.max)}`] : [])].join("\n");
      return html("td", { class: t > 0.6 ? "heat hot" : t > 0.5 ? "heat warm" : "heat", style: `--t:${(t * 100).toFixed(1)}%`, "data-mark": "", "data-tip": tip, "data-value": value }, values ? [text.number(value), within ? html("small", {}, within) : null] : html("span", { class: "unseen" }, text.number(value)));
    })));
    box.replaceChildren(html("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": `${result.name} by ${down.name} and ${across.name}` },
      html("table", { class: "heat-table" }, html("thead", {}, head), html("tbody", {}, ...body))));
    $("heat-legend").replaceChildren(html("span", {}, text.withUnit(result, low)), html("span", { class: "ramp-bar", "aria-hidden": "true" }), html("span", {}, text.withUnit(result, high)));
  };
  on(["heat-result", "heat-row", "heat-column", "heat-how"], draw);
  sweep.filter.listen(draw);
})();
