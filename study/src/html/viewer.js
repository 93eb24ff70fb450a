// The image viewer: two pictures of a set in one stage, compared by slider, by flipping or side by side.
"use strict";
(() => {
  const $ = (id) => document.getElementById(id);
  if (!$("viewer")) return;
  const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
  const count = (value) => value.toLocaleString("en").replaceAll(",", "\u202f");
  const sets = JSON.parse($("viewer-data").textContent);
  const stage = $("viewer-stage");
  const panes = [...stage.querySelectorAll(".pane")];
  const split = stage.querySelector(".split");
  const [left, right, slide, tileLine] = ["left", "right", "slide", "tile"].map((name) => $(`viewer-${name}`));
  const state = { set: sets[0], how: "slider", zoom: 1, x: 0, y: 0, fitted: true, split: 0.5, flipped: false, tile: -1 };
  $("viewer").hidden = false;
  $("viewer-set").append(...sets.map((set, i) => new Option(set.name, i)));

  const columns = () => Math.ceil(state.set.width / state.set.tile);
  const stacked = () => state.how === "side" && stage.clientWidth < 640;
  const paneSize = () => {
    const [w, h] = [stage.clientWidth, stage.clientHeight];
    if (state.how !== "side") return [w, h];
    return stacked() ? [w, h / 2] : [w / 2, h];
  };

  const layout = () => {
    const width = stage.clientWidth;
    const ratio = state.set.height / Math.max(state.set.width, 1);
    const one = state.how === "side" && !stacked() ? (width / 2) * ratio : width * ratio;
    const border = stage.offsetHeight - stage.clientHeight;
    const tall = clamp(Math.ceil(one), 120, innerHeight * (stacked() ? 0.38 : 0.78));
    stage.style.height = `${Math.ceil(tall * (stacked() ? 2 : 1)) + border}px`;
    const [w, h] = paneSize();
    panes.forEach((pane, i) => {
      const [x, y] = state.how !== "side" ? [0, 0] : stacked() ? [0, h * i] : [w * i, 0];
      Object.assign(pane.style, { left: `${x}px`, top: `${y}px`, width: `${w}px`, height: `${h}px` });
    });
    if (state.fitted) fit(); else draw();
  };

  const fitZoom = () => {
    const [w, h] = paneSize();
    return Math.min(w / state.set.width, h / state.set.height);
  };
  const fit = () => {
    state.zoom = fitZoom();
    state.fitted = true;
    draw();
  };
  const zoomTo = (zoom, px, py) => {
    const [w, h] = paneSize();
    const [x, y] = [px ?? w / 2, py ?? h / 2];
    const next = clamp(zoom, Math.min(fitZoom(), 1) * 0.999, 64);
    state.x = x - ((x - state.x) / state.zoom) * next;
    state.y = y - ((y - state.y) / state.zoom) * next;
    state.zoom = next;
    state.fitted = next <= fitZoom() * 1.001;
    draw();
  };

  const draw = () => {
    const { set, zoom, how } = state;
    const [w, h] = paneSize();
    const hold = (at, room, size) => (size <= room ? (room - size) / 2 : clamp(at, room - size, 0));
    state.x = hold(state.x, w, set.width * zoom);
    state.y = hold(state.y, h, set.height * zoom);
    for (const pane of panes) {
      const plane = pane.firstElementChild;
      plane.style.width = `${set.width}px`;
      plane.style.height = `${set.height}px`;
      plane.style.transform = `translate(${state.x}px, ${state.y}px) scale(${zoom})`;
      plane.style.setProperty("--zoom", zoom);
      // A picture that merely fills the stage is smoothed; one that was enlarged shows its pixels.
      plane.classList.toggle("sharp", !state.fitted && zoom >= 2);
    }
    const at = Math.round(state.split * w);
    split.hidden = how !== "slider";
    split.style.left = `${at}px`;
    panes[1].style.clipPath = how === "slider" ? `inset(0 0 0 ${at}px)` : "none";
    panes[1].style.visibility = how === "flip" && !state.flipped ? "hidden" : "visible";
    $("viewer-slide-label").hidden = how !== "slider";
    $("viewer-flip").hidden = how !== "flip";
    $("viewer-zoom").textContent = `${Math.round(zoom * 100)} %`;
    stage.style.touchAction = state.fitted ? "pan-y" : "none";
  };

  const showImages = () => {
    [left, right].forEach((select, i) => {
      const source = $(`picture-${state.set.images[select.value]}`);
      const image = panes[i].querySelector("img");
      if (source) image.src = source.src; else image.removeAttribute("src");
      image.alt = `${select.value}: ${state.set.name}`;
      panes[i].querySelector(".tag").textContent = select.value;
    });
  };

  const chooseSet = (index) => {
    const before = state.set;
    state.set = sets[index];
    const kinds = Object.keys(state.set.images);
    [[left, "reference"], [right, "result"]].forEach(([select, usual], i) => {
      const wanted = [select.value, usual].find((kind) => kinds.includes(kind)) ?? kinds[Math.min(i, kinds.length - 1)];
      select.replaceChildren(...kinds.map((kind) => new Option(kind, kind)));
      select.value = wanted;
    });
    if (before.width !== state.set.width || before.height !== state.set.height) state.fitted = true;
    chooseTile(-1);
    showImages();
    layout();
  };

  const chooseTile = (index) => {
    const { set } = state;
    state.tile = index;
    const [column, row] = [index % columns(), Math.floor(index / columns())];
    for (const pane of panes) {
      const box = pane.querySelector(".box");
      box.hidden = index < 0;
      if (index < 0) continue;
      const [x, y] = [column * set.tile, row * set.tile];
      Object.assign(box.style, {
        left: `${x}px`, top: `${y}px`, width: `${Math.min(set.tile, set.width - x)}px`, height: `${Math.min(set.tile, set.height - y)}px`,
      });
    }
    tileLine.textContent = index < 0 ? "Point at a tile for its numbers." : describe(set.tiles[index], index, column, row);
  };
  const describe = (tile, index, column, row) => {
    const place = `Tile ${index} (column ${column}, row ${row})`;
    if (!tile) return `${place}: no numbers.`;
    const [full, traced, rate, similar, psnr] = tile;
    const percent = (share) => `${(share * 100).toFixed(1)}\u202f%`;
    return `${place}: ${[
      `${count(traced)} of ${count(full)} rays traced${full > 0 ? ` (${percent(traced / full)})` : ""}`,
      `mean rate ${rate.toFixed(3)}`,
      similar === null ? "nothing to interpolate" : `${percent(similar)} similar`,
      psnr === null ? "identical" : `PSNR ${psnr.toFixed(2)}\u202fdB`,
    ].join(", ")}.`;
  };

  // Where a pointer is: in its pane, and in the picture.
  const locate = (event) => {
    const box = stage.getBoundingClientRect();
    const [w, h] = paneSize();
    const [x, y] = [(event.clientX - box.left - stage.clientLeft) % w, (event.clientY - box.top - stage.clientTop) % h];
    return { x, y, px: (x - state.x) / state.zoom, py: (y - state.y) / state.zoom };
  };
  const tileAt = ({ px, py }) => {
    const { set } = state;
    const inside = px >= 0 && py >= 0 && px < set.width && py < set.height && set.tile > 0;
    return inside ? Math.floor(py / set.tile) * columns() + Math.floor(px / set.tile) : -1;
  };
  const setSplit = (share) => {
    state.split = clamp(share, 0, 1);
    slide.value = String(Math.round(state.split * 1000));
    draw();
  };
  const flip = () => { state.flipped = !state.flipped; draw(); };
  const setHow = (how) => {
    state.how = how;
    state.flipped = false;
    document.querySelector(`[name="viewer-how"][value="${how}"]`).checked = true;
    layout();
  };

  const pointers = new Map();
  let moved = 0;
  stage.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    pointers.set(event.pointerId, event);
    moved = 0;
    if (event.target === split) stage.setPointerCapture(event.pointerId);
  });
  stage.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) {
      if (event.target !== split) chooseTile(tileAt(locate(event)));
      return;
    }
    const [dx, dy] = [event.clientX - before.clientX, event.clientY - before.clientY];
    moved += Math.abs(dx) + Math.abs(dy);
    const others = [...pointers.values()].filter((other) => other.pointerId !== event.pointerId);
    pointers.set(event.pointerId, event);
    if (before.target === split && others.length === 0) {
      const box = stage.getBoundingClientRect();
      setSplit((event.clientX - box.left) / box.width);
    } else if (others.length === 1) {
      const distance = (a) => Math.hypot(a.clientX - others[0].clientX, a.clientY - others[0].clientY);
      const { x, y } = locate(others[0]);
      zoomTo(state.zoom * (distance(event) / Math.max(distance(before), 1)), x, y);
    } else if (!state.fitted && moved > 4) {
      if (!stage.hasPointerCapture(event.pointerId)) stage.setPointerCapture(event.pointerId);
      stage.classList.add("moving");
      state.x += dx;
      state.y += dy;
      draw();
    }
  });
  const release = (event) => {
    const down = pointers.get(event.pointerId);
    pointers.delete(event.pointerId);
    stage.classList.remove("moving");
    if (event.type !== "pointerup" || !down || moved > 6 || down.target === split) return;
    chooseTile(tileAt(locate(event)));
    if (state.how === "flip") flip();
  };
  stage.addEventListener("pointerup", release);
  stage.addEventListener("pointercancel", release);
  stage.addEventListener("dblclick", (event) => {
    const { x, y } = locate(event);
    if (state.fitted) zoomTo(Math.max(8, state.zoom * 2), x, y); else fit();
  });
  stage.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    const { x, y } = locate(event);
    zoomTo(state.zoom * 2 ** (-event.deltaY / 240), x, y);
  }, { passive: false });
  stage.addEventListener("keydown", (event) => {
    if (event.altKey || event.ctrlKey || event.metaKey) return;
    const last = columns() * Math.ceil(state.set.height / state.set.tile) - 1;
    const step = { ArrowRight: 1, ArrowLeft: -1, ArrowDown: columns(), ArrowUp: -columns() }[event.key];
    const keys = {
      "+": () => zoomTo(state.zoom * 2), "=": () => zoomTo(state.zoom * 2), "-": () => zoomTo(state.zoom / 2), 0: fit,
      f: () => { if (state.how === "flip") flip(); else setHow("flip"); },
      s: () => { [left.value, right.value] = [right.value, left.value]; showImages(); },
      Escape: () => chooseTile(-1),
    };
    const act = step ? () => moveTile(step, last) : keys[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!act) return;
    event.preventDefault();
    act();
  });
  const moveTile = (step, last) => {
    const next = state.tile < 0 ? 0 : state.tile + step;
    if (next < 0 || next > last) return;
    chooseTile(next);
    // Keep the tile in sight.
    const [w, h] = paneSize();
    const { tile } = state.set;
    const [x, y] = [(next % columns()) * tile * state.zoom, Math.floor(next / columns()) * tile * state.zoom];
    const size = tile * state.zoom;
    state.x = clamp(state.x, -x, Math.max(w - x - size, -x));
    state.y = clamp(state.y, -y, Math.max(h - y - size, -y));
    draw();
  };

  $("viewer-set").addEventListener("change", (event) => chooseSet(Number(event.target.value)));
  left.addEventListener("change", showImages);
  right.addEventListener("change", showImages);
  for (const radio of document.getElementsByName("viewer-how")) radio.addEventListener("change", () => setHow(radio.value));
  $("viewer-in").addEventListener("click", () => zoomTo(state.zoom * 2));
  $("viewer-out").addEventListener("click", () => zoomTo(state.zoom / 2));
  $("viewer-fit").addEventListener("click", fit);
  $("viewer-pixels").addEventListener("click", () => zoomTo(8));
  $("viewer-flip").addEventListener("click", flip);
  slide.addEventListener("input", () => setSplit(Number(slide.value) / 1000));
  new ResizeObserver(() => { if (stage.clientWidth !== state.seenWidth) { state.seenWidth = stage.clientWidth; layout(); } }).observe(stage);
  chooseSet(0);
})();
