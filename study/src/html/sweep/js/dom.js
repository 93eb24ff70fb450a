// Elements: all text goes in as text, whatever a plan calls its axes.
"use strict";
sweep.dom = (() => {
  const $ = (id) => document.getElementById(id);
  const fill = (node, attributes, children) => {
    for (const [name, value] of Object.entries(attributes)) {
      if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
      else if (value === true) node.setAttribute(name, "");
      else if (value !== false && value !== undefined && value !== null) node.setAttribute(name, value);
    }
    node.append(...children.flat().filter((child) => child !== null && child !== undefined));
    return node;
  };
  const html = (name, attributes = {}, ...children) => fill(document.createElement(name), attributes, children);
  const svg = (name, attributes = {}, ...children) => fill(document.createElementNS("http://www.w3.org/2000/svg", name), attributes, children);

  /** Puts columns into a select: those of a group under its name. */
  const choices = (select, groups, chosen) => {
    for (const [label, list] of groups) {
      if (list.length === 0) continue;
      const options = list.map(([value, text, title]) => html("option", { value, title }, text));
      select.append(...(label ? [html("optgroup", { label }, ...options)] : options));
    }
    if (chosen !== undefined && chosen !== null) select.value = chosen;
    // A choice explains itself where it stands.
    const explain = () => { select.title = select.selectedOptions[0]?.title ?? ""; };
    select.addEventListener("change", explain);
    explain();
  };
  const option = (column) => [column.name, sweep.text.named(column), column.text];
  const results = (select, chosen) => {
    const first = sweep.raw.headlines.map((name) => sweep.column(name)).filter((own) => own?.varies);
    const rest = sweep.results.filter((own) => !first.includes(own));
    const of = (role) => rest.filter((own) => own.role === role).map(option);
    choices(select, [["First asked for", first.map(option)], ["Figures", of("figure")], ["Counters", of("counter")]], chosen);
  };
  const dimensions = (select, chosen, none) => {
    choices(select, [["", [...(none ? [["", none, ""]] : []), ...sweep.dimensions.map((own) => [own.name, own.name, own.text])]]], chosen ?? (none ? "" : undefined));
  };

  /** A table as the others of the page: columns are { name, number, title }, rows lists of cells. */
  const table = (caption, columns, rows, attributes = {}) => {
    const kind = (column) => (column.number ? "num" : undefined);
    const head = columns.map((column) => html("th", { scope: "col", class: kind(column), title: column.title, "aria-sort": column.sort }, column.head ?? column.name));
    const body = rows.map(({ cells, ...own }) => html("tr", own, ...cells.map((cell, i) => (i === 0
      ? html("th", { scope: "row", class: kind(columns[0]) }, cell)
      : html("td", { class: kind(columns[i]) }, cell)))));
    return html("div", { class: columns.length > 11 ? "scroll many" : "scroll", tabindex: "0", role: "region", "aria-label": caption, ...attributes },
      html("table", {}, html("caption", {}, caption), html("thead", {}, html("tr", {}, ...head)), html("tbody", {}, ...body)));
  };

  /** Takes a section that has nothing to show out of the page and its contents. */
  const hide = (id) => {
    $(id).hidden = true;
    const link = document.querySelector(`nav a[href="#${id}"]`);
    if (link) link.parentElement.hidden = true;
  };

  /** Calls what draws again when one of the controls changes. */
  const on = (ids, draw) => { for (const id of ids) $(id).addEventListener("change", draw); };

  /** Groups of rows by a dimension in the order of its values; all rows without one. */
  const groups = (rows, dimension) => {
    if (!dimension) return [{ name: "", rows }];
    return dimension.of.filter((value) => value !== null)
      .map((value) => ({ value, name: dimension.kind === "text" ? value : `${dimension.name} ${sweep.text.value(dimension, value)}`, rows: rows.filter((row) => dimension.values[row] === value) }))
      .filter((group) => group.rows.length > 0);
  };
  return { $, hide, html, svg, choices, results, dimensions, table, on, groups };
})();
