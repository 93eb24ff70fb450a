//! Plans, rows, results, studies.

use std::path::Path;

use rayreel_study::point::segment::{Belonging, decode};
use rayreel_study::{Plan, html, table};

use crate::place;
use crate::seeds;
use crate::target::{Target, text, told};

/// A study of one scene, two policies and a machine, cut down to a few points.
const STUDY: &[u8] = include_bytes!("../../corpus/study/small.json");

pub fn targets() -> Vec<Target> {
    let target = |name, seeds, read, mend| Target { name, seeds, read, change: None, mend };
    vec![
        target("plan", || vec![seeds::PLAN.into()], read_plan, None),
        target(
            "plan-json",
            || vec![seeds::swept().plan.clone()],
            read_stored,
            Some(|bytes: &mut Vec<u8>| mend_plan(bytes)),
        ),
        target("segment", || vec![seeds::swept().segment.clone()], read_segment, Some(mend_segment)),
        target("results", || vec![seeds::swept().results.clone()], read_results, None),
        target("study", || vec![STUDY.to_vec()], read_study, None),
    ]
}

fn read_plan(bytes: &[u8]) -> String {
    let plan = seeds::plan(&text(bytes));
    if let Ok(plan) = &plan {
        let stored = plan.to_json().expect("a plan can be written");
        if plan.points.len() <= 200 {
            assert!(Plan::from_json(&stored).is_ok_and(|again| again.id() == plan.id()), "a plan comes back");
        }
    }
    told(&plan)
}

fn read_stored(bytes: &[u8]) -> String {
    let plan = Plan::from_json(bytes);
    if let Ok(plan) = &plan {
        for (at, point) in plan.points.iter().enumerate().take(20) {
            assert!(!plan.describe(at).is_empty());
            drop(told(&plan.resolve(point)));
        }
    }
    told(&plan)
}

/// The checksum of a plan.
fn mend_plan(bytes: &mut [u8]) {
    let at = "{\"checksum\":\"".len();
    if bytes.len() > at + 34 {
        let sum = blake3::hash(&bytes[at + 34..]).to_hex();
        bytes[at..at + 32].copy_from_slice(&sum.as_bytes()[..32]);
    }
}

fn read_segment(bytes: &[u8]) -> String {
    match decode(bytes, Belonging { plan: "p", bucket: 0 }) {
        Some(rows) => format!("{} rows", rows.len().min(3)),
        None => "no segment".into(),
    }
}

/// The checksum and the number of rows.
fn mend_segment(bytes: &mut Vec<u8>) {
    let Some(end) = bytes.iter().position(|byte| *byte == b'\n') else { return };
    let (rows, crc) =
        (bytes[end + 1..].split_inclusive(|byte| *byte == b'\n').count(), crc32fast::hash(&bytes[end + 1..]));
    let mut head: serde_json::Value = serde_json::from_slice(&bytes[..end]).unwrap_or_default();
    if let Some(head) = head.as_object_mut() {
        head.insert("rows".into(), rows.into());
        head.insert("crc".into(), crc.into());
        let text = serde_json::to_vec(&head).unwrap_or_default();
        bytes.splice(..end, text);
    }
}

/// A table that is read is shown, written and compared like any other.
fn read_results(bytes: &[u8]) -> String {
    let read = table::parquet::decode(bytes.to_vec(), Path::new("results.parquet"));
    if let Ok(results) = &read {
        let page = place::with(|place| html::sweep::write(results, &place.path("page.html")));
        return format!("{} rows, {} {}", results.rows(), told(&table::csv::encode(results)), told(&page));
    }
    told(&read)
}

fn read_study(bytes: &[u8]) -> String {
    place::with(|place| {
        place.put("study.json", bytes);
        if !place.path("p.png").exists() {
            place.put("p.png", &seeds::picture(image::ImageFormat::Png).expect("a picture"));
        }
        let folder = place.path("study.json");
        told(&html::write(folder.parent().unwrap_or(Path::new("")), &place.path("page.html")))
    })
}
