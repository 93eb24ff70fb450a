//! A checker of command histories, made from JEDEC's rules alone and independent of the device model: times run from the last
//! cycle of a command to the last of the next (JESD209-4), those to PRE from the last cycle of the column command's data.

use super::super::device::Command;
use super::{Bench, Dice, lpddr4};
use crate::config::{self, PagePolicy};
use crate::time::DramCycle;
use Command::{Activate, Precharge, PrechargeAll, Read, Refresh, Write};

#[derive(Clone, Copy, Debug)]
struct Sent {
    at: u64,
    command: Command,
    bank: usize,
    row: u64,
}

/// Commands by time, a line's column command as its bursts.
fn expand(history: &[(DramCycle, Command, usize, u64)], t: &config::Dram) -> Vec<Sent> {
    let mut sent = Vec::new();
    for &(DramCycle(at), command, bank, row) in history {
        let bursts = if matches!(command, Read | Write) { 2 } else { 1 };
        sent.extend((0..bursts).map(|burst| Sent { at: at + burst * u64::from(t.tccd), command, bank, row }));
    }
    sent.sort_by_key(|s| s.at);
    sent
}

/// Least distance from `a` to a later `b`.
fn distance(a: &Sent, b: &Sent, t: &config::Dram) -> u32 {
    let bank = a.bank == b.bank;
    let length = |command| match command {
        Activate | Read | Write => 4,
        Precharge | PrechargeAll | Refresh => 2,
    };
    let bus = length(a.command);
    let rule = match (a.command, b.command) {
        (Activate, Read | Write) if bank => t.trcd,
        (Activate, Precharge) if bank => t.tras,
        (Activate, PrechargeAll) => t.tras,
        (Activate, Activate) if bank => t.tras + t.trp,
        (Activate, Activate) => t.trrd,
        (Read, Read) | (Write, Write) => t.tccd,
        (Read, Write) => t.rl + t.tccd + t.twpre - t.wl,
        (Write, Read) => t.wl + 1 + t.tccd + t.twtr,
        (Read, Precharge) if bank => t.trtp,
        (Read, PrechargeAll) => t.trtp,
        (Write, Precharge) if bank => t.wl + 1 + t.tccd + t.twr,
        (Write, PrechargeAll) => t.wl + 1 + t.tccd + t.twr,
        (Precharge, Activate) if bank => t.trp,
        (Precharge, Refresh) => t.trp,
        (PrechargeAll, Activate | Refresh) => t.trp_all,
        (Refresh, Activate | Refresh) => t.trfc,
        _ => 0,
    };
    // From last cycles to first ones. No rule: only the bus.
    let first = if rule == 0 { 0 } else { (rule + bus).saturating_sub(length(b.command)) };
    first.max(bus)
}

/// Before command `b` a row of its bank was closed without a command: there was time for a PRE, and under `Timeout` the row was left
/// alone for as long as that takes.
fn closed_by_itself(sent: &[Sent], b: Sent, t: &config::Dram) {
    let close = Sent { command: Precharge, ..b };
    let here = || sent.iter().filter(|a| a.bank == b.bank && !matches!(a.command, Refresh | PrechargeAll));
    for a in here() {
        assert!(b.at - a.at >= u64::from(distance(a, &close, t) + distance(&close, &b, t)), "{a:?}, {b:?}");
    }
    if t.page_policy == PagePolicy::Timeout {
        let last = here().rfind(|a| matches!(a.command, Activate | Read | Write)).unwrap();
        assert!(b.at - last.at >= u64::from(t.page_timeout), "{last:?}, {b:?}");
    }
}

fn check(sent: &[Sent], t: &config::Dram) {
    let mut rows = vec![None; t.banks as usize];
    for (i, b) in sent.iter().enumerate() {
        for a in sent[..i].iter().rev().take_while(|a| a.at + 1000 > b.at) {
            assert!(b.at - a.at >= distance(a, b, t).into(), "{a:?} then {b:?}");
        }
        match b.command {
            Activate if rows[b.bank].is_some() => {
                // Closed without a command: there was time for a PRE after all that came before.
                assert_ne!(t.page_policy, PagePolicy::Open, "{b:?}");
                closed_by_itself(&sent[..i], *b, t);
                rows[b.bank] = Some(b.row);
            }
            Activate => rows[b.bank] = Some(b.row),
            Read | Write => assert_eq!(rows[b.bank], Some(b.row), "{b:?}"),
            Precharge => assert!(rows[b.bank].take().is_some(), "{b:?}"),
            PrechargeAll => rows.fill(None),
            Refresh if t.page_policy == PagePolicy::Open => assert!(rows.iter().all(Option::is_none), "{b:?}"),
            Refresh => {
                let open = (0..rows.len()).filter(|bank| rows[*bank].is_some());
                open.for_each(|bank| closed_by_itself(&sent[..i], Sent { bank, ..*b }, t));
                rows.fill(None);
            }
        }
    }
    let activates: Vec<_> = sent.iter().filter(|s| s.command == Activate).map(|s| s.at).collect();
    assert!(activates.windows(5).all(|w| w[4] + 3 - w[0] >= t.tfaw.into()), "tFAW");
    let refreshes: Vec<_> = sent.iter().filter(|s| s.command == Refresh).map(|s| s.at).collect();
    for (number, at) in refreshes.iter().enumerate() {
        let due = (number as u64 + 1) * u64::from(t.trefi);
        assert!((due..due + 300).contains(at), "refresh {number} at {at}, due {due}");
    }
    let data = |s: &Sent| match s.command {
        Read => Some(s.at + u64::from(t.rl)),
        Write => Some(s.at + u64::from(t.wl)),
        _ => None,
    };
    let bus: Vec<_> = sent.iter().filter_map(data).collect();
    assert!(bus.windows(2).all(|w| w[1] >= w[0] + u64::from(t.tccd)), "data overlap");
}

#[test]
fn random_traffic_breaks_no_rule() {
    let narrow = config::Dram { trrd: 5, tfaw: 70, trp: 13, trcd: 11, tras: 30, twtr: 3, ..lpddr4() };
    let policies = [PagePolicy::Open, PagePolicy::Closed, PagePolicy::Timeout];
    for seed in 0..48 {
        let base = if seed % 2 == 0 { lpddr4() } else { narrow.clone() };
        let page_policy = policies[seed as usize % 3];
        let t = config::Dram { page_policy, page_timeout: 60, power_down_after: 80, ..base };
        let mut b = Bench::new(&t);
        let mut dice = Dice(seed);
        let (rows, writes, wait) = (1 + dice.roll(5), dice.roll(100), 2 + dice.roll(120));
        let (mut at, mut sent) = (0, 0);
        while sent < 3000 {
            at += dice.roll(wait);
            b.run(at);
            let write = dice.roll(100) < writes;
            sent += u32::from(b.push(at + 1, dice.roll(8) as u8, dice.roll(rows), write, sent));
        }
        b.run(at + 100_000);
        assert_eq!(b.channel.taken(), 0);
        let c = *b.channel.counters();
        assert_eq!(c.read_lines + c.write_lines, 3000);
        assert_eq!(c.row_hits + c.row_closed + c.row_conflicts, 3000);
        assert_eq!(c.reads + c.writes, 6000);
        check(&expand(&b.channel.history, &t), &t);
    }
}

#[test]
#[should_panic(expected = "then")]
fn the_checker_sees_a_violation() {
    let t = lpddr4();
    check(&expand(&[(DramCycle(0), Activate, 0, 1), (DramCycle(28), Read, 0, 1)], &t), &t);
}
