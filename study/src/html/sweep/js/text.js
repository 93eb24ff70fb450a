// Values for people, as the rest of the page writes them.
"use strict";
sweep.text = (() => {
  const GAP = "\u202f";
  const fixed = (value, places) => {
    const [whole, fraction] = Math.abs(value).toFixed(places).split(".");
    const grouped = whole.length > 4 ? whole.replace(/\B(?=(\d{3})+$)/g, GAP) : whole;
    const text = fraction === undefined ? grouped : `${grouped}.${fraction}`;
    return value < 0 && /[1-9]/.test(text) ? `\u2212${text}` : text;
  };
  const number = (value) => {
    const size = Math.abs(value);
    if (!Number.isFinite(value)) return value > 0 ? "∞" : "\u2212∞";
    if (size >= 1e10) return value.toExponential(3).replace("e+", "e");
    if (Number.isInteger(value)) return fixed(value, 0);
    if (size >= 100) return fixed(value, 1);
    if (size < 1e-3) return value.toExponential(3);
    return fixed(value, size >= 10 ? 2 : size >= 0.1 ? 3 : 5);
  };
  const bytes = (value) => {
    if (value > 0 && value % 1048576 === 0) return `${value / 1048576}MiB`;
    return value > 0 && value % 1024 === 0 ? `${value / 1024}KiB` : `${value}B`;
  };
  /** A value of a column without its unit. */
  const value = (column, own) => {
    if (own === null) return "–";
    if (column.unit === "bytes") return bytes(own);
    // What somebody chose is written as it was chosen.
    if (typeof own === "number" && (column.goal || !Number.isFinite(own))) return number(own);
    return String(own);
  };
  /** Behind an estimate half the width of its 95 % interval. */
  const within = (column, row) => {
    const interval = sweep.column(`${column.name}_interval_percent`);
    const own = interval ? sweep.value(interval, row) : null;
    // As `plus_minus` in `text.rs`: no sign stands before a zero.
    return own === null || !/[1-9]/.test(fixed(own, 1)) ? "" : ` ±${GAP}${fixed(own, 1)}${GAP}%`;
  };
  // One frame, two frames; ms stays ms.
  const unit = (column, own) => (column.unit && column.unit !== "bytes" ? `${GAP}${own === 1 ? column.unit.replace(/(?<=[a-z]{3})s$/, "") : column.unit}` : "");
  return {
    fixed, number, value, within,
    /** A value of an axis in a file: as the page and the plan write it; nothing where there is none. */
    cell: (column, own) => (own === null ? null : value(column, own)),
    /** How many of something, which takes an s where they are not one. */
    counted: (count, thing) => `${count} ${thing}${count === 1 ? "" : "s"}`,
    /** The value of a column in a row. */
    at: (column, row) => value(column, column.values[row]) + within(column, row),
    atWithUnit: (column, row) => value(column, column.values[row]) + (column.values[row] === null ? "" : unit(column, column.values[row])) + within(column, row),
    withUnit: (column, own) => value(column, own) + (own === null ? "" : unit(column, own)),
    named: (column) => (column.unit && column.unit !== "bytes" ? `${column.name} (${column.unit})` : column.name),
    percent: (share) => `${fixed(share * 100, 1)}${GAP}%`,
    signed: (share) => `${share > 0 && fixed(share * 100, 1) !== "0.0" ? "+" : ""}${fixed(share * 100, 1)}${GAP}%`,
    /** How many points a chart leaves out and why; nothing where it has all. */
    leftOut: (count, what) => (count === 0 ? "" : ` ${count} ${count === 1 ? "point" : "points"} ${what} ${count === 1 ? "is" : "are"} left out.`),
    /** What a row is: its values of the dimensions. */
    describe: (row) => sweep.dimensions.filter((own) => own.values[row] !== null)
      .map((own) => `${own.name} ${value(own, own.values[row])}`).join(", "),
    /** A tick with the places that tell it from its neighbours, as `label` in `scale.rs`. */
    tick: (tick, step, most) => {
      const power = most.toExponential().split("e").at(-1).replace("+", "");
      const isPower = most >= 1e12 || (most > 0 && most < 1e-3);
      const [scale, behind] = isPower ? [Number(`1e${power}`) || 1, `e${power}`] : most >= 1e9 ? [1e9, "G"] : most >= 1e6 ? [1e6, "M"] : most >= 1e4 ? [1e3, "k"] : [1, ""];
      const isWhole = (own) => own > 0.5 && Math.abs(own - Math.round(own)) < 1e-6;
      let own = step / scale, places = 0;
      while (places < 14 && !isWhole(own)) { own *= 10; places += 1; }
      return tick === 0 ? "0" : fixed(tick / scale, places) + behind;
    },
  };
})();
