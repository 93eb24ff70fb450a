use super::*;
use crate::memory::dram::tests::Dice;

/// The plainest cache there is: a list of lines a set, newest first.
struct Plain {
    sets: Vec<Vec<u64>>,
    ways: usize,
    lru: bool,
}

impl Plain {
    fn new(sets: usize, ways: usize, lru: bool) -> Self {
        Self { sets: vec![Vec::new(); sets], ways, lru }
    }

    /// Looks a line up and fills it on a miss; whether it hit, and who left.
    fn access(&mut self, line: u64) -> (bool, Option<u64>) {
        let index = (line % self.sets.len() as u64) as usize;
        let set = &mut self.sets[index];
        if set.contains(&line) {
            if self.lru {
                set.retain(|&l| l != line);
                set.insert(0, line);
            }
            return (true, None);
        }
        set.insert(0, line);
        (false, if set.len() > self.ways { set.pop() } else { None })
    }
}

fn access(tags: &mut Tags, line: u64) -> (bool, Option<u64>) {
    if tags.touch(line) { (true, None) } else { (false, tags.insert(line)) }
}

/// Random lines, some near, some far, and loops of several lengths.
fn streams() -> Vec<Vec<u64>> {
    let mut dice = Dice(5);
    let mut all = vec![
        (0..20_000).map(|_| dice.roll(300)).collect(),
        (0..20_000).map(|i| i / 7 % 50 + (dice.roll(4) << 34)).collect(),
    ];
    all.extend([15, 16, 17, 64, 65, 200].map(|length| (0..5000).map(|i| i % length).collect::<Vec<u64>>()));
    all
}

#[test]
fn lru_and_fifo_are_those_of_a_plain_list() {
    for (replacement, lru) in [(Replacement::Lru, true), (Replacement::Fifo, false)] {
        for (sets, ways) in [(16, 4), (1, 16), (64, 1), (4, 3)] {
            for stream in streams() {
                let mut tags = Tags::new(sets * ways * 64, ways as u32, 64, replacement);
                let mut plain = Plain::new(sets as usize, ways as usize, lru);
                for line in stream {
                    assert_eq!(
                        access(&mut tags, line),
                        plain.access(line),
                        "{replacement:?} {sets} x {ways}, line {line}"
                    );
                }
            }
        }
    }
}

#[test]
fn lru_and_fifo_differ_when_an_old_line_is_used() {
    for (replacement, leaves) in [(Replacement::Lru, 2), (Replacement::Fifo, 1)] {
        let mut tags = Tags::new(128, 2, 64, replacement);
        assert_eq!((tags.insert(1), tags.insert(2)), (None, None));
        assert!(tags.touch(1));
        assert_eq!(tags.insert(3), Some(leaves));
    }
}

#[test]
fn random_replacement_is_reproducible_and_uses_free_ways_first() {
    let run = || {
        let mut tags = Tags::new(4 * 64, 4, 64, Replacement::Random);
        (0..400).map(|line| tags.insert(line)).collect::<Vec<_>>()
    };
    let evicted = run();
    assert_eq!(evicted, run());
    assert!(evicted[..4].iter().all(Option::is_none) && evicted[4..].iter().all(Option::is_some));
    let youngest = evicted.iter().enumerate().filter(|&(line, e)| e.is_some_and(|e| e + 1 == line as u64)).count();
    assert!((60..140).contains(&youngest), "a quarter of the victims is the youngest line, not {youngest} of 396");
}

#[test]
fn an_invalid_way_is_filled_first() {
    for replacement in [Replacement::Lru, Replacement::Fifo, Replacement::Random] {
        let mut tags = Tags::new(4 * 64, 4, 64, replacement);
        (0..4).for_each(|line| assert_eq!(tags.insert(line), None));
        assert!(tags.invalidate(2) && !tags.invalidate(2) && !tags.contains(2));
        assert_eq!(tags.insert(9), None);
        assert!([0, 1, 3, 9].into_iter().all(|line| tags.contains(line)));
        assert!(tags.insert(10).is_some());
    }
}

#[test]
#[should_panic(expected = "power of two")]
fn three_sets_are_refused() {
    Tags::new(3 * 64, 1, 64, Replacement::Lru);
}
