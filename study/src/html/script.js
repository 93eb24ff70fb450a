// What only makes sense on a screen: theme, modes, tooltips, search. The page reads without it.
"use strict";
(() => {
  const root = document.documentElement;
  const $ = (id) => document.getElementById(id);
  const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
  root.classList.add("js");

  // Light, dark, or as the system says.
  const THEMES = ["system", "light", "dark"];
  const theme = $("theme");
  const remember = (value) => {
    // A page opened from a file may have no storage.
    try { return value === undefined ? localStorage.getItem("rayreel-theme") : localStorage.setItem("rayreel-theme", value); }
    catch { return null; }
  };
  const setTheme = (name) => {
    if (name === "system") delete root.dataset.theme; else root.dataset.theme = name;
    theme.textContent = `Theme: ${name}`;
  };
  setTheme(THEMES.includes(remember()) ? remember() : "system");
  theme.hidden = false;
  theme.addEventListener("click", () => {
    const next = THEMES[(THEMES.indexOf(root.dataset.theme ?? "system") + 1) % THEMES.length];
    setTheme(next);
    remember(next);
  });

  // Tables that go on to the right say so in words too, as long as they do. Other scripts make tables as well.
  const mark = (box) => box.classList.toggle("more", box.scrollWidth - box.clientWidth - box.scrollLeft > 4);
  let marking = false;
  const markAll = () => {
    if (marking) return;
    marking = true;
    requestAnimationFrame(() => { marking = false; document.querySelectorAll(".scroll").forEach(mark); });
  };
  addEventListener("resize", markAll);
  addEventListener("scroll", (event) => { if (event.target.classList?.contains("scroll")) mark(event.target); }, true);
  addEventListener("toggle", markAll, true);
  new MutationObserver(markAll).observe(document.body, { childList: true, subtree: true, attributes: true, attributeFilter: ["hidden"] });
  markAll();

  // One mode at a time, the same everywhere on the page.
  const runs = [];
  for (const block of document.querySelectorAll(".mode")) {
    const last = runs.at(-1);
    if (last && last.at(-1).nextElementSibling === block) last.push(block); else runs.push([block]);
  }
  const choices = [];
  const setMode = (mode) => {
    for (const run of runs.filter((own) => own.some((block) => block.dataset.mode === mode))) {
      for (const block of run) block.hidden = block.dataset.mode !== mode;
    }
    for (const button of choices) button.setAttribute("aria-pressed", String(button.dataset.mode === mode));
  };
  for (const run of runs.filter((own) => own.length > 1)) {
    const group = document.createElement("div");
    group.className = "choice modes";
    group.setAttribute("role", "group");
    group.setAttribute("aria-label", "Mode");
    for (const block of run) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = block.dataset.name;
      button.dataset.mode = block.dataset.mode;
      button.addEventListener("click", () => {
        // The page changes height above the button too: keep the button where it is.
        const before = button.getBoundingClientRect().top;
        setMode(block.dataset.mode);
        scrollBy({ top: button.getBoundingClientRect().top - before, behavior: "instant" });
      });
      choices.push(button);
      group.append(button);
    }
    run[0].before(group);
  }
  if (choices.length > 0) setMode(choices[0].dataset.mode);

  // What a mark says when asked.
  const tip = $("tip");
  const showTip = (text, x, y) => {
    tip.textContent = text;
    tip.hidden = false;
    const { width, height } = tip.getBoundingClientRect();
    const left = x + 14 + width > innerWidth ? x - width - 14 : x + 14;
    const top = y + 14 + height > innerHeight ? y - height - 14 : y + 14;
    tip.style.transform = `translate(${Math.round(clamp(left, 4, Math.max(4, innerWidth - width - 4)))}px, ${Math.round(Math.max(top, 4))}px)`;
  };
  const hideTip = () => { tip.hidden = true; };
  // For charts that other scripts draw.
  window.rayreel = { showTip, hideTip };
  for (const mark of document.querySelectorAll("[data-mark]:not([data-tip])")) {
    const title = mark.querySelector("title");
    mark.dataset.tip = title.textContent;
    title.remove();
  }
  const markOf = (event) => event.target.closest?.("[data-mark]");
  document.addEventListener("pointermove", (event) => {
    const mark = markOf(event);
    if (mark) showTip(mark.dataset.tip, event.clientX, event.clientY);
    else if (!event.target.closest?.("[data-lines], [data-own-tip]")) hideTip();
  });
  document.addEventListener("pointerdown", (event) => {
    const mark = markOf(event);
    if (mark) showTip(mark.dataset.tip, event.clientX, event.clientY);
    else if (!event.target.closest?.("[data-own-tip]")) hideTip();
  });
  addEventListener("scroll", hideTip, { passive: true });
  for (const chart of document.querySelectorAll("svg.chart")) {
    const marks = [...chart.querySelectorAll("[data-mark]")];
    if (marks.length === 0) continue;
    let at = -1;
    chart.tabIndex = 0;
    const leave = () => { marks[at]?.classList.remove("on"); hideTip(); };
    chart.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      if (event.key === "Escape") leave();
      if (!step) return;
      event.preventDefault();
      leave();
      at = at < 0 && step < 0 ? marks.length - 1 : (at + step + marks.length) % marks.length;
      const box = marks[at].getBoundingClientRect();
      marks[at].classList.add("on");
      showTip(marks[at].dataset.tip, box.right, box.bottom);
    });
    chart.addEventListener("blur", leave);
  }

  // Lines: the values of the frame under the pointer.
  const number = (value) => {
    const size = Math.abs(value);
    if (size === Infinity) return "identical";
    if (!Number.isSafeInteger(value) && (size >= 1e10 || size < 1e-3)) return value.toExponential(3).replace("e+", "e");
    const places = Number.isInteger(value) || size >= 1000 ? { maximumFractionDigits: size >= 10000 ? 0 : 1 } : { maximumSignificantDigits: 4 };
    return value.toLocaleString("en", places).replaceAll(",", "\u202f");
  };
  for (const chart of document.querySelectorAll("[data-lines]")) {
    const list = (text) => text.split(",").map((v) => (v === "" ? null : Number(v)));
    const frames = list(chart.dataset.x);
    const [left, right, top, bottom] = chart.dataset.plot.split(" ").map(Number);
    const [first, last] = chart.dataset.ends.split(" ").map(Number);
    const lines = [...chart.querySelectorAll("[data-v]")].map((line) => ({ name: line.dataset.name, values: list(line.dataset.v), within: list(line.dataset.within ?? "") }));
    const cursor = document.createElementNS(chart.namespaceURI, "line");
    cursor.setAttribute("class", "cursor");
    cursor.setAttribute("y1", top);
    cursor.setAttribute("y2", bottom);
    let at = -1;
    const show = (index, clientX, clientY) => {
      at = clamp(index, 0, frames.length - 1);
      const x = left + (right - left) * clamp((frames[at] - first) / Math.max(last - first, 1), 0, 1);
      cursor.setAttribute("x1", x);
      cursor.setAttribute("x2", x);
      chart.append(cursor);
      const box = chart.getBoundingClientRect();
      const off = (within) => (within[at] ? ` ±\u202f${within[at].toFixed(1)}\u202f%` : "");
      const rows = lines.map(({ name, values, within }) => `${name} ${values[at] === null ? "–" : `${number(values[at])} ${Number.isFinite(values[at]) ? chart.dataset.unit : ""}${off(within)}`}`);
      showTip([`frame ${frames[at]}`, ...rows].join("\n"), clientX ?? box.left + (x / 360) * box.width, clientY ?? box.top + box.height / 3);
    };
    const leave = () => { cursor.remove(); hideTip(); };
    const nearest = (frame) => {
      let low = 0;
      for (let i = 1; i < frames.length; i += 1) if (Math.abs(frames[i] - frame) < Math.abs(frames[low] - frame)) low = i;
      return low;
    };
    const follow = (event) => {
      const box = chart.getBoundingClientRect();
      const x = ((event.clientX - box.left) / box.width) * 360;
      show(nearest(first + ((x - left) / (right - left)) * (last - first)), event.clientX, event.clientY);
    };
    if (frames.length === 0) continue;
    chart.addEventListener("pointermove", follow);
    chart.addEventListener("pointerdown", follow);
    chart.addEventListener("pointerleave", leave);
    chart.addEventListener("blur", leave);
    chart.tabIndex = 0;
    chart.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (event.key === "Escape") leave();
      if (!step) return;
      event.preventDefault();
      show(at < 0 ? 0 : at + step);
    });
  }

  // A chart as a file: its style goes with it, as it shows now.
  const STYLES = ["fill", "fill-opacity", "stroke", "stroke-width", "stroke-dasharray", "stroke-linejoin", "stroke-linecap", "opacity", "paint-order",
    "text-anchor", "font-size", "font-weight", "visibility"];
  const SVG = Object.assign(document.createElement("div"), { innerHTML: "<svg></svg>" }).firstChild.namespaceURI;
  const element = (name, attributes, text) => {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    return made;
  };
  // Other programs know no mixed colours: as a pixel shows it.
  const pen = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const plain = (colour) => {
    if (!/^(ok|color|lab|lch)/.test(colour)) return colour;
    pen.clearRect(0, 0, 1, 1);
    pen.fillStyle = colour;
    pen.fillRect(0, 0, 1, 1);
    return `rgb(${[...pen.getImageData(0, 0, 1, 1).data].slice(0, 3).join(", ")})`;
  };
  const font = () => getComputedStyle(document.body).fontFamily;
  const styled = (part, copy) => {
    const own = getComputedStyle(part);
    for (const key of STYLES) copy.setAttribute(key, plain(own.getPropertyValue(key)));
    for (const key of ["class", "style", "tabindex", "data-mark", "data-v", "data-tip"]) copy.removeAttribute(key);
  };
  // What the colours mean: the list in the figure, or the nearest one before it; of that what the chart shows.
  const keysOf = (figure) => {
    const chart = figure.querySelector("svg.chart, table, .bars");
    const lists = [...(figure.closest("section") ?? document).querySelectorAll(".legend")];
    const before = lists.filter((list) => list.compareDocumentPosition(figure) & Node.DOCUMENT_POSITION_FOLLOWING);
    const entries = [...((figure.querySelector(".legend") ?? before.at(-1) ?? lists[0])?.children ?? [])];
    const shown = entries.filter((entry) => [...entry.querySelectorAll("svg [class]")].flatMap((part) => [...part.classList]).every((name) => chart.getElementsByClassName(name).length > 0));
    return shown.length > 0 ? shown : entries;
  };
  /** Draws the keys of a figure below its chart, in rows of this width; how high they are. */
  const legend = (made, figure, width, top) => {
    let [x, row] = [0, 0];
    const entries = keysOf(figure);
    for (const entry of entries) {
      const [own, symbol] = [getComputedStyle(entry), entry.querySelector("svg")];
      const [, , wide, high] = symbol?.getAttribute("viewBox").split(" ").map(Number) ?? [0, 0, 0, 0];
      pen.font = `${own.fontWeight} 12px ${font()}`;
      const room = wide + 6 + pen.measureText(entry.textContent).width + 16;
      if (x > 0 && x + room > width) [x, row] = [0, row + 1];
      const y = top + row * 20;
      if (symbol) {
        const group = element("g", { transform: `translate(${x} ${y + 8 - high / 2})` });
        for (const part of symbol.children) {
          const copy = part.cloneNode(true);
          styled(part, copy);
          group.append(copy);
        }
        made.append(group);
      }
      made.append(element("text", { x: x + wide + (wide > 0 ? 6 : 0), y: y + 12, "font-size": 12, "font-weight": own.fontWeight, fill: plain(own.color) }, entry.textContent));
      x += room;
    }
    return entries.length > 0 ? (row + 1) * 20 + 12 : 0;
  };
  /** Writes the caption of a figure above its chart, in lines of this width; how high they are. */
  const heading = (made, figure, width) => {
    const lines = [];
    for (const part of figure.querySelectorAll("figcaption > *")) {
      const own = getComputedStyle(part);
      pen.font = `${own.fontWeight} 12px ${font()}`;
      let line = "";
      for (const word of part.textContent.split(/\s+/).filter(Boolean)) {
        const longer = line ? `${line} ${word}` : word;
        const isFull = line !== "" && pen.measureText(longer).width > width;
        if (isFull) lines.push([line, own]);
        line = isFull ? word : longer;
      }
      if (line) lines.push([line, own]);
    }
    lines.forEach(([line, own], i) => made.append(element("text", { x: 0, y: (i + 1 - lines.length) * 16 - 8, "font-size": 12, "font-weight": own.fontWeight, fill: plain(own.color) }, line)));
    return lines.length * 16 + 4;
  };
  // XML has no way to write these.
  const valid = (text) => text.replace(/[\0-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]/g, "\ufffd");
  const sheet = (made, figure, width, height, above = 0) => {
    const below = legend(made, figure, width, height + 12);
    const [w, h, top] = [width + 24, height + 24 + below + above, -12 - above];
    for (const [key, value] of Object.entries({ viewBox: `-12 ${top} ${w} ${h}`, width: w, height: h, "font-family": font() })) made.setAttribute(key, value);
    made.prepend(element("rect", { x: -12, y: top, width: w, height: h, fill: getComputedStyle(figure).backgroundColor }));
    return valid(new XMLSerializer().serializeToString(made));
  };
  const ofChart = (chart) => {
    const copy = chart.cloneNode(true);
    const [from, to] = [chart, copy].map((own) => [own, ...own.querySelectorAll("*")]);
    from.forEach((part, i) => {
      styled(part, to[i]);
      if (part.dataset.tip) to[i].append(element("title", {}, part.dataset.tip));
    });
    const { width, height } = chart.viewBox.baseVal;
    return sheet(copy, chart.closest("figure"), width, height);
  };
  /** The colours of a bar of a ramp, from left to right. */
  const ramp = (bar, steps) => {
    const probe = bar.appendChild(Object.assign(document.createElement("i"), { className: "heat" }));
    const colours = Array.from({ length: steps }, (_, i) => {
      probe.style.setProperty("--t", `${((i + 0.5) / steps) * 100}%`);
      return plain(getComputedStyle(probe).backgroundColor);
    });
    probe.remove();
    return colours;
  };
  /** Draws boxes from a height on: their backgrounds, and each word where it stands. */
  const boxes = (made, box, above) => {
    const frame = box.getBoundingClientRect();
    for (const part of [box, ...box.querySelectorAll("*:not(.unseen)")]) {
      const [own, at] = [getComputedStyle(part), part.getBoundingClientRect()];
      const [x, y, line] = [at.left - frame.left, at.top - frame.top + above, parseFloat(own.borderLeftWidth)];
      // A line is a box that is nothing but its border.
      if (line > 0 && at.width <= line) made.append(element("rect", { x, y, width: line, height: at.height, fill: plain(own.borderLeftColor) }));
      if (part.matches(".ramp-bar")) ramp(part, 24).forEach((fill, i, { length }) => made.append(element("rect", { x: x + (at.width * i) / length, y, width: at.width / length + 0.5, height: at.height, fill })));
      else if (at.width > 0 && own.backgroundColor !== "rgba(0, 0, 0, 0)") made.append(element("rect", { x, y, width: at.width, height: at.height, fill: plain(own.backgroundColor) }));
      for (const node of [...part.childNodes].filter((child) => child.nodeType === Node.TEXT_NODE)) {
        for (const { 0: word, index } of node.data.matchAll(/[^\s-]+-*|-+/g)) {
          const range = document.createRange();
          range.setStart(node, index);
          range.setEnd(node, index + word.length);
          const place = range.getBoundingClientRect();
          const size = parseFloat(own.fontSize);
          // Of a long name as much as its box shows.
          const isCut = own.overflowX === "hidden" && place.right > at.right;
          const letters = isCut ? Math.max(Math.floor((word.length * (at.right - place.left)) / place.width) - 1, 0) : word.length;
          made.append(element("text", { x: place.left - frame.left, y: place.top - frame.top + above + place.height / 2 + size * 0.35, "font-size": size, "font-weight": own.fontWeight, fill: plain(own.color) }, word.slice(0, letters) + (isCut ? "…" : "")));
          if (isCut) break;
        }
      }
    }
    return frame;
  };
  // A chart made of boxes, with what stands around it.
  const ofBoxes = (box) => {
    const [made, figure] = [element("svg", {}), box.closest("figure")];
    const { width, height } = boxes(made, box, 0);
    const key = figure.querySelector(".ramp-legend");
    const below = key ? boxes(made, key, height + 8).height + 8 : 0;
    return sheet(made, figure, width, height + below, heading(made, figure, width));
  };
  /** The chart of a figure as a file; nothing where it has none. */
  const alone = (figure) => {
    const [chart, box] = [figure.querySelector("svg.chart"), figure.querySelector("table, .bars")];
    return chart ? ofChart(chart) : box && ofBoxes(box);
  };
  const save = (name, type, text) => {
    const url = URL.createObjectURL(new Blob([text], { type }));
    Object.assign(document.createElement("a"), { href: url, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(url), 10000);
  };
  const button = (text, label, onclick) => {
    const made = Object.assign(document.createElement("button"), { type: "button", textContent: text, onclick });
    made.setAttribute("aria-label", label);
    return made;
  };
  const quoted = (cell) => (/[",\r\n]/.test(cell) ? `"${cell.replaceAll('"', '""')}"` : cell);
  // A spreadsheet computes a word that begins with one of these: as in `csv.rs`.
  const isNumber = (text) => /^[+-]?((\d+\.?\d*|\.\d+)(e[+-]?\d+)?|inf)$/i.test(text);
  const harmless = (text) => (/^[=+\-@\t\r]/.test(text) && !isNumber(text) ? `'${text}` : text);
  const spelled = (cell) => (typeof cell === "number" && !Number.isFinite(cell) ? `${cell < 0 ? "-" : ""}inf` : String(cell ?? ""));
  const csv = (rows) => rows.map((row) => `${row.map((cell) => quoted(harmless(spelled(cell)))).join(",")}\r\n`).join("");
  const name = (figure) => figure.dataset.chart ?? "chart";
  const svgButton = (figure) => button("SVG", `Save ${name(figure)} as SVG`, () => save(`${name(figure)}.svg`, "image/svg+xml", alone(figure)));
  for (const figure of document.querySelectorAll("figure[data-chart]")) figure.querySelector(".save")?.prepend(svgButton(figure));
  /** For charts that other scripts draw: `rows` gives the table, names first. Who draws says whether there is something to save. */
  const offer = (figure, rows) => {
    const made = Object.assign(document.createElement("p"), { className: "save" });
    made.append(svgButton(figure), button("CSV", `Save ${name(figure)} as CSV`, () => save(`${name(figure)}.csv`, "text/csv", csv(rows()))));
    figure.append(made);
    return { enable: (is) => { for (const own of made.children) own.disabled = !is; } };
  };
  Object.assign(window.rayreel, { alone, csv, offer });

  // The section in sight, in the contents.
  const links = new Map([...document.querySelectorAll("nav a")].map((link) => [link.hash.slice(1), link]));
  const seen = new Set();
  const watch = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (isIntersecting) seen.add(target.id); else seen.delete(target.id);
    }
    const current = [...links.keys()].find((id) => seen.has(id));
    for (const [id, link] of links) {
      if (id !== current) { link.removeAttribute("aria-current"); continue; }
      link.setAttribute("aria-current", "true");
      const list = link.closest("nav");
      if (list.scrollWidth > list.clientWidth) list.scrollTo({ left: link.offsetLeft - 40 });
    }
  }, { rootMargin: "-15% 0px -70% 0px" });
  for (const part of document.querySelectorAll("main > section")) watch.observe(part);

  // Search in the configuration.
  const search = $("config-search");
  if (search) {
    search.closest(".search").hidden = false;
    const rows = [...$("config-values").querySelectorAll("tbody tr")];
    const texts = rows.map((row) => row.textContent.toLowerCase());
    const filter = () => {
      const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
      rows.forEach((row, i) => { row.hidden = !words.every((word) => texts[i].includes(word)); });
      $("config-found").textContent = words.length > 0 ? `${rows.filter((row) => !row.hidden).length} of ${rows.length}` : "";
    };
    search.addEventListener("input", filter);
    addEventListener("beforeprint", () => { search.value = ""; filter(); });
  }

  // Print everything that can be unfolded.
  let folded = [];
  addEventListener("beforeprint", () => {
    folded = [...document.querySelectorAll("details:not([open])")];
    for (const part of folded) part.open = true;
    for (const image of document.images) image.loading = "eager";
  });
  addEventListener("afterprint", () => { for (const part of folded) part.open = false; });
})();
