//! A queue of line requests in order of age, which knows for each bank how many of them wait and how many hit the open row.

use crate::time::DramCycle;

/// A line request in a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Cycle at which it enters the queue.
    pub arrival: DramCycle,
    /// Row.
    pub row: u64,
    /// Bank.
    pub bank: u8,
    /// A write; else a read.
    pub write: bool,
    /// It caused a PRE or ACT already, so it is no row hit any more.
    pub prepared: bool,
    /// Name by which the requester knows it.
    pub token: u32,
    /// Line number.
    pub line: u64,
}

/// Requests in order of age.
#[derive(Clone, Debug)]
pub struct Queue {
    entries: Vec<Entry>,
    waiting: Vec<u32>,
    hits: Vec<u32>,
    /// Banks for which someone waits, bit by bit.
    waiting_banks: u64,
    /// Banks whose open row someone hits, bit by bit.
    hit_banks: u64,
}

impl Queue {
    /// An empty queue for requests to so many banks.
    pub fn new(banks: u32) -> Self {
        let none = vec![0; banks as usize];
        Self { entries: Vec::new(), waiting: none.clone(), hits: none, waiting_banks: 0, hit_banks: 0 }
    }

    /// Adds the youngest request; `open` is the open row of its bank.
    pub fn push(&mut self, entry: Entry, open: Option<u64>) {
        let bank = usize::from(entry.bank);
        self.waiting[bank] += 1;
        self.waiting_banks |= 1 << bank;
        if open == Some(entry.row) {
            self.hits[bank] += 1;
            self.hit_banks |= 1 << bank;
        }
        self.entries.push(entry);
    }

    /// Takes the request at `index` out, whose row is open.
    pub fn remove(&mut self, index: usize) -> Entry {
        let entry = self.entries.remove(index);
        let bank = usize::from(entry.bank);
        self.waiting[bank] -= 1;
        self.hits[bank] -= 1;
        self.waiting_banks &= !(u64::from(self.waiting[bank] == 0) << bank);
        self.hit_banks &= !(u64::from(self.hits[bank] == 0) << bank);
        entry
    }

    /// The bank opened `row`, or closed.
    pub fn row_changed(&mut self, bank: usize, row: Option<u64>) {
        self.hits[bank] = match row {
            Some(row) if self.waiting[bank] > 0 => {
                self.entries.iter().filter(|e| usize::from(e.bank) == bank && e.row == row).count() as u32
            }
            _ => 0,
        };
        self.hit_banks = self.hit_banks & !(1 << bank) | u64::from(self.hits[bank] > 0) << bank;
    }

    /// Banks for which someone waits, bit by bit.
    #[inline]
    pub fn waiting_banks(&self) -> u64 {
        self.waiting_banks
    }

    /// Banks whose open row someone hits, bit by bit.
    #[inline]
    pub fn hit_banks(&self) -> u64 {
        self.hit_banks
    }

    /// Requests, oldest first.
    #[inline]
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// A request.
    pub fn entry_mut(&mut self, index: usize) -> &mut Entry {
        &mut self.entries[index]
    }

    /// Number of requests.
    #[inline]
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there is none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }
}
