//! Points of two values that are both better when larger, with the frontier: what no other point beats in both.

use crate::html::charts::WIDTH;
use crate::html::charts::chart::{Chart, Data, Key, cell, ends, once, percent_cell};
use crate::html::charts::scale::{Scale, extent};
use crate::html::charts::svg::{Svg, marker, n, text_width, told_apart};
use crate::html::text::escape;
use crate::point::known::interval_of;

/// A point.
pub struct Dot {
    /// Its name.
    pub name: String,
    /// The horizontal value; none is infinite: the PSNR of an identical picture.
    pub x: Option<f64>,
    /// The vertical value.
    pub y: f64,
    /// Half the interval of the vertical value, a part of it; nothing where it is exact.
    pub within: Option<f64>,
    /// Colour class.
    pub class: String,
    /// Shape of its marker.
    pub shape: usize,
    /// What it says when asked.
    pub tip: String,
}

impl Dot {
    fn x_or_infinity(&self) -> f64 {
        self.x.unwrap_or(f64::INFINITY)
    }

    /// Whether this point is at least as good in both and better in one.
    fn beats(&self, other: &Self) -> bool {
        let (x, y) = (self.x_or_infinity(), other.x_or_infinity());
        x >= y && self.y >= other.y && (x > y || self.y > other.y)
    }
}

/// Which points no other beats.
pub fn frontier(dots: &[Dot]) -> Vec<bool> {
    dots.iter().map(|dot| !dots.iter().any(|other| other.beats(dot))).collect()
}

/// More names than this are no legend.
const KEYS_MAX: usize = 24;

/// Height of the chart.
const HEIGHT: f64 = 270.0;

/// Draws the points; `names` say what the axes show, `label` describes the chart.
pub fn scatter(dots: &[Dot], names: [&str; 2], label: &str) -> Chart {
    let best = frontier(dots);
    let identical = dots.iter().any(|d| d.x.is_none());
    let [top, bottom] = [24.0, HEIGHT - 38.0];
    let right = if identical { WIDTH - 58.0 } else { WIDTH - 10.0 };
    let [low, high] = extent(dots.iter().filter_map(|d| d.x)).unwrap_or([30.0, 50.0]);
    let pad = ((high - low) * 0.04).max(0.5);
    let [_, most] = extent(dots.iter().map(|d| ends(d.y, d.within)[1])).unwrap_or([0.0, 1.0]);
    let y = Scale::nice([0.0, most * 1.05], 5, [bottom, top]);
    let left = y.margin(36.0, |tick| y.label(tick) + "×");
    let x = Scale::nice([low - pad, high + pad], 5, [left, right]);
    let mut svg = Svg::new(WIDTH, HEIGHT);
    axes(&mut svg, &x, &y, identical, names);
    let place = |dot: &Dot| [dot.x.map_or(WIDTH - 22.0, |v| x.at(v)), y.at(dot.y)];
    stairs(&mut svg, dots, &best, place, [left, bottom]);
    // The frontier last, so that no dimmed point covers it.
    for wanted in [false, true] {
        for (dot, _) in dots.iter().zip(&best).filter(|(_, on)| **on == wanted) {
            let ([px, py], dim) = (place(dot), if wanted { "" } else { " dim" });
            svg.upright_interval(px, ends(dot.y, dot.within).map(|end| y.at(end)), &format!("within{dim}"));
            svg.raw(&format!(
                "<path d=\"{}\" class=\"dot {}{dim}\" data-mark=\"\"><title>{}</title></path>",
                marker(dot.shape, px, py),
                dot.class,
                escape(&dot.tip)
            ));
        }
    }
    names_of(&mut svg, dots, &best, place, [left, WIDTH - 2.0, top - 12.0, bottom]);
    let mut data = Data::new(&["name", names[0], names[1], &interval_of(names[1]), "frontier"]);
    for (dot, on) in dots.iter().zip(&best) {
        let (x, y, within) = (cell(Some(dot.x_or_infinity())), cell(Some(dot.y)), percent_cell(dot.within));
        data.row(vec![dot.name.clone(), x, y, within, on.to_string()]);
    }
    let keys = once(dots.iter().map(|dot| Key::of_marker(&dot.class, dot.shape, &dot.name)));
    // Of many points only those on the frontier have their names in the picture.
    let keys = if keys.len() <= KEYS_MAX { keys } else { Vec::new() };
    Chart { svg: svg.finish(label, ""), data, keys }
}

fn axes(svg: &mut Svg, x: &Scale, y: &Scale, identical: bool, [x_name, y_name]: [&str; 2]) {
    let ([left, right], [bottom, top]) = (x.range, y.range);
    let end = if identical { WIDTH - 4.0 } else { right };
    for tick in y.ticks() {
        svg.line([left, y.at(tick)], [end, y.at(tick)], "grid");
        svg.text(left - 5.0, y.at(tick) + 4.0, "tick e", &(y.label(tick) + "×"));
    }
    for (tick, text) in x.named_ticks(|tick| x.label(tick)) {
        svg.line([x.at(tick), top], [x.at(tick), bottom], "grid");
        svg.text(x.at(tick), bottom + 15.0, "tick m", &text);
    }
    if identical {
        svg.rect([end - 36.0, top, 36.0, bottom - top], "apart");
        svg.text(WIDTH - 22.0, bottom + 15.0, "tick m", "same");
    }
    svg.line([left, y.at(1.0)], [end, y.at(1.0)], "one");
    svg.line([left, bottom], [end, bottom], "axis");
    svg.text(left, 11.0, "note s", y_name);
    svg.text(end, bottom + 32.0, "note e", x_name);
}

/// The frontier as stairs: everything below and to the left of it is beaten.
fn stairs(svg: &mut Svg, dots: &[Dot], best: &[bool], place: impl Fn(&Dot) -> [f64; 2], [left, bottom]: [f64; 2]) {
    let mut points: Vec<[f64; 2]> = dots.iter().zip(best).filter(|(_, on)| **on).map(|(dot, _)| place(dot)).collect();
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(b[1].total_cmp(&a[1])));
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return };
    let mut d = format!("M{} {}H{}", n(left), n(first[1]), n(first[0]));
    for pair in points.windows(2) {
        d += &format!("V{}H{}", n(pair[1][1]), n(pair[1][0]));
    }
    d += &format!("M{} {}V{}", n(last[0]), n(last[1]), n(bottom));
    svg.path(&d, "frontier", "");
}

/// Names of the points on the frontier, each where it covers nothing, if there is such a place.
fn names_of(svg: &mut Svg, dots: &[Dot], best: &[bool], place: impl Fn(&Dot) -> [f64; 2], frame: [f64; 4]) {
    let [left, right, top, bottom] = frame;
    let mut taken: Vec<[f64; 4]> = dots.iter().map(|d| around(place(d))).collect();
    let on: Vec<&Dot> = dots.iter().zip(best).filter(|(_, on)| **on).map(|(dot, _)| dot).collect();
    let texts = told_apart(&on.iter().map(|dot| dot.name.as_str()).collect::<Vec<_>>(), 16);
    for (dot, text) in on.into_iter().zip(&texts) {
        let ([x, y], width) = (place(dot), text_width(text));
        let tries = [
            (x + 9.0, y - 2.0, "s"),
            (x - 9.0, y - 4.0, "e"),
            (x + 4.0, y - 10.0, "s"),
            (x - 4.0, y - 10.0, "e"),
            (x + 9.0, y + 12.0, "s"),
            (x - 9.0, y + 13.0, "e"),
        ];
        for (tx, ty, align) in tries {
            let start = if align == "s" { tx } else { tx - width };
            let room = [start, start + width, ty - 9.0, ty + 2.0];
            let inside = room[0] >= left && room[1] <= right && room[2] >= top && room[3] <= bottom;
            if inside && !taken.iter().any(|other| overlap(other, &room)) {
                svg.text(tx, ty, &format!("name {align}"), text);
                taken.push(room);
                break;
            }
        }
    }
}

/// The room of a marker: left, right, top, bottom.
fn around([x, y]: [f64; 2]) -> [f64; 4] {
    [x - 6.0, x + 6.0, y - 6.0, y + 6.0]
}

fn overlap(a: &[f64; 4], b: &[f64; 4]) -> bool {
    a[0] < b[1] && b[0] < a[1] && a[2] < b[3] && b[2] < a[3]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dot(x: Option<f64>, y: f64) -> Dot {
        Dot { name: "a".into(), x, y, within: None, class: "p0".into(), shape: 0, tip: String::new() }
    }

    #[test]
    fn the_frontier_is_what_nothing_beats() {
        let dots =
            [dot(Some(40.0), 3.0), dot(Some(45.0), 2.0), dot(Some(39.0), 2.9), dot(None, 1.0), dot(Some(45.0), 2.0)];
        assert_eq!(frontier(&dots), [true, true, false, true, true], "equal points do not beat each other");
    }

    #[test]
    fn intervals_are_as_dim_as_their_points_and_stand_in_the_file() {
        let within = |x, y, within| Dot { within, ..dot(Some(x), y) };
        let dots = [within(40.0, 3.0, Some(0.1)), within(39.0, 2.0, Some(0.2)), within(45.0, 1.0, None)];
        let chart = scatter(&dots, ["x", "y"], "label");
        let count = |class: &str| chart.svg.matches(&format!("class=\"{class}\"")).count();
        assert_eq!((count("within"), count("within dim")), (1, 1), "{}", chart.svg);
        let csv = "name,x,y,y_interval_percent,frontier\r\na,40,3,10,true\r\na,39,2,20,false\r\na,45,1,,true\r\n";
        assert_eq!(chart.data.csv(), csv);
    }

    #[test]
    fn any_points_can_be_drawn() {
        for dots in [vec![], vec![dot(None, 1.0)], vec![dot(Some(f64::MAX), f64::MAX), dot(Some(f64::MIN), 0.0)]] {
            let svg = scatter(&dots, ["x", "y"], "label").svg;
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
    }
}
