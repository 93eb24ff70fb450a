//! What counters show.

use super::*;

#[test]
fn shares_are_of_the_peak_and_levels_are_as_they_are() {
    let shown = |kind: Kind, looks: &[(u64, u64)]| {
        let mut timeline = Timeline::new(&crate::config::NamedMachine::load("sgrt-ti2", &[]).unwrap().config);
        timeline.tracks = vec![Track { core: None, name: String::new(), kind }];
        let look = |&(at, value): &(u64, u64)| Look { at: TiCycle(at), values: vec![value] };
        timeline.looks = looks.iter().map(look).collect();
        timeline.shown(0)
    };
    assert_eq!(shown(Kind::Grows(1, 1), &[(0, 10), (200, 110)]), ["50.00"]);
    // An array that runs two of its cycles a T&I cycle; a bus that moves 51.2 bytes a T&I cycle.
    assert_eq!(shown(Kind::GrewBefore(1000, 500), &[(0, 0), (200, 300)]), ["75.00"]);
    assert_eq!(shown(Kind::Grows(256, 5), &[(0, 0), (100, 512)]), ["10.00"]);
    assert_eq!(shown(Kind::Grows(1, 1), &[(0, 0), (3, 2)]), ["66.67"]);
    assert_eq!(shown(Kind::Level, &[(0, 3), (7, 9)]), ["3"]);
    // 250 cycles that are booked at once take two steps and a half: those before where they are booked at their end, else those after.
    let looks = [(0, 0), (100, 0), (200, 0), (300, 250), (400, 250), (500, 250)];
    assert_eq!(shown(Kind::GrewBefore(1, 1), &looks), ["50.00", "100.00", "100.00", "0.00", "0.00"]);
    assert_eq!(shown(Kind::Grows(1, 1), &looks), ["0.00", "0.00", "100.00", "100.00", "50.00"]);
    // Nothing is lost where there is no room.
    assert_eq!(shown(Kind::GrewBefore(1, 1), &[(0, 0), (100, 250), (200, 400)]), ["100.00", "300.00"]);
    // Nor does anything go where it cannot have been: what was booked at the end was done before it.
    assert_eq!(shown(Kind::Grows(1, 1), &[(0, 0), (100, 0), (200, 150)]), ["50.00", "100.00"]);
    assert_eq!(shown(Kind::GrewBefore(1, 1), &[(0, 0), (100, 150), (200, 150)]), ["100.00", "50.00"]);
}

#[test]
fn thinning_keeps_the_first_and_the_last_look() {
    let config = crate::config::NamedMachine::load("sgrt-ti2", &[]).unwrap().config;
    let mut timeline = Timeline::new(&config);
    let looks = LOOKS_MAX as u64 * 4 + 1;
    for at in 0..looks {
        timeline.look(TiCycle(at * DISTANCE_CYCLES), &[], at);
    }
    assert!(timeline.looks.len() <= LOOKS_MAX && timeline.distance_cycles > DISTANCE_CYCLES);
    let ends = [timeline.looks.first(), timeline.looks.last()].map(|look| look.unwrap().values.clone());
    assert_eq!(ends, [vec![0], vec![looks - 1]]);
}
