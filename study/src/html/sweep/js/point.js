// The point that was chosen, and what it is made of.
"use strict";
sweep.point = (() => {
  const { $, html } = sweep.dom;
  const text = sweep.text;
  const listeners = [];
  let chosen = null;

  const configOf = (row, half) => sweep.config.filter((own) => own.half === half && own.values[row] !== null)
    .map((own) => ({ key: own.key, value: own.values[row], varies: own.varies }));

  /** What a point changes of its presets; of files, whatever varies. */
  const changes = (row) => ["machine", "policy"].flatMap((half) => {
    const preset = sweep.presetOf(row, half);
    const own = configOf(row, half);
    if (!preset) return own.filter((entry) => entry.varies);
    return own.filter((entry) => entry.key in preset && preset[entry.key] !== entry.value)
      .map((entry) => ({ ...entry, preset: preset[entry.key] }));
  });

  const changeList = (row) => {
    const own = changes(row);
    return own.length === 0 ? ["as the presets"] : own.flatMap(({ key, value }, i) => [i > 0 ? " " : "", html("code", {}, `${key}=${value}`)]);
  };

  // As `shell.rs` quotes. Files cannot be named: only their stems stand in results.
  const quoted = (word) => (/^[\w\-./=:,@%+]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`);
  const command = (row) => {
    const of = (name) => sweep.column(name)?.values[row];
    // A machine of which nothing is simulated has no preset.
    const isKnown = (half) => sweep.presetOf(row, half) || (half === "machine" && of(half) === "none");
    if (!["machine", "policy"].every(isKnown)) return null;
    const first = of("first_frame");
    const parts = ["rayreel replay", quoted(of("trace")), `--frames ${first}..${first + of("frames")}`, `--machine ${of("machine")}`, `--policy ${of("policy")}`];
    const detail = of("detail") ?? "full";
    if (detail.startsWith("precision ")) parts.push(`--precision ${detail.slice(10)}`);
    else if (detail !== "full") parts.push(`--detail ${detail}`);
    return [...parts, ...changes(row).map(({ key, value }) => `--set ${quoted(`${key}=${value}`)}`)].join(" ");
  };

  const facts = (list) => html("dl", { class: "facts-list" }, ...list.flatMap(([name, value, title]) => [html("div", { title }, html("dt", {}, name), html("dd", {}, value))]));
  const folded = (summary, ...children) => html("details", {}, html("summary", {}, summary), ...children);

  const show = () => {
    const card = $("chosen");
    card.hidden = chosen === null;
    if (chosen === null) return;
    const row = chosen;
    const value = (column) => [column.name, text.atWithUnit(column, row), column.text];
    const headlines = sweep.raw.headlines.map((name) => sweep.column(name));
    const line = command(row);
    const own = changes(row).map(({ key, value: now, preset }) => html("li", {}, html("code", {}, `${key}=${now}`), preset === undefined || preset === null ? "" : ` instead of ${preset}`));
    const config = ["machine", "policy"].flatMap((half) => {
      const lines = configOf(row, half).map((entry) => `${entry.key} = ${entry.value}`).join("\n");
      return lines ? [html("h3", {}, half), html("pre", { tabindex: "0" }, lines)] : [];
    });
    const close = html("button", { type: "button", onclick: () => choose(null) }, "Close");
    card.replaceChildren(
      html("div", { class: "chosen-head" }, html("h3", {}, `Point ${sweep.number(row)}`), close),
      facts(sweep.dimensions.filter((own) => own.values[row] !== null).map(value)),
      facts(headlines.map(value)),
      html("h4", {}, "What it changes"), own.length > 0 ? html("ul", {}, ...own) : html("p", {}, "Nothing: it is as its presets are."),
      ...(line ? [html("p", { class: "command" }, html("span", {}, "Run it alone:"), html("code", { tabindex: "0" }, line))] : []),
      folded("All its results", facts(sweep.columns.filter((column) => column.goal && column.values[row] !== null).map(value))),
      folded("Its whole configuration", html("div", { class: "configs" }, ...config)),
    );
  };

  const choose = (row, move = false) => {
    chosen = row;
    show();
    for (const draw of listeners) draw();
    if (move && row !== null) {
      $("chosen").scrollIntoView({ block: "center" });
      $("chosen").focus({ preventScroll: true });
    }
  };
  return {
    changes, changeList, choose,
    get chosen() { return chosen; },
    listen: (draw) => { listeners.push(draw); },
    /** The number of a point as a button that chooses it. */
    button: (row) => html("button", { type: "button", class: "pick", "data-row": row, onclick: () => choose(row, true), title: "Show this point" }, String(sweep.number(row))),
  };
})();
