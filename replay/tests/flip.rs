//! FLIP against values of NVIDIA's own code, and what must hold of any pictures.

use proptest::prelude::*;
use rayreel_replay::image::Srgb8;
use rayreel_replay::image::flip::{FlipMap, PIXELS_PER_DEGREE, flip};

/// Of each pair of pictures at so many pixels per degree: mean over all pixels and the values of three of them, by NVIDIA's flip-evaluator 1.7 from PyPI.
/// `flip_reference.py` beside this file made them.
const REFERENCE: [(&str, f64, f64, [f32; 3]); 10] = [
    ("noise", PIXELS_PER_DEGREE, 0.4441610, [0.9643825, 0.4058432, 0.5391659]),
    ("dim_noise", PIXELS_PER_DEGREE, 0.4419581, [0.4158042, 0.5779575, 0.5578641]),
    ("disc", PIXELS_PER_DEGREE, 0.0774956, [0.0000202, 0.3398933, 0.0000000]),
    ("wires", PIXELS_PER_DEGREE, 0.1208623, [0.0040146, 0.0097423, 0.0085464]),
    ("waves", PIXELS_PER_DEGREE, 0.4456146, [0.1685367, 0.5480126, 0.4006022]),
    ("one_code", PIXELS_PER_DEGREE, 0.0226397, [0.0226397, 0.0226397, 0.0226397]),
    ("extremes", PIXELS_PER_DEGREE, 1.0000000, [1.0000000, 1.0000000, 1.0000000]),
    ("tiny", PIXELS_PER_DEGREE, 0.7117794, [0.9701593, 0.5390843, 0.6019243]),
    ("wires", 30.0, 0.1043355, [0.0000000, 0.0000000, 0.0000000]),
    ("wires", 130.0, 0.1340509, [0.0300743, 0.0816087, 0.0534139]),
];

/// Both compute in f32 but sum in other orders. A feature difference is a square root, so rounding of 1e-7 in equal features
/// becomes 3e-4 in the exponent and up to 1e-4 in a value; other steps stay far below. The mean is nearer.
const NEAR: f32 = 1.0e-4;
const NEAR_MEAN: f64 = 1.0e-5;

fn formula(width: u32, height: u32, pixel: impl Fn(i64, i64) -> [i64; 3]) -> Srgb8 {
    let at = |i: u32| pixel(i64::from(i % width), i64::from(i / width)).map(|v| v as u8);
    Srgb8 { width, height, pixels: (0..width * height).map(at).collect() }
}

fn noise(width: u32, height: u32, seed: u32, brightest: u32) -> Srgb8 {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((state >> 8) % brightest) as u8
    };
    let pixels = (0..width * height).map(|_| [next(), next(), next()]).collect();
    Srgb8 { width, height, pixels }
}

fn disc(edge: i64, red: i64) -> Srgb8 {
    let inside = |x: i64, y: i64| (x - 20).pow(2) + (y - 15).pow(2) < edge;
    formula(60, 40, |x, y| if inside(x, y) { [red, 60, 40] } else { [x * 3 % 256, y * 5 % 256, 128] })
}

fn wires(columns: i64) -> Srgb8 {
    formula(72, 50, |x, y| if x % columns == 0 || y % 7 == 0 { [25, 20, 30] } else { [220, 210, 180] })
}

fn waves(shift: i64) -> Srgb8 {
    let pixel = |x, y| [(x * x + 3 * y * y + shift) / 8 % 256, (x * y + shift) / 4 % 256, (x + y + shift) % 256];
    formula(33, 150, pixel)
}

/// The pictures of a row of [`REFERENCE`], as in `flip_reference.py`.
fn pair(name: &str) -> [Srgb8; 2] {
    let flat = |edge, colour| formula(edge, edge, move |_, _| colour);
    match name {
        "noise" => [1, 2].map(|seed| noise(64, 48, seed, 256)),
        "dim_noise" => [256, 250].map(|brightest| noise(40, 30, 3, brightest)),
        "disc" => [disc(144, 200), disc(121, 190)],
        "wires" => [9, 18].map(wires),
        "waves" => [0, 40].map(waves),
        "one_code" => [flat(30, [100; 3]), flat(30, [101, 100, 100])],
        "extremes" => [flat(24, [0, 255, 0]), flat(24, [0, 0, 255])],
        _ => [5, 6].map(|seed| noise(3, 2, seed, 256)),
    }
}

fn map([a, b]: &[Srgb8; 2]) -> FlipMap {
    flip(a, b, PIXELS_PER_DEGREE).unwrap()
}

#[test]
fn agrees_with_nvidias() {
    for (name, pixels_per_degree, mean, probes) in REFERENCE {
        let [a, b] = pair(name);
        let map = flip(&a, &b, pixels_per_degree).unwrap();
        let (width, height) = (map.width as usize, map.height as usize);
        let places = [(0, 0), (width / 2, height / 2), (width - 1, height / 3)];
        for ((x, y), expected) in places.into_iter().zip(probes) {
            let found = map.values[y * width + x];
            assert!((found - expected).abs() < NEAR, "{name} ({x}, {y}): {found}, {expected} expected");
        }
        assert!((map.mean() - mean).abs() < NEAR_MEAN, "{name}: {}, {mean} expected", map.mean());
    }
}

#[test]
fn any_number_of_threads_gives_the_same() {
    // Several strips of rows.
    let pictures = [1, 2].map(|seed| noise(50, 300, seed, 256));
    let on = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let maps = [1, 2, 5].map(|threads| on(threads).install(|| map(&pictures)));
    assert!(maps.iter().all(|map| *map == maps[0]));
    assert_eq!(maps[0].mean().to_bits(), maps[1].mean().to_bits());
}

/// What is far away makes no difference, whichever strip it is in.
#[test]
fn differences_stay_local() {
    let (a, mut b) = (noise(60, 200, 1, 256), noise(60, 200, 1, 256));
    b.pixels[100 * 60 + 30] = [255, 0, 255];
    let map = map(&[a, b]);
    let reach = 10;
    for (i, &value) in map.values.iter().enumerate() {
        let (x, y) = ((i % 60) as i32, (i / 60) as i32);
        let near = (x - 30).abs() <= reach && (y - 100).abs() <= reach;
        assert_eq!(value > 0.0, near, "({x}, {y}): {value}");
    }
}

fn pictures() -> impl Strategy<Value = [Srgb8; 2]> {
    (1u32..24, 1u32..24, any::<u32>(), any::<u32>(), 1u32..257, 1usize..40).prop_map(|(w, h, s, t, brightest, step)| {
        let a = noise(w, h, s, brightest);
        let mut b = a.clone();
        let other = noise(w, h, t, brightest);
        b.pixels.iter_mut().zip(other.pixels).step_by(step).for_each(|(pixel, new)| *pixel = new);
        [a, b]
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn from_0_to_1_and_the_same_both_ways([a, b] in pictures()) {
        let there = flip(&a, &b, PIXELS_PER_DEGREE).unwrap();
        prop_assert!(there.values.iter().all(|v| (0.0..=1.0).contains(v)));
        prop_assert_eq!(&there, &flip(&b, &a, PIXELS_PER_DEGREE).unwrap());
        prop_assert_eq!(flip(&a, &a, PIXELS_PER_DEGREE).unwrap().mean(), 0.0);
    }
}
