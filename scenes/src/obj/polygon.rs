//! Cutting polygons into triangles.

use glam::DVec3;

/// Above this many corners a concave polygon is cut as a fan: ear cutting is cubic at worst.
const MAX_EAR_CORNERS: usize = 512;

/// Corner indices of the triangles of a polygon: a fan from corner 0 for a convex one, as
/// everywhere, and ears for a concave one. `false` when ears could not be cut and a fan had to do.
///
/// A corner that stands where the one before it stands has no part in it.
pub(crate) fn triangulate(points: &[DVec3]) -> (Vec<[usize; 3]>, bool) {
    let mut kept: Vec<usize> = (0..points.len()).collect();
    kept.dedup_by(|a, b| points[*a] == points[*b]);
    while kept.len() > 1 && points[kept[0]] == points[kept[kept.len() - 1]] {
        kept.pop();
    }
    if kept.len() < 3 || kept.len() == points.len() {
        return cut(points);
    }
    let corners: Vec<DVec3> = kept.iter().map(|&corner| points[corner]).collect();
    let (triangles, exact) = cut(&corners);
    (triangles.into_iter().map(|triangle| triangle.map(|corner| kept[corner])).collect(), exact)
}

fn cut(points: &[DVec3]) -> (Vec<[usize; 3]>, bool) {
    let count = points.len();
    let normal = area_normal(points);
    let fan = || (1..count.saturating_sub(1)).map(|i| [0, i, i + 1]).collect();
    let corners = || (0..count).map(|i| [(i + count - 1) % count, i, (i + 1) % count]);
    if normal == DVec3::ZERO && count > 3 {
        // Of a bow tie as much lies on one side as on the other: nobody can tell what it encloses.
        return (fan(), is_line(points));
    }
    // A star that is drawn in one line turns left everywhere, but twice round.
    let once = once_round(points, normal, corners());
    let convex = once && corners().all(|corner| turn(points, normal, corner) >= -1e-9);
    if count <= 3 || convex || count > MAX_EAR_CORNERS {
        return (fan(), count <= 3 || convex);
    }
    let mut left: Vec<usize> = (0..count).collect();
    let mut triangles = Vec::with_capacity(count - 2);
    while left.len() > 3 {
        let n = left.len();
        let ear = (0..n).find(|&i| is_ear(points, normal, &left, i));
        // A polygon that crosses itself may have no ear; a fan over the rest loses nothing that was
        // defined.
        let Some(i) = ear else { break };
        triangles.push([left[(i + n - 1) % n], left[i], left[(i + 1) % n]]);
        left.remove(i);
    }
    let exact = once && left.len() == 3;
    triangles.extend((1..left.len() - 1).map(|i| [left[0], left[i], left[i + 1]]));
    (triangles, exact)
}

/// Unit normal by Newell's sum; zero for a polygon without area.
fn area_normal(points: &[DVec3]) -> DVec3 {
    let origin = points.first().copied().unwrap_or_default();
    let sum: DVec3 = points
        .iter()
        .zip(points.iter().cycle().skip(1))
        .map(|(a, b)| (*a - origin).cross(*b - origin))
        .fold(DVec3::ZERO, |sum, c| sum + c);
    sum.normalize_or_zero()
}

/// Whether all corners lie on one line.
fn is_line(points: &[DVec3]) -> bool {
    let from = |point: &DVec3| *point - points[0];
    let far = points.iter().map(from).max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    let far = far.unwrap_or_default();
    points.iter().all(|point| from(point).cross(far).length() <= 1e-9 * far.length_squared())
}

/// Sine-like measure of the turn at the middle corner: positive turns left, relative to the lengths
/// of the sides.
fn turn(points: &[DVec3], normal: DVec3, [a, b, c]: [usize; 3]) -> f64 {
    let (first, second) = (points[b] - points[a], points[c] - points[b]);
    let scale = first.length() * second.length();
    if scale > 0.0 { first.cross(second).dot(normal) / scale } else { 0.0 }
}

/// Whether the sides turn once round: twice, or not at all, in a polygon that crosses itself.
fn once_round(points: &[DVec3], normal: DVec3, corners: impl Iterator<Item = [usize; 3]>) -> bool {
    let angle = |[a, b, c]: [usize; 3]| {
        let (first, second) = (points[b] - points[a], points[c] - points[b]);
        libm::atan2(first.cross(second).dot(normal), first.dot(second))
    };
    (corners.map(angle).sum::<f64>() - std::f64::consts::TAU).abs() < 1.0
}

fn is_ear(points: &[DVec3], normal: DVec3, left: &[usize], i: usize) -> bool {
    let n = left.len();
    let [a, b, c] = [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
    if turn(points, normal, [a, b, c]) <= 1e-9 {
        return false;
    }
    let side = |p: DVec3, q: DVec3, x: DVec3| (q - p).cross(x - p).dot(normal);
    left.iter().filter(|k| ![a, b, c].contains(k)).all(|&k| {
        let x = points[k];
        let inside = side(points[a], points[b], x) >= 0.0
            && side(points[b], points[c], x) >= 0.0
            && side(points[c], points[a], x) >= 0.0;
        !inside || x == points[a] || x == points[b] || x == points[c]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_concave_arrow_keeps_its_area() {
        let arrow = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 0.5]].map(|[x, y]| DVec3::new(x, y, 0.0));
        for shift in 0..4 {
            let points: Vec<DVec3> = (0..4).map(|i| arrow[(i + shift) % 4]).collect();
            let (triangles, exact) = triangulate(&points);
            assert!(exact);
            let areas: Vec<f64> = triangles
                .iter()
                .map(|t| (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).z / 2.0)
                .collect();
            assert!(areas.iter().all(|a| *a > 0.0), "{areas:?}");
            assert!((areas.iter().sum::<f64>() - 1.5).abs() < 1e-12, "{areas:?}");
        }
    }

    /// A hole is reached by a side that is gone along twice.
    #[test]
    fn a_hole_that_is_bridged_stays_open() {
        let square = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
        let hole = [[1.0, 1.0], [1.0, 3.0], [3.0, 3.0], [3.0, 1.0]];
        // The corner of the hole that lies behind it is seen from no corner of the square.
        let seen =
            (0..160).map(|i| (i % 4, i / 4 % 4, i / 16)).filter(|&(square, hole, _)| hole != [2, 1, 0, 3][square]);
        for (of_square, of_hole, first) in seen {
            let ring = |corners: [[f64; 2]; 4], from: usize| (0..5).map(move |i| corners[(from + i) % 4]);
            let mut corners: Vec<[f64; 2]> = ring(square, of_square).chain(ring(hole, of_hole)).collect();
            corners.rotate_left(first);
            let points: Vec<DVec3> = corners.into_iter().map(|[x, y]| DVec3::new(x, y, 0.0)).collect();
            let (triangles, exact) = triangulate(&points);
            let areas =
                triangles.iter().map(|t| (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).z / 2.0);
            let areas: Vec<f64> = areas.collect();
            assert!(exact && areas.iter().all(|area| *area >= 0.0), "{of_square} {of_hole} {first}: {areas:?}");
            assert!((areas.iter().sum::<f64>() - 12.0).abs() < 1e-12, "{of_square} {of_hole} {first}: {areas:?}");
        }
    }

    #[test]
    fn a_bow_tie_is_not_exact_and_a_line_is() {
        let of = |corners: [[f64; 2]; 4]| triangulate(&corners.map(|[x, y]| DVec3::new(x, y, 0.0)));
        for high in [1.0, 1.001] {
            let (triangles, exact) = of([[0.0, 0.0], [1.0, high], [1.0, 0.0], [0.0, 1.0]]);
            assert!(!exact && triangles.len() == 2, "{high}");
        }
        assert!(of([[0.0, 0.0], [1.0, 1.0], [3.0, 3.0], [2.0, 2.0]]).1);
    }

    #[test]
    fn a_corner_that_is_repeated_changes_nothing() {
        let arrow = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        for (shift, again) in (0..4).flat_map(|shift| (0..4).map(move |again| (shift, again))) {
            let mut points: Vec<DVec3> = (0..4).map(|i| arrow[(i + shift) % 4]).collect();
            points.insert(again, points[again]);
            let (triangles, exact) = triangulate(&points);
            let area = |t: &[usize; 3]| (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).z / 2.0;
            let areas: Vec<f64> = triangles.iter().map(area).collect();
            assert!(exact && areas.len() == 2 && areas.iter().all(|area| *area > 0.0), "{points:?}: {areas:?}");
            assert!((areas.iter().sum::<f64>() - 6.0).abs() < 1e-12, "{areas:?}");
        }
        let triangle = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 0.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        assert_eq!(triangulate(&triangle), (vec![[0, 1, 2]], true));
    }

    #[test]
    fn a_star_in_one_line_is_not_convex() {
        let at = |i: u32| {
            let angle = std::f64::consts::TAU * f64::from(i) / 5.0;
            DVec3::new(libm::cos(angle), libm::sin(angle), 0.0)
        };
        let (triangles, exact) = triangulate(&[0, 2, 4, 1, 3].map(at));
        assert_eq!((triangles.len(), exact), (3, false));
        assert!(triangulate(&[0, 1, 2, 3, 4].map(at)).1);
    }

    #[test]
    fn a_polygon_without_area_still_gives_triangles() {
        assert_eq!(triangulate(&[DVec3::ZERO; 5]).0.len(), 3);
        assert_eq!(triangulate(&[DVec3::ZERO; 2]).0.len(), 0);
    }

    #[test]
    fn a_huge_concave_polygon_is_a_fan_that_says_so() {
        let star: Vec<DVec3> = (0..2000)
            .map(|i| {
                let angle = std::f64::consts::TAU * f64::from(i) / 2000.0;
                DVec3::new(libm::cos(angle), libm::sin(angle), 0.0) * if i % 2 == 0 { 1.0 } else { 0.5 }
            })
            .collect();
        let (triangles, exact) = triangulate(&star);
        assert_eq!((triangles.len(), exact), (1998, false));
    }
}
