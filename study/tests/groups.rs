//! Points that share a replay: each result is what the point gives by itself.

use std::path::PathBuf;
use std::sync::Arc;

use rayreel_formats::Limits;
use rayreel_formats::trace::Trace;
use rayreel_machine::config::NamedMachine;
use rayreel_replay::{NamedPolicy, PathSource, Stop};
use rayreel_study::point::compute::{compute, compute_all, compute_rows};
use rayreel_study::point::key::Point;
use rayreel_study::point::task::Missing;
use rayreel_study::point::wanted::{Kind, PictureWanted, Views};

fn trace() -> Trace {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../traces/v1_0_cornell.rtrace");
    Trace::open(&path, Limits::default()).unwrap()
}

/// Points of three machines and of none, the second with pictures.
fn points(detail: &str, machines: &[&str]) -> Vec<Point> {
    let policy = NamedPolicy::load("adaptive", &[]).unwrap();
    let frames = (trace().meta().first_frame, 1);
    let point = |machine: &&str| {
        let machine = (*machine != "none").then(|| NamedMachine::load(machine, &[]).unwrap());
        Point { detail: detail.parse().unwrap(), ..Point::plain("cornell", frames, machine, policy.clone()) }
    };
    let mut all: Vec<Point> = machines.iter().map(point).collect();
    let picture = |kind| PictureWanted { frame: frames.0, kind, shrink: 1 };
    all[1].wanted.views = Views { tiles: true, pictures: vec![picture(Kind::Result), picture(Kind::Flip)] };
    all
}

#[test]
fn together_each_is_as_by_itself() {
    let (trace, stop) = (trace(), Stop::never());
    let tree = trace.topology();
    for detail in ["full", "counts", "all"] {
        let points = points(detail, &["sgrt-ti2", "sgrt-ti1", "sgrt-ti2-rob", "none"]);
        assert!(points.iter().all(|point| point.shares_replay(&points[0])));
        let wanted: Vec<_> = points.iter().map(|point| (point, Missing::all(point))).collect();
        let together = compute_all(&wanted, (&trace, Some(&tree)), &stop, |_, _| {}).unwrap();
        for (i, ((point, missing), together)) in wanted.iter().zip(&together).enumerate() {
            let alone = compute(point, *missing, (&trace, Some(&tree)), &stop, |_, _| {}).unwrap();
            assert!(*together == alone, "{detail}: point {i}");
            assert_eq!(together.details.is_some(), i == 1);
        }
        let cycles = |i: usize| together[i].row.as_ref().unwrap().0.figures["cycles"].clone();
        assert!(cycles(3).is_null() && (detail == "counts" || cycles(0) != cycles(1)));
    }
}

#[test]
fn none_pays_for_another_that_fails() {
    let (trace, stop) = (trace(), Stop::never());
    let tree = trace.topology();
    // It has no kernels for adaptive sampling.
    let points = points("full", &["sgrt-ti2", "raycore", "sgrt-ti1"]);
    let keys: Vec<String> = points.iter().map(|point| point.row_key().unwrap()).collect();
    let wanted: Vec<_> = points.iter().zip(&keys).collect();
    let rows = compute_rows(&wanted, (&trace, &tree), &stop, |_, _| {});
    let failed: Vec<bool> = rows.iter().map(|row| row.as_ref().unwrap().0.error.is_some()).collect();
    assert_eq!(failed, [false, true, false]);
}

#[test]
fn other_policies_frames_and_details_do_not_share() {
    let all = points("full", &["sgrt-ti2", "sgrt-ti1"]);
    let policy = Arc::new(NamedPolicy::load("full", &[]).unwrap());
    let others = [
        Point { policy, ..all[0].clone() },
        Point { frames: (0, 2), ..all[0].clone() },
        Point { source: "other".into(), ..all[0].clone() },
        Point { detail: "0.1".parse().unwrap(), ..all[0].clone() },
    ];
    assert!(others.iter().all(|other| !other.shares_replay(&all[0])));
}
