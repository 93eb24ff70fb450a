// The pictures of a replay over its frames: a slider, and play.
"use strict";
(() => {
  const $ = (id) => document.getElementById(id);
  const { frames, pictures } = JSON.parse($("player-data").textContent);
  const player = $("player");
  if (!player || frames.length < 2) return;
  const [slider, play, fps, number] = [$("frame"), $("play"), $("fps"), $("frame-number")];
  slider.max = frames.length - 1;
  player.hidden = false;

  const show = (place) => {
    slider.value = place;
    slider.setAttribute("aria-valuetext", `frame ${frames[place]}`);
    number.textContent = frames[place];
    for (const [kind, all] of Object.entries(pictures)) $(`picture-${kind}`).src = `data:image/png;base64,${all[place]}`;
  };
  show(0);

  let timer;
  const next = () => {
    show((Number(slider.value) + 1) % frames.length);
    timer = setTimeout(next, 1000 / Number(fps.value));
  };
  const stop = () => {
    clearTimeout(timer);
    timer = undefined;
    play.textContent = "Play";
    play.setAttribute("aria-pressed", "false");
  };
  play.addEventListener("click", () => {
    if (timer !== undefined) return stop();
    play.textContent = "Pause";
    play.setAttribute("aria-pressed", "true");
    timer = setTimeout(next, 1000 / Number(fps.value));
  });
  slider.addEventListener("input", () => { stop(); show(Number(slider.value)); });
})();
