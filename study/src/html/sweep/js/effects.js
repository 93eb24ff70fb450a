// Which axis moves which result by how much, as in `effects.rs`, for the points that are shown and for any result.
"use strict";
(() => {
  const { $, html, results, table } = sweep.dom;
  const text = sweep.text;
  if (!$("effects")) return;

  const follows = (one, other) => {
    const known = new Map();
    return sweep.all.every((row) => {
      if (!known.has(other.values[row])) known.set(other.values[row], one.values[row]);
      return known.get(other.values[row]) === one.values[row];
    });
  };
  /** Of each dimension those that go forward together with it, by name, and all others. */
  const company = new Map(sweep.dimensions.map((own) => {
    const rest = sweep.dimensions.filter((other) => other !== own);
    const isTogether = (other) => follows(other, own) && follows(own, other);
    return [own, { together: rest.filter(isTogether).map((other) => other.name), others: rest.filter((other) => !isTogether(other)) }];
  }));

  const effect = (dimension, result) => {
    const sums = new Map(dimension.of.filter((value) => value !== null).map((value) => [value, [0, 0]]));
    const { others, together } = company.get(dimension);
    const groups = new Map();
    let sum = 0, count = 0;
    for (const row of sweep.filter.rows) {
      const value = sweep.value(result, row);
      if (value === null || !sums.has(dimension.values[row])) continue;
      if (!Number.isFinite(value)) continue;
      const key = JSON.stringify(others.map((other) => other.values[row]));
      if (!groups.has(key)) groups.set(key, []);
      groups.get(key).push([dimension.values[row], value]);
    }
    // Like with like, as `Effect::new`: of the sets of values that groups have the largest, then that of most groups, then the first.
    const place = new Map([...sums.keys()].map((value, at) => [value, at]));
    const sets = new Map();
    for (const group of groups.values()) {
      const values = [...new Set(group.map(([value]) => place.get(value)))].sort((a, b) => a - b);
      const key = String(values);
      if (!sets.has(key)) sets.set(key, { values, groups: [] });
      sets.get(key).groups.push(group);
    }
    const first = (a, b) => a.values.map((value, at) => value - b.values[at]).find((difference) => difference !== 0) ?? 0;
    const before = (a, b) => b.values.length - a.values.length || b.groups.length - a.groups.length || first(a, b);
    const compared = [...sets.values()].sort(before)[0] ?? { values: [], groups: [] };
    for (const [value, number] of compared.groups.flat()) {
      const own = sums.get(value);
      own[0] += number; own[1] += 1; sum += number; count += 1;
    }
    const points = [...groups.values()].reduce((all, group) => all + group.length, 0);
    const leftOut = new Set([...sets.values()].flatMap((own) => own.values)).size - compared.values.length;
    const words = (together.length > 0 ? `, with ${together.join(", ")}` : "") + (count < points ? `, of ${count} points` : "")
      + (leftOut === 0 ? "" : `, without ${leftOut} ${leftOut === 1 ? "value" : "values"}`);
    const means = [...sums].filter(([, own]) => own[1] > 0).map(([value, own]) => ({ value, mean: own[0] / own[1] }));
    if (means.length < 2) return null;
    const overall = sum / count;
    const least = means.reduce((a, b) => (b.mean < a.mean ? b : a));
    const most = means.reduce((a, b) => (b.mean > a.mean ? b : a));
    // As `Effect::relative`: a share of the mean over all, or where that is 0 of the means' mean magnitude.
    const whole = overall === 0 ? means.reduce((all, own) => all + Math.abs(own.mean), 0) / means.length : Math.abs(overall);
    const share = (mean) => (whole === 0 ? 0 : (mean - overall) / whole);
    return { dimension, means, overall, words, least, most, share, low: share(least.mean), high: share(most.mean), size: share(most.mean) - share(least.mean) };
  };
  const all = (result) => sweep.dimensions.map((own) => effect(own, result)).filter(Boolean).sort((a, b) => b.size - a.size);

  const without = (count) => (count === 0 ? "" : `, without ${count} infinite ${count === 1 ? "value" : "values"}`);

  const card = (result) => {
    const list = all(result);
    const low = Math.min(0, ...list.map((own) => own.low)), high = Math.max(0, ...list.map((own) => own.high));
    const width = high > low ? high - low : 1;
    const at = (end) => `${(((end - low) / width) * 100).toFixed(2)}%`;
    const bar = (own) => {
      const name = own.dimension.name;
      const shown = (value) => text.value(own.dimension, value);
      const ends = (own.size === 0 ? "no change" : `${shown(own.least.value)} to ${shown(own.most.value)}`) + own.words;
      const lines = own.means.slice(0, 24).map(({ value, mean }) => `${shown(value)}: ${text.number(mean)} ${result.unit} (${text.signed(own.share(mean))})`);
      const tip = [`${result.name} by ${name}`, ...lines, ...(own.means.length > 24 ? ["…"] : [])].join("\n");
      return html("li", { "data-axis": name, "data-share": own.size.toFixed(6) }, html("span", { class: "bar-name" }, name, html("small", {}, ends)),
        html("span", { class: "bar-track", "data-mark": "", "data-tip": tip }, html("span", { class: "bar-fill", style: `left:${at(own.low)};width:${((own.size / width) * 100).toFixed(2)}%` }), html("span", { class: "bar-mid", style: `left:${at(0)}` })),
        html("span", { class: "bar-value" }, text.percent(own.size)));
    };
    // Of all points that are shown, not only of those that some bar compares.
    const shown = sweep.filter.rows.map((row) => sweep.value(result, row)).filter((value) => typeof value === "number" && !Number.isNaN(value));
    const finite = shown.filter(Number.isFinite);
    const mean = finite.length > 0 ? `mean ${text.number(finite.reduce((a, b) => a + b, 0) / finite.length)} ${result.unit}`.trim() + without(shown.length - finite.length) : "";
    const figure = html("figure", { class: "card", "data-result": result.name, "data-chart": `effects-${result.name}` }, html("figcaption", {}, html("strong", {}, result.name), " ", html("small", {}, mean), html("p", {}, result.text)),
      list.length > 0 ? html("ul", { class: "bars" }, ...list.map(bar)) : html("p", {}, "No two of these points differ in one axis alone."));
    if (list.length > 0) window.rayreel.offer(figure, () => [["axis", "value", result.name], ...list.flatMap((own) => own.means.map(({ value, mean }) => [own.dimension.name, text.cell(own.dimension, value), mean]))]);
    return figure;
  };

  const headlines = sweep.raw.headlines.map((name) => sweep.column(name)).filter((own) => own?.varies);
  const select = $("effects-result");
  select.append(html("option", { value: "" }, "none"));
  results(select, "");
  const draw = () => {
    const other = sweep.column(select.value);
    const shown = other && !headlines.includes(other) ? [other, ...headlines] : headlines;
    $("effects-cards").replaceChildren(...shown.map(card));
    $("effects-of").textContent = sweep.filter.rows.length < sweep.done.length ? `of ${text.counted(sweep.filter.rows.length, "point")}` : "";
    const columns = [{ name: "Axis" }, ...shown.map((own) => ({ name: own.name, number: true, title: own.text }))];
    const rows = sweep.dimensions.map((own) => ({ cells: [own.name, ...shown.map((result) => { const found = effect(own, result); return found ? text.percent(found.size) : "–"; })] }));
    $("effects-table").replaceChildren(table("Main effects, % of the mean", columns, rows));
  };
  select.addEventListener("change", draw);
  sweep.filter.listen(draw);
})();
