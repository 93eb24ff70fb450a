// Which points are shown: words that some column contains, and comparisons such as perf_per_watt > 20.
"use strict";
sweep.filter = (() => {
  const { $ } = sweep.dom;
  const TERM = /([A-Za-z_]\w*)\s*(>=|<=|!=|==|=|>|<|~)\s*("[^"]*"|[^\s,]+)/g;

  const numberOf = (text) => {
    const size = /^(-?[\d.]+(?:e[+-]?\d+)?)(KiB|MiB|GiB|B|k|M|G|%)?$/i.exec(text);
    if (!size) return text === "true" ? 1 : text === "false" ? 0 : text === "inf" || text === "∞" ? Infinity : NaN;
    const factor = { kib: 1024, mib: 1048576, gib: 1073741824, "%": 0.01 }[size[2]?.toLowerCase()] ?? { k: 1e3, M: 1e6, G: 1e9 }[size[2]] ?? 1;
    return Number(size[1]) * factor;
  };
  const near = (a, b) => a === b || Math.abs(a - b) <= 1e-6 * Math.max(Math.abs(a), Math.abs(b));

  const comparison = (name, sign, given) => {
    const column = sweep.column(name);
    if (!column) throw new Error(`no column ${name}`);
    const text = given.replaceAll('"', "").toLowerCase();
    const shown = (row) => sweep.text.value(column, column.values[row]).toLowerCase();
    if (sign === "~") return (row) => shown(row).includes(text);
    if (column.kind === "text") {
      if (sign.length === 1 && sign !== "=") throw new Error(`${name} has words: use =, != or ~`);
      if (sign === ">=" || sign === "<=") throw new Error(`${name} has words: use =, != or ~`);
      return (row) => (shown(row) === text) === (sign !== "!=");
    }
    const wanted = numberOf(given.replaceAll('"', ""));
    if (Number.isNaN(wanted)) throw new Error(`${given} is no number`);
    const own = (row) => sweep.value(column, row);
    const test = {
      ">": (value) => value > wanted, "<": (value) => value < wanted,
      ">=": (value) => value >= wanted || near(value, wanted), "<=": (value) => value <= wanted || near(value, wanted),
      "=": (value) => near(value, wanted), "==": (value) => near(value, wanted), "!=": (value) => !near(value, wanted),
    }[sign];
    return (row) => own(row) !== null && test(own(row));
  };

  const parse = (text) => {
    const tests = [];
    const words = text.replace(TERM, (_, name, sign, given) => { tests.push(comparison(name, sign, given)); return " "; })
      .split(/[\s,]+/).filter((word) => word && !/^(and|&&)$/i.test(word));
    const searched = [...new Set([...sweep.columns.filter((own) => own.kind === "text" && (own.varies || own.name !== "detail")), ...sweep.dimensions])];
    for (const word of words.map((own) => own.toLowerCase())) {
      if (/[<>=~]/.test(word)) throw new Error(`${word} compares nothing: write column > value`);
      tests.push((row) => searched.some((own) => sweep.text.value(own, own.values[row]).toLowerCase().includes(word)));
    }
    return (row) => tests.every((test) => test(row));
  };

  const listeners = [];
  const own = {
    /** Points that could be computed, and all of them, as far as they are shown. */
    rows: sweep.done, withFailed: sweep.all,
    /** Calls `draw` now and whenever the choice changes. */
    listen: (draw) => { listeners.push(draw); draw(); },
  };
  const apply = () => {
    const text = $("filter").value.trim();
    try {
      const test = parse(text);
      own.rows = sweep.done.filter(test);
      own.withFailed = sweep.all.filter(test);
      $("filter-found").textContent = text ? `${own.withFailed.length} of ${sweep.all.length} points` : "";
      $("filter").removeAttribute("aria-invalid");
    } catch (error) {
      // The last good choice stays while somebody types.
      $("filter-found").textContent = error.message;
      $("filter").setAttribute("aria-invalid", "true");
      return;
    }
    for (const draw of listeners) draw();
  };
  let waiting;
  $("filter").addEventListener("input", () => { clearTimeout(waiting); waiting = setTimeout(apply, 150); });
  $("filter-form").addEventListener("submit", (event) => { event.preventDefault(); clearTimeout(waiting); apply(); });
  return own;
})();
