//! A system that fails at every single request: `shim.c` is preloaded into the program and spoils the n-th read, write, sync or name
//! of a command, for every n. Afterwards what has a name is whole, the exit code says who must act, and the next run ends with the
//! bytes of a run that nothing disturbed.
//!
//! By default some requests of each kind and command are spoilt; `RAYREEL_LONG=1` spoils each one.
#![cfg(target_os = "linux")]

#[allow(dead_code, reason = "shared with the other end-to-end tests")]
#[path = "../common/mod.rs"]
mod common;
mod disk;
mod jobs;
#[allow(dead_code, reason = "shared with the tests of traces at URLs")]
#[path = "../remote/server.rs"]
mod server;
mod system;

use jobs::{Job, jobs};
use system::{Kind, System};

/// Requests of a kind that are spoilt in a command, unless all are.
const SOME: usize = 5;

#[derive(Default)]
struct Count {
    requests: usize,
    faults: usize,
    unharmed: usize,
    /// Faults by kind, in the order of [`Kind::ALL`].
    of_kind: [usize; Kind::ALL.len()],
}

/// Spoils the requests of one command.
fn spoil(system: &System, job: &Job) -> Count {
    system.fresh(job);
    let quiet = system.run(&job.command, None);
    assert_eq!(quiet.code, 0, "{}: {}", job.name, quiet.err);
    let undisturbed = system.state(job, &quiet.out);
    assert!(undisturbed.iter().all(|(_, bytes)| bytes.as_ref().is_some_and(|bytes| !bytes.is_empty())), "{}", job.name);
    // What a command says that it has done stays done, whenever the power goes. A cache may be filled again.
    for kind in [Kind::Cut, Kind::CutOfBytes].into_iter().filter(|_| !job.prints) {
        system.fresh(job);
        let ran = system.run(&job.command, Some((kind, usize::MAX >> 1)));
        system.cut(kind);
        assert_eq!(ran.code, 0, "{}: {}", job.name, ran.err);
        assert!(system.state(job, &ran.out) == undisturbed, "{}: {kind:?} after the end", job.name);
    }
    system.fresh(job);
    let requests = system.count(&job.command, "count");
    system.fresh(job);
    let large = system.count(&job.command, "count-memory");
    let mut count = Count { requests, ..Count::default() };
    assert!(requests > 5, "{}: {requests} requests", job.name);
    let every = std::env::var_os("RAYREEL_LONG").is_some();
    for (number, kind) in Kind::ALL.into_iter().enumerate() {
        let requests = if kind == Kind::NoMemory { large } else { requests };
        let step = if every { 1 } else { requests.div_ceil(SOME).max(1) };
        for at in (1 + number % step..=requests).step_by(step) {
            system.fresh(job);
            let ran = system.run(&job.command, Some((kind, at)));
            // Short reads of what cannot be short are none.
            let Some(request) = system.spoilt() else { continue };
            let what = format!("{} with {kind:?} at {request} of {requests}", job.name);
            count.faults += 1;
            count.of_kind[number] += 1;
            if kind.is_cut() {
                system.cut(kind);
            } else if !kind.kills() {
                let (failed, undone) =
                    (kind == Kind::Fail && ran.code == 74, kind == Kind::Fail && ran.code == 3 && job.leaves);
                assert!(ran.code == 0 || failed || undone, "{what}: code {}\n{}", ran.code, ran.err);
                let said = if undone { "not done: " } else { "error: " };
                assert!(ran.code == 0 || ran.err.contains(said), "{what}: {}", ran.err);
            }
            if ran.code == 0 {
                count.unharmed += 1;
                assert!(system.state(job, &ran.out) == undisturbed, "{what}: it said that all is well");
                continue;
            }
            // Whoever looks now sees whole files or none.
            for ((name, now), (_, then)) in system.state(job, &quiet.out).iter().zip(&undisturbed) {
                assert!(now.is_none() || now == then, "{what}: {name} is neither whole nor absent");
            }
            if job.ends && system.folder.join(job.results[0]).exists() {
                continue;
            }
            let again = system.run(&job.again, None);
            assert_eq!(again.code, 0, "{what}: the next run says\n{}", again.err);
            for ((name, now), (_, then)) in system.state(job, &again.out).iter().zip(&undisturbed) {
                assert!(now == then, "{what}: the next run gives another {name}");
            }
        }
    }
    count
}

#[test]
fn nothing_is_lost_whatever_fails() {
    let system = System::new();
    let mut total = Count::default();
    for job in jobs(&system) {
        let count = spoil(&system, &job);
        let Count { requests, faults, unharmed, of_kind } = count;
        total.of_kind.iter_mut().zip(of_kind).for_each(|(all, faults)| *all += faults);
        eprintln!("{:8} {requests:5} requests, {faults:5} faults, {unharmed:5} without harm, none lost", job.name);
        total.faults += faults;
        total.requests += requests;
    }
    eprintln!("all      {:5} requests, {:5} faults", total.requests, total.faults);
    assert!(total.faults > 100, "{}", total.faults);
    for (kind, faults) in Kind::ALL.iter().zip(total.of_kind) {
        assert!(faults > 5, "{kind:?} struck {faults} times");
    }
}
