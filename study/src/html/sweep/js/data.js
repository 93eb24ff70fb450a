// The table of results: columns by name, each with one value a row, unpacked when first asked for.
"use strict";
const sweep = (() => {
  const raw = JSON.parse(document.getElementById("sweep-data").textContent);
  const rows = raw.rows;
  const digits = new Map([..."ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"].map((digit, i) => [digit, i]));

  const unpack = (own) => {
    if (own.own) return own.own;
    if (!own.of) return new Array(rows).fill(own.all ?? null);
    const width = own.at.length / rows;
    return Array.from({ length: rows }, (_, row) => {
      let index = 0;
      for (let i = row * width; i < (row + 1) * width; i += 1) index = index * 64 + digits.get(own.at[i]);
      return own.of[index];
    });
  };

  const lazy = (own) => {
    let values;
    Object.defineProperty(own, "values", { configurable: true, get: () => (values ??= unpack(own)) });
    own.varies = !("all" in own);
    return own;
  };

  const columns = raw.columns.map(lazy);
  const byName = new Map(columns.map((column) => [column.name, column]));

  // The picture that equals that of full has no PSNR, which is more than any; pictures that are steady have no decibels of flicker.
  for (const [name, by, wanted] of raw.infinite) {
    const [column, told] = [byName.get(name), byName.get(by)];
    if (!column || !told) continue;
    const is = (row) => told.values[row] !== null && Number(told.values[row]) === wanted;
    const values = column.values.map((value, row) => (value === null && is(row) ? Infinity : value));
    Object.defineProperty(column, "values", { value: values });
  }

  const results = columns.filter((column) => column.goal && column.varies);
  const dimensions = raw.dimensions.map((name) => byName.get(name));
  const status = byName.get("status");
  const all = Array.from({ length: rows }, (_, row) => row);
  const done = all.filter((row) => !status || status.values[row] === "done");
  const numbers = byName.get("point");

  return {
    raw, columns, results, dimensions, done, all,
    config: raw.config.map(lazy),
    /** The preset that a row is made of, as far as points change it; null for a file, also for one that has a preset's name. */
    presetOf: (row, half) => {
      const name = byName.get(half)?.values[row];
      return Object.hasOwn(raw.presets[half], name) && !raw.files[half].includes(row) ? raw.presets[half][name] : null;
    },
    column: (name) => byName.get(name),
    /** What a row is called: its number in the plan. */
    number: (row) => (numbers ? numbers.values[row] : row),
    rowOf: (number) => (numbers ? numbers.values.indexOf(number) : number),
    /** A column's value in a row as a number, or null: flags are 0 and 1. */
    value: (column, row) => {
      const own = column.values[row];
      return own === null || typeof own === "string" ? null : Number(own);
    },
  };
})();
