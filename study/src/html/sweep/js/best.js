// The best points for any objective, of the points that are shown.
"use strict";
(() => {
  const { $, results, dimensions, table, on, groups } = sweep.dom;
  const text = sweep.text;
  if (!$("best")) return;
  const BEST = 10, GROUPS = 24;
  results($("best-result"), sweep.raw.objective);
  dimensions($("best-each"), sweep.raw.each, "nothing: all points");
  const setGoal = () => { $("best-goal").value = sweep.column($("best-result").value).goal; };
  setGoal();

  const draw = () => {
    const own = sweep.column($("best-result").value);
    const sign = $("best-goal").value === "min" ? 1 : -1;
    const shown = [own, ...sweep.raw.headlines.map((name) => sweep.column(name)).filter((other) => other !== own)];
    const each = sweep.column($("best-each").value);
    // The name of the group stands above.
    const axes = sweep.dimensions.filter((axis) => axis !== each);
    const columns = [{ name: "Point", number: true }, ...axes.map((axis) => ({ name: axis.name, title: axis.text })),
      ...shown.map((result) => ({ name: text.named(result), number: true, title: result.text })), { name: "Changes" }];
    const rows = sweep.filter.rows.filter((row) => sweep.value(own, row) !== null);
    const part = (group) => {
      // The order of the plan breaks ties: sorting is stable.
      const best = [...group.rows].sort((a, b) => { const [u, v] = [sweep.value(own, a), sweep.value(own, b)]; return u === v ? 0 : sign * (u - v); }).slice(0, BEST);
      const lines = best.map((row) => ({ cells: [sweep.point.button(row), ...axes.map((axis) => text.value(axis, axis.values[row])),
        ...shown.map((result) => text.at(result, row)), sweep.point.changeList(row)] }));
      return table(`${sign > 0 ? "Least" : "Most"} ${own.name}${group.name ? ` on ${group.name}` : ""}`, columns, lines);
    };
    const all = groups(rows, each).slice(0, GROUPS);
    $("best-tables").replaceChildren(...(rows.length > 0 ? all.map(part) : ["No point has this result."]));
  };
  on(["best-result"], setGoal);
  on(["best-result", "best-goal", "best-each"], draw);
  sweep.filter.listen(draw);
})();
