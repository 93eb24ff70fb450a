// Which points are shown: an expression such as perf_per_watt > 20 or trv == 4, or words that some column contains.
"use strict";
sweep.filter = (() => {
  const { $ } = sweep.dom;
  const known = (name) => Boolean(sweep.column(name));

  /** Columns that have a part of a name, for who has not the whole of it. */
  const hint = (name) => {
    const text = name.toLowerCase();
    const near = sweep.columns.map((own) => own.name).filter((own) => own.includes(text) || (own.length > 2 && text.includes(own))).slice(0, 3);
    return `; a word stands in quotes${near.length > 0 ? `, and there is ${near.join(", ")}` : ""}`;
  };

  /** Results that the last expression asked for, each with the points that have none of it. */
  const lacking = new Map();
  const expression = (text) => {
    const test = sweep.language.compile(text, known, hint, (name) => sweep.column(name).digits);
    const value = (name, row) => {
      const found = sweep.column(name).values[row];
      if (found === null && !sweep.dimensions.includes(sweep.column(name))) {
        if (!lacking.has(name)) lacking.set(name, new Set());
        lacking.get(name).add(row);
      }
      return found;
    };
    return (row) => {
      try {
        return test((name) => value(name, row));
      } catch (error) {
        throw new Error(`at point ${sweep.number(row)}: ${error.message}`);
      }
    };
  };

  const words = (text) => {
    const searched = [...new Set([...sweep.columns.filter((own) => own.kind === "text" && (own.varies || own.name !== "detail")), ...sweep.dimensions])];
    const has = (row, word) => searched.some((own) => sweep.text.value(own, own.values[row]).toLowerCase().includes(word));
    const all = text.toLowerCase().split(/[\s,]+/).filter(Boolean);
    return (row) => all.every((word) => has(row, word));
  };

  const parse = (text) => {
    if (text === "") return () => true;
    return sweep.language.isWords(text, known) ? words(text) : expression(text);
  };

  /** An expression over what varies here, to show how one looks. */
  const example = () => {
    const last = (sweep.done.length > 0 ? sweep.done : sweep.all).at(-1);
    const of = (own) => {
      const value = sweep.text.value(own, own.values[last]);
      return own.kind === "text" && !/^[0-9]/.test(value) ? `${own.name} = "${value.replace(/["\\]/g, "\\$&")}"` : `${own.name} >= ${value}`;
    };
    const text = sweep.dimensions.filter((own) => own.values[last] !== null).slice(0, 2).map(of).join(" or ");
    try {
      const test = expression(text);
      sweep.done.forEach(test);
      return text;
    } catch {
      return "";
    }
  };

  const all = sweep.text.counted(sweep.all.length, "point");
  const listeners = [];
  const own = {
    /** Points that could be computed, and all of them, as far as they are shown. */
    rows: sweep.done, withFailed: sweep.all,
    /** Whether all points are shown. */
    isAll: true,
    /** Calls `draw` now and whenever the choice changes. */
    listen: (draw) => { listeners.push(draw); draw(); },
  };
  const apply = () => {
    const text = $("filter").value.trim();
    lacking.clear();
    try {
      const test = parse(text);
      const shown = sweep.all.filter(test);
      const done = new Set(sweep.done);
      own.withFailed = shown;
      own.rows = shown.filter((row) => done.has(row));
      own.isAll = text === "";
      // Nothing is less than every number, as in exclude: who asks for the fastest gets what never ran, too.
      const without = [...lacking].map(([name, rows]) => [name, shown.filter((row) => rows.has(row)).length]).filter(([, count]) => count > 0);
      const told = without.map(([name, count]) => `, ${count} of them without ${name}`).join("");
      $("filter-found").textContent = text ? `${shown.length} of ${all}${told}` : "";
      $("filter").removeAttribute("aria-invalid");
    } catch (error) {
      // The last good choice stays while somebody types.
      $("filter-found").textContent = `${error.message}. Still shown: ${own.withFailed.length} of ${all}`;
      $("filter").setAttribute("aria-invalid", "true");
      return;
    }
    for (const draw of listeners) draw();
  };
  $("filter").placeholder = example() || $("filter").placeholder;
  let waiting;
  $("filter").addEventListener("input", () => { clearTimeout(waiting); waiting = setTimeout(apply, 150); });
  $("filter-form").addEventListener("submit", (event) => { event.preventDefault(); clearTimeout(waiting); apply(); });
  return own;
})();
