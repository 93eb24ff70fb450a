// Which points no other beats, as in `pareto.rs`.
"use strict";
sweep.front = (rows, x, y, goals) => {
  const [sx, sy] = goals.map((goal) => (goal === "max" ? -1 : 1));
  const points = rows.map((row) => [sx * sweep.value(x, row), sy * sweep.value(y, row), row]);
  points.sort((a, b) => a[0] - b[0] || a[1] - b[1] || a[2] - b[2]);
  const front = [];
  let last;
  for (const point of points) {
    if (!last || point[1] < last[1] || (point[1] === last[1] && point[0] === last[0])) {
      front.push(point[2]);
      last = point;
    }
  }
  return front;
};
