//! Traffic: spill, borders, external geometry buffer, interface through memory, rasteriser.

use super::mocks::{Mem, Unit, mixed, run, srp, uniform};
use crate::config::{Bytes, GeometryBuffer, Interface, MachineConfig, PrimaryVisibility};
use crate::memory::Route;
use crate::srp::Srp;
use crate::test_config::machine;
use crate::work::layout::Region;
use crate::work::{Round, TileWork};

fn finished(config: &MachineConfig, work: TileWork) -> (Srp, Unit, Mem) {
    let (mut s, mut unit, mut memory) = (srp(config), Unit::new(64, 50), Mem::new(64, 20));
    run(&mut s, vec![work], &mut unit, &mut memory, true);
    (s, unit, memory)
}

#[test]
fn what_does_not_fit_is_written_and_read_once() {
    let mut config = machine();
    config.srp.local_memory = Bytes(2 * 1990); // a share of 1990 bytes: 99 samples of 20 bytes and a half
    let mut work = uniform(0, 1, None, 0);
    (work.rect.width, work.rect.height, work.apron_samples) = (10, 10, 3);
    let (s, ..) = finished(&config, work.clone());
    // 2060 - 1990 = 70 bytes: 4 samples, 80 bytes, 2 lines.
    assert_eq!(s.stats().local.spilled_samples, 4);
    assert_eq!((s.stats().dma.sample_written, s.stats().dma.sample_read), (128, 128));
    config.srp.local_memory = Bytes(2 * 2060);
    assert_eq!(finished(&config, work).0.stats().local.spilled_samples, 0);
}

#[test]
fn borders_are_written_and_read_once() {
    let mut work = uniform(3, 1, None, 0);
    work.rounds.push(Round { tests: 4, ..Round::default() });
    (work.border_samples, work.kept_samples) = (10, 20);
    let (s, _, memory) = finished(&machine(), work);
    assert_eq!((s.stats().dma.border_read, s.stats().dma.border_written), (256, 448));
    let order: Vec<Route> =
        memory.log.iter().filter(|(_, r)| r.region == Region::Border).map(|(_, r)| r.route).collect();
    // Before the tests of the second round, and at the end for others.
    assert_eq!(order, [&[Route::Read; 4][..], &[Route::Write; 7]].concat());
}

#[test]
fn an_external_geometry_buffer_is_written_and_read_by_rounds() {
    let mut config = machine();
    config.gpu.geometry_buffer = GeometryBuffer::External;
    let mut work = uniform(0, 20, None, 0);
    work.rounds.push(Round { tests: 50, interpolated: 30, attributes: 30, ..Round::default() });
    let (s, ..) = finished(&config, work);
    // Written: 20 samples x 16 bytes; 30 x (4 + 4 + 1) = 270 bytes from byte 320 on, 5 lines.
    // Read: 50 x 2 x (4 + 4 + 1) + 30 x 2 x (4 + 4 + 1) = 1440 bytes, 23 lines.
    assert_eq!((s.stats().dma.sample_written, s.stats().dma.sample_read), (640, 1472));
    assert_eq!(s.stats().local.spilled_samples, 0);
}

#[test]
fn local_memory_is_counted_by_field() {
    let mut work = uniform(0, 2, Some(0), 1);
    work.rounds.push(Round { tests: 5, colours: 4, interpolated: 3, attributes: 2, shaded: 2, ..Round::default() });
    let (s, ..) = finished(&machine(), work.clone());
    // Words: object 1, normal 1, position 2, shadow 1, colour 1, flags 1.
    let reads = 2 + 5 * 2 * 3 + 4 * 2 + 3 * 2 + 2 * 2 * 3 + 2 * (1 + 3) + 4;
    let writes = 2 * 7 + 2 + 3 * 2 + 2 * 3 + 2;
    assert_eq!((s.stats().local.reads, s.stats().local.writes), (reads, writes));
    // A position of six bytes fits into a word of eight.
    let mut wide = machine();
    wide.srp.local_word_bytes = 8;
    assert_eq!(finished(&wide, work).0.stats().local.writes, writes - 2);
}

#[test]
fn through_memory_a_ray_follows_its_line() {
    let mut config = machine();
    config.gpu.interface = Interface::Memory;
    let (mut s, mut unit, mut memory) = (srp(&config), Unit::new(64, 50), Mem::new(64, 20));
    run(&mut s, vec![uniform(0, 3, None, 0)], &mut unit, &mut memory, true);
    // Rays are complete at 13, 15, 18. Two share a line, written at 16 as the streams moved before the kernel, read at 17,
    // here at 37. The third is flushed 64 cycles after it came.
    let rays: Vec<_> = memory.log.iter().filter(|(_, r)| r.region == Region::Ray).collect();
    assert_eq!(rays[0].1.route, Route::Write);
    assert_eq!(rays[0].0, 16);
    assert_eq!((rays[1].0, rays[1].1.route, rays[1].1.line), (17, Route::Read, rays[0].1.line));
    assert_eq!(unit.pushed.iter().map(|p| p.0).collect::<Vec<_>>(), [37, 38, 18 + 64 + 1 + 20]);
    // Hits at 87 and 88, and at 153: the first two share a line.
    let d = s.stats().dma;
    assert_eq!((d.ray_written, d.ray_read), (4 * 64, 4 * 64));
    config.gpu.stream_flush_cycles = 10;
    assert_eq!(finished(&config, uniform(0, 3, None, 0)).1.pushed[2].0, 18 + 10 + 1 + 20);
}

#[test]
fn queues_hold_what_their_settings_say() {
    let mut config = machine();
    config.gpu.interface = Interface::Memory;
    // Two rays a line. One read of a stream at a time is answered 20 cycles after it was asked.
    config.gpu.stream_reads = 1;
    let memory = finished(&config, uniform(0, 64, None, 0)).2;
    let hits = (Region::Ray.base() + (1 << 31)) / 64;
    let ray_reads = memory.log.iter().filter(|(_, r)| r.route == Route::Read && r.line < hits);
    let reads: Vec<u64> = ray_reads.map(|(at, _)| *at).collect();
    assert_eq!(reads.len(), 32);
    assert!(reads.windows(2).all(|pair| pair[1] >= pair[0] + 20), "{reads:?}");
    // A slower link and fewer items whose reads are gathered at a time cost time.
    let mut config = machine();
    let last = |config: &MachineConfig| finished(config, uniform(0, 64, Some(0), 1)).1.pushed.last().unwrap().0;
    let before = last(&config);
    config.gpu.interface_latency_cycles += 7;
    assert!(last(&config) >= before + 7);
    config.gpu.interface_latency_cycles -= 7;
    config.srp.gather_entries = 1;
    assert!(last(&config) > before);
}

#[test]
fn a_rasteriser_delivers_primaries() {
    let mut config = machine();
    config.gpu.primary_visibility = PrimaryVisibility::Raster;
    let work = uniform(0, 30, Some(1), 2);
    let (s, unit, memory) = finished(&config, work);
    assert_eq!(unit.pushed.len(), 60, "shadow rays only");
    assert!(unit.pushed.iter().all(|(_, r)| r.ray % 3 != 0));
    // 20 bytes a sample: 3 a line. 30 triangles, and half as many again behind each: 75 of 64 bytes, a line each.
    let moved = 640 + 75 * 64;
    assert_eq!((s.stats().dma.gbuffer_written, s.stats().dma.gbuffer_read), (moved, moved));
    assert_eq!((s.stats().raster.triangles, s.stats().raster.samples), (75, 75));
    // A triangle a cycle is set up before the first sample is made; the last of three a line is written.
    let samples = |(_, r): &&(u64, crate::memory::Request)| {
        r.region == Region::GBuffer && r.line < (Region::GBuffer.base() + (1 << 38)) / 64
    };
    let first_sample = memory.log.iter().find(samples).map(|(at, _)| *at);
    assert_eq!(
        first_sample,
        Some(75 + 3),
        "set up from cycle 0 on, made in cycles 75, 76 and 77, and written a cycle later"
    );
    let first_read = memory.log.iter().find(|(_, r)| r.region == Region::GBuffer && r.route == Route::Read);
    assert!(first_read.is_some_and(|(at, _)| *at >= 3));
}

#[test]
fn raster_and_memory_work_on_mixed_tiles() {
    let mut config = machine();
    config.gpu.primary_visibility = PrimaryVisibility::Raster;
    config.gpu.interface = Interface::Memory;
    let work = mixed(0, 50, 4);
    let (rays, primaries) = (work.rays.len(), 100);
    let (s, unit, _) = finished(&config, work);
    assert_eq!(unit.pushed.len(), rays - primaries);
    assert_eq!(s.stats().local.tiles, 1);
}
