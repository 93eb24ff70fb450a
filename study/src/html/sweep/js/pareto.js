// Points of two results with the front of those that no other beats.
"use strict";
(() => {
  const { $, hide, html, svg, results, dimensions, table, on, groups } = sweep.dom;
  const text = sweep.text;
  const { showTip, hideTip } = window.rayreel;
  const [firstX, firstY] = sweep.raw.pair ?? [];
  if (!firstX) { hide("pareto"); return; }
  // The point that is chosen here stands below this chart; where there is none, above the table of all.
  $("pareto-how").after($("chosen"));

  results($("pareto-x"), firstX);
  results($("pareto-y"), firstY);
  dimensions($("pareto-colour"), sweep.raw.colour, "none");
  dimensions($("pareto-each"), sweep.raw.each, "all points together");
  const setGoal = (axis) => { $(`pareto-${axis}-goal`).value = sweep.column($(`pareto-${axis}`).value).goal; };
  ["x", "y"].forEach(setGoal);

  // The least of 1, 2 and 5 times a power of ten.
  const scale = (values, [from, to], count) => {
    let low = Math.min(...values.slice(0, 1)), high = low;
    for (const value of values) { low = Math.min(low, value); high = Math.max(high, value); }
    if (values.length === 0) { low = 0; high = 1; }
    // What differs in its last digits only is one value to an axis.
    const span = high - low > Math.max(Math.abs(low), Math.abs(high)) * 1e-12 ? high - low : 0;
    const pad = span * 0.04 || Math.abs(low) * 0.05 || 1;
    const under = low >= 0 && low - pad < 0 ? 0 : low - pad;
    const raw = (high + pad - under) / count;
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((m) => m * power).find((own) => own >= raw * (1 - 1e-9));
    const most = Math.max(Math.abs(under), Math.abs(high));
    const label = (tick) => text.tick(tick, step, most);
    const first = Math.ceil(under / step);
    const ticks = Array.from({ length: count + 2 }, (_, i) => (first + i) * step)
      .filter((tick, i, all) => tick <= high + pad && (i === 0 || label(tick) !== label(all[i - 1])));
    return { at: (value) => from + ((value - under) / (high + pad - under)) * (to - from), ticks, label };
  };

  const SHAPES = [
    (x, y) => `M${x - 4} ${y}a4 4 0 1 0 8 0a4 4 0 1 0 -8 0z`,
    (x, y) => `M${x - 3.6} ${y - 3.6}h7.2v7.2h-7.2z`,
    (x, y) => `M${x} ${y - 4.8}l4.6 8h-9.2z`,
    (x, y) => `M${x} ${y - 5}l5 5l-5 5l-5 -5z`,
    (x, y) => `M${x} ${y + 4.8}l4.6 -8h-9.2z`,
    (x, y) => `M${x - 1.5} ${y - 4.5}h3v3h3v3h-3v3h-3v-3h-3v-3h3z`,
  ];
  const COLOURS = 7, KEYS = 40;
  // Values of numbers are ordered: so are their colours. Words take colours and shapes in turn.
  const looks = (dimension, rows) => {
    if (!dimension) return { of: () => 0, list: [{ class: "p0", shape: 0 }] };
    const there = new Set(rows.map((row) => dimension.values[row]));
    const values = dimension.of.filter((value) => there.has(value));
    const ordered = dimension.kind === "number" && values.length > 2;
    const list = values.map((value, i) => (value === null
      ? { class: "pfull", shape: 3, name: "none" }
      : ordered
        ? { class: "ramp", share: i / Math.max(values.filter((own) => own !== null).length - 1, 1), shape: i % SHAPES.length, name: text.value(dimension, value) }
        : { class: `p${i % COLOURS}`, shape: i % SHAPES.length, name: text.value(dimension, value) }));
    const index = new Map(values.map((value, i) => [value, i]));
    return { of: (row) => index.get(dimension.values[row]), list };
  };
  const styled = (look) => (look.class === "ramp" ? { class: "ramp", style: `--t:${(look.share * 100).toFixed(1)}%` } : { class: look.class });

  // As wide as `.chart .name` draws it.
  const pen = document.createElement("canvas").getContext("2d");
  const wide = (own, weight = 600) => {
    pen.font = `${weight} 11px ${getComputedStyle(document.body).fontFamily}`;
    return pen.measureText(own).width;
  };
  const fitting = (name, room) => {
    const fits = (own) => wide(own) <= room;
    const letters = [...name];
    while (letters.length > 1 && !fits(letters.length < [...name].length ? `${letters.join("")}…` : name)) letters.pop();
    return letters.length < [...name].length ? `${letters.join("")}…` : name;
  };

  let places = [];
  let walk = [];
  let at = -1;
  const draw = () => {
    const [x, y] = [sweep.column($("pareto-x").value), sweep.column($("pareto-y").value)];
    const goals = [$("pareto-x-goal").value, $("pareto-y-goal").value];
    const colour = sweep.column($("pareto-colour").value);
    const rows = sweep.filter.rows.filter((row) => sweep.value(x, row) !== null && sweep.value(y, row) !== null);
    const fronts = groups(rows, sweep.column($("pareto-each").value)).map((group) => ({ ...group, front: sweep.front(group.rows, x, y, goals) }));
    const on = new Set(fronts.flatMap((group) => group.front));

    const box = $("pareto-chart");
    const width = Math.max(Math.min(box.clientWidth || 800, 1100), 290);
    const height = Math.round(Math.min(Math.max(width * 0.55, 300), 500));
    const infinite = { x: rows.some((row) => sweep.value(x, row) === Infinity), y: rows.some((row) => sweep.value(y, row) === Infinity) };
    const plot = { right: width - (infinite.x ? 64 : 14), top: infinite.y ? 62 : 26, bottom: height - 40 };
    const finite = (column) => rows.map((row) => sweep.value(column, row)).filter(Number.isFinite);
    const sy = scale(finite(y), [plot.bottom, plot.top], 6);
    plot.left = Math.max(52, ...sy.ticks.map((tick) => wide(sy.label(tick), 400) + 10));
    let sx = scale(finite(x), [plot.left, plot.right], width < 500 ? 4 : 7);
    // Long texts need more room than that many have.
    const most = Math.max(...sx.ticks.map((tick) => wide(sx.label(tick), 400) + 8), 1);
    const apart = (plot.right - plot.left) / most;
    sx.ticks = sx.ticks.filter((tick) => sx.at(tick) + wide(sx.label(tick), 400) / 2 <= width);
    if (sx.ticks.length > apart) sx = { ...sx, ticks: sx.ticks.filter((_, i) => i % Math.ceil(sx.ticks.length / Math.max(apart, 1)) === 0) };
    const place = (row) => {
      const [vx, vy] = [sweep.value(x, row), sweep.value(y, row)];
      return [vx === Infinity ? width - 30 : sx.at(vx), vy === Infinity ? 40 : sy.at(vy)].map((v) => Math.round(v * 10) / 10);
    };

    const parts = [];
    for (const tick of sy.ticks) {
      parts.push(svg("line", { x1: plot.left, x2: plot.right, y1: sy.at(tick), y2: sy.at(tick), class: "grid" }));
      parts.push(svg("text", { x: plot.left - 6, y: sy.at(tick) + 4, class: "tick e" }, sy.label(tick)));
    }
    for (const tick of sx.ticks) {
      parts.push(svg("line", { x1: sx.at(tick), x2: sx.at(tick), y1: plot.top, y2: plot.bottom, class: "grid" }));
      parts.push(svg("text", { x: sx.at(tick), y: plot.bottom + 16, class: "tick m" }, sx.label(tick)));
    }
    if (infinite.x) {
      parts.push(svg("rect", { x: width - 52, y: plot.top, width: 44, height: plot.bottom - plot.top, class: "apart" }));
      parts.push(svg("text", { x: width - 30, y: plot.bottom + 16, class: "tick m" }, "identical"));
    }
    if (infinite.y) {
      parts.push(svg("rect", { x: plot.left, y: 30, width: plot.right - plot.left, height: 20, class: "apart" }));
      parts.push(svg("text", { x: plot.left + 4, y: 44, class: "tick s" }, "identical"));
    }
    parts.push(svg("line", { x1: plot.left, x2: plot.right, y1: plot.bottom, y2: plot.bottom, class: "axis" }));
    parts.push(svg("line", { x1: plot.left, x2: plot.left, y1: plot.top, y2: plot.bottom, class: "axis" }));
    const better = (goal, less, more) => (goal === "min" ? `${less} less is better` : `${more} more is better`);
    parts.push(svg("text", { x: plot.right, y: height - 6, class: "note e" }, `${text.named(x)}, ${better(goals[0], "←", "→")}`));
    parts.push(svg("text", { x: 4, y: 13, class: "note s" }, `${text.named(y)}, ${better(goals[1], "↓", "↑")}`));

    const list = looks(colour, rows);
    const paths = list.list.map(() => ["", ""]);
    places = rows.map((row) => {
      const [px, py] = place(row);
      const own = list.of(row);
      paths[own][on.has(row) ? 1 : 0] += SHAPES[list.list[own].shape](px, py);
      return { row, px, py };
    });
    const thick = rows.length > 3000 ? " tiny" : "";
    list.list.forEach((look, i) => { if (paths[i][0]) parts.push(svg("path", { d: paths[i][0], ...styled(look), "data-kind": "beaten", opacity: on.size < rows.length ? 0.45 : 1 })); });
    for (const group of fronts) {
      const corners = group.front.map(place);
      if (corners.length > 1) parts.push(svg("path", { d: `M${corners.map((own) => own.join(" ")).join("L")}`, class: "frontier" }));
    }
    list.list.forEach((look, i) => { if (paths[i][1]) parts.push(svg("path", { d: paths[i][1], ...styled(look), "data-kind": `front${thick}` })); });
    if (fronts.length > 1 && fronts.length < 9) {
      const taken = [];
      for (const group of fronts) {
        const [px, py] = place(group.front[Math.floor(group.front.length / 2)]);
        // At the side with more room, and no longer than that.
        const rooms = { e: px - 9 - plot.left, s: width - 4 - px - 9 };
        const side = rooms.e > rooms.s ? "e" : "s";
        const [name, start] = [fitting(group.name, rooms[side]), px + (side === "e" ? -9 : 9)];
        const left = side === "e" ? start - wide(name) : start;
        // Above, below and farther from the point: the first place that no other name has, if there is one.
        const isFree = (own) => own >= 13 && own <= plot.bottom && !taken.some((other) => left < other.right && other.left < left + wide(name) && Math.abs(own - other.base) < 13);
        const base = [Math.max(py - 8, 24), py + 14, py - 22, py + 28].find(isFree);
        if (base === undefined) continue;
        taken.push({ left, right: left + wide(name), base });
        parts.push(svg("text", { x: start, y: base, class: `name ${side} halo` }, name));
      }
    }
    const ring = svg("circle", { r: 8, class: "ring", visibility: "hidden", id: "pareto-ring" });
    const mark = svg("circle", { r: 8, class: "ring chosen-ring", visibility: "hidden", id: "pareto-chosen" });
    parts.push(ring, mark);
    const label = `${text.named(y)} against ${text.named(x)}: ${text.counted(rows.length, "point")}, ${on.size} on the front`;
    box.replaceChildren(svg("svg", { class: "chart wide", viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": label, tabindex: "0" }, ...parts));
    walk = fronts.flatMap((group) => group.front);
    at = -1;
    ringAt(mark, sweep.point.chosen);

    $("pareto-name").textContent = `${y.name} against ${x.name}`;
    const both = new Set([x, y]);
    const lacking = (own) => sweep.filter.rows.filter((row) => sweep.value(own, row) === null).length;
    $("pareto-what").textContent = [...both].map((own) => `${own.name}: ${own.text}.`).reverse().join(" ") + [...both].map((own) => text.leftOut(lacking(own), `without ${own.name}`)).join("");
    const named = list.list.filter((look) => look.name !== undefined);
    const entries = named.slice(0, KEYS).map((look) =>
      html("li", {}, svg("svg", { viewBox: "0 0 16 16", "aria-hidden": "true" }, svg("path", { d: SHAPES[look.shape](8, 8), ...styled(look) })), look.name));
    $("pareto-legend").replaceChildren(...(colour ? [html("ul", { class: "legend" }, html("li", {}, html("b", {}, colour.name)), ...entries, ...(named.length > KEYS ? [html("li", {}, `and ${named.length - KEYS} more`)] : []))] : []));
    saves.enable(rows.length > 0);
    $("pareto-count").textContent = on.size === 1 ? "1 point on the front" : `${on.size} points on the front`;
    const columns = [{ name: "Point", number: true }, { name: x.name, number: true, title: x.text }, { name: y.name, number: true, title: y.text }, ...sweep.dimensions.map((own) => ({ name: own.name, title: own.text }))];
    const lines = walk.slice(0, 200).map((row) => ({ cells: [sweep.point.button(row), text.at(x, row), text.at(y, row), ...sweep.dimensions.map((own) => text.value(own, own.values[row]))] }));
    $("pareto-table").replaceChildren(table(walk.length > 200 ? "The first 200 points on the front" : "Points on the front", columns, lines));
  };

  const ringAt = (circle, row) => {
    const own = places.find((place) => place.row === row);
    circle.setAttribute("visibility", own ? "visible" : "hidden");
    if (!own) return null;
    circle.setAttribute("cx", own.px);
    circle.setAttribute("cy", own.py);
    return own;
  };
  const about = (row) => {
    const [x, y] = [sweep.column($("pareto-x").value), sweep.column($("pareto-y").value)];
    const lines = [x, y].map((own) => `${own.name} ${text.atWithUnit(own, row)}`);
    return [`Point ${sweep.number(row)}`, ...lines, ...sweep.dimensions.filter((own) => own.values[row] !== null).map((own) => `${own.name} ${text.value(own, own.values[row])}`)].join("\n");
  };
  const chart = () => $("pareto-chart").firstElementChild;
  const nearest = (event) => {
    const box = chart().getBoundingClientRect();
    const zoom = chart().viewBox.baseVal.width / box.width;
    const [px, py] = [(event.clientX - box.left) * zoom, (event.clientY - box.top) * zoom];
    let best = null, least = 26 ** 2;
    for (const own of places) {
      const distance = (own.px - px) ** 2 + (own.py - py) ** 2;
      if (distance < least) { least = distance; best = own; }
    }
    return best;
  };
  const leave = () => { $("pareto-ring")?.setAttribute("visibility", "hidden"); hideTip(); };
  const box = $("pareto-chart");
  const follow = (event) => {
    const own = nearest(event);
    if (!own) { leave(); return; }
    ringAt($("pareto-ring"), own.row);
    showTip(about(own.row), event.clientX, event.clientY);
  };
  box.addEventListener("pointermove", follow);
  box.addEventListener("pointerdown", follow);
  box.addEventListener("pointerleave", leave);
  box.addEventListener("focusout", leave);
  box.addEventListener("click", (event) => { const own = nearest(event); if (own) sweep.point.choose(own.row); });
  box.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
    if (event.key === "Escape") leave();
    if (event.key === "Enter" && at >= 0) sweep.point.choose(walk[at]);
    if (!step || walk.length === 0) return;
    event.preventDefault();
    at = at < 0 ? (step > 0 ? 0 : walk.length - 1) : (at + step + walk.length) % walk.length;
    const own = ringAt($("pareto-ring"), walk[at]);
    const frame = chart().getBoundingClientRect();
    const zoom = frame.width / chart().viewBox.baseVal.width;
    showTip(about(walk[at]), frame.left + own.px * zoom, frame.top + own.py * zoom);
  });

  const saves = window.rayreel.offer(box.closest("figure"), () => {
    const [x, y] = [sweep.column($("pareto-x").value), sweep.column($("pareto-y").value)];
    const [on, both] = [new Set(walk), [...new Set([x, y])]];
    return [["point", ...sweep.dimensions.map((own) => own.name), ...both.map((own) => own.name), "front"],
      ...places.map(({ row }) => [sweep.number(row), ...sweep.dimensions.map((own) => text.cell(own, own.values[row])), ...both.map((own) => own.values[row]), on.has(row)])];
  });
  on(["pareto-x"], () => setGoal("x"));
  on(["pareto-y"], () => setGoal("y"));
  on(["pareto-x", "pareto-y", "pareto-x-goal", "pareto-y-goal", "pareto-colour", "pareto-each"], draw);
  sweep.filter.listen(draw);
  sweep.point.listen(() => ringAt($("pareto-chosen"), sweep.point.chosen));
  let drawn = box.clientWidth;
  new ResizeObserver(() => { if (Math.abs(box.clientWidth - drawn) > 4 && box.clientWidth > 0) { drawn = box.clientWidth; draw(); } }).observe(box);
})();
