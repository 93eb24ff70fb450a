//! The sets of a tag array: for each its tags, in order.
//!
//! With LRU and FIFO a set is ordered by age, the youngest first, so that no stamps are kept: free ways stand last. With random
//! replacement a line stays in its way.

/// What a tag is kept in.
pub trait Tag: Copy + Eq {
    /// A way without a line.
    const FREE: Self;

    /// A tag that fits.
    fn new(tag: u64) -> Self;

    /// The tag; nothing for a free way.
    fn tag(self) -> Option<u64>;
}

macro_rules! tags {
    ($($width:ty),*) => {$(
        impl Tag for $width {
            const FREE: Self = Self::MAX;

            #[inline]
            fn new(tag: u64) -> Self {
                debug_assert!(tag < u64::from(Self::FREE), "a tag that does not fit");
                tag as Self
            }

            #[inline]
            fn tag(self) -> Option<u64> {
                (self != Self::FREE).then_some(u64::from(self))
            }
        }
    )*};
}

tags!(u32, u64);

/// Sets of `ways` tags each.
#[derive(Clone, Debug)]
pub struct Sets<T> {
    tags: Vec<T>,
    ways: usize,
}

impl<T: Tag> Sets<T> {
    /// Empty sets.
    pub fn new(sets: usize, ways: usize) -> Self {
        Self { tags: vec![T::FREE; sets * ways], ways }
    }

    #[inline]
    fn set(&self, set: usize) -> &[T] {
        &self.tags[set * self.ways..][..self.ways]
    }

    #[inline]
    fn set_mut(&mut self, set: usize) -> &mut [T] {
        &mut self.tags[set * self.ways..][..self.ways]
    }

    /// Whether `tag` is in `set`.
    #[inline]
    pub fn contains(&self, set: usize, tag: T) -> bool {
        match self.ways {
            4 => among::<T, 4>(self.set(set), tag),
            8 => among::<T, 8>(self.set(set), tag),
            _ => self.set(set).contains(&tag),
        }
    }

    /// Makes `tag` the youngest of `set`; whether it is there.
    #[inline]
    pub fn touch(&mut self, set: usize, tag: T) -> bool {
        let set = match self.ways {
            4 => return self.touch_ways::<4>(set, tag),
            8 => return self.touch_ways::<8>(set, tag),
            _ => self.set_mut(set),
        };
        let at = set.iter().position(|&other| other == tag);
        if let Some(at) = at {
            set[..=at].rotate_right(1);
        }
        at.is_some()
    }

    /// As [`Sets::touch`], for sets of `N` ways.
    #[inline(always)]
    pub fn touch_ways<const N: usize>(&mut self, set: usize, tag: T) -> bool {
        touch::<T, N>(&mut self.tags[set * N..][..N], tag)
    }

    /// Puts `tag`, which is not there, into `set` as the youngest; returns what leaves, the oldest.
    #[inline]
    pub fn push(&mut self, set: usize, tag: T) -> T {
        match self.ways {
            4 => push::<T, 4>(self.set_mut(set), tag),
            8 => push::<T, 8>(self.set_mut(set), tag),
            _ => self.set_mut(set).iter_mut().fold(tag, |tag, way| std::mem::replace(way, tag)),
        }
    }

    /// Puts `tag` into a way of `set`; returns what was there.
    pub fn put(&mut self, set: usize, way: usize, tag: T) -> T {
        std::mem::replace(&mut self.set_mut(set)[way], tag)
    }

    /// The first free way of `set`.
    pub fn free_way(&self, set: usize) -> Option<usize> {
        self.way(set, T::FREE)
    }

    /// The way of `tag` in `set`.
    fn way(&self, set: usize, tag: T) -> Option<usize> {
        self.set(set).iter().position(|&other| other == tag)
    }

    /// Takes `tag` out of `set`; whether it was there. In a set that is `ordered` younger ones stay before older ones.
    pub fn remove(&mut self, set: usize, tag: T, ordered: bool) -> bool {
        let Some(way) = self.way(set, tag) else { return false };
        let set = self.set_mut(set);
        set[way] = T::FREE;
        if ordered {
            set[way..].rotate_left(1);
        }
        true
    }
}

/// Whether `tag` is one of `N`. All are compared: a loop that stops early costs more in mispredictions.
#[inline]
fn among<T: Tag, const N: usize>(set: &[T], tag: T) -> bool {
    let set: &[T; N] = set.try_into().expect("a set has N ways");
    set.iter().fold(false, |found, &other| found | (other == tag))
}

/// As [`Sets::touch`], for `N` ways.
#[inline(always)]
fn touch<T: Tag, const N: usize>(set: &mut [T], tag: T) -> bool {
    let set: &mut [T; N] = set.try_into().expect("a set has N ways");
    let found = among::<T, N>(set, tag);
    if found {
        let (before, mut passed) = (*set, false);
        set[0] = tag;
        for way in 1..N {
            passed |= before[way - 1] == tag;
            set[way] = if passed { before[way] } else { before[way - 1] };
        }
    }
    found
}

/// As [`Sets::push`], for `N` ways.
#[inline(always)]
fn push<T: Tag, const N: usize>(set: &mut [T], tag: T) -> T {
    let set: &mut [T; N] = set.try_into().expect("a set has N ways");
    let before = *set;
    set[1..].copy_from_slice(&before[..N - 1]);
    set[0] = tag;
    before[N - 1]
}
