// The table of all points that are shown: sorted by a click, a page at a time, with the columns that a reader chooses.
"use strict";
(() => {
  const { $, html, table } = sweep.dom;
  const text = sweep.text;
  const PAGE = 50;
  // Of points that all failed, status and why may be the same.
  const WHY = ["status", "error"];
  const failed = sweep.done.length < sweep.all.length;
  const headlines = sweep.raw.headlines.map((name) => sweep.column(name));
  const offered = sweep.columns.filter((own) => own.name !== "point" && (own.varies || own.role === "point" || own.role === "axis" || headlines.includes(own) || sweep.raw.rows < 2 || (failed && WHY.includes(own.name))));
  const usual = [...sweep.dimensions, ...headlines, ...(failed ? [sweep.column("status")] : [])].filter(Boolean);
  let shown = new Set(usual);
  let [sorted, down, from] = [null, false, 0];

  // Words by their order in the plan, so that small, medium, large stay in this order.
  const rank = (column) => {
    if (column.kind !== "text") return (row) => sweep.value(column, row);
    const order = new Map((column.of ?? [...new Set(column.values)]).map((value, i) => [value, i]));
    return (row) => (column.values[row] === null ? null : order.get(column.values[row]));
  };
  const ordered = () => {
    const rows = [...sweep.filter.withFailed];
    if (sorted === null) return rows;
    const key = sorted === "point" ? (row) => sweep.number(row) : rank(sweep.column(sorted));
    // What is missing comes last, whichever way.
    return rows.sort((a, b) => {
      const [u, v] = [key(a), key(b)];
      if (u === null || v === null) return (u === null) - (v === null);
      return u === v ? 0 : (u < v ? -1 : 1) * (down ? -1 : 1);
    });
  };

  const head = (name, label) => ({
    sort: sorted === name ? (down ? "descending" : "ascending") : "none",
    head: html("button", { type: "button", class: "sort", "data-sort": name, onclick: () => {
      [sorted, down] = sorted === name ? [name, !down] : [name, sweep.column(name)?.goal === "max"];
      from = 0;
      draw();
      document.querySelector(`[data-sort="${name}"]`).focus({ preventScroll: true });
    } }, label, html("span", { "aria-hidden": "true", class: "arrow" }, sorted === name ? (down ? " ▾" : " ▴") : "")),
  });

  const draw = () => {
    const rows = ordered();
    from = Math.min(from, Math.max(0, Math.floor((rows.length - 1) / PAGE) * PAGE));
    const list = offered.filter((own) => shown.has(own));
    const columns = [{ ...head("point", "Point"), number: true }, ...list.map((own) => ({ ...head(own.name, text.named(own)), number: own.kind === "number", title: own.text }))];
    const page = rows.slice(from, from + PAGE);
    const lines = page.map((row) => ({ "data-row": row, class: row === sweep.point.chosen ? "strong" : undefined, cells: [sweep.point.button(row), ...list.map((own) => text.at(own, row))] }));
    const left = $("points-table").firstElementChild?.scrollLeft ?? 0;
    $("points-table").replaceChildren(table("Points", columns, lines));
    $("points-table").firstElementChild.scrollLeft = left;
    $("points-range").textContent = rows.length === 0 ? "no points" : `${from + 1} to ${from + page.length} of ${rows.length}`;
    $("points-back").disabled = from === 0;
    $("points-next").disabled = from + PAGE >= rows.length;
  };
  $("points-back").addEventListener("click", () => { from = Math.max(0, from - PAGE); draw(); });
  $("points-next").addEventListener("click", () => { from += PAGE; draw(); });

  // Which columns.
  const roles = [["point", "The point"], ["axis", "Axes"], ["status", "Status"], ["figure", "Figures"], ["counter", "Counters"]];
  const boxes = new Map();
  for (const [role, title] of roles) {
    const own = offered.filter((column) => column.role === role);
    if (own.length === 0) continue;
    const list = own.map((column) => {
      const box = html("input", { type: "checkbox", checked: shown.has(column), onchange: () => { if (box.checked) shown.add(column); else shown.delete(column); draw(); } });
      const label = html("label", { title: column.text }, box, html("span", {}, text.named(column)));
      boxes.set(column, { box, label });
      return label;
    });
    $("points-choice").append(html("fieldset", { class: "checks" }, html("legend", {}, title), ...list));
  }
  const choose = (columns) => {
    shown = new Set(columns);
    for (const [column, { box }] of boxes) box.checked = shown.has(column);
    draw();
  };
  $("points-default").addEventListener("click", () => choose(usual));
  $("points-none").addEventListener("click", () => choose([]));
  $("points-search").addEventListener("input", () => {
    const words = $("points-search").value.toLowerCase().split(/\s+/).filter(Boolean);
    for (const [column, { label }] of boxes) {
      const all = `${column.name} ${column.unit} ${column.text}`.toLowerCase();
      label.hidden = !words.every((word) => all.includes(word));
    }
    for (const set of document.querySelectorAll(".checks")) set.hidden = [...set.querySelectorAll("label")].every((label) => label.hidden);
  });

  sweep.filter.listen(() => { from = 0; draw(); });
  sweep.point.listen(draw);
})();
